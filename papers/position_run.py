"""One train along a line for experiments about where it is: the line's own sensors, unit and physics, nobody else's.

The stock is one of a Setup, its path that of its first train, its driving part the real one (`onboard.motion`), the
carrier the plain one; no interlocking. In place of the duty stands a driver who runs from stop to stop, releases the
emergency brake once the train stands, and goes on: on sight while the position is unknown. What happens on the way
(rail, faults) is a list of moments at true positions. Bounds are judged in every step by the kernel's own sheet, but
while a faulty tachometer has made the position false (decision 004).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from network.timetable import Timetable
from onboard import notes
from onboard.duty.records import (
    DrivingCommand,
    DrivingOrder,
    FoundByOtherSensor,
    PositionLost,
    Sensed,
    StopLimit,
    Stopped,
    TagBelieved,
)
from simulation.carriers.plain_track import PlainTrack
from simulation.result import TRACE_EVERY_STEPS
from simulation.setup import STEP_S, Setup
from simulation.world.kernel import MOVING_STEPS_MAX, advance, new_sheet
from simulation.world.on_board import new_keeper, new_motion, path_data
from simulation.world.records import PASSED_FRONT, PASSED_REAR, PASSED_TAG, TRACE
from simulation.world.roster import Duty, drawn_up
from simulation.world.trains import Trains
from vehicle.train_file import TrainType

SLOT: Final = 0
STANDS_S: Final = 2.0  # how long the train stands at each stop: nothing of this is about passengers
HOURS_MAX: Final = 6.0
STOPPED_WITHIN_M: Final = 5.0
GAINS_MPS2: Final = 1.5  # no train here gains speed faster, on any gradient
STALLED_S: Final = (
    600.0  # who has not moved for so long has run past the last tag that could tell where it is
)
Rows = NDArray[np.void]


@dataclass(frozen=True, slots=True)
class Moment:
    """What happens when the front first is at or beyond a path coordinate (m)."""

    at_m: float
    what: Callable[[Trains, int], object]


def rail(at_m: float, share: float) -> Moment:
    """What is left of the dry rail's adhesion from a place on."""
    return Moment(at_m, lambda trains, slot: trains.set_rail(slot, share))


def slippery(from_m: float, to_m: float, share: float) -> list[Moment]:
    """A stretch with so much of the dry rail's adhesion."""
    return [rail(from_m, share), rail(to_m, 1.0)]


def unprotected(train: TrainType) -> TrainType:
    """The same train with wheels that may lock."""
    row = train.row.copy()
    row["wheel_slide_share_max"] = 1.0
    return replace(train, row=row)


def in_motion(trace: Rows) -> Rows:
    """Rows of TRACE in which the train moves and its unit states bounds."""
    moves: Rows = trace[(trace["speed_mps"] > 0.0) & np.isfinite(trace["bound_ahead_m"])]
    return moves


def half_widths_m(trace: Rows) -> NDArray[np.float64]:
    """Half of what the bounds span in each row of TRACE, m."""
    return np.asarray((trace["bound_ahead_m"] + trace["bound_behind_m"]) / 2.0, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class CheckPoint:
    """What the unit believed in the step in which the front passed a tag of the real line; m."""

    tag_id: int
    true_m: float
    error_m: float
    behind_m: float
    ahead_m: float
    known: bool


@dataclass(slots=True)
class PositionResult:
    """What came of a run. `trace`: rows of TRACE, one a second; `stated`: of each, whether the position was known.

    `out_m`: by how much the truth was out at worst.
    """

    trace: Rows
    stated: NDArray[np.bool_]
    out_m: float = -math.inf
    out_at_m: float = math.nan
    steps: int = 0
    known_steps: int = 0
    check_points: list[CheckPoint] = field(default_factory=list[CheckPoint])
    notes: list[tuple[float, float, notes.Note]] = field(
        default_factory=list[tuple[float, float, notes.Note]]
    )
    arrived: bool = False

    @property
    def held(self) -> bool:
        """Whether the unit stated bounds and the truth was never out of them; what is no number is out."""
        return self.known_steps > 0 and self.out_m <= 0.0


class PositionRun:
    """One run in progress; `result` fills as it goes. `moments` are by true path coordinate.

    `number`: of the first stock's trains the one that runs, its first by default. `unit_timetable`: the one that the
    unit goes by, where the train is sent another way than that.
    """

    def __init__(
        self,
        setup: Setup,
        moments: Sequence[Moment] = (),
        *,
        number: str | None = None,
        steps_max: int = MOVING_STEPS_MAX,
        unit_timetable: Timetable | None = None,
    ) -> None:
        self.setup: Final = setup
        self.steps_max: Final = steps_max  # that the kernel runs ahead
        lengths_m = {p.id: round(p.length_m, 6) for p in setup.line.pieces.values()}
        self.carrier: Final = PlainTrack(lengths_m, STEP_S)
        self.trains: Final = Trains(setup, self.carrier)
        stock_id = self.trains.stock_ids[SLOT]
        duties = drawn_up(setup, setup.line)[stock_id]
        at = next((i for i, duty in enumerate(duties) if duty.mission.number == number), 0)
        self.duty: Final[Duty] = duties[at]
        heard = setup if unit_timetable is None else replace(setup, timetable=unit_timetable)
        believed = drawn_up(heard, setup.believed_line)[stock_id][at].mission
        self.mission: Final = believed
        self.now_s = float(self.duty.enter_s)
        self._moments: list[Moment] = []
        self.at(moments)
        self._target = 0
        self._on_sight = False
        self._lost = False
        trains = self.trains
        trains.place(SLOT, self.duty)
        trains.begin_leg(SLOT, self.duty.enter_s)
        self.motion: Final = new_motion(trains, SLOT, new_keeper(trains, SLOT, learns=False))
        data = path_data(trains, SLOT, believed.path)
        self.motion.stand_at_start(believed, data, float(trains.tachometers[SLOT].odometer_m))
        self._sheet, self._trace = new_sheet(1), np.zeros(2 * MOVING_STEPS_MAX, dtype=TRACE)
        self._traces: list[Rows] = []
        self._stated: list[NDArray[np.bool_]] = []
        self.result: Final = PositionResult(np.zeros(0, dtype=TRACE), np.zeros(0, dtype=np.bool_))

    @property
    def true_m(self) -> float:
        """True path coordinate of the front, m."""
        return float(self.trains.truths[SLOT].position_m)

    def at(self, moments: Sequence[Moment]) -> None:
        """What happens on the way, beside what is said already."""
        self._moments = sorted([*self._moments, *moments], key=lambda moment: moment.at_m)

    def run(self) -> PositionResult:
        """Run to the last stop, until the train has stalled or `HOURS_MAX` are over; `result.arrived` says which."""
        end_s = self.now_s + HOURS_MAX * 3600.0
        self._leave()
        moved_m, moved_s = self.true_m, self.now_s
        while self.now_s < end_s and self.now_s < moved_s + STALLED_S and not self.result.arrived:
            self._stretch()
            if self.true_m != moved_m:
                moved_m, moved_s = self.true_m, self.now_s
        self.result.trace = np.concatenate([self.result.trace, *self._traces])
        self.result.stated = np.concatenate([self.result.stated, *self._stated])
        return self.result

    # one stretch ----------------------------------------------------------------------------------------------------

    def _stretch(self) -> None:
        """The kernel until something happens; then what has happened."""
        trains, sheet, result = self.trains, self._sheet, self.result
        step = round(self.now_s / STEP_S)
        done, rows, moved = advance(
            trains.stock, trains.pool.track, sheet, self._trace, 0, step, self._steps_to_moment()
        )
        self.now_s = (step + done) * STEP_S
        stock_id = trains.stock_ids[SLOT]
        if moved:
            speeds = sheet.speeds_mps[0, :done]
            self.carrier.run([(stock_id, [float(v) for v in speeds])], done)
            trains.compare([SLOT], [self.carrier.truth(stock_id)])
        unit = trains.units[SLOT]
        known = bool(unit.position_known) and not unit.found  # what is found ends the stretch
        result.steps += done
        result.known_steps += done if known else 0
        kept = self._trace[:rows]
        self._traces.append(kept[kept["step"] % TRACE_EVERY_STEPS == 0].copy())
        self._stated.append(np.full(self._traces[-1].size, known))
        happened: list[Sensed] = []
        passed, bits = int(sheet.passed[SLOT]), int(sheet.events[SLOT])
        if passed & (PASSED_FRONT | PASSED_REAR):
            trains.set_boundaries(SLOT)
        if passed & PASSED_TAG:
            happened += self._tag()
            if any(isinstance(each, TagBelieved) for each in happened):
                trains.position_fixed(SLOT)
        happened += self.motion.events(bits)
        self._judge()
        if any(isinstance(each, FoundByOtherSensor) for each in happened):
            trains.position_fixed(SLOT)
        for moment in self._due():
            moment.what(trains, SLOT)
        self._answer(happened)
        at_m = self.true_m
        result.notes += [(self.now_s, at_m, note) for note in self.motion.taken_notes()]

    def _judge(self) -> None:
        """Keep by how much the truth was out of the bounds."""
        trains, result, sheet = self.trains, self.result, self._sheet
        out_m = float(sheet.worst[SLOT, 0])
        if not (trains.premises.is_false(SLOT) or out_m <= result.out_m or math.isnan(result.out_m)):
            result.out_m, result.out_at_m = out_m, float(sheet.worst[SLOT, 2])

    def _steps_to_moment(self) -> int:
        """How many steps surely do not run past the next moment by more than one."""
        if not self._moments:
            return self.steps_max
        fastest_mps = float(self.trains.plants[SLOT].speed_mps) + GAINS_MPS2 * MOVING_STEPS_MAX * STEP_S
        steps = int((self._moments[0].at_m - self.true_m) / (fastest_mps * STEP_S))
        return min(max(steps, 1), self.steps_max)

    def _due(self) -> list[Moment]:
        due = [moment for moment in self._moments if moment.at_m <= self.true_m]
        self._moments = self._moments[len(due) :]
        return due

    def _tag(self) -> list[Sensed]:
        trains, unit = self.trains, self.trains.units[SLOT]
        tag_id, says_id, odometer_m = trains.read_tag(SLOT)
        behind_m, ahead_m = float(unit.bound_behind_m), float(unit.bound_ahead_m)
        error_m = float(unit.position_m) - self.true_m
        known = bool(unit.position_known)
        self.result.check_points.append(CheckPoint(tag_id, self.true_m, error_m, behind_m, ahead_m, known))
        return [] if says_id is None else self.motion.tag_read(says_id, odometer_m)

    # the driver -----------------------------------------------------------------------------------------------------

    def _answer(self, happened: Sequence[Sensed]) -> None:
        stands = bool(self.trains.plants[SLOT].speed_mps == 0.0)
        if any(isinstance(each, PositionLost) for each in happened):
            self._lost = self._on_sight = True
        found = any(isinstance(each, TagBelieved) and each.found for each in happened)
        if found or (self._on_sight and self.trains.units[SLOT].position_known):
            self._on_sight = False
        stopped = [each for each in happened if isinstance(each, Stopped)]
        if self._lost and stands:
            self._lost = False
            self._obey(DrivingOrder.RELEASE, DrivingOrder.RESUME)
        elif stopped and stands and not self._on_sight:  # wheels that are locked show a stand, too
            self._arrived()
        elif happened:
            self._obey()

    def _arrived(self) -> None:
        """The train stands: at its next stop, or short of it by what it believes.

        A train whose bounds reach the end of its track goes no further: its driver sees that it is there.
        """
        unit = self.trains.units[SLOT]
        beyond_m = unit.position_m - self.mission.targets[self._target + 1].mark_m
        if beyond_m > -STOPPED_WITHIN_M - unit.bound_ahead_m:
            self._target += 1
        if self._target + 1 == len(self.mission.targets):
            self.result.arrived = True
            return
        self.now_s += STANDS_S
        self._leave()

    def _leave(self) -> None:
        self._obey(DrivingOrder.DEPART)

    def _obey(self, *orders: DrivingOrder) -> None:
        command = DrivingCommand(
            drive=True,
            on_sight=self._on_sight,
            at=self._target,
            target=None if self._on_sight else self._target + 1,
            limit=StopLimit(len(self.mission.spans), None, "the end of the line"),
            orders=orders,
        )
        self.motion.obey(command, self.now_s)
        laid = self.motion.taken_plan()
        if laid is not None:
            rows = laid.rows
            self.motion.follow(self.trains.pool.lay_plan(SLOT, rows.size, rows), rows.size)
