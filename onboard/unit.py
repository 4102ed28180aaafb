"""The on-board unit (車上装置): joins localisation, authority, supervision, driving and the duty of the day.

The fast part is `onboard.tick`, run every step on this unit's row; this is the part that acts on events: telegrams,
tags, timers and what the tick reports. Each event ends in `_think`: what is open now, and what follows from it.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from network.model import SectionKind, TagPurpose
from onboard.authority import machine as auth
from onboard.authority.coverage import covered_at, next_coverage_m
from onboard.authority.records import Noted
from onboard.authority.stop_limit import (
    StopLimit,
    arrival_points,
    cleared_sections,
    departure_points,
    entered_on_proof,
    next_rear_trigger_m,
    points_of,
    points_perhaps_under,
    stop_limit,
)
from onboard.driving.stop_keeper import StopKeeper
from onboard.driving.stopping import LIMIT_MARGIN_M
from onboard.driving.supervision import RESERVE_M
from onboard.driving.tasc import WEAK_TOLERANCE_M, Verdict, judge
from onboard.duty.mission import Mission, PathTag, Target
from onboard.duty.timekeeping import cruise_for
from onboard.localisation.fix import Taken, missed_by_m, take
from onboard.localisation.sighting import NOT_SEEN_M, sign_fix
from onboard.localisation.tags import TagDoubt, tag_fix
from onboard.records import (
    EMERGENCY_INTERVENTION,
    EVENT_INTERVENTION,
    EVENT_MOVING,
    EVENT_POSITION,
    EVENT_STOPPED,
    EVENT_TACHOMETER,
    EVENT_TAG_OVERDUE,
    EVENT_VERDICT,
    MODE_DRIVE,
    MODE_HOLD,
    NO_INTERVENTION,
    BehaviourRow,
    UnitRow,
)
from onboard.unit_records import (
    Finished,
    LeftLine,
    Phase,
    Transmit,
    UnitAction,
    UnitFacts,
    UnitParameters,
)
from radio.envelope import Dropped, Endpoint
from radio.messages import AnyMessage
from vehicle.records import TrainRow

__all__ = [
    "Finished",
    "LeftLine",
    "Noted",
    "Phase",
    "Transmit",
    "Unit",
    "UnitAction",
    "UnitFacts",
    "UnitParameters",
]

ARRIVED_ON_SIGHT_WITHIN_M: Final = 6.0  # the same by the crew's eye
ARRIVED_WITHIN_M: Final = 5.0  # stood this near the mark, the train has arrived


class Unit:
    """One on-board unit. `row` is its row of `onboard.records.UNIT`, shared with the compiled tick."""

    def __init__(
        self,
        facts: UnitFacts,
        row: UnitRow,
        train: TrainRow,
        behaviour: BehaviourRow,
        endpoint: Endpoint,
        keeper: StopKeeper,
    ) -> None:
        self.facts: Final = facts
        self.row: Final = row
        self.phase = Phase.OFF
        self.mission: Mission | None = None
        self.at = 0  # index of the target where the train stands or that it left last
        self.stands_at: int | None = None  # target at which a train without a position stands, by the crew
        self.load_share = 0.0
        self.authority = auth.Authority(facts.unit_id, facts.manager_id)
        self.limit = StopLimit(0.0, None, "no mission")
        self.wake_at_s = math.inf
        self._train = train
        self._behaviour = behaviour
        self._endpoint = endpoint
        self.keeper: Final = keeper
        self._sighted: Target | None = None  # whose sign has been seen
        self._elevation_m: NDArray[np.float64] = np.zeros(1)
        self._driving_mps: NDArray[np.float64] = np.zeros(1)
        self._tags: dict[int, PathTag] = {}
        self._doubt: Final = TagDoubt(row, facts.parameters)
        self._wanted: tuple[auth.PointsNeeded, ...] = ()  # thrown as soon as and whenever they can be
        self._entered: frozenset[str] = frozenset()  # points sections that the train came onto by their proof
        self._ready_s = -math.inf  # not before: doors, dwell
        self._release_emergency_s = math.inf
        self._actions: list[UnitAction] = []

    # events -----------------------------------------------------------------------------------------------

    def begin(
        self, mission: Mission, path: NDArray[np.void], now_s: float, *, ready_s: float, signing_on: bool
    ) -> list[UnitAction]:
        """Take up a mission; the row's position is already on its path. `path` are the rows of PATTERN."""
        self._take_up(mission, path, ready_s)
        self._expect_tag()
        if signing_on:
            self.phase = Phase.SIGNING_ON
            enters = mission.spans[0].kind is SectionKind.PORTAL
            self._authority(auth.BeginOnLine((mission.spans[0].section_id,), enters), now_s)
        elif self.row.position_known:
            self.phase = Phase.STANDING
        else:
            self.phase = Phase.RESTARTED
            self.stands_at = 0
        return self._done(now_s)

    def restart(
        self, mission: Mission, path: NDArray[np.void], now_s: float, *, ready_s: float, stands_at: int | None
    ) -> list[UnitAction]:
        """Switched on again (復旧): the crew enters the train number and, if it stands at one, the station.

        Position and holdings are forgotten; until both are found the train runs on sight (4.4 (3), table 3).
        """
        self._take_up(mission, path, ready_s)
        self.phase = Phase.RESTARTED
        self.stands_at = stands_at
        self.row.position_known = 0
        self.row.restricted_mps = self.facts.parameters.restricted_mps
        self.row.expected_tag_m = math.inf
        self.row.stop_limit_m = math.inf
        self.row.intervention = EMERGENCY_INTERVENTION
        if self.row.speed_mps == 0.0:
            self._release_emergency_s = now_s + self.facts.parameters.emergency_release_s
        self._note("restarted", epoch=self._endpoint.epoch)
        at_portal = stands_at == 0 and mission.targets[0].station_id is None
        # In a portal it wishes to enter, which the crew knows; anywhere else only the manager knows what it holds.
        self._authority(auth.BeginOnLine((mission.spans[0].section_id,) if at_portal else None), now_s)
        return self._done(now_s)

    def checked_by_crew(self, points: auth.PointsNeeded, now_s: float) -> list[UnitAction]:
        """The crew has seen that points ahead lie as needed."""
        self._authority(auth.CheckedByCrew(points), now_s)
        return self._done(now_s)

    def throw_by_crew(self, points: auth.PointsNeeded, now_s: float) -> list[UnitAction]:
        """The crew stands before points that lie otherwise, and has the unit command them if it holds them."""
        self._authority(auth.Throw((points,)), now_s)
        return self._done(now_s)

    def give_back(self, now_s: float, hold_s: float) -> list[UnitAction]:
        """The crew sets back the route ahead and asks for none for `hold_s`; only standing, with it not entered."""
        mission, row = self.mission, self.row
        if mission is None or self.phase is not Phase.STANDING or not row.position_known:
            self._note("give_back_refused", why="the train does not stand at a known place")
            return self._taken()
        here_m = row.position_m + row.bound_ahead_m
        ahead = tuple(
            s.section_id for s in mission.spans if s.start_m >= here_m and self.authority.holds(s.section_id)
        )
        own = mission.spans[mission.span_index(mission.targets[self.at].section_id)]
        if row.speed_mps > 0.0 or here_m >= own.end_m:
            self._note("give_back_refused", why="the train may have entered the route")
            return self._taken()
        self._ready_s = now_s + hold_s + self.facts.parameters.request_lead_s
        self._wanted = ()
        self._note("gave_back", sections=ahead)
        self._authority(auth.GiveBack(ahead), now_s)
        return self._done(now_s)

    def arrived_on_sight(self, index: int, now_s: float) -> list[UnitAction]:
        """A train without a position has been brought to a stand at a target by its driver."""
        self.stands_at = index
        self.at = index
        self._ready_s = now_s + self.facts.parameters.dwell_min_s
        target = None if self.mission is None else self.mission.targets[index]
        if target is not None:
            self._note("arrived", station=target.station_id or target.section_id, error_m=None)
            rear_m = target.mark_m - ARRIVED_ON_SIGHT_WITHIN_M - float(self._train.length_m)
            cleared = cleared_sections(self.mission, self.authority, rear_m) if self.mission else ()
            if cleared:  # the crew sees the mark, and that the whole train has arrived (到着確認)
                self._authority(auth.Cleared(cleared), now_s)
        return self._done(now_s)

    def _take_up(self, mission: Mission, path: NDArray[np.void], ready_s: float) -> None:
        self.mission = mission
        self.at = 0
        self.stands_at = None
        self._elevation_m = np.ascontiguousarray(path["elevation_m"])
        self._driving_mps = np.ascontiguousarray(path["driving_mps"])
        self._tags = {tag.tag_id: tag for tag in mission.tags}
        self._doubt.new_path(mission.tags)
        self._wanted = ()
        self._entered = frozenset()
        self._ready_s = ready_s
        self.row.mode = MODE_HOLD
        self.row.cruise_mps = math.inf
        self.row.target_stop_m = self.row.position_m
        self._note("mission", train=mission.number, direction=mission.direction.name.lower())

    def change_ends(self, now_s: float) -> list[UnitAction]:
        """The driver has changed ends; the next mission follows with `begin`."""
        self._authority(auth.TurnedBack(), now_s)
        self._note("changed_ends")
        return self._taken()

    def leave(self, now_s: float) -> list[UnitAction]:
        """Sign off at the portal."""
        self.phase = Phase.SIGNING_OFF
        self._authority(auth.EndOnLine(), now_s)
        return self._done(now_s)

    def receive(self, data: bytes, now_s: float) -> list[UnitAction]:
        """A telegram from the air."""
        opened = self._endpoint.open(data, now_s)
        if isinstance(opened, Dropped):
            self._note("telegram_dropped", source=opened.source or "?", reason=opened.reason.value)
            return self._taken()
        self._note(
            "took_effect",
            source=opened.source,
            epoch=opened.epoch,
            kind=type(opened.message).__name__,
            correlation=opened.correlation,
        )
        asked = self.authority.asked
        self._remember_entered()
        heard = auth.Heard(opened.source, opened.message, opened.fresh, opened.correlation)
        self._authority(heard, now_s)
        if asked is not None and self.authority.asked is None and self.mission is not None:
            self._wanted += departure_points(self.mission, asked.from_section)
        return self._done(now_s)

    def tag_read(self, tag_id: int, odometer_m: float, now_s: float) -> list[UnitAction]:
        """The reader read a tag when the tachometer stood at `odometer_m`."""
        tag = self._tags.get(tag_id)
        tolerance_m = self.facts.parameters.tag_accuracy_m
        if (
            tag is None
            or missed_by_m(self.row, tag_fix(self.row, tag.position_m, odometer_m, tolerance_m)) > 0.0
        ):
            self._position_fault(f"tag {tag_id} where none can be", now_s)
            return self._done(now_s)
        if not self._doubt.believes(tag, odometer_m):
            self._note("tag_doubted", tag=tag_id)
            return self._done(now_s)
        self._doubt.take(tag, odometer_m)
        was_known = self.row.position_known == 1
        taken = take(self.row, tag_fix(self.row, tag.position_m, odometer_m, tolerance_m))
        correction_m = taken.correction_m if isinstance(taken, Taken) else 0.0
        self._note("tag_read", tag=tag_id, purpose=tag.purpose.value, correction_m=round(correction_m, 3))
        self._expect_tag(tag.position_m)
        if not was_known:
            self._position_found(now_s)
        self._approach(tag, now_s)
        return self._done(now_s)

    def frame_taken(self, distance_m: float | None) -> list[UnitAction]:
        """The camera looked for the sign of the next mark: `distance_m` from the front to the sign, None: not seen."""
        if self.phase is not Phase.RUNNING or self.mission is None:
            return self._taken()
        target = self.mission.targets[self.at + 1]
        taken = None
        if distance_m is not None and self.row.position_known:
            taken = take(self.row, sign_fix(self.row, target.mark_m, float(distance_m)))
        if isinstance(taken, Taken) and self._sighted != target:
            self._sighted = target
            self._note("sign_seen", station=target.station_id, correction_m=round(taken.correction_m, 3))
        if self._sighted != target and target.mark_m - self.row.position_m < NOT_SEEN_M:
            self._impossible(Verdict.TARGET_NOT_SEEN)
        return self._taken()

    def events(self, bits: int, now_s: float) -> list[UnitAction]:
        """What the compiled tick reported."""
        if bits & EVENT_TACHOMETER:
            self._note("tachometer_fault", speed_mps=round(float(self.row.speed_mps), 2))
            self._position_fault("the tachometer shows what cannot be", now_s)
        if bits & EVENT_VERDICT:
            self._note_impossible()
        if bits & EVENT_TAG_OVERDUE:
            if self.phase is Phase.RUNNING:
                self._impossible(Verdict.TARGET_NOT_SEEN)
            self._position_fault("expected tag was not read", now_s)
        if bits & EVENT_INTERVENTION:
            self._note("intervention", level=int(self.row.intervention))
        if bits & EVENT_MOVING and self.phase is Phase.RUNNING:
            self._note("moving")
        if bits & EVENT_STOPPED:
            self._stopped(now_s)
        if bits & EVENT_POSITION:  # the radio reaches again
            self._authority(auth.Tick(), now_s)
        return self._done(now_s)

    def timer(self, now_s: float) -> list[UnitAction]:
        """A time asked for with `wake_at_s` has come."""
        if now_s >= self._release_emergency_s:
            self._release_emergency_s = math.inf
            self.row.intervention = NO_INTERVENTION
            self._note("emergency_released")
            self._choose_cruise(now_s)
        self._authority(auth.Tick(), now_s)
        return self._done(now_s)

    def waits_for(self) -> str:
        """What the train waits for, in words, for whoever looks on when nothing moves."""
        if self.phase in (Phase.SIGNING_ON, Phase.SIGNING_OFF):
            return f"{self.phase.value}: {self.authority.refusal or 'no answer from the block manager'}"
        if self.authority.asked is not None:
            why = self.authority.refusal or "no answer from the block manager"
            return f"route {self.authority.asked.id}: {why}"
        if self.authority.commands:
            command = self.authority.commands[0]
            return f"points {command.needed.points_id}: {command.refusal or 'not proven'}"
        if self.row.intervention == EMERGENCY_INTERVENTION:
            return "release of the emergency brake"
        if self.phase is Phase.STANDING:
            return "departure time"
        return "nothing" if self.row.position_known else "a tag: its position is unknown"

    # parts --------------------------------------------------------------------------------------------------

    def _authority(self, event: auth.Event, now_s: float) -> None:
        self.authority, actions = auth.step(self.authority, event, now_s, self._covered())
        for action in actions:
            if isinstance(action, auth.Send):
                self._send(action.destination, action.message, action.correlation, now_s)
            else:
                self._note(action.what, **action.data)

    def _send(self, destination: str, message: AnyMessage, correlation: int, now_s: float) -> None:
        data = self._endpoint.seal(destination, message, now_s, correlation)
        self._actions.append(Transmit(destination, type(message).__name__, data))

    def _note(self, what: str, **data: object) -> None:
        self._actions.append(Noted(what, data))

    def _taken(self) -> list[UnitAction]:
        actions, self._actions = self._actions, []
        return actions

    def _done(self, now_s: float) -> list[UnitAction]:
        self._think(now_s)
        return self._taken()

    def _covered(self) -> bool:
        mission = self.mission
        if mission is None or not self.row.position_known:
            return True  # who does not know where it is can only try
        return covered_at(self.facts.line, mission.path, self.row.position_m)

    def _expect_tag(self, after_m: float | None = None) -> None:
        if self.mission is None:
            return
        # A tag within the bound may lie behind already: none is due before the front is surely short of it.
        beyond_m = self.row.position_m + self.row.bound_ahead_m if after_m is None else after_m
        ahead = (tag.position_m for tag in self.mission.tags if tag.position_m > beyond_m + 0.1)
        self.row.expected_tag_m = next(ahead, math.inf)

    def _position_fault(self, why: str, now_s: float) -> None:
        """The position cannot be trusted: stop, then on sight to a tag (位置検知異常による停止制御, table 5)."""
        self._note("position_fault", why=why)
        self._doubt.begin()
        if self.phase in (Phase.RUNNING, Phase.STANDING):
            self.stands_at = self.at if self.phase is Phase.STANDING else None
            self.phase = Phase.RESTARTED
        self.row.expected_tag_m = self.row.rear_trigger_m = self.row.position_trigger_m = math.inf
        self.row.position_known = 0
        self.row.restricted_mps = self.facts.parameters.restricted_mps
        self.row.intervention = EMERGENCY_INTERVENTION
        if self.row.speed_mps == 0.0:
            self._release_emergency_s = now_s + self.facts.parameters.emergency_release_s

    def _position_found(self, now_s: float) -> None:
        """A tag has told where the train is; what it holds has not changed, so it runs normally again."""
        self._note("position_found")
        if self.phase is Phase.RESTARTED:
            return
        self.row.restricted_mps = math.inf
        self._choose_cruise(now_s)

    def _approach(self, tag: PathTag, now_s: float) -> None:
        """At the approach tag (④), or at the next one if that was not read: arrival points, next route."""
        if self.mission is None:
            return
        passed = [t for t in self.mission.tags if t.position_m <= tag.position_m]
        approach = next((t for t in reversed(passed) if t.purpose is TagPurpose.APPROACH), None)
        newer = [t for t in passed if approach is not None and t.position_m >= approach.position_m]
        if approach is None or any(t.purpose is TagPurpose.ARRIVAL for t in newer):
            return
        self._wanted += arrival_points(self.mission, approach.position_m)
        self._ask_beyond(now_s)

    def _stopped(self, now_s: float) -> None:
        if self.row.intervention == EMERGENCY_INTERVENTION:
            self._release_emergency_s = now_s + self.facts.parameters.emergency_release_s
        if self.phase is not Phase.RUNNING or self.mission is None:
            return
        target = self.mission.targets[self.at + 1]
        away_m = float(self.row.position_m) - target.mark_m
        if away_m < -ARRIVED_WITHIN_M and self.row.bound_ahead_m > self.facts.parameters.doubt_bound_max_m:
            self._position_fault("the bounds leave no room to go on", now_s)
            return
        if away_m < -WEAK_TOLERANCE_M and self._stands_at_limit_of(target):
            self._impossible(Verdict.SIGN_BEYOND_LIMIT)
        elif away_m < -ARRIVED_WITHIN_M:
            self._note("stopped_short", short_m=round(-away_m, 2), why=self.limit.reason)
            self.row.braking_to_stop = 0
            self._ask_onward(now_s)
            return
        if away_m > ARRIVED_WITHIN_M:  # no train sets back here: it counts as arrived, as far as it went
            self._note("overran", beyond_m=round(away_m, 2))
        self.at += 1
        self.phase = Phase.STANDING
        self.row.mode = MODE_HOLD
        self._ready_s = now_s + self.facts.parameters.dwell_min_s
        self._note("arrived", station=target.station_id or target.section_id, error_m=round(away_m, 3))
        learned = self.keeper.stopped(self._train, self._behaviour, self.load_share)
        if learned is not None:
            self._note("learned", **learned)

    def _stands_at_limit_of(self, target: Target) -> bool:
        """Whether the train went as far as it may on the track where it calls, and the mark lies beyond that."""
        reach_m = self.limit.limit_m - self.row.bound_ahead_m - LIMIT_MARGIN_M - RESERVE_M
        if self.mission is None or target.mark_m < reach_m:
            return False
        return self.mission.span_at(self.row.position_m).section_id == target.section_id

    def _impossible(self, verdict: Verdict) -> None:
        """The stop at the next mark cannot be made as it should; the first reason found stands."""
        if self.keeper.verdict() is Verdict.POSSIBLE:
            judge(self.keeper.tasc, int(verdict))
            self.row.stop_verdict = int(verdict)
            self._note_impossible()

    def _note_impossible(self) -> None:
        if self.mission is None or self.at + 1 >= len(self.mission.targets):
            return
        target = self.mission.targets[self.at + 1]
        why = self.keeper.verdict().name.lower().replace("_", " ")
        self._note("stop_impossible", why=why, station=target.station_id or target.section_id)

    def _ask_onward(self, now_s: float) -> None:
        """A train that stands on a track, its route from there not held (lost, or never asked), asks for it."""
        if self.mission is None or self.authority.asked is not None:
            return
        span = self.mission.span_at(self.row.position_m)
        route = self.mission.route_beyond(span.section_id)
        if route is not None and not all(self.authority.holds(s) for s in route.section_ids):
            self._authority(auth.Ask(route), now_s)

    def _ask_beyond(self, now_s: float) -> None:
        """A train that does not call at the next track asks for the route beyond it on the approach."""
        if self.mission is None:
            return
        position_m = self.row.position_m
        ahead = (s for s in self.mission.spans if s.start_m > position_m and s.kind is SectionKind.TRACK)
        track = next(ahead, None)
        if track is None or any(t.section_id == track.section_id for t in self.mission.targets):
            return
        route = self.mission.route_beyond(track.section_id)
        if route is not None:
            self._authority(auth.Ask(route), now_s)

    def _think(self, now_s: float) -> None:
        """What follows from the state as it is now."""
        mission = self.mission
        if mission is None or self.phase is Phase.GONE:
            return
        self.wake_at_s = self._release_emergency_s
        if self.phase is Phase.SIGNING_ON and self.authority.on_line:
            self.phase = Phase.STANDING
        if self.phase is Phase.SIGNING_OFF and not self.authority.on_line:
            self.phase = Phase.GONE
            self._actions.append(LeftLine())
            return
        row = self.row
        if self.phase is Phase.RESTARTED and not self._recovered(mission, now_s):
            self.wake_at_s = min(self.wake_at_s, self.authority.next_timer_s())
            return
        if row.position_known:
            rear_m = float(row.position_m - row.bound_behind_m - self._train.length_m)
            rear_m -= self._doubt.release_margin_m(standing=self.phase is Phase.STANDING)
            cleared = cleared_sections(mission, self.authority, rear_m)
            if cleared:
                self._authority(auth.Cleared(cleared), now_s)
            self._remember_entered()
            self._withdraw_throws(mission, now_s)
            self._throw_wanted(mission, now_s)
        self._set_limit(mission, now_s)
        if self.phase is Phase.STANDING:
            self._stand(mission, now_s)
        if self.phase is Phase.RUNNING:
            self._aim(mission)
        end_m = next_rear_trigger_m(mission, self.authority)
        row.rear_trigger_m = self._doubt.release_trigger_m(end_m, self._train.length_m)
        row.position_trigger_m = math.inf
        timer_s = self.authority.next_timer_s()
        if auth.waiting_for_radio(self.authority):
            row.position_trigger_m = next_coverage_m(self.facts.line, mission.path, row.position_m)
        else:
            self.wake_at_s = min(self.wake_at_s, timer_s)

    def _recovered(self, mission: Mission, now_s: float) -> bool:
        """On sight: normal running once a tag has told the position and the manager the holdings."""
        row = self.row
        if row.position_known and self.authority.on_line:
            self._resume(mission, now_s)
            return True
        if self.stands_at == len(mission.targets) - 1 and self.authority.on_line:
            row.mode = MODE_HOLD
            self.phase = Phase.FINISHED
            self._actions.append(Finished(mission.number))
            return False
        span = mission.span_at(row.position_m) if row.position_known else None
        row.stop_limit_m = math.inf if span is None else span.end_m
        marks_m = [t.mark_m for t in mission.targets if t.mark_m > row.position_m + 1.0]
        aim_m = min(marks_m, default=math.inf) if row.position_known else math.inf
        if aim_m != row.target_stop_m:
            row.target_stop_m = aim_m
            row.braking_to_stop = 0
        may_run = row.intervention != EMERGENCY_INTERVENTION and now_s >= self._ready_s
        if self.stands_at is not None and self.stands_at + 1 < len(mission.targets):
            here = mission.targets[self.stands_at]
            leave_s = max(self._ready_s, -math.inf if here.departure_s is None else here.departure_s)
            may_run = may_run and now_s >= leave_s
            route = mission.route_beyond(here.section_id)
            missing = route is not None and not all(self.authority.holds(s) for s in route.section_ids)
            if route is not None and missing and self.authority.on_line and self.authority.asked is None:
                self._authority(auth.Ask(route), now_s)
            self.wake_at_s = min(self.wake_at_s, leave_s if now_s < leave_s else math.inf)
        self.wake_at_s = min(self.wake_at_s, self._ready_s if now_s < self._ready_s else math.inf)
        row.mode = MODE_DRIVE if may_run else MODE_HOLD
        return False

    def _resume(self, mission: Mission, now_s: float) -> None:
        """Everything is known again: which target comes next follows from the position."""
        row = self.row
        # Still moving, the mark just ahead is yet to be stopped at; one left before the fault is not.
        within_m = ARRIVED_WITHIN_M if row.speed_mps == 0.0 else -ARRIVED_WITHIN_M
        passed = [i for i, t in enumerate(mission.targets) if t.mark_m <= row.position_m + within_m]
        self.at = max(self.at, passed[-1] if passed else 0)
        row.restricted_mps = math.inf
        row.target_stop_m = row.position_m
        ahead = [
            s for s in mission.spans if s.start_m > row.position_m and self.authority.holds(s.section_id)
        ]
        departing = [
            s for s in ahead if not any(k.kind is SectionKind.BETWEEN for k in ahead[: ahead.index(s)])
        ]
        self._wanted += tuple(needed for span in departing for needed in points_of(span))
        # Beyond the last mark there is nowhere further to go: it counts as arrived, as far as it went.
        last_passed = self.at == len(mission.targets) - 1
        near = abs(mission.targets[self.at].mark_m - row.position_m) < ARRIVED_WITHIN_M
        stands = row.speed_mps == 0.0 and (near or last_passed)
        if not stands:  # beyond the last mark, that one is still to be reached
            self.at = min(self.at, len(mission.targets) - 2)
        self.phase = Phase.STANDING if stands else Phase.RUNNING
        row.mode = MODE_HOLD if stands else MODE_DRIVE
        self.stands_at = None
        # It was running on proofs when it lost its memory: those under the train have done their work.
        self._entered |= {
            s.section_id for s in mission.spans if s.start_m < row.position_m - row.bound_behind_m
        }
        self._note("resumed", next_target=self.at + 1)
        if stands and self.at > 0:  # it came here while it did not know
            target = mission.targets[self.at]
            away_m = round(float(row.position_m) - target.mark_m, 3)
            self._note("arrived", station=target.station_id or target.section_id, error_m=away_m)
        self._choose_cruise(now_s)

    def _remember_entered(self) -> None:
        """Points that the train has come onto by their proof, before anything can withdraw it."""
        row, mission = self.row, self.mission
        if mission is not None and row.position_known:
            certain_m = row.position_m - row.bound_behind_m
            self._entered |= entered_on_proof(mission, self.authority, certain_m)

    def _withdraw_throws(self, mission: Mission, now_s: float) -> None:
        """No points are asked to move once the front may have come onto them."""
        perhaps_m = self.row.position_m + self.row.bound_ahead_m
        sections = points_perhaps_under(mission, self.authority, perhaps_m)
        if sections:
            self._authority(auth.Withdrawn(tuple(sorted(sections))), now_s)

    def _throw_wanted(self, mission: Mission, now_s: float) -> None:
        """Command what is wanted and neither proven nor under way: anew, too, when a proof was withdrawn."""
        if not self._wanted:
            return
        position_m = self.row.position_m
        ahead = {s.section_id for s in mission.spans if s.start_m > position_m + self.row.bound_ahead_m}
        self._wanted = tuple(dict.fromkeys(n for n in self._wanted if n.section_id in ahead))
        under_way = {*self.authority.proven, *(command.needed for command in self.authority.commands)}
        missing = tuple(needed for needed in self._wanted if needed not in under_way)
        if missing:
            self._authority(auth.Throw(missing), now_s)

    def _set_limit(self, mission: Mission, now_s: float) -> None:
        limit = stop_limit(mission, self.authority, self._entered)
        if limit != self.limit:
            self.limit = limit
            if self.phase is Phase.RUNNING and self.row.speed_mps == 0.0:
                self._choose_cruise(now_s)
            piece_id, kilometrage_m = mission.path.locate(limit.limit_m)
            self._note(
                "stop_limit",
                kilometrage_m=round(kilometrage_m, 1),
                piece=piece_id,
                before=limit.before_section or "",
                why=limit.reason,
            )
        self.row.stop_limit_m = limit.limit_m

    def _stand(self, mission: Mission, now_s: float) -> None:
        """At a target: ask for the next route in time, leave when the time has come and the way is free."""
        if self.at + 1 >= len(mission.targets):
            if not self.authority.report_due:
                self.phase = Phase.FINISHED
                self._actions.append(Finished(mission.number))
            return
        here = mission.targets[self.at]
        leave_s = max(self._ready_s, -math.inf if here.departure_s is None else here.departure_s)
        route = mission.route_beyond(here.section_id)
        missing = route is not None and not all(self.authority.holds(s) for s in route.section_ids)
        ask_s = leave_s - self.facts.parameters.request_lead_s
        if route is not None and missing and self.authority.asked is None:
            if now_s >= ask_s:
                self._authority(auth.Ask(route), now_s)
            else:
                self.wake_at_s = min(self.wake_at_s, ask_s)
        if now_s < leave_s:
            self.wake_at_s = min(self.wake_at_s, leave_s)
        elif self._way_is_free(mission, here):
            self._leave_target(mission, now_s)

    def _way_is_free(self, mission: Mission, here: Target) -> bool:
        """The stop limit lies beyond the track where the train stands: no start towards points not proven."""
        end_m = mission.spans[mission.span_index(here.section_id)].end_m
        room_m = self.limit.limit_m - self.row.position_m
        beyond = self.limit.limit_m > end_m or self.limit.before_section is None
        on_track = mission.route_beyond(here.section_id) is not None
        return room_m > 2.0 * self.facts.parameters.standoff_m and (beyond or not on_track)

    def _leave_target(self, mission: Mission, now_s: float) -> None:
        self.row.braking_to_stop = 0
        self.row.mode = MODE_DRIVE
        self.row.target_stop_m = self.row.position_m
        self.phase = Phase.RUNNING
        self._choose_cruise(now_s)
        station = mission.targets[self.at].station_id
        self._note("departs", station=station or mission.targets[self.at].section_id)

    def _choose_cruise(self, now_s: float) -> None:
        """Cruising speed for what is left of the way to the next target and of the time."""
        if self.mission is None or self.phase is not Phase.RUNNING:
            return
        parameters = self.facts.parameters
        there = self.mission.targets[self.at + 1]
        due_s = there.arrival_s
        if due_s is not None and there.departure_s is not None:
            due_s = min(due_s, there.departure_s - parameters.dwell_min_s)
        self.row.cruise_mps = math.inf
        self.row.due_s = math.inf if due_s is None else due_s - parameters.time_margin_s
        if due_s is None or there.mark_m <= self.row.position_m:
            return
        self.row.cruise_mps = cruise_for(
            self._train,
            self.load_share,
            self._elevation_m,
            self._driving_mps,
            self.row.position_m,
            there.mark_m,
            due_s - now_s - parameters.time_margin_s,
            self._behaviour.stop_deceleration_mps2,
            float(self.row.speed_mps),
        )

    def _aim(self, mission: Mission) -> None:
        """The front stops at the next mark, or before the stop limit if that comes first."""
        mark_m = mission.targets[self.at + 1].mark_m
        limit_m = self.limit.limit_m
        aim_m = mark_m if mark_m < limit_m else limit_m - self.facts.parameters.standoff_m
        if aim_m > self.row.target_stop_m + 0.01:
            self.row.braking_to_stop = 0
        self.row.target_stop_m = aim_m
