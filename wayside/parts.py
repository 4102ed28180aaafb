"""The part of a way that is free, for a train that follows another.

Invariant: a part ends with a section of a stretch of open line that nobody holds but the unit itself and trains that
run the same way, by the routes last granted to them; so no two trains ever stand against each other in a stretch. The
radio reaches all of that section: who waits where it does not would never hear of the rest.
"""

from __future__ import annotations

from wayside.config import RouteEntry
from wayside.register import Register


def free_part(
    register: Register, unit_id: str, route: RouteEntry, section_ids: tuple[str, ...]
) -> tuple[str, ...]:
    """The sections wanted up to the last, before another's, in which a train can wait and hear; empty: no part may be
    granted.
    """
    conflict = register.other_holder(unit_id, section_ids)
    if conflict is None:
        return section_ids
    part = section_ids[: section_ids.index(conflict[0])]
    while part and part[-1] not in register.plan.hears:
        part = part[:-1]
    if not part:
        return ()
    stretch = _stretch(register, route, part[-1])
    holders = {register.holders[section_id] for section_id in stretch if section_id in register.holders}
    follows = all(_runs(register, holder, stretch) for holder in holders - {unit_id})
    return part if follows else ()


def _stretch(register: Register, route: RouteEntry, section_id: str) -> tuple[str, ...]:
    """The sections of open line about one of them, as a route passes them; empty where it is none."""
    found: list[str] = []
    for each in route.section_ids:
        if each in register.plan.open_line:
            found.append(each)
        elif section_id in found:
            break
        else:
            found = []
    return tuple(found) if section_id in found else ()


def _runs(register: Register, unit_id: str, stretch: tuple[str, ...]) -> bool:
    """Whether a unit runs this way through a stretch."""
    route = register.plan.routes.get(register.unit(unit_id).route_id or "")
    return route is not None and _stretch(register, route, stretch[0]) == stretch
