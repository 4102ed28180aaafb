"""What each stock has on board: its unit, its driving part, its power. The one place where the world speaks to a unit.

The world tells a unit what sensors show and what its crew enters, and takes telegrams and commands from it; it never
writes what a unit believes. What the unit shows its driver is `shown`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import msgspec

from host.store import NotCommissioned
from host.units import Units
from network.path import Path
from onboard.charge import ChargeWatch
from onboard.driving.stop_keeper import StopKeeper, believed_dead_time_s, fill_design
from onboard.driving.tuning import Learned
from onboard.driving.tuning import StopDecelerations as StopWaves
from onboard.duty.records import (
    AtMark,
    Begin,
    ChangeEnds,
    DrivingCommand,
    Happening,
    Person,
    Sensed,
    SwitchedOn,
    TakeUpWay,
)
from onboard.mission import Mission
from onboard.motion import UnitMotion
from onboard.notes import Note
from onboard.plan import DutyPlan, plan_of
from onboard.records import PathData
from onboard.unit import Report, UnitAnswer
from simulation.clock import Clock
from simulation.faults.fault import VehiclePart
from simulation.setup import Setup
from simulation.world.charging import Charging
from simulation.world.roster import Duty
from simulation.world.trains import Trains


def new_keeper(trains: Trains, slot: int, *, learns: bool) -> StopKeeper:
    """A train's memory of its stops, with what it has learned on days before; it outlives the unit's boots."""
    train, stock_id = trains.kinds[slot], trains.stock_ids[slot]
    learned = trains.setup.learned.get(stock_id, Learned(stock_id, believed_dead_time_s(train)))
    fill_design(trains.designs[slot], train, trains.behaviours[slot], learned)
    return StopKeeper(trains.tascs[slot], trains.designs[slot], trains.waves[slot], learned, learns)


def new_motion(
    trains: Trains,
    slot: int,
    keeper: StopKeeper,
    charge: ChargeWatch | None = None,
    before: UnitMotion | None = None,
    *,
    by_hand: bool = False,
) -> UnitMotion:
    """The driving part of a unit that is switched on, `before` the one before that."""
    setup = trains.setup
    return UnitMotion(
        setup.believed_line,
        setup.unit,
        trains.units[slot],
        trains.kinds[slot],
        trains.behaviours[slot],
        keeper,
        trains.readers[slot],
        trains.laws[slot],
        setup.planning,
        reads_tags=trains.reads_tags(slot) and not by_hand,
        charge=charge,
        before=before,
    )


def path_data(trains: Trains, slot: int, path: Path) -> PathData:
    """A unit's path database of a path."""
    rows, pool = trains.rows_of(slot, path), trains.pool
    return PathData(pool.pattern_of(rows), rows.offset, rows.known_first, rows.known_end - rows.known_first)


class OnBoard:
    """The units of all stocks, by slot."""

    def __init__(self, setup: Setup, trains: Trains, units: Units, charging: Charging | None = None) -> None:
        self.unpowered: Final[set[int]] = set()
        self.uncommissioned: Final[set[int]] = set()  # of these, those that have power and lost their state
        self.numberless: Final[set[int]] = set()  # slots whose unit has power, and no train number yet
        self._charging: Final = charging
        self.clocks: Final = [Clock()] * len(trains.stock_ids)
        self.claims_besides: Final[
            dict[int, tuple[str, ...]]
        ] = {}  # what mad units claim that they do not hold
        self._setup: Final = setup
        self._trains: Final = trains
        self._units: Final = units
        self._plans: dict[tuple[str, int], DutyPlan] = {}
        self._keepers = [
            new_keeper(trains, slot, learns=setup.tuning.learn) for slot in range(len(trains.stock_ids))
        ]
        self._motions = [self._new_motion(slot) for slot in range(len(trains.stock_ids))]

    def _new_motion(self, slot: int, before: UnitMotion | None = None) -> UnitMotion:
        charge = None if self._charging is None else self._charging.watch_of(slot)
        return new_motion(self._trains, slot, self._keepers[slot], charge, before)

    # what people and sensors tell it ------------------------------------------------------------------------------

    def tell(
        self,
        slot: int,
        now_s: float,
        happened: Sequence[Happening] = (),
        telegrams: Sequence[bytes] = (),
    ) -> tuple[UnitAnswer, list[Note]] | None:
        """Put what happened to the unit; its answer, and all lines for the journal. None while it has no power.

        The unit is asked by its own clock; in the answer its wake is true time again. Its driver knows the weather, and
        by that how little the rail may hold.
        """
        if slot in self.unpowered:
            return None
        motion = self._motions[slot]
        motion.adhesion_factor = self._setup.scatter.adhesion_least(now_s)
        clock = self.clocks[slot]
        own_s = clock.shows(now_s)
        self._trains.truths[slot].clock_ahead_s = own_s - now_s
        if self._charging is not None:
            self._charging.unit_looks(slot, own_s)
        by_eye = [told for event in happened if isinstance(event, AtMark) for told in motion.at_mark(event)]
        report = Report(
            motion.place(),
            (*happened, *by_eye),
            self.claims_besides.get(slot, ()),
            motion.crossings.places(motion.load_share),
        )
        answer = self._units.advance(self._trains.stock_ids[slot], own_s, telegrams, report)
        motion.obey(answer.command, own_s)
        laid = motion.taken_plan()
        if laid is not None:
            motion.follow(self._trains.pool.lay_plan(slot, laid.rows.size, laid.rows), laid.rows.size)
        if answer.wake_at_s is not None:
            answer = msgspec.structs.replace(answer, wake_at_s=clock.true_s(answer.wake_at_s))
        return answer, [*motion.taken_notes(), *answer.notes]

    def await_number(self, slot: int) -> None:
        """Until its crew has entered a train number the outputs of a unit stay on the safe side."""
        self.numberless.add(slot)
        self._trains.truths[slot].powered = 0

    def _has_number(self, slot: int) -> None:
        self.numberless.discard(slot)
        self._trains.truths[slot].powered = 1

    def enter_number(self, slot: int, duty: Duty, *, comes_on_line: bool, turned: bool) -> list[Person]:
        """The crew enters a train number, after changing ends if it `turned`; what the unit is told of it."""
        motion, mission = self._motions[slot], duty.mission
        self._has_number(slot)
        path = self._path(slot, mission)
        begin = Begin(self._plan(slot, mission), comes_on_line)
        if comes_on_line:
            motion.stand_at_start(mission, path, float(self._trains.tachometers[slot].odometer_m))
            return [begin]
        if turned:
            motion.turn(mission, path)
            return [ChangeEnds(), begin]
        motion.go_on(mission, path)
        return [begin]

    def take_up_way(self, slot: int, duty: Duty) -> list[Person]:
        """The driver takes up another way of the same train; what the unit is told of it."""
        self._plans.pop((duty.mission.number, slot), None)
        self._motions[slot].go_on(duty.mission, self._path(slot, duty.mission))
        return [TakeUpWay(self._plan(slot, duty.mission))]

    def forget_plan(self, slot: int, duty: Duty) -> None:
        """A train to come has another way than was drawn up."""
        self._plans.pop((duty.mission.number, slot), None)

    def asks_crossing(self, slot: int, crossing_id: str) -> bool:
        """Whether the unit asks a level crossing on its way."""
        return self._motions[slot].crossings.asks(crossing_id)

    def tag_read(self, slot: int, tag_id: int, odometer_m: float) -> list[Sensed]:
        """The reader read a tag."""
        return [] if self._deaf(slot) else self._motions[slot].tag_read(tag_id, odometer_m)

    def tick_events(self, slot: int, bits: int) -> list[Sensed]:
        """The compiled tick reported."""
        return [] if self._deaf(slot) else self._motions[slot].events(bits)

    def _deaf(self, slot: int) -> bool:
        """Whether sensors tell the unit nothing: it is off, or knows of no path on which to look for anything."""
        return slot in self.unpowered or slot in self.numberless

    def is_out_of_order(self, slot: int) -> bool:
        """Whether something of the vehicle is not in order, as its inputs show it."""
        return bool(self._motions[slot].vehicle.unfit)

    def vehicle_shows(self, slot: int, part: VehiclePart, value: float) -> list[Sensed]:
        """What doors, brake or motors show from now on."""
        motion = self._motions[slot]
        events = motion.vehicle_shows(msgspec.structs.replace(motion.vehicle, **{part: value}))
        return [] if slot in self.unpowered else events

    def load_is(self, slot: int, share: float) -> None:
        """What the load sensor shows: 0 empty, 1 full."""
        self._motions[slot].load_share = share

    # by hand, the unit cut out ------------------------------------------------------------------------------------

    def take_by_hand(self, slot: int, duty: Duty) -> None:
        """A driver whose unit is off uses the driving part as his hands: a fresh one, that reads no tags."""
        motion = self._motions[slot] = new_motion(
            self._trains, slot, self._keepers[slot], before=self._motions[slot], by_hand=True
        )
        odometer_m = float(self._trains.tachometers[slot].odometer_m)
        motion.stand_at_start(duty.mission, self._path(slot, duty.mission), odometer_m)
        self._trains.truths[slot].powered = 1

    def drive_by_hand(self, slot: int, command: DrivingCommand, now_s: float) -> None:
        """He drives, or holds his train."""
        self._motions[slot].obey(command, now_s)

    # power --------------------------------------------------------------------------------------------------------

    def power_off(self, slot: int) -> None:
        """The unit dies: its outputs fall to the safe side, so the emergency brake applies itself."""
        self.unpowered.add(slot)
        self.numberless.discard(slot)
        self.uncommissioned.discard(slot)
        self._units.kill(self._trains.stock_ids[slot])
        self._trains.truths[slot].powered = 0

    def lose_store(self, slot: int) -> None:
        """The durable state of a unit that is off is gone."""
        self._units.lose(self._trains.stock_ids[slot])

    def commission(self, slot: int, number: int) -> None:
        """People put a unit into service again that waits for it; it has yet to boot."""
        self.uncommissioned.discard(slot)
        self._units.commission(self._trains.stock_ids[slot], number)

    def power_on(self, slot: int) -> bool:
        """The unit boots, and knows nothing before its crew enters a train number; False: it has lost its durable
        state, and stays off.
        """
        try:
            self._units.restart(self._trains.stock_ids[slot])
        except NotCommissioned:
            self.uncommissioned.add(slot)
            return False
        self.unpowered.discard(slot)
        self._trains.premises.booted(slot)
        self.await_number(slot)
        self._motions[slot] = self._new_motion(slot, before=self._motions[slot])
        return True

    def switch_on(
        self, slot: int, duty: Duty, stands_at: int | None, beyond_m: float = 0.0
    ) -> list[Person | Sensed]:
        """After a boot on the line the crew enters the train number and, if it stands at one, the stop.

        It says how far beyond the mark by its eye, which a unit without a reader of tags takes for a fix.
        """
        self._has_number(slot)
        sensed = self._trains.stock["sensed"][slot]
        self._motions[slot].switch_on(
            duty.mission,
            self._path(slot, duty.mission),
            float(self._trains.tachometers[slot].odometer_m),
            float(sensed["speed_mps"]),
        )
        by_eye = [] if stands_at is None else self._motions[slot].at_mark(AtMark(stands_at, beyond_m))
        return [SwitchedOn(self._plan(slot, duty.mission), stands_at), *by_eye]

    # what the driver sees -----------------------------------------------------------------------------------------

    def shown_to_driver(self, slot: int) -> DrivingCommand:
        """What the unit shows its driver."""
        return self._motions[slot].command

    def plan(self, slot: int) -> DutyPlan | None:
        """The plan of the train that the stock runs."""
        duty = self._trains.duties[slot]
        return None if duty is None else self._plan(slot, duty.mission)

    def drives_on_sight(self, slot: int) -> bool:
        """Whether the driver drives on sight: the unit shows that it does not know where it is, or what it holds."""
        return slot not in self.unpowered and self.shown_to_driver(slot).on_sight

    def learned(self) -> dict[str, Learned]:
        """What the trains know of their brakes, by stock id; empty where none learns."""
        if not self._setup.tuning.learn:
            return {}
        return {keeper.learned.train_id: keeper.learned for keeper in self._keepers}

    def learned_from(self) -> dict[str, StopWaves]:
        """Waves of the last stop that each train counted."""
        return {k.learned.train_id: k.last for k in self._keepers if k.learns and k.last is not None}

    def _plan(self, slot: int, mission: Mission) -> DutyPlan:
        key = (mission.number, slot)
        if key not in self._plans:
            self._plans[key] = plan_of(mission, float(self._trains.kinds[slot].length_m))
        return self._plans[key]

    def _path(self, slot: int, mission: Mission) -> PathData:
        return path_data(self._trains, slot, mission.path)
