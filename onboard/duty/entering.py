"""Coming in where others may not do so at once (不同時進入): leave for the arrival points, asked for and given back.

Invariant: leave is asked for only by a train that is short of the points; they are given back only when its whole train
stands on the track behind them, or has its way on beyond it, so that its overrun is in nobody's way any more.
"""

from __future__ import annotations

from collections.abc import Iterable

from onboard.authority.records import AskRoute, RequestKind
from onboard.duty.duty_step import DutyStep
from onboard.duty.records import AT_A_MARK, DutyPhase, DutyState
from onboard.plan import DutyPlan, PlanLeg, PointsNeeded, Span

KEEPS = True  # off: arrival points are given back as soon as a tag proves that they are behind


def leg_with(plan: DutyPlan, section_id: str) -> PlanLeg | None:
    """The route of the plan that leads through a section."""
    return next((leg for leg in plan.legs if section_id in leg.section_ids), None)


def lacks_leave(duty: DutyStep, points: Iterable[PointsNeeded]) -> PointsNeeded | None:
    """The first of these points that it holds and may not command: where leave is needed to come in, or where nobody
    knows any more that it had leave to go.
    """
    authority, plan = duty.state.authority, duty.plan
    if not ((authority.on_line and plan.overlaps) or any(leg.entry for leg in plan.legs)):
        return None
    return next(
        (p for p in points if authority.holds(p.section_id) and p.section_id not in authority.commandable),
        None,
    )


def ask_leave(duty: DutyStep, points: Iterable[PointsNeeded]) -> bool:
    """Whether it lacks leave for any of these points; then it asks for that, unless it asks for something already."""
    needed = lacks_leave(duty, points)
    leg = None if needed is None else leg_with(duty.plan, needed.section_id)
    if needed is None or leg is None:
        return False
    if duty.state.authority.open(RequestKind.ROUTE) is None:
        ahead = leg.section_ids[leg.section_ids.index(needed.section_id) :]
        duty.authority(AskRoute(leg.route_id, leg.to_enter if needed.section_id in leg.entry else ahead))
    return True


def ask_beyond(duty: DutyStep, track: Span | None) -> None:
    """A train that runs through a track asks for the route beyond it before it comes there, once it may come in."""
    leg = None if track is None else leg_with(duty.plan, track.section_id)
    if leg is not None and not set(leg.entry) <= set(duty.state.authority.commandable):
        return
    if track is not None and not duty.plan.calls_at(track.section_id):
        duty.ask(duty.plan.leg_beyond(track.section_id))


def kept_until_stand(plan: DutyPlan, state: DutyState) -> int:
    """How many spans may be given back from the beginning of the path, by this rule."""
    stands = state.phase is DutyPhase.RUNNING and state.place.stands
    if not KEEPS or stands or state.phase in AT_A_MARK:
        return len(plan.spans)
    for leg in plan.legs:
        if leg.entry and state.authority.holds(leg.entry[0]):
            first = next(i for i, span in enumerate(plan.spans) if span.section_id == leg.entry[0])
            beyond = plan.spans[first + len(leg.entry) + 1 :][:1]
            if not (beyond and state.authority.holds(beyond[0].section_id)):
                return first
    return len(plan.spans)
