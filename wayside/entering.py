"""Leave to come in (不同時進入): while a train comes in whose overrun would foul another's way, that other stays out.

Invariant: of two units one of which comes in, none has leave for points that the other's overrun would foul. A unit
comes in from when it has leave for the points before its arrival track until it has given all of them back, which it
does standing on that track; or by a person's word that it holds nothing of them.

The whole route is held from its grant on, so nobody can take the track meanwhile, and who waits for leave always gets
it: it waits only for trains that come to a stand, or that run on over the points, and these wait for nobody behind
them. Leave is the capability to command the arrival points, and to be asked for from where the train comes near; no
capability, no proof, no way past them. A unit that asks for it has none: so the register may forget who has.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from msgspec.structs import replace

from radio.messages import RefusalReason, RouteRequest
from wayside.config import RouteEntry
from wayside.register import Against, Register, RegisteredUnit

EXCLUDES = True  # off: opposing trains come in at once, whatever they would overrun


def weighed(
    register: Register, unit_id: str, message: RouteRequest, against: Against | None
) -> tuple[Register, Against | None, bool]:
    """The register, why a request is refused, if so, and whether it is one for leave.

    A unit that asks for leave says by that that it has none. `against`: what else is against the request.
    """
    route = register.plan.routes.get(message.route_id)
    if against is not None or route is None:
        return register, against, False
    asks = asks_leave(register, unit_id, route, message.section_ids)
    if asks:
        register = leave_lacking(register, unit_id, route)
    fouls = fouled(register, unit_id, route, message.section_ids)
    return register, None if fouls is None else (RefusalReason.OVERLAP, *fouls), asks


def carried_over(before: RegisteredUnit, after: RegisteredUnit, held: Iterable[str]) -> RegisteredUnit:
    """A unit that has claimed what it holds, with the leave that this boot told it of before."""
    kept = frozenset(held)
    return replace(after, leave=before.leave & kept, without_leave=before.without_leave & kept)


def asks_leave(register: Register, unit_id: str, route: RouteEntry, section_ids: tuple[str, ...]) -> bool:
    """Whether a unit asks for leave: for the end of its route, which it holds, from arrival points on."""
    held = register.held_by(unit_id)
    return bool(route.entry) and section_ids[0] in route.entry and set(section_ids) <= set(held)


def fouled(
    register: Register, unit_id: str, route: RouteEntry, section_ids: tuple[str, ...]
) -> tuple[str, str] | None:
    """The section that keeps a unit from going over what it asks for, and the unit whose overrun, or way, is there."""
    if not EXCLUDES or not register.plan.has_overlaps:
        return None
    enters = asks_leave(register, unit_id, route, section_ids)
    goes_over = [s for s in section_ids if enters or s not in route.entry]
    for other in register.plan.unit_ids:
        if other == unit_id or not (held := register.held_by(other)):
            continue
        overrun = set(overlap_of(register, other, held))
        taken = next((s for s in goes_over if s in overrun), None)
        if taken is None and enters:
            live = overrun.union(held).difference(register.unit(other).without_leave)
            taken = next((s for s in route.overlap if s in live), None)
        if taken is not None:
            return taken, other
    return None


def overlap_of(register: Register, unit_id: str, held: Iterable[str]) -> Iterator[str]:
    """What a unit would foul that overran its stop, while it comes in or may do so."""
    unit, routes = register.unit(unit_id), register.plan.routes
    live = set(held).difference(unit.without_leave)
    known = routes.get(unit.route_id or "")
    for route in routes.values() if known is None else (known,):
        if route.section_ids[-1] in live and not live.isdisjoint(route.entry):
            yield from route.overlap


def leave_given(
    register: Register, unit_id: str, route: RouteEntry, section_ids: tuple[str, ...]
) -> Register:
    """The register with a unit let onto these sections; onto arrival points only where it asked for leave."""
    if not register.plan.has_overlaps:
        return register
    unit, held = register.unit(unit_id), frozenset((*register.held_by(unit_id), *section_ids))
    waits = frozenset[str]()
    if EXCLUDES and not asks_leave(register, unit_id, route, section_ids):
        waits = held.intersection(route.entry)
    leave = held.intersection((*unit.leave, *section_ids)) - waits
    return register.with_unit(
        unit_id, replace(unit, leave=leave, without_leave=held & (unit.without_leave | waits) - leave)
    )


def leave_lacking(register: Register, unit_id: str, route: RouteEntry) -> Register:
    """The register with a unit that has just said, by asking for it, that it has no leave for its arrival points."""
    unit, lacks = register.unit(unit_id), frozenset(route.entry)
    return register.with_unit(
        unit_id, replace(unit, leave=unit.leave - lacks, without_leave=unit.without_leave | lacks)
    )
