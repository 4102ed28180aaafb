"""The driving part of the on-board unit between its events: from metres to joints, and from the command to the tick.

It stands beside the compiled tick and shares its row: takes tags, signs and what the tick reports, keeps the position
and its bounds true to the plan's joints, and sets what the tick works to (stop limit, mark, cruising speed, what to
watch for). What the train may do is decided by the duty (`onboard.duty`); nothing here grants anything.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from network.model import Line
from onboard import notes, records
from onboard.ability import Ability, Means, WayAhead
from onboard.authority.coverage import covered_at, next_coverage_m
from onboard.charge import ChargeWatch
from onboard.crossings.ahead import CrossingsAhead
from onboard.driving.laws.table import LawsRow, note_of_run
from onboard.driving.pace import Pace
from onboard.driving.planner.plan import PlanOnPath
from onboard.driving.planner.wish import PLAIN, Planning
from onboard.driving.stop_keeper import StopKeeper
from onboard.driving.stopping import aim_within, limit_is_short
from onboard.driving.tasc import WEAK_TOLERANCE_M, StopVerdict, judge
from onboard.duty.records import (
    AtMark,
    DrivingCommand,
    DrivingOrder,
    FoundByOtherSensor,
    Looked,
    MarkRelation,
    PlaceInJoints,
    PositionLost,
    Sensed,
    Stopped,
    TagBelieved,
    VehicleChecked,
    WheelsTurning,
)
from onboard.duty.unable import Unable
from onboard.fixes import ROOM_M, Fixes
from onboard.localisation.table import READERS_ROW, ReadersRow
from onboard.localisation.tags import TagDoubt, TagOutcome, Wheels
from onboard.localisation.wheel_scale import FrontAtCount
from onboard.mission import Mission, PathTag, Target, front_on
from onboard.unit_records import UnitParameters
from onboard.vehicle import IN_ORDER, VehicleInputs
from vehicle.record import cells_of
from vehicle.records import TrainRow
from vehicle.wheel import pulse_m

STANDS_WITHIN_M: Final = 0.01  # a train that has come this far has begun to move
NO_ROOM: Final = "the bounds leave no room to go on"
ARRIVED_WITHIN_M: Final = 5.0  # stood this near the mark, the train has arrived


class UnitMotion:
    """The driving part of one unit. `row` is its row of UNIT (a numpy record), shared with the compiled tick."""

    def __init__(
        self,
        line: Line,
        parameters: UnitParameters,
        row: records.UnitRow,
        train: TrainRow,
        behaviour: records.BehaviourRow,
        keeper: StopKeeper,
        readers: ReadersRow | None = None,
        laws: LawsRow | None = None,
        planning: Planning = PLAIN,
        *,
        reads_tags: bool = True,
        charge: ChargeWatch | None = None,  # of a set that runs on a battery
        before: UnitMotion | None = None,  # the unit was switched off
    ) -> None:
        self.row: Final = cells_of(records.UnitRow, row)
        self._record: Final = row  # the same memory, as compiled code takes it
        fresh: Any = np.zeros(1, READERS_ROW).view(np.recarray)[0] if readers is None else readers
        self.readers: Final[Any] = cells_of(ReadersRow, fresh)
        self.keeper: Final = keeper
        self.command = DrivingCommand()
        self.load_share: float = 0.0 if before is None else before.load_share
        self.adhesion_factor = 1.0  # the least of the day's weather, of the dry rail's
        self.vehicle: VehicleInputs = IN_ORDER if before is None else before.vehicle
        self.charge = charge
        self.reads_tags = reads_tags  # a train without a reader expects none
        self.notes: Final[list[notes.Note]] = []
        row.due_s = row.replan_s = math.inf
        row.axles_differ_share = parameters.wheel_varies_share
        row.pulse_m, row.believes_wheels = pulse_m(train), int(parameters.believes_wheels)
        self._line: Final = line
        self._parameters: Final = parameters
        self._train: Final = train
        self._length_m: Final = float(train.length_m)
        self._behaviour: Final = behaviour
        self._mission: Mission | None = None
        # The one on whose path its coordinates are.
        self._placed: Mission | None = None if before is None else before._placed
        self._starts_m, self._ends_m = list[float](), list[float]()
        self._joints_m, self._marks_m = list[float](), list[float]()
        self._tags: Mapping[int, tuple[int, PathTag]] = {}
        self._doubt: Final = TagDoubt(self.row, parameters, row)
        self._ability: Final = Ability()
        self._fixes: Final = Fixes(self._doubt, row, self.readers, parameters, self._length_m, self.notes)
        self._found = self._off_plan = False
        self._to_be_seen = False  # stands as at a stop, and only its driver sees whether that is one
        self._due_m = math.inf  # place of the tag that is expected, also once it is overdue
        self._laws: Final = laws
        self._pace: Final = Pace(parameters, row, train, behaviour, laws, planning)
        self.crossings: Final = CrossingsAhead(line, parameters, self.row, train, behaviour, self._pace)
        self._stood_m: float | None = None  # the tachometer at the last stand, while it stands
        self._look_for_sign(None)

    # the path that the train is on ------------------------------------------------------------------------------

    def stand_at_start(self, mission: Mission, path: records.PathData, odometer_m: float) -> None:
        """The crew has entered a train number at its first mark: that is where the train stands."""
        row = self.row
        row.odometer_m, row.odometer_scale = odometer_m, row.odometer_scale or 1.0
        self._doubt.position_told()
        row.position_m = mission.targets[0].mark_m
        row.bound_ahead_m = row.bound_behind_m = self._parameters.tag_accuracy_m + row.pulse_m
        row.position_known = 1
        row.tag_window_m = self._parameters.tag_window_m
        self._take_up(mission, path)

    def go_on(self, mission: Mission, path: records.PathData) -> None:
        """Another train number in the same direction: the same place on another path."""
        kept = self._doubt.leave_path(turned=False)
        self.row.position_m = front_on(mission, self._placed, float(self.row.position_m), self._length_m)
        self._take_up(mission, path, kept)

    def turn(self, mission: Mission, path: records.PathData) -> None:
        """The driver has changed ends: what was the rear is the front, on the next mission's path."""
        row = self.row
        kept = self._doubt.leave_path(turned=True)
        row.position_m = front_on(mission, self._placed, float(row.position_m), self._length_m)
        row.bound_ahead_m, row.bound_behind_m = row.bound_behind_m, row.bound_ahead_m
        self._take_up(mission, path, kept)

    def switch_on(
        self, mission: Mission, path: records.PathData, odometer_m: float, speed_mps: float
    ) -> None:
        """A unit that boots: position forgotten, the emergency brake applied, its sensors as they show now."""
        row = self.row
        row.odometer_m, row.odometer_scale = odometer_m, 1.0
        row.position_m = front_on(mission, self._placed, float(row.position_m), self._length_m)
        row.speed_mps, row.boots = speed_mps, row.boots + 1
        self._doubt.position_told()
        row.tag_window_m = self._parameters.tag_window_m
        self._take_up(mission, path)
        row.position_known = 0
        row.expected_tag_m = row.rear_trigger_m = row.position_trigger_m = row.stop_limit_m = math.inf
        row.intervention = records.EMERGENCY_INTERVENTION

    def _take_up(self, mission: Mission, path: records.PathData, kept: Sequence[FrontAtCount] = ()) -> None:
        row = self.row
        self._mission, self._placed, self._off_plan = mission, mission, False
        self._starts_m, self._ends_m = [x.start_m for x in mission.spans], [x.end_m for x in mission.spans]
        self._joints_m = [*self._starts_m, self._ends_m[-1]]
        self._marks_m = [target.mark_m for target in mission.targets]
        self._tags = {tag.tag_id: (index, tag) for index, tag in enumerate(mission.tags)}
        self._doubt.new_path(mission.tags, kept)
        row.path_offset, row.path_rows = path.offset, len(path.rows)
        row.places_offset, row.places_rows = path.places_offset, path.places_rows
        row.paths_taken_up += 1
        self._fixes.take_up(mission, virtual=not self.reads_tags)
        self._pace.take_up(path.rows)
        self.crossings.take_up(mission)
        row.mode = records.MODE_HOLD
        row.target_stop_m = row.mark_m = row.position_m
        self._expect_tag()

    def taken_plan(self) -> PlanOnPath | None:
        """The plan for this path that was made since the last call, to be laid and followed."""
        return self._pace.taken_plan()

    def follow(self, offset: int, rows: int) -> None:
        """Take up a plan for this path that lies at `offset` of the pool; no rows: none any more."""
        self.row.plan_offset, self.row.plan_rows = offset, rows

    # what is reported to the duty ---------------------------------------------------------------------------------

    def place(self) -> PlaceInJoints:
        """Where the train is now, in joints of the plan."""
        row, mission = self.row, self._mission
        emergency = bool(row.intervention == records.EMERGENCY_INTERVENTION)
        stands = bool(row.speed_mps == 0.0)
        if mission is None or not row.position_known:  # who does not know where it is can only try the radio
            return PlaceInJoints(stands=stands, emergency=emergency, unfit=self.vehicle.unfit)
        position_m = float(row.position_m)
        rear_m = position_m - float(row.bound_behind_m) - self._length_m
        joints_m, marks_m = self._joints_m, self._marks_m
        # Still moving, the mark just ahead is yet to be stopped at; one left before is not.
        within_m = ARRIVED_WITHIN_M if stands else -ARRIVED_WITHIN_M
        near = bisect_right(marks_m, position_m - ARRIVED_WITHIN_M)
        near = near if near < len(marks_m) and marks_m[near] < position_m + ARRIVED_WITHIN_M else -1
        return PlaceInJoints(
            known=True,
            covered=covered_at(self._line, mission.path, position_m),
            stands=stands,
            emergency=emergency,
            here=max(bisect_right(self._starts_m, position_m) - 1, 0),
            sure=bisect_right(self._starts_m, position_m - float(row.bound_behind_m)),
            perhaps=bisect_right(self._starts_m, position_m + float(row.bound_ahead_m)),
            clear=bisect_right(self._ends_m, rear_m - self._doubt.release_margin_m(standing=False)),
            clear_at_mark=bisect_right(self._ends_m, rear_m),
            reach=bisect_right(joints_m, position_m + 2.0 * self._parameters.standoff_m),
            near=near,
            passed=max(bisect_right(marks_m, position_m + within_m) - 1, 0),
            unfit=self.vehicle.unfit,
            unable=self._unable(mission, near) if stands and near >= 0 else None,
            unsure=stands and (self._to_be_seen or (near >= 0 and self._fixes.unsure)),
            untold=self._fixes.untold,
        )

    def _unable(self, mission: Mission, at: int) -> Unable | None:
        """Why the train could not reach the next stop if it left the one where it stands now."""
        way = WayAhead(mission, at, float(self.row.position_m), self._pace.climb_m, self._pace.driving_mps)
        means = Means(self._train, self._behaviour, self.load_share, self.vehicle, self.adhesion_factor)
        why = self._ability.why_not(way, means)
        return why if why or self.charge is None else self.charge.why_not(mission, at)

    def vehicle_shows(self, vehicle: VehicleInputs) -> list[Sensed]:
        """What the vehicle shows of itself now."""
        before, self.vehicle = self.vehicle, vehicle
        looked: list[Sensed] = [Looked()] if vehicle != before else []
        return [VehicleChecked()] if vehicle.unfit != before.unfit else looked

    def taken_notes(self) -> list[notes.Note]:
        """Lines of the journal since the last call."""
        taken = self.notes.copy()
        self.notes.clear()
        return taken

    def at_mark(self, event: AtMark) -> list[Sensed]:
        """The driver's eye has told where the train stands, which a unit that reads tags does not go by."""
        self._to_be_seen = False
        return self._taken_up(self._fixes.at_mark(event, self.command))

    def _taken_up(self, of_fixes: list[Sensed]) -> list[Sensed]:
        """What fixes mean to the duty; who has found its position runs on from there."""
        if any(isinstance(each, FoundByOtherSensor) for each in of_fixes):
            self._found = True
            self._expect_tag()
        return of_fixes

    def tag_read(self, tag_id: int, odometer_m: float) -> list[Sensed]:
        """The reader read a tag when the tachometer stood at `odometer_m`."""
        known = self._tags.get(tag_id)
        odometer_m += self.row.odometer_off_m
        self._fixes.stand_back()
        if self._shows_stand() and not (known and self._reaches(known[1])):
            return self._lose("a tag was passed while the tachometer shows a stand", Wheels.FALSE)
        if known is None:
            self._fixes.tag_of_another_path()
            return self._lose(f"tag {tag_id} where none can be", Wheels.SOUND)
        row, (index, tag) = self.row, known
        found = bool(row.position_known != 1)
        heard, correction_m = self._doubt.tag_read(tag, odometer_m)
        if heard is TagOutcome.OUT:
            return self._lose(f"tag {tag_id} where none can be", self._doubt.wheels_by_tag(tag, odometer_m))
        if heard is not TagOutcome.BELIEVED:
            self.notes.append(notes.TagDoubted(tag_id=tag_id))
            self._expect_tag()
            return []
        self._expect_tag(tag.position_m)
        self._fixes.tag_believed(tag, correction_m)
        self._found = self._found or found
        return [TagBelieved(index, found)]

    def _shows_stand(self) -> bool:
        """Whether the tachometer shows that the train has not moved since it came to a stand."""
        return self._stood_m is not None and abs(self.row.odometer_m - self._stood_m) < STANDS_WITHIN_M

    def _reaches(self, tag: PathTag) -> bool:
        """Whether a tag lies under the front as it stands: it may be read at the last or the first centimetre."""
        row, within_m = self.row, self._parameters.tag_accuracy_m
        return bool(row.position_known == 1 and abs(tag.position_m - row.position_m) <= within_m)

    def events(self, bits: int) -> list[Sensed]:
        """What the compiled tick reported."""
        row = self.row
        happened: list[Sensed] = []
        if bits & records.EVENT_TACHOMETER:
            self.notes.append(notes.TachometerFault(speed_mps=round(float(row.speed_mps), 2)))
            wheels = Wheels.FALSE if row.wheel_slide == 0 else Wheels.DOUBTED
            happened += self._lose("the tachometer shows what cannot be", wheels)
        if bits & records.EVENT_FIX and self._fixes.sign_missed(self._next_target()):
            self._impossible(StopVerdict.TARGET_NOT_SEEN)
        if bits & records.EVENT_CONTRADICTED and not self.reads_tags and row.position_known:
            happened += self._lose("fixes miss the bounds of the position")
        happened += self._taken_up(self._fixes.take_events(bits, self.command))
        if bits & records.EVENT_VERDICT:
            self._note_impossible()
        if bits & records.EVENT_TAG_OVERDUE:
            if self.command.target is not None:
                self._impossible(StopVerdict.TARGET_NOT_SEEN)
            happened += self._lose("expected tag was not read", self._doubt.wheels_by_overdue(self._due_m))
        if bits & records.EVENT_INTERVENTION:
            self.notes.append(notes.Intervention(level=int(row.intervention)))
        if bits & records.EVENT_MOVING:
            self._stood_m = None
            happened.append(WheelsTurning())
        if bits & records.EVENT_STOPPED:
            self._stood_m = float(row.odometer_m)
            happened += self._stopped()
        if bits & records.EVENT_IDLE and not (bits & records.EVENT_STOPPED):
            happened += self._stands_idle()
        if bits & records.EVENT_OFF_PLAN:
            self._off_plan = True
        if bits & (records.EVENT_POSITION | records.EVENT_SAFE_REAR | records.EVENT_OFF_PLAN):
            happened.append(Looked())
        return happened

    def _look_for_sign(self, target: Target | None) -> None:
        """Go by the sign of this mark from now on."""
        mark_m = math.inf if target is None else target.mark_m
        if mark_m != self.readers.sign.mark_m:
            self.readers.sign.mark_m, self.readers.sign.seen = mark_m, 0
            self._fixes.forget_sign()

    def _stopped(self) -> list[Sensed]:
        row, target = self.row, self._next_target()
        if target is None or self.command.target is None or self.command.on_sight:
            return [Stopped(MarkRelation.AT, 0.0)]
        away_m = float(row.position_m) - target.mark_m
        to_mark_m = row.bound_ahead_m if away_m < 0.0 else row.bound_behind_m
        if abs(away_m) > ARRIVED_WITHIN_M and to_mark_m > self._parameters.doubt_bound_max_m:
            return self._lose(NO_ROOM)
        held_short = False
        if away_m < -WEAK_TOLERANCE_M and self._stands_at_limit_of(target):
            self._impossible(StopVerdict.SIGN_BEYOND_LIMIT)
            held_short = target.mark_m < row.stop_limit_m - ROOM_M
        elif away_m < -ARRIVED_WITHIN_M:
            row.braking_to_stop = 0
            return [Stopped(MarkRelation.SHORT, away_m)]
        self._to_be_seen = held_short or (target.station_id is not None and not self._fixes.narrow)
        run = None if self._laws is None else note_of_run(self._laws)
        learned = self.keeper.learn_from_stop(self._train, self._behaviour, self.load_share)
        self.notes.extend(note for note in (run, learned) if note is not None)
        return [Stopped(MarkRelation.BEYOND if away_m > ARRIVED_WITHIN_M else MarkRelation.AT, away_m)]

    def _stands_idle(self) -> list[Sensed]:
        """It may go on to its mark and does not: it is there, or its own bounds leave no room, which nothing mends."""
        row, target = self.row, self._next_target()
        if target is None or self.command.target is None or not row.position_known:
            return []
        tight = bool(row.position_m + row.bound_ahead_m + ROOM_M >= row.stop_limit_m)
        there = row.position_m >= target.mark_m - ARRIVED_WITHIN_M
        if there or (tight and self._stands_at_limit_of(target)):
            return self._stopped()
        return self._lose(NO_ROOM) if tight else []

    def _stands_at_limit_of(self, target: Target) -> bool:
        """Whether it went as far as it may on the track where it calls; not by a crossing or a late limit."""
        if self._mission is None:
            return False
        here, limit_m = self._mission.span_at(self.row.position_m), float(self.row.stop_limit_m)
        short = limit_is_short(self._record, target.mark_m) and target.mark_m <= limit_m
        return short and here.section_id == target.section_id

    def _next_target(self) -> Target | None:
        targets = () if self._mission is None else self._mission.targets[self.command.at + 1 :]
        return targets[0] if targets else None

    def _impossible(self, verdict: StopVerdict) -> None:
        """The stop at the next mark cannot be made as it should; the first reason found stands."""
        if self.keeper.verdict() is StopVerdict.POSSIBLE:
            judge(self.keeper.tasc, int(verdict))
            self.row.stop_verdict = int(verdict)
            self._note_impossible()

    def _note_impossible(self) -> None:
        if (target := self._next_target()) is not None:
            why = self.keeper.verdict().name.lower().replace("_", " ")
            self.notes.append(notes.StopImpossible(why=why, station=target.place_id))

    def _expect_tag(self, after_m: float | None = None) -> None:
        if self._mission is None or not self.reads_tags:
            self.row.expected_tag_m = math.inf
            return
        # A tag within the bound may lie behind already: none is due before the front is surely short of it.
        beyond_m = self.row.position_m + self.row.bound_ahead_m if after_m is None else after_m
        ahead = (tag.position_m for tag in self._mission.tags if tag.position_m > beyond_m + 0.1)
        self.row.expected_tag_m = self._due_m = next(ahead, math.inf)

    def _lose(self, why: str, wheels: Wheels = Wheels.DOUBTED) -> list[Sensed]:
        """The position cannot be trusted: stop, then on sight to a tag (位置検知異常による停止制御, table 5)."""
        row = self.row
        self.notes.append(notes.PositionFault(why=why))
        self._doubt.begin_doubt(wheels)
        self._fixes.doubt(tight=why == NO_ROOM)
        row.expected_tag_m = row.rear_trigger_m = row.position_trigger_m = math.inf
        row.position_known, self._to_be_seen = 0, False
        row.restricted_mps = self._pace.sight_mps
        row.intervention = records.EMERGENCY_INTERVENTION
        self._pace.give_up_plan()
        return [PositionLost()]

    # what the duty wants ------------------------------------------------------------------------------------------

    def obey(self, command: DrivingCommand, now_s: float) -> None:
        """Set what the tick works to."""
        row, roads, self.command = self.row, command.crossings, command
        if self.charge is not None:
            self.charge.told(command.unable)
        self._look_for_sign(None if command.target is None else self._next_target())
        if DrivingOrder.RELEASE in command.orders:
            row.intervention = records.NO_INTERVENTION
        if DrivingOrder.STOP in command.orders:
            row.intervention = records.EMERGENCY_INTERVENTION
        if DrivingOrder.LOSE in command.orders:
            self._lose(NO_ROOM)
        restricted = command.on_sight or command.sweeps or roads.creeps or not row.position_known
        row.restricted_mps = self._pace.sight_mps if restricted else math.inf
        if command.on_sight:
            self._run_on_sight(command)
        else:
            self._run(command, now_s)
        row.look_s, row.look_before_m = roads.look_s, self.crossings.start_m(roads.unless_on)
        self._found = False
        timed, ask_m = self._pace.timed, self._fixes.ask_m if row.position_known else math.inf
        row.position_trigger_m = min(math.inf if timed is None else timed.position_m, ask_m)
        if command.await_radio and row.position_known and self._mission is not None:
            covered_m = next_coverage_m(self._line, self._mission.path, row.position_m)
            row.position_trigger_m = min(row.position_trigger_m, covered_m)

    def _run_on_sight(self, command: DrivingCommand) -> None:
        """No further than the section it is in; to the next mark, if it knows where that is."""
        row, mission = self.row, self._mission
        self._pace.give_up_plan()
        row.rear_trigger_m, row.stop_limit_m, aim_m = self.crossings.clears_at_m(), math.inf, math.inf
        if row.position_known and mission is not None:
            row.stop_limit_m = mission.span_at(row.position_m).end_m
            aim_m = mission.mark_ahead_m(row.position_m, moves=bool(row.speed_mps > 0.0))
        if aim_m != row.target_stop_m:
            row.target_stop_m = row.mark_m = aim_m
            row.braking_to_stop = 0
        may_run = command.drive and row.intervention != records.EMERGENCY_INTERVENTION
        if self.charge is not None and mission is not None and command.stands_at is not None:
            self.charge.on_sight(mission, command.stands_at)
            may_run = may_run and not self.charge.connected
        row.mode = records.MODE_DRIVE if may_run else records.MODE_HOLD

    def _run(self, command: DrivingCommand, now_s: float) -> None:
        row, mission, roads = self.row, self._mission, command.crossings
        if mission is None:
            return
        limit_m = self.crossings.nearer(joint_m := self._joint_m(command.limit.joint), roads.guarded)
        moved, row.stop_limit_m = limit_m != row.stop_limit_m and row.speed_mps == 0.0, limit_m
        row.mode = records.MODE_DRIVE if command.drive else records.MODE_HOLD
        if DrivingOrder.DEPART in command.orders:
            row.braking_to_stop = 0
        if DrivingOrder.DEPART in command.orders or DrivingOrder.RESUME in command.orders:
            row.target_stop_m = row.mark_m = row.position_m
        if command.target is not None:
            there = mission.targets[command.target]
            if moved or command.orders or self._found or self._off_plan or self._pace.passed_by(there):
                self._pace.choose(mission, command.target, now_s, self.load_share)
                self._off_plan = False
            self._aim(there.mark_m, self.crossings.nearer(joint_m, roads.before))
        end_m = math.inf if command.rear is None else self._ends_m[command.rear]
        freed_m = self._doubt.release_trigger_m(end_m, self._length_m)
        row.rear_trigger_m = min(freed_m, self.crossings.clears_at_m())

    def _joint_m(self, joint: int) -> float:
        return self._starts_m[joint] if joint < len(self._starts_m) else self._ends_m[-1]

    def _aim(self, mark_m: float, limit_m: float) -> None:
        """The front stops at the next mark, or before the stop limit if that comes first."""
        row = self.row
        aim_m = aim_within(mark_m, limit_m, self._parameters.standoff_m)
        if aim_m > row.target_stop_m + 0.01:
            row.braking_to_stop = 0
        row.target_stop_m, row.mark_m = aim_m, mark_m
