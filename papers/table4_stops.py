"""The 22 simulated stops of Oda's section 3.2, stops that cannot succeed, and the controller that makes them.

Every run uses the same controller; the proportional gain is found without position error, as in 3.2.3. The paper's own
is the same law with parts left out (`onboard.driving.tasc.Part`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from network.units import mps
from onboard.driving.tasc import WHOLE_LAW, StopLawPart, StopVerdict
from papers.parameter_sets import CUMULATIVE_ERROR, SECTION_3_2
from papers.single_run import Rows, new_stops
from papers.single_train import Bench
from vehicle.train_file import TrainType, load_train, shipped_train

SPEED_KMH: Final = 70.0
START_M: Final = 450.0
SAFETY_BEACON_M: Final = 1000.0
FRAME_RATE_FPS: Final = 52.0
FRAME_S: Final = 1.0 / FRAME_RATE_FPS  # equation 1: the estimate runs ahead, as with the line's camera
BEACONS_M: Final = (400.0, 100.0, 10.0)
SUB_TARGET_M: Final = 100.0
DETECTIONS_M: Final = (20.0, 40.0, 60.0, 80.0, 100.0)
PATTERN_MPS2: Final = SECTION_3_2.driving.stop_deceleration_mps2
GAIN_PER_S: Final = SECTION_3_2.driving.stop_gain_per_s
GAINS_PER_S: Final = tuple(round(0.2 * k, 1) for k in range(1, 11))
TRIAL_SPEEDS_KMH: Final = (40.0, 50.0, 60.0, 70.0, 80.0)
# 2.1: proportional; 4.1.1: with a bias. No prediction in chapter 3, nothing of patterns drawn anew or soft ends
PAPERS_LAW: Final = StopLawPart.FEED_FORWARD
NOT_IN_THE_PAPER: Final = WHOLE_LAW & ~PAPERS_LAW
NOTHING: Final = StopLawPart(0)

ACCURACY_M: Final = 1.0
PASSING_M: Final = 0.25
FAILING_SHARE: Final = 0.40


@dataclass(frozen=True, slots=True)
class SignRun:
    """One of the 22 runs: 0 signs is the conventional method; the sign of the error; the paper's result, m."""

    signs: int
    error_is_positive: bool
    detection_m: float
    paper_m: float

    @property
    def name(self) -> str:
        """The cell of table 4."""
        sign = "positive" if self.error_is_positive else "negative"
        if self.signs == 0:
            return f"conventional, error {sign}"
        return f"{('one target', 'two targets')[self.signs - 1]}, error {sign}, {self.detection_m:.0f} m"


def _cells(signs: int, error_is_positive: bool, *paper_m: float) -> tuple[SignRun, ...]:
    return tuple(
        SignRun(signs, error_is_positive, range_m, value)
        for range_m, value in zip(DETECTIONS_M, paper_m, strict=True)
    )


CASES: Final = (
    SignRun(0, True, 0.0, 0.25),
    SignRun(0, False, 0.0, 0.04),
    *_cells(1, True, 0.05, 0.21, 0.19, 0.18, 0.17),
    *_cells(1, False, 6.11, 3.41, 0.02, 0.18, 0.16),
    *_cells(2, True, 0.19, 0.18, 0.18, 0.14, 0.17),
    *_cells(2, False, 0.21, 0.19, 0.17, 0.18, 0.18),
)


def oda_train() -> TrainType:
    """The paper's train."""
    return load_train(shipped_train("oda_train"))


def controller(
    gain_per_s: float = GAIN_PER_S, pattern_mps2: float = PATTERN_MPS2, without: StopLawPart = NOTHING
) -> Bench:
    """The paper's train with the one set of controller parameters of all runs; `without`: parts of the law left out."""
    driving = SECTION_3_2.driving.model_copy(
        update={"stop_deceleration_mps2": pattern_mps2, "stop_gain_per_s": gain_per_s}
    )
    bench = Bench(oda_train(), driving, SECTION_3_2.unit)
    bench.design.parts &= ~int(without)
    return bench


def plain_stop(speed_kmh: float) -> Rows:
    """A stop from `speed_kmh` without any position error; shape (1,)."""
    stop = new_stops(1)
    stop["speed_mps"] = mps(speed_kmh)
    stop["start_m"] = START_M
    return stop


def stop_of(case: SignRun) -> Rows:
    """A case's position errors; shape (1,)."""
    stop = plain_stop(SPEED_KMH)
    stop["since_fix_m"] = SAFETY_BEACON_M - START_M
    stop["count_error"] = CUMULATIVE_ERROR if case.error_is_positive else -CUMULATIVE_ERROR
    if case.signs == 0:
        stop["beacons"] = len(BEACONS_M)
        stop["beacon_m"][0, : len(BEACONS_M)] = BEACONS_M
    else:
        stop["signs"] = case.signs
        stop["sign_m"][0, :2] = (0.0, SUB_TARGET_M)
        stop["detection_m"] = case.detection_m
        stop["frame_s"] = FRAME_S
    return stop


def cells_of_table4() -> Rows:
    """The stops of CASES; shape (22,)."""
    return np.concatenate([stop_of(case) for case in CASES])


def trial_stops() -> Rows:
    """Stops from several speeds without position error, by which 3.2.3 finds the gain."""
    return np.concatenate([plain_stop(kmh) for kmh in TRIAL_SPEEDS_KMH])


def best_gain_per_s(without: StopLawPart = NOTHING) -> float:
    """The gain with the least mean error over stops from several speeds without position error (3.2.3)."""
    stops = trial_stops()

    def mean_error_m(gain_per_s: float) -> float:
        outcomes, _ = controller(gain_per_s, without=without).run(stops)
        return round(float(np.abs(outcomes["error_m"]).mean()), 4)  # a tenth of a millimetre decides nothing

    return min(GAINS_PER_S, key=mean_error_m)


def errors_m(bench: Bench, stops: Rows) -> list[float]:
    """Stop positions, m, positive past the mark."""
    outcomes, _ = bench.run(stops)
    return [float(error_m) for error_m in outcomes["error_m"]]


def wheel_errors_m(gain_per_s: float) -> list[float]:
    """Those of CASES where the 1 % comes from the wheel's circumference, so that the speed is wrong by as much."""
    stops = cells_of_table4()
    stops["wheel_error"], stops["count_error"] = stops["count_error"], 0.0
    return errors_m(controller(gain_per_s), stops)


def passes(case: SignRun, error_m: float) -> bool:
    """Whether our figure agrees with the paper's cell: the same verdict at 1 m and near enough."""
    if case.paper_m <= ACCURACY_M:
        return abs(error_m) <= PASSING_M
    near = abs(abs(error_m) - case.paper_m) <= FAILING_SHARE * case.paper_m
    return abs(error_m) > ACCURACY_M and near


def impossible_stops() -> tuple[tuple[str, StopVerdict, Rows], ...]:
    """Name, expected verdict and row of three stops that cannot be made, each with a stop limit."""
    weak = stop_of(SignRun(1, True, 100.0, 0.0))
    weak["brake_factor"] = 0.6
    weak["stop_limit_m"] = 20.0
    unseen = stop_of(SignRun(1, False, 0.0, 0.0))
    unseen["signs"] = 0
    unseen["expects_sign"] = 1
    unseen["stop_limit_m"] = 20.0
    beyond = stop_of(SignRun(1, False, 100.0, 0.0))
    beyond["stop_limit_m"] = -5.0
    return (
        ("brake at 60 % of its design", StopVerdict.BRAKE_TOO_WEAK, weak),
        ("target never seen", StopVerdict.TARGET_NOT_SEEN, unseen),
        ("sign 5 m behind the stop limit", StopVerdict.SIGN_BEYOND_LIMIT, beyond),
    )
