"""One train on plain track, through the kernel: the bench that all single-train experiments of the papers share.

The train is one row of STOCK, as in a run of the line: `simulation.world.kernel` moves its body, lets its sensors show
it and ticks its unit, on a path of its own on the one-metre grid. Many runs are made in one compiled call, each from
the same prepared row and each on its own gradient (`single_run`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from network.files.toml_input import Record
from network.profile import PROFILE
from onboard.driving.laws.cue import PLAN, PLAN_COAST
from onboard.driving.laws.settings import fit_law
from onboard.driving.stop_keeper import StopKeeper, believed_dead_time_s, fill_design
from onboard.driving.tasc import DesignRow
from onboard.driving.tuning import Learned
from onboard.driving_settings import Driving
from onboard.records import MODE_DRIVE, NO_PLACES, PATTERN, BehaviourRow, UnitRow
from onboard.unit_records import UnitParameters
from papers.single_run import BENCH_OUTCOME, FIXES_MAX, BenchOutcomeRow, Heights, Rows, run_all
from simulation.sensors import slide_protection, tachometer
from simulation.setup import behaviour_row
from simulation.world.kernel import PathArrays
from simulation.world.records import STOCK, TRACE
from vehicle.records import TrainRow
from vehicle.train_file import TrainType, new_plant
from vehicle.wheel import pulse_m

BEYOND_M: Final = 400.0  # of track behind the mark
STOCK_ID: Final = "train"


def prepared_row(
    body: Rows,
    believed: Rows,
    driving: Driving,
    unit: UnitParameters,
    learned: Learned,
    pulses: bool,
    law_settings: Record | None = None,
    drawn: Callable[[str, str], float] = lambda _law, _field: 0.0,
) -> Rows:
    """A STOCK row, shape (1,), of a train that drives at rest at path coordinate 0 and knows it, nothing ahead."""
    stock = np.zeros(1, dtype=STOCK)
    stock["plant"] = new_plant(1, 1.0)  # coasting: no brake applied
    stock["body"], stock["board"]["kind"] = body, believed
    stock["board"]["behaviour"] = behaviour_row(driving, believed[0])
    row = stock.view(np.recarray)[0]
    fit_law(row.board.laws, driving.law, law_settings, drawn)
    row.truth.active = row.truth.powered = 1
    for name in ("front_boundary_m", "rear_boundary_m", "sign_m", "sight_m", "crossing_m", "track_end_m"):
        row.truth[name] = np.inf
    tachometer.fit_train(row.sensors.tachometer, row.body)
    slide_protection.fit_train(row.sensors.slide_protection, row.body)
    if not pulses:
        row.sensors.tachometer.pulse_m = 0.0
    own: UnitRow = row.board.unit
    own.position_known, own.mode, own.odometer_scale = 1, MODE_DRIVE, 1.0
    own.pulse_m = pulse_m(row.board.kind) if pulses else 0.0
    own.bound_ahead_m = own.bound_behind_m = unit.tag_accuracy_m + own.pulse_m
    own.bound_growth = unit.wheel_error_share
    own.expected_tag_m = own.rear_trigger_m = own.position_trigger_m = np.inf
    own.restricted_mps = own.cruise_mps = own.due_s = own.replan_s = np.inf
    kind: TrainRow = row.board.kind
    behaviour: BehaviourRow = row.board.behaviour
    fill_design(row.board.design, kind, behaviour, learned)
    return stock


def new_track(train: TrainRow, behaviour: BehaviourRow, length_m: float) -> PathArrays:
    """A level path of that length without limits but the train's own, and a plan to coast along all of it."""
    rows = int(length_m) + 2
    profile, pattern = np.zeros(rows, dtype=PROFILE), np.zeros(rows, dtype=PATTERN)
    profile["limit_mps"] = pattern["permitted_mps"] = train.speed_max_mps
    pattern["driving_mps"] = max(train.speed_max_mps - behaviour.settings.driving_margin_mps, 1.0)
    plan = np.zeros(rows, dtype=PLAN)
    plan["mode"], plan["speed_mps"] = PLAN_COAST, train.speed_max_mps
    return PathArrays(profile, pattern, plan, np.zeros(FIXES_MAX), NO_PLACES, NO_PLACES)


class Bench:
    """One train, what its unit believes of it and how it drives; makes as many runs as are asked for."""

    def __init__(
        self,
        train: TrainType,
        driving: Driving,
        unit: UnitParameters,
        body: Rows | None = None,
        learned: Learned | None = None,
        pulses: bool = False,
        law_settings: Record | None = None,
        drawn: Callable[[str, str], float] = lambda _law, _field: 0.0,
    ) -> None:
        """`train` is what the unit believes in; `body`, shape (1,), is what runs, the same if left out.

        Without `pulses` the tachometer counts as finely as the papers' do, whose errors are shares of the way.
        `law_settings` are tables of `[law]`; `drawn` gives what a law draws for each stock, the mean if left out.
        """
        believed = train.row
        if learned is None:
            learned = Learned(STOCK_ID, believed_dead_time_s(believed.view(np.recarray)[0]))
        self.unit = unit
        self.learned = learned
        self.prepared = prepared_row(
            believed if body is None else body,
            believed,
            driving,
            unit,
            learned,
            pulses,
            law_settings,
            drawn,
        )
        self.work = self.prepared.copy()

    @property
    def design(self) -> DesignRow:
        """How the train stops at the mark; to be changed before stops are made."""
        row: DesignRow = self.prepared.view(np.recarray)[0].board.design
        return row

    def run_over(
        self, track: PathArrays, heights: Heights, runs: Rows, trace_steps: int = 0
    ) -> tuple[Rows, Rows]:
        """Make runs in one compiled call: rows of BENCH_OUTCOME, and the last one's TRACE, path coordinates."""
        row = self.prepared.view(np.recarray)[0]
        row.board.unit.path_rows, row.truth.profile_rows = track.pattern.size, track.profile.size
        outcomes, trace = np.zeros(runs.size, dtype=BENCH_OUTCOME), np.zeros(trace_steps, dtype=TRACE)
        places = (self.begin_m, self.unit.tag_accuracy_m, self.unit.standoff_m)
        run_all(self.work, self.prepared, runs, track, heights, places, outcomes, trace)
        return outcomes, trace[: int(outcomes["steps"][-1])]

    def run(self, stops: Rows, trace_steps: int = 0) -> tuple[Rows, Rows]:
        """Make stops on the level, or the gradient of each: as `run_over`."""
        return self.run_over(*self.track(stops), stops, trace_steps)

    def track(self, stops: Rows) -> tuple[PathArrays, Heights]:
        """A level path that is long enough for each of these stops, which are to coast along it."""
        row = self.prepared.view(np.recarray)[0]
        length_m = self.begin_m + float(stops["start_m"].max()) + BEYOND_M
        track = new_track(row.board.kind, row.board.behaviour, length_m)
        stops["plan_rows"] = track.plan.size
        level_m = np.zeros(track.profile.size)
        return track, Heights(level_m, level_m, level_m)

    @property
    def begin_m(self) -> float:
        """Path coordinate at which runs begin, m: the whole train is on the path."""
        return float(np.ceil(self.prepared["body"]["length_m"][0])) + 1.0

    def single_stop(self, stop: Rows, trace_steps: int = 0) -> tuple[BenchOutcomeRow, Rows]:
        """Make a single stop, shape (1,); also its trace, in m past the mark."""
        outcomes, trace = self.run(stop, trace_steps)
        trace["position_m"] -= self.begin_m + float(stop["start_m"][0])
        outcome: BenchOutcomeRow = outcomes.view(np.recarray)[0]
        return outcome, trace

    def keeper(self) -> StopKeeper:
        """What the unit keeps of the stop just made."""
        board = self.work.view(np.recarray)[0].board
        return StopKeeper(board.tasc, board.design, board.wave, self.learned)
