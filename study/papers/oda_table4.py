"""`branchline reproduce oda-table4`: the 22 simulated stops of Oda's section 3.2, and stops that cannot succeed.

Every run uses the same controller; the proportional gain is found without position error, as in 3.2.3.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from network.units import mps
from onboard.driving.stop_keeper import (
    CORRECTION_LEAST_M,
    END_JERK_MPS3,
    END_MPS2,
    PATTERN_LEAST_SHARE,
)
from onboard.driving.tasc import Verdict
from onboard.unit_records import UnitParameters
from simulation.setup import STEP_S
from study.papers.reproduction import Options, Parameter, Reproduction, Row
from study.papers.single_stop import Rows, StopResult, new_stops
from study.papers.single_train import COASTING, Bench
from vehicle.train_file import TrainType, load_train, shipped_train

SPEED_KMH: Final = 70.0
START_M: Final = 450.0
SAFETY_BEACON_M: Final = 1000.0
CUMULATIVE_ERROR: Final = 0.01
FRAME_RATE_FPS: Final = 52.0
BEACONS_M: Final = (400.0, 100.0, 10.0)
SUB_TARGET_M: Final = 100.0
DETECTIONS_M: Final = (20.0, 40.0, 60.0, 80.0, 100.0)
PATTERN_MPS2: Final = 0.78
TAG_ACCURACY_M: Final = 0.1  # Oda, table 1: odometry and marker, about 0.1 m
# 1 % of the distance run, as wheels that count too little count it
BOUND_GROWTH: Final = CUMULATIVE_ERROR / (1.0 - CUMULATIVE_ERROR)
GAINS_PER_S: Final = tuple(round(0.2 * k, 1) for k in range(1, 11))
TRIAL_SPEEDS_KMH: Final = (40.0, 50.0, 60.0, 70.0, 80.0)

ACCURACY_M: Final = 1.0
PASSING_M: Final = 0.25
FAILING_SHARE: Final = 0.40


@dataclass(frozen=True, slots=True)
class Case:
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


def _cells(signs: int, error_is_positive: bool, *paper_m: float) -> tuple[Case, ...]:
    return tuple(
        Case(signs, error_is_positive, range_m, value)
        for range_m, value in zip(DETECTIONS_M, paper_m, strict=True)
    )


CASES: Final = (
    Case(0, True, 0.0, 0.25),
    Case(0, False, 0.0, 0.04),
    *_cells(1, True, 0.05, 0.21, 0.19, 0.18, 0.17),
    *_cells(1, False, 6.11, 3.41, 0.02, 0.18, 0.16),
    *_cells(2, True, 0.19, 0.18, 0.18, 0.14, 0.17),
    *_cells(2, False, 0.21, 0.19, 0.17, 0.18, 0.18),
)


def oda_train() -> TrainType:
    """The paper's train."""
    return load_train(shipped_train("oda_train"))


def controller(gain_per_s: float, pattern_mps2: float = PATTERN_MPS2) -> Bench:
    """The paper's train with the one set of controller parameters of all runs."""
    driving = COASTING.model_copy(
        update={"stop_deceleration_mps2": pattern_mps2, "stop_gain_per_s": gain_per_s}
    )
    unit = UnitParameters(tag_accuracy_m=TAG_ACCURACY_M, wheel_error_share=BOUND_GROWTH)
    return Bench(oda_train(), driving, unit)


def plain_stop(speed_kmh: float) -> Rows:
    """A stop from `speed_kmh` without any position error; a row of STOP, shape (1,)."""
    stop = new_stops(1)
    stop["speed_mps"] = mps(speed_kmh)
    stop["start_m"] = START_M
    return stop


def stop_of(case: Case, frame_sign: float = -1.0) -> Rows:
    """A case's position errors; `frame_sign` -1: a picture shows the past, so the estimate lags the train."""
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
        stop["frame_s"] = frame_sign / FRAME_RATE_FPS
    return stop


def best_gain_per_s() -> float:
    """The gain with the least mean error over stops from several speeds without position error (3.2.3)."""
    stops = np.concatenate([plain_stop(kmh) for kmh in TRIAL_SPEEDS_KMH])

    def mean_error_m(gain_per_s: float) -> float:
        outcomes, _ = controller(gain_per_s).run(stops)
        return round(float(np.abs(outcomes["error_m"]).mean()), 4)  # a tenth of a millimetre decides nothing

    return min(GAINS_PER_S, key=mean_error_m)


def stop_errors_m(
    gain_per_s: float, pattern_mps2: float = PATTERN_MPS2, frame_sign: float = -1.0
) -> list[float]:
    """Stop position of each of CASES, m, positive past the mark."""
    stops = np.concatenate([stop_of(case, frame_sign) for case in CASES])
    outcomes, _ = controller(gain_per_s, pattern_mps2).run(stops)
    return [float(error_m) for error_m in outcomes["error_m"]]


def wheel_errors_m(gain_per_s: float) -> list[float]:
    """The same where the 1 % comes from the wheel's circumference, so that the speed is wrong by as much."""
    stops = np.concatenate([stop_of(case) for case in CASES])
    stops["wheel_error"], stops["count_error"] = stops["count_error"], 0.0
    outcomes, _ = controller(gain_per_s).run(stops)
    return [float(error_m) for error_m in outcomes["error_m"]]


def passes(case: Case, error_m: float) -> bool:
    """Whether our figure agrees with the paper's cell: the same verdict at 1 m and near enough."""
    if case.paper_m <= ACCURACY_M:
        return abs(error_m) <= PASSING_M
    near = abs(abs(error_m) - case.paper_m) <= FAILING_SHARE * case.paper_m
    return abs(error_m) > ACCURACY_M and near


def _criterion(case: Case) -> str:
    if case.paper_m <= ACCURACY_M:
        return f"at most {PASSING_M} m from the mark"
    return f"over {ACCURACY_M:g} m and within 40 % of {case.paper_m} m"


def impossible_stops() -> tuple[tuple[str, Verdict, Rows], ...]:
    """Name, expected verdict and STOP row of three stops that cannot be made, each with a stop limit."""
    weak = stop_of(Case(1, True, 100.0, 0.0))
    weak["brake_factor"] = 0.6
    weak["stop_limit_m"] = 20.0
    unseen = stop_of(Case(1, False, 0.0, 0.0))
    unseen["signs"] = 0
    unseen["expects_sign"] = 1
    unseen["stop_limit_m"] = 20.0
    beyond = stop_of(Case(1, False, 100.0, 0.0))
    beyond["stop_limit_m"] = -5.0
    return (
        ("brake at 60 % of its design", Verdict.BRAKE_TOO_WEAK, weak),
        ("target never seen", Verdict.TARGET_NOT_SEEN, unseen),
        ("sign 5 m behind the stop limit", Verdict.SIGN_BEYOND_LIMIT, beyond),
    )


def _impossible_row(name: str, expected: Verdict, stop_limit_m: float, result: StopResult) -> Row:
    ours = {
        "verdict": _words(result.verdict),
        "stopped_m": round(result.error_m, 2),
        "stop_limit_m": stop_limit_m,
        "emergency_brake": result.emergency,
    }
    criterion = f"reported as {_words(expected)}, and stopped within the stop limit"
    return Row(name, None, ours, result.verdict is expected and result.within_limit, criterion)


def _words(verdict: Verdict) -> str:
    return verdict.name.lower().replace("_", " ")


def parameters(gain_per_s: float) -> tuple[Parameter, ...]:
    """Every parameter of the runs with its origin."""
    left_out = "assumed: the paper leaves it out"
    train = oda_train().row.view(np.recarray)[0]
    return (
        Parameter("train", "oda_train", "", "3.2.3: equation 3 with 1177.2 and 784.8 kN, ten cars"),
        Parameter("dead time", float(train.brake_dead_time_s), "s", "3.2.3"),
        Parameter("greatest brake command", float(train.brake_deceleration_mps2[1]), "m/s^2", "3.2.3"),
        Parameter("greatest jerk", float(train.brake_jerk_max_mps3), "m/s^3", "3.2.3"),
        Parameter(
            "cumulative error", CUMULATIVE_ERROR * 100.0, "% of the distance run", "3.2.1; the speed is right"
        ),
        Parameter("beacons", "400, 100, 10", "m before the mark", "3.2.3 (1)"),
        Parameter("second target", SUB_TARGET_M, "m before the mark", "3.2.3 (3)"),
        Parameter(
            "frame rate", FRAME_RATE_FPS, "frames/s", "3.2.2, the camera of the trial; error by equation 1"
        ),
        Parameter(
            "last safety beacon",
            SAFETY_BEACON_M,
            "m before the mark",
            "3.2.1: about every 1000 m; its place is assumed",
        ),
        Parameter(
            "pattern deceleration",
            PATTERN_MPS2,
            "m/s^2",
            "not in the paper: the middle of the values with which both failing cells fit, one for all runs; see "
            "the remarks",
        ),
        Parameter(
            "proportional gain",
            gain_per_s,
            "1/s",
            "3.2.3: the best without position error, of 0.2 to 2.0 from 40 to 80 km/h",
        ),
        Parameter("speed at the beginning", SPEED_KMH, "km/h", left_out),
        Parameter("beginning", START_M, "m before the mark", left_out + "; the train coasts to the pattern"),
        Parameter(
            "flattest corrected pattern",
            PATTERN_LEAST_SHARE * PATTERN_MPS2,
            "m/s^2",
            "assumed: half the pattern",
        ),
        Parameter("bound of a fix at a beacon", TAG_ACCURACY_M, "m", "table 1: odometry and marker"),
        Parameter(
            "bounds of a sign",
            "those of the line's camera",
            "",
            "onboard.localisation.sighting, assumed there",
        ),
        Parameter("deceleration left at rest", END_MPS2, "m/s^2", "assumed: soft end of the pattern"),
        Parameter(
            "jerk of the soft end", END_JERK_MPS3, "m/s^3", "assumed: below what standing people notice"
        ),
        Parameter("least correction", CORRECTION_LEAST_M, "m", "assumed"),
        Parameter("control period", STEP_S, "s", "3.3.2: 100 ms on the scale track"),
    )


def agreeing_patterns_mps2(gain_per_s: float) -> tuple[float, ...]:
    """Of the pattern decelerations 0.70 to 0.90 m/s^2 by 0.01, those with which all 22 runs agree."""
    found: list[float] = []
    for hundredths in range(70, 91):
        errors = stop_errors_m(gain_per_s, hundredths / 100.0)
        if all(passes(case, error) for case, error in zip(CASES, errors, strict=True)):
            found.append(hundredths / 100.0)
    return tuple(found)


def reproduce(options: Options) -> Reproduction:
    """Run table 4; nothing is drawn at random, so the seed has no part in it."""
    gain = best_gain_per_s()
    errors = stop_errors_m(gain)
    rows = [
        Row(case.name, case.paper_m, round(error, 2), passes(case, error), _criterion(case))
        for case, error in zip(CASES, errors, strict=True)
    ]
    near, far = errors[CASES.index(_failing(20.0))], errors[CASES.index(_failing(40.0))]
    rows.append(Row("seen at 20 m is worse than at 40 m", True, near > far, near > far, "as in the paper"))
    bench = controller(gain)
    for name, expected, stop in impossible_stops():
        result, _ = bench.one(stop)
        rows.append(_impossible_row(name, expected, float(stop[0]["stop_limit_m"]), result))
    return Reproduction(
        "oda-table4",
        "Stops by beacons and by signs seen by a camera (Oda, table 4)",
        parameters(gain),
        tuple(rows),
        _remarks(options, gain),
    )


def _failing(detection_m: float) -> Case:
    return next(case for case in CASES if case.paper_m > ACCURACY_M and case.detection_m == detection_m)


def _remarks(options: Options, gain: float) -> tuple[str, ...]:
    remarks = [
        "The paper prints the size of the error; ours is positive past the mark.",
        "The stops run through the kernel and the tick of a line run: localisation with bounds and the one rule for "
        "fixes, supervision, TASC. In a loop of its own a fix acted within its step; now it acts in the next one, as "
        "on the line. With the pattern of 0.79 m/s^2, as before, that moves both failing cells: 6.12 to 6.22 m and "
        "2.86 to 3.01 m, the others by less than 0.03 m (a sign seen one step's run sooner gives the old figures), and "
        "the patterns with which all agree from 0.78 to 0.80 down by 0.01: hence 0.78 in place of 0.79.",
        "Stops that pass end nearer to the mark than the paper's: when a fix moves the estimate, our controller "
        "draws the pattern anew through the predicted state; the paper does not say what its own does.",
    ]
    if not options.quick:
        fitting = agreeing_patterns_mps2(gain)
        other = stop_errors_m(gain, frame_sign=1.0)
        same = all(passes(case, error) for case, error in zip(CASES, other, strict=True))
        by_wheel = wheel_errors_m(gain)
        missed = [
            f"{case.name}: {error:.2f} m"
            for case, error in zip(CASES, by_wheel, strict=True)
            if not passes(case, error)
        ]
        span = f"from {fitting[0]:.2f} to {fitting[-1]:.2f}" if fitting else "of no value tried"
        remarks += [
            f"All 22 runs agree with pattern decelerations {span} m/s^2: a train that sees the mark 10 m nearer "
            "than it believed, with 0.93 m/s^2 after 1 s, overruns by the paper's two figures only in that range.",
            "The pattern deceleration was inferred from these two cells: they confirm the model's form, not the "
            "number.",
            "The frame's error makes the estimate lag the train (a picture shows the past); with the opposite "
            f"sign the verdicts are {'the same' if same else 'not all the same'}.",
            "The paper puts the 1 % on the position alone. A worn wheel would show it in the speed too, and "
            f"proportional control then lags the pattern: {len(missed)} of 22 runs would not agree"
            f" ({'; '.join(missed)}).",
        ]
    return tuple(remarks)
