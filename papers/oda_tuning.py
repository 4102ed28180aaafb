"""`branchline reproduce oda-tuning`: trains with hidden characteristics learn them from 80 stops each (chapter 4).

Every train is fitted twice from the same stops, by the 441-point search and by the six-point approximation, and
each learns for itself. It is judged on as many stops of other days, which nobody learned from: untuned, tuned, and as
it would be tuned by the mean in place of the mode, and with the disturbed stops kept.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.stop_keeper import believed_dead_time_s
from onboard.driving.tuning import (
    LOAD_SHARE_MAX,
    SEARCH_EVALUATIONS,
    SIX_POINTS,
    STEP_S,
    Learned,
    StopDecelerations,
    approximate,
    learned_after_stop,
    search,
)
from papers.line_stops import NEAR_M, NEAR_SHARE, place_of, places_are_near
from papers.parameter_sets import LINE, coasting
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.single_run import Rows, new_stops
from papers.single_train import Bench
from papers.specification import Evenly, Findings, Specification, equal_figure, none_of
from papers.table4_stops import BEACONS_M, START_M, oda_train
from papers.tag_trials import clopper_pearson
from radio.chance import generator
from vehicle.train_file import TrainType

SIGMA: Final = "sigma of held-out stops, m"
AWAY: Final = "root mean square distance of held-out stops from the mark, m"
NEAR: Final = f"held-out stops within {NEAR_M} m"
TRAINS: Final = 100
TRAINS_QUICK: Final = 12
RUNS: Final = 160
STATIONS: Final = 15
DAYS_PAPER: Final = 2
PATTERN_MPS2: Final = LINE.driving.stop_deceleration_mps2
DEAD_TIME_S: Final = Evenly("hidden dead time", 0.5, 1.5, "s", "assumed, evenly, in steps of 0.1")
LAG_S: Final = Evenly("hidden lag", 0.01, 0.3, "s", "assumed, evenly")
OFFSET_KMHPS: Final = Evenly(
    "hidden offset", -0.4, 0.4, "km/h/s", "assumed, evenly; the paper's train had 0.4 (4.2.2)"
)
SPEEDS_MPS: Final = (13.0, 20.0)
BRAKE_SIGMA: Final = 0.02
WET_SHARE: Final = 0.30
WET_BRAKE: Final = 0.85
WET_ADHESION: Final = Evenly("adhesion in rain", 0.4, 0.7, "of the dry one", "assumed; some stops slide")
FULL_SHARE: Final = 0.50
FULL_BRAKE: Final = 0.92
SHARE: Final = 0.95  # of trains
GRADIENT_PERMILLE: Final = 10.0
GRADIENT_SIGMA_PERMILLE: Final = 0.5
WHEEL_ERROR: Final = 0.003
SPEED_NOISE_MPS: Final = 0.01


@dataclass(frozen=True, slots=True)
class HiddenBrake:
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


class TunedBy(Enum):
    """Whose characteristic the controller goes by; the value is how it is printed."""

    NONE = "untuned"
    MODE = "tuned"
    MEAN = "by the mean"
    KEPT = "disturbed stops kept"


@dataclass(frozen=True, slots=True)
class TunedTrain:
    """One train's story: what was learned, from when on it was right, and the stops of other days by it, m."""

    hidden: HiddenBrake
    by_search: Learned
    learned: Mapping[TunedBy, Learned]
    held_out_m: Mapping[TunedBy, NDArray[np.float64]]
    ordinary: NDArray[np.bool_]  # of the stops of other days: neither rain nor a full train
    full_counted: int  # stops with a full train that were learned from nevertheless
    settled_after: (
        int  # counted stops until the mode was right and stayed so; more than it makes: it never was
    )

    @property
    def by_approximation(self) -> Learned:
        """What the train goes by."""
        return self.learned[TunedBy.MODE]


def hidden_train(rng: np.random.Generator) -> HiddenBrake:
    """A train's characteristics, drawn evenly; the dead time in whole steps, as the simulator has it."""
    return HiddenBrake(
        round(DEAD_TIME_S.draw(rng), 1),
        LAG_S.draw(rng),
        OFFSET_KMHPS.draw(rng) / 3.6,
    )


def real_body(nominal: TrainType, hidden: HiddenBrake) -> Rows:
    """The train's body with its own dead time and lag; the simulator moves in steps of 0.1 s; shape (1,)."""
    row = nominal.row.copy()
    row["brake_dead_time_s"] = hidden.dead_time_s
    row["brake_lag_s"] = hidden.lag_s
    return row


def a_stop(rng: np.random.Generator, hidden: HiddenBrake) -> Rows:
    """One stop of the day with its disturbances: speed, load, rain, gradient, wheel; shape (1,)."""
    stop = new_stops(1)
    stop["speed_mps"] = rng.uniform(*SPEEDS_MPS)
    stop["start_m"] = START_M
    stop["wheel_error"] = rng.uniform(-WHEEL_ERROR, WHEEL_ERROR)
    stop["beacons"] = len(BEACONS_M)
    stop["beacon_m"][0, : len(BEACONS_M)] = BEACONS_M
    gradient = rng.uniform(-GRADIENT_PERMILLE, GRADIENT_PERMILLE)
    stop["gradient_believed_permille"] = gradient
    stop["gradient_permille"] = gradient + rng.normal(0.0, GRADIENT_SIGMA_PERMILLE)
    full = rng.random() < FULL_SHARE
    stop["load_share"] = rng.uniform(LOAD_SHARE_MAX, 1.0) if full else rng.uniform(0.0, LOAD_SHARE_MAX)
    factor = hidden.brake_factor * (1.0 + rng.normal(0.0, BRAKE_SIGMA))
    if full:
        factor *= FULL_BRAKE
    if rng.random() < WET_SHARE:
        factor *= WET_BRAKE
        stop["adhesion_factor"] = WET_ADHESION.draw(rng)
    stop["brake_factor"] = factor
    return stop


def with_noise(rng: np.random.Generator, record: StopDecelerations) -> StopDecelerations:
    """What the unit keeps of a stop if its tachometer's speed is noisy: the wave differentiates it."""
    noise_mps = rng.normal(0.0, SPEED_NOISE_MPS, record.actual_mps2.size + 1)
    return replace(record, actual_mps2=record.actual_mps2 - np.diff(noise_mps) / STEP_S)


def bench_with(nominal: TrainType, hidden: HiddenBrake, learned: Learned) -> Bench:
    """The train with a controller that goes by what it learned: dead time (prediction) and offset (bias)."""
    return Bench(nominal, coasting(LINE.driving), LINE.unit, real_body(nominal, hidden), learned)


def is_right(learned: Learned, hidden: HiddenBrake) -> bool:
    """Whether a mode is the truth to within one step of the grid in both."""
    truth = (hidden.delay_s, hidden.offset_mps2)
    return learned.stops > 0 and places_are_near(place_of(learned), truth)


def is_full(stops: Rows) -> NDArray[np.bool_]:
    """Which stops are made with a train beyond the end of its load compensation."""
    return np.asarray(stops["load_share"] > LOAD_SHARE_MAX)


def by_the_mean(learned: Learned) -> Learned:
    """What the train would go by if the mean of the stops counted and not their mode."""
    if learned.stops == 0:
        return learned
    at_mean = (_all_at_mean(learned.dead_time_counts), _all_at_mean(learned.offset_counts))
    return replace(learned, dead_time_counts=at_mean[0], offset_counts=at_mean[1])


def _all_at_mean(counts: tuple[int, ...]) -> tuple[int, ...]:
    place = round(sum(index * count for index, count in enumerate(counts)) / sum(counts))
    return tuple(sum(counts) * int(index == place) for index in range(len(counts)))


def tune(nominal: TrainType, seed: int, name: str) -> TunedTrain:
    """One train's runs untuned, learning from each, and stops of other days by what it learned."""
    hidden = hidden_train(generator(seed, "oda-tuning", name, "hidden"))
    rng = generator(seed, "oda-tuning", name, "stops")
    noise = generator(seed, "oda-tuning", name, "tachometer")
    stops = np.concatenate([a_stop(rng, hidden) for _ in range(RUNS)])
    new = Learned(name, believed_dead_time_s(nominal.row.view(np.recarray)[0]))
    by_search = by_approximation = keeping = new
    delivered = bench_with(nominal, hidden, new)
    settled_after = full_counted = 0
    for index, full in enumerate(is_full(stops)):
        delivered.single_stop(stops[index : index + 1])
        kept = delivered.keeper().record(float(stops["load_share"][index]))
        if kept is not None:
            record = with_noise(noise, kept)
            by_search = learned_after_stop(by_search, record, search(record))
            before = by_approximation.stops
            by_approximation = learned_after_stop(
                by_approximation, record, approximate(record, by_approximation.centre)
            )
            full_counted += int(full) * (by_approximation.stops - before)
            plain = replace(record, slid=False, load_share=0.0)
            keeping = learned_after_stop(keeping, plain, approximate(plain, keeping.centre))
        if not is_right(by_approximation, hidden):
            settled_after = RUNS + 1 if index == RUNS - 1 else by_approximation.stops + 1
    learned = {
        TunedBy.NONE: new,
        TunedBy.MODE: by_approximation,
        TunedBy.MEAN: by_the_mean(by_approximation),
        TunedBy.KEPT: keeping,
    }
    held_out, ordinary = other_days(seed, name, hidden)
    errors = {tuning: stops_by(nominal, hidden, known, held_out) for tuning, known in learned.items()}
    return TunedTrain(hidden, by_search, learned, errors, ordinary, full_counted, settled_after)


def never_tuned(nominal: TrainType, seed: int, name: str) -> TunedTrain:
    """The null method: the same train on the same other days, as it was delivered whatever it is judged by."""
    hidden = hidden_train(generator(seed, "oda-tuning", name, "hidden"))
    new = Learned(name, believed_dead_time_s(nominal.row.view(np.recarray)[0]))
    held_out, ordinary = other_days(seed, name, hidden)
    errors = stops_by(nominal, hidden, new, held_out)
    return TunedTrain(
        hidden, new, dict.fromkeys(TunedBy, new), dict.fromkeys(TunedBy, errors), ordinary, 0, settled_after=0
    )


def other_days(seed: int, name: str, hidden: HiddenBrake) -> tuple[Rows, NDArray[np.bool_]]:
    """Stops that nobody learns from, and which of them are neither in rain nor with a full train."""
    rng = generator(seed, "oda-tuning", name, "held out")
    stops = np.concatenate([a_stop(rng, hidden) for _ in range(RUNS)])
    return stops, ~is_full(stops) & (stops["adhesion_factor"] == 1.0)


def stops_by(nominal: TrainType, hidden: HiddenBrake, learned: Learned, stops: Rows) -> NDArray[np.float64]:
    """Where these stops end by what was learned, m past the mark."""
    outcomes, _ = bench_with(nominal, hidden, learned).run(stops)
    return np.array(outcomes["error_m"], dtype=np.float64)


def parameters(trains: int) -> tuple[Parameter, ...]:
    """What was chosen, and why."""
    return (
        Parameter("trains", trains, "", "several trains, drawn at random; the paper has one"),
        Parameter(
            "runs of each train",
            RUNS,
            "",
            "4.2.2: 80 runs between stations; as many again with full trains, which do not count",
        ),
        Parameter("dead times searched", "0 to 2 by 0.1", "s", "4.1.1"),
        Parameter("offsets searched", "-1 to +1 by 0.1", "km/h/s", "4.1.1"),
        Parameter("dead time as designed", float(oda_train().row["brake_dead_time_s"][0]), "s", "3.2.3"),
        *(each.parameter for each in (DEAD_TIME_S, LAG_S, OFFSET_KMHPS)),
        Parameter("beacons", "400, 100, 10", "m before the mark", "3.2.3 (1)"),
        Parameter("brake, stop to stop", BRAKE_SIGMA * 100.0, "% (sigma)", "assumed"),
        Parameter("stops in rain", WET_SHARE, "share", "assumed: a wet season"),
        Parameter("brake in rain", WET_BRAKE, "of the dry one", "assumed: wet discs, which nothing reports"),
        WET_ADHESION.parameter,
        Parameter("stops with a full train", FULL_SHARE, "share", "assumed: the peaks of a commuter line"),
        Parameter(
            "brake when full",
            FULL_BRAKE,
            "of the usual one",
            f"assumed: the load compensation ends at a load of {LOAD_SHARE_MAX}",
        ),
        Parameter("gradient not on the map", GRADIENT_SIGMA_PERMILLE, "permille (sigma)", "assumed"),
        Parameter("wheel's circumference", WHEEL_ERROR, "share, evenly", "assumed; distance and speed alike"),
        Parameter("tachometer's speed", SPEED_NOISE_MPS, "m/s (sigma)", "assumed"),
    )


def _rms_m(errors_m: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(errors_m**2)))


def held_out(tuned: list[TunedTrain], tuning: TunedBy, *, ordinary: bool) -> NDArray[np.float64]:
    """Stops of other days by one tuning, all of them or the ordinary ones, m past the mark."""
    return np.concatenate([t.held_out_m[tuning][t.ordinary if ordinary else slice(None)] for t in tuned])


def interval_reaches(count: int, trains: int) -> bool:
    """Whether the 95 % interval of a count's share reaches SHARE."""
    return clopper_pearson(count, trains, SHARE).high >= SHARE


def learning_rows(tuned: list[TunedTrain]) -> tuple[CaseRow, ...]:
    """What was learned, and how."""
    same = sum(place_of(train.by_search) == place_of(train.by_approximation) for train in tuned)
    near = sum(
        places_are_near(place_of(train.by_search), place_of(train.by_approximation)) for train in tuned
    )
    agree = interval_reaches(same, len(tuned)) and near == len(tuned)
    evaluations = {"search": SEARCH_EVALUATIONS, "approximation": len(SIX_POINTS)}
    paper = {"search": 441, "approximation": 6}
    right = {
        tuning.value: sum(is_right(train.learned[tuning], train.hidden) for train in tuned)
        for tuning in TunedBy
    }
    mode = right[TunedBy.MODE.value]
    best = interval_reaches(mode, len(tuned)) and mode > max(
        right[TunedBy.MEAN.value], right[TunedBy.KEPT.value]
    )
    differ = sum(
        place_of(train.learned[TunedBy.MEAN]) != place_of(train.by_approximation) for train in tuned
    ) / len(tuned)
    full = sum(train.full_counted for train in tuned)
    settled = float(np.percentile([train.settled_after for train in tuned], 95))
    return (
        CaseRow(
            f"of {len(tuned)} trains, those in which both methods give the same mode",
            "1 of 1",
            {"the same": same, "to a step of the grid": near},
            agree,
            f"the same in {SHARE}, by its 95 % interval; all to a step",
        ),
        equal_figure("evaluations of J a stop", paper, evaluations, "as in the paper"),
        CaseRow(
            f"of {len(tuned)} trains, those that go by what is right to one step of the grid",
            None,
            right,
            best,
            f"tuned: {SHARE}, by its 95 % interval, and more than by the mean or with disturbed stops kept",
        ),
        CaseRow(
            "trains whose mean lies elsewhere than their mode",
            None,
            differ,
            differ >= 0.5,
            "at least half: else nothing here could tell them apart",
        ),
        none_of("stops of full trains that were learned from", full, "none (4.1.1)"),
        CaseRow(
            "stops that count until the mode is right and stays so, 95 % of trains",
            DAYS_PAPER * STATIONS,
            round(settled, 1),
            settled <= DAYS_PAPER * STATIONS,
            "at most 30: the paper's 2 days of adjusting (6 by hand) at 15 stations",
        ),
    )


def stop_rows(tuned: list[TunedTrain]) -> tuple[CaseRow, ...]:
    """What it does to stops that nobody learned from, dry and not full: those are the train's own."""
    errors = {tuning: held_out(tuned, tuning, ordinary=True) for tuning in TunedBy}
    rms = {tuning: _rms_m(found) for tuning, found in errors.items()}
    sigma = {t.value: round(float(errors[t].std()), 3) for t in (TunedBy.NONE, TunedBy.MODE)}
    within = {t.value: round(float(np.mean(np.abs(found) <= NEAR_M)), 4) for t, found in errors.items()}
    return (
        CaseRow(
            SIGMA,
            "less scatter (figure 27)",
            sigma,
            sigma[TunedBy.MODE.value] < sigma[TunedBy.NONE.value],
            "smaller tuned than untuned",
        ),
        CaseRow(
            AWAY,
            None,
            {tuning.value: round(value, 3) for tuning, value in rms.items()},
            rms[TunedBy.MODE] < min(value for tuning, value in rms.items() if tuning is not TunedBy.MODE),
            "smallest tuned",
        ),
        CaseRow(
            NEAR,
            None,
            within,
            within[TunedBy.MODE.value] >= NEAR_SHARE,
            f"{100.0 * NEAR_SHARE:g} % tuned, as line-stops asks",
        ),
    )


def untuned(train: TunedTrain) -> TunedTrain:
    """The train as if what it learned were what it was delivered with."""
    return replace(train, held_out_m={**train.held_out_m, TunedBy.MODE: train.held_out_m[TunedBy.NONE]})


def figures_of(tuned: list[TunedTrain]) -> tuple[UnjudgedFigure, ...]:
    """What tuning does where the day disturbs the stop, and how much was left out."""
    with_all = {t.value: round(_rms_m(held_out(tuned, t, ordinary=False)), 3) for t in TunedBy}
    left_out = sum(train.by_approximation.left_out for train in tuned) / (len(tuned) * RUNS)
    return (
        UnjudgedFigure(
            "root mean square distance of all held-out stops, m",
            with_all,
            "rain and full trains too: tuning describes the train, following and beacons must make good the day",
        ),
        UnjudgedFigure(
            "stops left out of the learning, share", round(left_out, 3), f"full trains: {FULL_SHARE}"
        ),
    )


def fleet(count: int, seed: int) -> list[tuple[TrainType, int, str]]:
    """Trains to be tuned, drawn from the seed."""
    return [(oda_train(), seed, f"train {number}") for number in range(1, count + 1)]


def experiment(options: Options) -> Findings:
    """Tune a fleet, and make stops of other days with it."""
    tuned = [tune(*train) for train in fleet(TRAINS_QUICK if options.quick else TRAINS, options.seed)]
    return Findings(
        (*learning_rows(tuned), *stop_rows(tuned)),
        parameters(len(tuned)),
        [
            "Tuned and untuned trains make the same stops of other days, drawn apart from those that were learned "
            "from. Judged are dry stops of trains that are not full: what is learned is the train. The mean, and a "
            "mode with the disturbed stops kept, take the weather and the peaks for the train.",
            "What is learned from is the wave that the tick keeps of each stop, as on the line, not a trace of the"
            " bench.",
            "The paper does not say where its six points lie, nor how it filters: their reach (0.2 s, 0.4 km/h/s) and "
            "the smoothing (1 s) were chosen on seeds 1 to 3 of this fleet.",
            "The paper counts days of adjusting 15 stations; ours counts stops, one at each station a day, of those "
            "the ones that are learned from: trains under adjustment carry no passengers.",
            "Where the two methods differ it is by a step of the grid: the truth lies between two places of nearly as "
            "many stops, and the approximation puts some of them to the other.",
            "A learner without a lag in its model takes the lag for dead time: the truth is the sum of the delays.",
        ],
        figures_of(tuned),
        stop_rows([untuned(train) for train in tuned]),
    )


reproduce: Final = Specification(
    "oda-tuning",
    "Self-tuning of dead time and deceleration offset (Oda, chapter 4)",
    experiment,
    NullMethod(
        "nothing is learned",
        (NEAR,),
        lambda options: stop_rows([never_tuned(*train) for train in fleet(TRAINS_QUICK, options.seed)]),
    ),
    LINE,
    f"A short slice: {TRAINS_QUICK} of {TRAINS} trains.",
)
