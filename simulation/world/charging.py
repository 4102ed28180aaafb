"""Where sets charge, whether their charge takes them on, what they do off the line, and the record of all that.

The world knows which chargers work and tells all crews at once of one that does not; it connects a set to the charger
at which it truly stands. The rest follows in the compiled step (`simulation.world.charge_control`). What a set needs
is its unit's own prediction (`simulation.world.ways`), what it has is what its battery shows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from network.model import Charger
from onboard.charge import ChargeRules, ChargeWatch
from onboard.reach import charger_at
from simulation.battery_settings import BatterySettings, Beyond, Departure
from simulation.events import BatteryLevel
from simulation.result import BatteryEvent, BatteryRecord
from simulation.setup import STEP_S, STEPS_PER_S, Setup
from simulation.world.books import Books
from simulation.world.charge_control import (
    DOWN,
    MOVED,
    READY_S,
    TOLD,
    UP,
    ChargingRow,
    has_enough,
    is_full,
    reset_charging,
)
from simulation.world.records import PASSED_FROM_A_STAND, PASSED_TO_A_STAND
from simulation.world.roster import Duty
from simulation.world.trains import Trains
from simulation.world.ways import ways_of
from vehicle.battery import BatteryRow, available_j, charge_to, soc_of, stand, stored_j, window_j
from vehicle.record import cells_of

SAMPLES_EVERY_S: Final = 30.0
BEYOND_STEP_S: Final = 1.0
SPARE_S: Final = 120.0  # assumed: for the pantograph, the route, and until the train moves
BEYOND_SAMPLES_S: Final = 120.0


@dataclass(slots=True)
class _Off:
    """A set that has left the line: after which train, and when."""

    number: str
    since_s: float


class BatteryGauge:
    """What one set's battery shows its unit."""

    def __init__(self, battery: Any, control: ChargingRow, auxiliary_w: float) -> None:  # noqa: ANN401
        self._battery: Final = battery
        self._control: Final = control
        self._auxiliary_w: Final = auxiliary_w
        self.now_s = 0.0

    @property
    def charges(self) -> bool:
        """Whether the set stands at a charger that works, or has been brought a generator."""
        return self._control.power_w > 0.0 or self._brought

    @property
    def full(self) -> bool:
        """Whether the battery takes no more."""
        return is_full(self._battery)

    @property
    def up(self) -> bool:
        """Whether the pantograph is up, or the generator's cable is in."""
        return bool(self._control.pantograph == UP) or self._brought

    @property
    def connected(self) -> bool:
        """Whether the pantograph is not down, or the generator's cable is in."""
        return self._control.pantograph != DOWN or self._brought

    @property
    def ready(self) -> bool:
        """Whether the pantograph is up and has no more to wait for."""
        enough = has_enough(self._battery, self._control.needed_j, self._control.spare_j)
        return bool(self._control.pantograph == UP and enough)

    @property
    def _brought(self) -> bool:
        return self._control.brought_w > 0.0

    def has_j(self, at_s: float) -> float:
        """What will be available at a time, J."""
        until_s = at_s - self._control.disconnect_s - READY_S
        if self._control.pantograph != UP or not self.now_s < until_s < math.inf:
            return float(available_j(self._battery))
        later = self._battery.copy()
        stand(later, self._auxiliary_w, self._control.power_w, until_s - self.now_s, BEYOND_STEP_S)
        return float(available_j(later))

    def ask(self, needed_j: float, leaves_s: float, keeps_j: float) -> None:
        """The set is to leave at a time, with so much."""
        self._control.needed_j, self._control.leaves_s = needed_j, leaves_s
        self._control.keeps_j = keeps_j
        self._control.spare_j = self._auxiliary_w * SPARE_S if needed_j > 0.0 else 0.0


class Charging:
    """The batteries of a run; made only where the scenario has them."""

    def __init__(
        self,
        setup: Setup,
        settings: BatterySettings,
        trains: Trains,
        books: Books,
        drawn: Mapping[str, Sequence[Duty]],
    ) -> None:
        self.records: list[BatteryRecord] = []
        self._setup: Final = setup
        self._settings: Final = settings
        self._trains: Final = trains
        self._books: Final = books
        self._ways: Final = ways_of(setup, drawn)
        self._rows: Final[list[Any]] = list(trains.stock["battery"])
        self._batteries: Final[list[BatteryRow]] = [cells_of(BatteryRow, row) for row in self._rows]
        self._control: Final[list[ChargingRow]] = [
            cells_of(ChargingRow, row) for row in trains.stock["charging"]
        ]
        self._dead: set[str] = set()
        self._off: dict[int, _Off] = {}
        self._pantograph = [DOWN] * len(self._batteries)
        self._brought = [False] * len(self._batteries)
        self._level = [BatteryLevel.ENOUGH] * len(self._batteries)
        self._gauges: dict[int, BatteryGauge] = {}
        self._watches: dict[int, ChargeWatch] = {}
        self._sampled_s = [-math.inf] * len(self._batteries)
        self._number = [""] * len(self._batteries)
        for slot, stock_id in enumerate(trains.stock_ids):
            self._begin_day(slot, stock_id)

    def _begin_day(self, slot: int, stock_id: str) -> None:
        kind = self._setup.trains[stock_id]
        if kind.battery is None:
            return
        row = self._rows[slot]
        for name in kind.battery.dtype.names or ():
            row[name] = kind.battery[name][0]
        share = self._settings.start_of.get(stock_id, self._settings.start_share)
        charge_to(row, share)
        reset_charging(row, self._trains.stock["charging"][slot])
        auxiliary_w = float(self._setup.believed_train(stock_id).row[0]["auxiliary_power_w"])
        settings = self._settings
        rules = ChargeRules(
            settings.departure is Departure.WAIT,
            settings.reserve_share * float(window_j(row)),
            settings.prediction_share,
        )
        control = self._control[slot]
        control.keeps_j = control.reserve_j = rules.reserve_j
        control.keeps_w = settings.shed_to_kw * 1e3
        gauge = self._gauges[slot] = BatteryGauge(row, control, auxiliary_w)
        self._watches[slot] = ChargeWatch(self._setup.believed_line, self._ways[stock_id], rules, gauge)

    def has_battery(self, slot: int) -> bool:
        """Whether a set runs on a battery."""
        return bool(self._batteries[slot].fitted)

    # chargers -------------------------------------------------------------------------------------------------

    def charger_is(self, station_id: str, *, works: bool, step: int) -> None:
        """A charger fails or is mended: sets that stand there see it, all crews are told."""
        (self._dead.discard if works else self._dead.add)(station_id)
        for watch in self._watches.values():
            watch.hear_of_dead(self._dead)
        for slot in self._trains.active():
            if self._trains.plants[slot].speed_mps == 0.0:
                self.stands(slot, step)

    def stands(self, slot: int, step: int) -> None:
        """A set has come to a stand, or takes up a train where it stands: is there a charger?"""
        if not self.has_battery(slot):
            return
        charger, control = self._charger(slot), self._control[slot]
        works = charger is not None and charger.station_id not in self._dead
        control.power_w = charger.power_w if charger is not None and works else 0.0
        if charger is not None:
            control.connect_s, control.disconnect_s = charger.connect_s, charger.disconnect_s
        self._write(slot, step, BatteryEvent.STANDS)

    def _charger(self, slot: int) -> Charger | None:
        """The charger at which a set truly stands."""
        duty, at = self._trains.duties[slot], self._books.stands_at(slot)
        if duty is None or at is None:
            return None
        line = self._setup.line
        return line.chargers.get(charger_at(line, duty.mission.targets[at]))

    def watch_of(self, slot: int) -> ChargeWatch | None:
        """What a set's unit watches its charge by; None where it runs from a wire."""
        return self._watches.get(slot)

    def unit_looks(self, slot: int, now_s: float) -> None:
        """A set's unit is about to look, at a time of its own clock."""
        if slot in self._watches:
            self._watches[slot].now_s = self._gauges[slot].now_s = now_s

    def empty(self, slot: int) -> bool:
        """Whether a battery has nothing left above its window."""
        return self.has_battery(slot) and available_j(self._rows[slot]) <= 0.0

    def goes_on(self, slots: Sequence[int]) -> bool:
        """Whether one of these does not stand with an empty battery, whatever their units ask of the motors, or a
        generator charges one.
        """
        stranded = all(self.empty(slot) and self._trains.plants[slot].speed_mps == 0.0 for slot in slots)
        return not stranded or any(self._control[slot].brought_w > 0.0 for slot in self._trains.active())

    def helpless(self, slot: int) -> bool:
        """Whether a set stands where nothing charges it, with nothing left, or at a stop with too little to leave."""
        control, row = self._control[slot], self._rows[slot]
        stands = self.has_battery(slot) and self._trains.plants[slot].speed_mps == 0.0
        if not stands or control.power_w > 0.0 or control.brought_w > 0.0 or is_full(row):
            return False
        left_j = float(available_j(row))
        return left_j <= 0.0 or (left_j < control.needed_j and self._books.stands_at(slot) is not None)

    def bring_power(self, slot: int) -> None:
        """Staff have brought a generator; it stays until the set has what its unit asks for, and the reserve."""
        if self.helpless(slot):
            self._control[slot].brought_w = self._settings.brought_kw * 1e3

    def levels(self) -> Iterator[tuple[int, BatteryLevel]]:
        """The sets whose battery has come to another level."""
        for slot in self._trains.active():
            level = BatteryLevel.LOW if self._control[slot].sheds else BatteryLevel.ENOUGH
            level = BatteryLevel.EMPTY if self.empty(slot) else level
            if level is not self._level[slot]:
                self._level[slot] = level
                yield slot, level

    # off the line ----------------------------------------------------------------------------------------------

    def leaves(self, slot: int, step: int) -> None:
        """A set leaves the line after its train."""
        if self.has_battery(slot):
            self._write(slot, step, BatteryEvent.LEAVES)
            self._off[slot] = _Off(self._number[slot], step / STEPS_PER_S)
            self._control[slot].power_w = 0.0
            self._control[slot].pantograph = DOWN

    def enters(self, slot: int, step: int) -> None:
        """A set comes onto the line, after what it did off it, if it was here before."""
        if not self.has_battery(slot):
            return
        off = self._off.pop(slot, None)
        if off is not None:
            self._go_beyond(slot, self._settings.beyond_of(off.number), off.since_s, step / STEPS_PER_S)
        self._write(slot, step, BatteryEvent.ENTERS)

    def _go_beyond(self, slot: int, beyond: Beyond, left_s: float, back_s: float) -> None:
        """Run, charge, wait: the battery carries nothing but what it is asked for there."""
        row = self._rows[slot]
        takes_j = beyond.takes_j
        runs_s = min(beyond.runs_s, max(back_s - left_s, 0.0))
        if takes_j > 0.0:  # all of it, and at its own power, however short the plan makes the time for it
            stand(row, takes_j / beyond.runs_s, 0.0, beyond.runs_s, BEYOND_STEP_S)
            self._write(slot, round((left_s + runs_s) * STEPS_PER_S), BatteryEvent.RAN_BEYOND)
        # Under a wire it charges while it runs; from its battery only once it has run.
        since_s = left_s + (runs_s if takes_j > 0.0 else 0.0)
        charges_s = min(beyond.charge_min * 60.0, back_s - since_s)
        if charges_s > 0.0:
            begins = round((back_s - charges_s) * STEPS_PER_S)
            self._write(slot, begins, BatteryEvent.CONNECTED)
            left_s = charges_s
            while left_s > 0.0:
                this_s = min(BEYOND_SAMPLES_S, left_s)
                stand(row, 0.0, beyond.charge_kw * 1e3, this_s, BEYOND_STEP_S)
                left_s -= this_s
                event = BatteryEvent.NONE if left_s > 0.0 else BatteryEvent.DISCONNECTED
                self._write(slot, round((back_s - left_s) * STEPS_PER_S), event)

    # the record ------------------------------------------------------------------------------------------------

    def begins(self, slot: int, duty: Duty, step: int) -> None:
        """A set takes up a train where it stands."""
        self._number[slot] = duty.train.number
        self.stands(slot, step)

    def note_passed(self, slot: int, passed: int, step: int) -> None:
        """What a set passed in the last step: it may have come to a stand, or begun to move."""
        if self.has_battery(slot) and passed & PASSED_FROM_A_STAND:
            self._write(slot, step, BatteryEvent.DEPARTS)
        elif passed & PASSED_TO_A_STAND:
            self.stands(slot, step)

    def moved_connected(self) -> Iterator[int]:
        """The sets that have begun to move with the pantograph not down, each once."""
        for slot in self._trains.active():
            if self._control[slot].moved == MOVED:
                self._control[slot].moved = TOLD
                yield slot

    def look(self, step: int) -> list[int]:
        """Write down how batteries are: now and then, and where a pantograph or a generator has come or gone.

        Returns the sets whose pantograph has come down.
        """
        now_s = step / STEPS_PER_S
        lowered: list[int] = []
        for slot in self._trains.active():
            if not self.has_battery(slot):
                continue
            before, state = self._pantograph[slot], self._control[slot].pantograph
            self._pantograph[slot] = state
            if state == DOWN and before != DOWN:
                lowered.append(slot)
            brought = bool(self._control[slot].brought_w > 0.0)
            if brought is not self._brought[slot]:
                self._brought[slot] = brought
                self._write(slot, step, BatteryEvent.BROUGHT if brought else BatteryEvent.TAKEN_AWAY)
            if state == UP and before != UP:
                self._write(slot, step, BatteryEvent.CONNECTED)
            elif before == UP and state != UP:
                self._write(slot, step, BatteryEvent.DISCONNECTED)
            elif now_s - self._sampled_s[slot] >= SAMPLES_EVERY_S:
                self._write(slot, step, BatteryEvent.NONE)
        return lowered

    def close(self, step: int) -> None:
        """The run is over."""
        for slot in self._trains.active():
            if self.has_battery(slot):
                self._write(slot, step, BatteryEvent.NONE)

    def _write(self, slot: int, step: int, event: BatteryEvent) -> None:
        battery, row = self._batteries[slot], self._rows[slot]
        duty, at = self._trains.duties[slot], None
        if self._trains.truths[slot].active:
            at = self._books.stands_at(slot)
        on_line = slot not in self._off
        place = "" if duty is None or at is None or not on_line else duty.mission.targets[at].station_id or ""
        self._sampled_s[slot] = step / STEPS_PER_S
        flows: Any = np.asarray(row["flows"].copy()).view(np.recarray)[()]  # a copy, with its names
        self.records.append(
            BatteryRecord(
                self._trains.stock_ids[slot],
                self._number[slot],
                step * STEP_S,
                event,
                place,
                float(soc_of(row)),
                float(stored_j(row, soc_of(row))),
                battery.supply_w,
                flows,
            )
        )
