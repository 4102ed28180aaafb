"""One step of the duty machine under way: the state so far and what has been done. It never outlives its step."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

from msgspec.structs import replace

from onboard import notes
from onboard.authority import machine as authority
from onboard.authority.records import Action as AuthorityAction
from onboard.authority.records import AskRoute, Cleared, RepeatDue, RequestKind, SetTimer, Write
from onboard.authority.records import Event as AuthorityEvent
from onboard.duty.records import ABLE, ASK, LEAVE, RELEASE, DrivingOrder, DutyState, SetTimerAt, Told
from onboard.duty.stop_limit import cleared_sections
from onboard.duty_parameters import DutyParameters, ReleaseRule
from onboard.plan import DutyPlan, PlanLeg, PlanStop, PointsNeeded

Action = AuthorityAction | SetTimerAt | Told | DrivingOrder
NEVER_S: Final = -math.inf


@dataclass(slots=True)
class DutyStep:
    """The step: plan, time, state so far, actions so far."""

    plan: DutyPlan
    parameters: DutyParameters
    now_s: float
    state: DutyState
    actions: list[Action] = field(default_factory=list)

    def set(self, **changes: object) -> None:
        """Change the state."""
        self.state = replace(self.state, **changes)

    def note(self, note: notes.Note) -> None:
        """Write a line of the journal."""
        self.actions.append(Write(note))

    def authority(self, event: AuthorityEvent) -> None:
        """Let the authority take an event."""
        after, actions = authority.step(self.state.authority, event, covered=self.state.place.covered)
        if after is not self.state.authority:
            self.state = replace(self.state, authority=after)
        self.actions += actions

    def say_what_waits(self) -> None:
        """Send what waits for the radio, where that reaches or, without a position, may reach."""
        if self.state.authority.waits_for_radio:
            self.authority(RepeatDue(None))

    def timer(self, timer: str, after_s: float, at_s: float = NEVER_S) -> bool:
        """Start a timer, unless its time has passed and its clock time has come; returns whether they have."""
        named = {"ask": ASK, "leave": LEAVE, "release": RELEASE, "able": ABLE}[timer]
        if after_s <= 0.0 and at_s <= self.now_s:
            return True
        after_s = max(after_s, 0.0)
        self.actions.append(SetTimer(named, after_s) if at_s == NEVER_S else SetTimerAt(named, at_s, after_s))
        return False

    def dwell_s(self, stop: int) -> float:
        """The shortest stay at a stop, s: none where no passengers get on or off."""
        return self.parameters.dwell_min_s if self.plan.stops[stop].passengers else 0.0

    def schedule(self, ready_s: float, stop: int) -> None:
        """When the route from a stop may be asked for, and when the train may leave it.

        The dwell is time that passes; the planned departure is read off the unit's clock: a late clock departs late.
        """
        departure_s = self.plan.stops[stop].departure_s
        planned_s = NEVER_S if departure_s is None else departure_s
        ready_after_s, lead_s = ready_s - self.now_s, self.parameters.request_lead_s
        ask = self.timer("ask", ready_after_s - lead_s, planned_s - lead_s)
        self.set(may_ask=ask, may_leave=self.timer("leave", ready_after_s, planned_s))

    def await_release(self) -> None:
        """The train stands after an emergency stop: the driver acknowledges it after a time."""
        self.set(released=False)
        self.timer("release", self.parameters.emergency_release_s)

    def want(self, points: tuple[PointsNeeded, ...]) -> None:
        """Throw these as soon as and whenever they can be."""
        self.set(wanted=tuple(dict.fromkeys((*self.state.wanted, *points))))

    def ask(self, leg: PlanLeg | None, seen: int = 0) -> None:
        """Ask for a route of which something ahead is not held, one at a time.

        What has been given back section by section may be another's: then only the part from where it stands is wanted;
        without a position from the span that its driver has `seen` it in.
        """
        state, place = self.state.authority, self.state.place
        if leg is None or state.open(RequestKind.ROUTE) is not None:
            return
        by_section = self.parameters.release is ReleaseRule.SECTION
        here = place.here if place.known else seen if by_section else 0
        behind = {span.section_id for span in self.plan.spans[:here]}
        ahead = tuple(section_id for section_id in leg.section_ids if section_id not in behind)
        if not all(map(state.holds, ahead)):
            self.authority(AskRoute(leg.route_id, ahead if by_section else leg.section_ids))

    def give_back_behind(self, clear: int) -> None:
        """Give back what is held of the first `clear` spans."""
        cleared = cleared_sections(self.plan, self.state.authority, clear)
        if cleared:
            self.authority(Cleared(cleared))

    def stop(self, index: int) -> PlanStop:
        """A stop of the plan."""
        return self.plan.stops[index]

    def leg_from_stop(self, index: int) -> PlanLeg | None:
        """The route that begins where the train stands at a stop."""
        return self.plan.leg_beyond(self.plan.spans[self.plan.stops[index].span].section_id)
