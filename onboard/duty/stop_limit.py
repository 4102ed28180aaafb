"""Where the train must stop (停止限界点): the end of what it holds, or the first points not proven.

Sugiyama et al. 2017, section 2.2: first before the departure points, then before the arrival points, then on the
arrival track, as grants and proofs come in. All in joints: joint `i` is where span `i` of the plan begins.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Final

from onboard.authority.records import Authority
from onboard.duty.records import StopLimit
from onboard.plan import DutyPlan

NOT_PROVEN: Final = "points not proven"
HALTED: Final = "halted where no radio reaches"


def stop_limit(
    plan: DutyPlan,
    authority: Authority,
    entered: Collection[str] = frozenset(),
    *,
    sweeps: bool = False,
    left: int = 0,
    within: int | None = None,
) -> StopLimit:
    """The stop limit on the plan's path; the path's beginning when nothing on it is held.

    Points of sections that the train has `entered` on their proof no longer hold it back: they are locked under
    it, whatever has become of the proof since (4.4 (1), table 3). Before a section that must be passed on sight it
    stops, unless it `sweeps` already, or it is of the first spans, which its front has `left`. Nor does one of these
    that it does not hold end its way: the register gave it back what a false claim had put behind it.
    Halted, it keeps `within` so many spans.
    """
    begun = False
    for joint, span in enumerate(plan.spans):
        if not authority.holds(span.section_id):
            if begun and joint >= left:
                return StopLimit(joint, span.section_id, "not held")
            continue
        begun = True
        if joint == within:
            return StopLimit(joint, span.section_id, HALTED)
        if span.section_id in authority.unswept and not sweeps and joint >= left:
            return StopLimit(joint, span.section_id, "to be passed on sight")
        missing = any(needed not in authority.proven for needed in span.points)
        if missing and span.section_id not in entered:
            return StopLimit(joint, span.section_id, NOT_PROVEN)
    if not begun:
        return StopLimit(0, plan.spans[0].section_id, "not held")
    return StopLimit(len(plan.spans), None, "end of the path")


def cleared_sections(plan: DutyPlan, authority: Authority, clear: int) -> tuple[str, ...]:
    """Sections held among the first `clear` spans, which the safe rear has left; in order of travel."""
    return tuple(s.section_id for s in plan.spans[:clear] if authority.holds(s.section_id))


def next_rear_span(plan: DutyPlan, authority: Authority, freed: int) -> int | None:
    """The span among the first `freed` that the safe rear leaves next to free a section; None for the last one held."""
    held = [index for index, span in enumerate(plan.spans) if authority.holds(span.section_id)]
    return held[0] if len(held) > 1 and held[0] < freed else None


def entered_on_proof(plan: DutyPlan, authority: Authority, sure: int) -> frozenset[str]:
    """Points sections among the first `sure` spans, in which the front surely is or was, with all points proven."""
    return frozenset(
        span.section_id
        for span in plan.spans[:sure]
        if span.points and all(needed in authority.proven for needed in span.points)
    )


def points_perhaps_under(plan: DutyPlan, authority: Authority, perhaps: int) -> tuple[str, ...]:
    """Sections with points still being thrown that the front may have come into, `perhaps` spans far."""
    under_way = {command.needed.section_id for command in authority.commands}
    return tuple(span.section_id for span in plan.spans[:perhaps] if span.section_id in under_way)
