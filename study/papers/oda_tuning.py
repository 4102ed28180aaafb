"""`branchline reproduce oda-tuning`: trains with hidden characteristics learn them from 80 stops each (chapter 4).

Every train is fitted twice from the same stops, by the 441-point search and by the six-point approximation, and
each learns for itself. Then it makes as many stops again with what it learned.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.stop_keeper import believed_dead_time_s
from onboard.driving.tuning import (
    OFFSET_STEP_MPS2,
    SEARCH_EVALUATIONS,
    SIX_POINTS,
    STEP_S,
    Learned,
    StopRecord,
    approximate,
    learn,
    search,
)
from radio.chance import generator
from study.papers.parameter_sets import LINE, coasting
from study.papers.reproduction import Options, Parameter, Reproduction, Row
from study.papers.single_stop import Rows, new_stops
from study.papers.single_train import Bench
from study.papers.table4_stops import BEACONS_M, START_M, oda_train
from vehicle.train_file import TrainType

TRAINS: Final = 100
TRAINS_QUICK: Final = 12
RUNS: Final = 80
STATIONS: Final = 15
DAYS_PAPER: Final = 2
PATTERN_MPS2: Final = LINE.driving.stop_deceleration_mps2
DEAD_TIMES_S: Final = (0.5, 1.5)
LAGS_S: Final = (0.01, 0.3)
OFFSETS_KMHPS: Final = (-0.4, 0.4)
SPEEDS_MPS: Final = (13.0, 20.0)
BRAKE_SIGMA: Final = 0.02
WET_SHARE: Final = 0.15
WET_BRAKE: Final = 0.92
WET_ADHESION: Final = (0.45, 0.80)
FULL_BRAKE: Final = 0.95
FULL_FROM: Final = 0.9
GRADIENT_PERMILLE: Final = 10.0
GRADIENT_SIGMA_PERMILLE: Final = 0.5
WHEEL_ERROR: Final = 0.003
SPEED_NOISE_MPS: Final = 0.01
ROUNDING: Final = 1e-9


@dataclass(frozen=True, slots=True)
class Hidden:
    """What a train is really like and its unit does not know; the offset is that at the pattern's deceleration."""

    dead_time_s: float
    lag_s: float
    offset_mps2: float

    @property
    def delay_s(self) -> float:
        """Dead time as a learner without a lag in its model sees it, s: with the mean delay of the lag.

        In steps the response is 1 - exp(-k step / lag) from k = 1 on, whose mean delay is a little under the lag.
        """
        return self.dead_time_s + STEP_S / math.expm1(STEP_S / self.lag_s)

    @property
    def brake_factor(self) -> float:
        """Actual over designed deceleration: a command of b - offset gives b."""
        return PATTERN_MPS2 / (PATTERN_MPS2 - self.offset_mps2)


@dataclass(frozen=True, slots=True)
class Tuned:
    """One train's story: both learners, stops (m) before and after, and the run from which the mode was right."""

    hidden: Hidden
    by_search: Learned
    by_approximation: Learned
    before_m: NDArray[np.float64]
    after_m: NDArray[np.float64]
    slid: NDArray[np.bool_]  # in either of the two
    settled_after: int  # RUNS + 1: never

    @property
    def modes_agree(self) -> bool:
        """Whether both methods give the same characteristic."""
        first, second = self.by_search, self.by_approximation
        return (first.dead_time_s, first.offset_mps2) == (second.dead_time_s, second.offset_mps2)


def hidden_train(rng: np.random.Generator) -> Hidden:
    """A train's characteristics, drawn evenly; the dead time in whole steps, as the simulator has it."""
    return Hidden(
        round(float(rng.uniform(*DEAD_TIMES_S)), 1),
        float(rng.uniform(*LAGS_S)),
        float(rng.uniform(*OFFSETS_KMHPS)) / 3.6,
    )


def real_body(nominal: TrainType, hidden: Hidden) -> Rows:
    """The train's body with its own dead time and lag; the simulator moves in steps of 0.1 s; shape (1,)."""
    row = nominal.row.copy()
    row["brake_dead_time_s"] = hidden.dead_time_s
    row["brake_lag_s"] = hidden.lag_s
    return row


def a_stop(rng: np.random.Generator, hidden: Hidden) -> Rows:
    """One stop of the day with its disturbances: speed, load, rain, gradient, wheel; a row of STOP, shape (1,)."""
    stop = new_stops(1)
    stop["speed_mps"] = rng.uniform(*SPEEDS_MPS)
    stop["start_m"] = START_M
    stop["wheel_error"] = rng.uniform(-WHEEL_ERROR, WHEEL_ERROR)
    stop["beacons"] = len(BEACONS_M)
    stop["beacon_m"][0, : len(BEACONS_M)] = BEACONS_M
    gradient = rng.uniform(-GRADIENT_PERMILLE, GRADIENT_PERMILLE)
    stop["gradient_believed_permille"] = gradient
    stop["gradient_permille"] = gradient + rng.normal(0.0, GRADIENT_SIGMA_PERMILLE)
    stop["load_share"] = rng.uniform(0.0, 1.0)
    factor = hidden.brake_factor * (1.0 + rng.normal(0.0, BRAKE_SIGMA))
    if stop["load_share"][0] > FULL_FROM:
        factor *= FULL_BRAKE
    if rng.random() < WET_SHARE:
        factor *= WET_BRAKE
        stop["adhesion_factor"] = rng.uniform(*WET_ADHESION)
    stop["brake_factor"] = factor
    return stop


def with_noise(rng: np.random.Generator, record: StopRecord) -> StopRecord:
    """What the unit keeps of a stop if its tachometer's speed is noisy: the wave differentiates it."""
    noise_mps = rng.normal(0.0, SPEED_NOISE_MPS, record.actual_mps2.size + 1)
    return replace(record, actual_mps2=record.actual_mps2 - np.diff(noise_mps) / STEP_S)


def bench_with(nominal: TrainType, hidden: Hidden, learned: Learned) -> Bench:
    """The train with a controller that goes by what it learned: dead time (prediction) and offset (bias)."""
    return Bench(nominal, coasting(LINE.driving), LINE.unit, real_body(nominal, hidden), learned)


def is_right(learned: Learned, hidden: Hidden) -> bool:
    """Whether a mode is the truth to within one step of the grid in both."""
    return (
        learned.stops > 0
        and abs(learned.dead_time_s - hidden.delay_s) <= STEP_S + ROUNDING
        and abs(learned.offset_mps2 - hidden.offset_mps2) <= OFFSET_STEP_MPS2 + ROUNDING
    )


def tune(nominal: TrainType, seed: int, name: str) -> Tuned:
    """One train's runs untuned, learning from each, and the same days' stops again with what it learned."""
    hidden = hidden_train(generator(seed, "oda-tuning", name, "hidden"))
    rng = generator(seed, "oda-tuning", name, "stops")
    noise = generator(seed, "oda-tuning", name, "tachometer")
    stops = np.concatenate([a_stop(rng, hidden) for _ in range(RUNS)])
    by_search = by_approximation = Learned(name, believed_dead_time_s(nominal.row.view(np.recarray)[0]))
    delivered = bench_with(nominal, hidden, by_search)
    before, slid = np.zeros(RUNS), np.zeros(RUNS, dtype=np.bool_)
    settled_after = 1
    for index in range(RUNS):
        result, _ = delivered.one(stops[index : index + 1])
        before[index] = result.error_m
        slid[index] = result.slid
        kept = delivered.keeper().record(float(stops["load_share"][index]))
        if kept is not None:
            record = with_noise(noise, kept)
            by_search = learn(by_search, record, search(record))
            fit = approximate(record, by_approximation.centre)
            by_approximation = learn(by_approximation, record, fit)
        if not is_right(by_approximation, hidden):
            settled_after = index + 2
    outcomes, _ = bench_with(nominal, hidden, by_approximation).run(stops)
    after = np.array(outcomes["error_m"], dtype=np.float64)
    slid |= outcomes["slid_steps"] > 0
    return Tuned(hidden, by_search, by_approximation, before, after, slid, settled_after)


def parameters(trains: int) -> tuple[Parameter, ...]:
    """What was chosen, and why."""
    return (
        Parameter("trains", trains, "", "several trains, drawn at random; the paper has one"),
        Parameter("runs of each train", RUNS, "", "4.2.2: 80 runs between stations"),
        Parameter("dead times searched", "0 to 2 by 0.1", "s", "4.1.1"),
        Parameter("offsets searched", "-1 to +1 by 0.1", "km/h/s", "4.1.1"),
        Parameter("dead time as designed", float(oda_train().row["brake_dead_time_s"][0]), "s", "3.2.3"),
        Parameter(
            "hidden dead time",
            f"{DEAD_TIMES_S[0]} to {DEAD_TIMES_S[1]}",
            "s",
            "assumed, evenly, in steps of 0.1",
        ),
        Parameter("hidden lag", f"{LAGS_S[0]} to {LAGS_S[1]}", "s", "assumed, evenly"),
        Parameter(
            "hidden offset",
            f"{OFFSETS_KMHPS[0]} to {OFFSETS_KMHPS[1]}",
            "km/h/s",
            "assumed, evenly; the paper's train had 0.4 (4.2.2)",
        ),
        *LINE.parameters(),
        Parameter("beacons", "400, 100, 10", "m before the mark", "3.2.3 (1)"),
        Parameter("brake, stop to stop", BRAKE_SIGMA * 100.0, "% (sigma)", "assumed"),
        Parameter("stops in rain", WET_SHARE, "share", "assumed"),
        Parameter("brake in rain", WET_BRAKE, "of the dry one", "assumed"),
        Parameter(
            "adhesion in rain",
            f"{WET_ADHESION[0]} to {WET_ADHESION[1]}",
            "of the dry one",
            "assumed; some stops slide",
        ),
        Parameter("brake when full", FULL_BRAKE, "of the usual one", f"assumed, above a load of {FULL_FROM}"),
        Parameter("gradient not on the map", GRADIENT_SIGMA_PERMILLE, "permille (sigma)", "assumed"),
        Parameter("wheel's circumference", WHEEL_ERROR, "share, evenly", "assumed; distance and speed alike"),
        Parameter("tachometer's speed", SPEED_NOISE_MPS, "m/s (sigma)", "assumed"),
    )


def rows_of(tuned: list[Tuned]) -> tuple[Row, ...]:
    """The figures of chapter 4 beside ours."""
    agree = sum(train.modes_agree for train in tuned) / len(tuned)
    right = sum(is_right(train.by_approximation, train.hidden) for train in tuned) / len(tuned)
    slid = np.concatenate([train.slid for train in tuned])
    before = np.concatenate([train.before_m for train in tuned])[~slid]
    after = np.concatenate([train.after_m for train in tuned])[~slid]
    with_slides = {
        "before": round(float(np.std([train.before_m for train in tuned])), 3),
        "after": round(float(np.std([train.after_m for train in tuned])), 3),
        "share_slid": round(float(slid.mean()), 4),
    }
    settled = float(np.percentile([train.settled_after for train in tuned], 95))
    evaluations = {"search": SEARCH_EVALUATIONS, "approximation": len(SIX_POINTS)}
    sigma = {"before": round(float(before.std()), 3), "after": round(float(after.std()), 3)}
    within = {
        "before": round(float(np.mean(np.abs(before) <= 0.35)), 3),
        "after": round(float(np.mean(np.abs(after) <= 0.35)), 3),
    }
    left_out = sum(train.by_approximation.left_out for train in tuned) / slid.size
    return (
        Row("trains in which both methods give the same mode", 1.0, agree, agree >= 0.95, "at least 0.95"),
        Row(
            "evaluations of J a stop",
            {"search": 441, "approximation": 6},
            evaluations,
            evaluations == {"search": 441, "approximation": 6},
            "as in the paper",
        ),
        Row(
            "trains whose mode is right to one step of the grid",
            None,
            right,
            right >= 0.95,
            "at least 0.95",
        ),
        Row(
            "sigma of the stop position without slides, m",
            "less scatter (figure 27)",
            sigma,
            sigma["after"] < sigma["before"],
            "smaller after than before",
        ),
        Row(
            "stops within 0.35 m", None, within, within["after"] > within["before"], "more after than before"
        ),
        Row(
            "runs until the mode is right and stays so, 95 % of trains",
            DAYS_PAPER * STATIONS,
            settled,
            settled <= DAYS_PAPER * STATIONS,
            "at most 30: the paper's 2 days (6 by hand) at 15 stations",
        ),
        Row("sigma of the stop position with slides, m", None, with_slides, True, "told, not judged"),
        Row(
            "stops left out as disturbed, share", None, round(left_out, 3), left_out < 0.5, "fewer than half"
        ),
    )


def reproduce(options: Options) -> Reproduction:
    """Tune a fleet drawn from the seed."""
    count = TRAINS_QUICK if options.quick else TRAINS
    nominal = oda_train()
    tuned = [tune(nominal, options.seed, f"train {number}") for number in range(1, count + 1)]
    remarks = [
        "A stop in which the wheels slid before or after tuning is in neither figure of scatter: the tuning keeps "
        "such stops out, and cannot mend them.",
        "What is learned from is the wave that the tick keeps of each stop, as on the line, not a trace of the bench. "
        "Of 100 trains that left both methods agreeing on 96 (99 before), all modes right as before and the scatter "
        "after tuning at 0.27 m; why three more trains differ by a step of the grid has not been found out.",
        "The paper does not say where its six points lie, nor how it filters: their reach (0.2 s, 0.4 km/h/s) and the "
        "smoothing (1 s) were chosen on seeds 1 to 3 of this fleet.",
        "The paper counts days of adjusting 15 stations; ours counts runs, one at each station a day.",
        "A learner without a lag in its model takes the lag for dead time: the truth is the sum of the delays.",
    ]
    if options.quick:
        remarks.append(f"A short slice: {count} of {TRAINS} trains.")
    return Reproduction(
        "oda-tuning",
        "Self-tuning of dead time and deceleration offset (Oda, chapter 4)",
        parameters(count),
        rows_of(tuned),
        tuple(remarks),
    )
