"""`branchline reproduce harada-accuracy`: where trains believe to be by curvature, at 200 places of a mountain line.

Harada, Maki, Kazato and Ishiguri, section 4 and figure 5: four runs over 88.5 km, 200 beacons of the train stop each,
a standard deviation of 0.65 m, all within 2 m. Ours are four runs of other days, trains of the kind, speeds and rails.
Each train has run the day before, so it knows its wheels (assumed: else it errs by what they are worn until the first
curve; told beside). The noise is that of a recorded gyro, as the settings have it, and not fitted; half and twice of it
are told beside.
With the filter off, or in time instead of space (3.3), the same runs are repeated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from network.files.kinds import origin_of
from onboard.localisation.curvature_map import CurvatureMap
from papers.charts import BLUE, ChartPage, Histogram, Panel, Plotted, Ruled
from papers.first_run import map_by_run
from papers.harada_bench import SHARED, Floats, PlannedTrip, TripRun, bounds_row, worst_m, worst_out_m
from papers.mountain_line import STATIONS, TRAIN_NUMBER, MountainLine, mountain_line
from papers.parameter_sets import LINE
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.specification import Findings, Specification
from simulation.sensor_settings import Curvature, Filter
from simulation.settings import PositionSensor
from study.report.style import RED

RUNS: Final = 4
SLOWER_MPS: Final = (0.0, 1.0, 2.0, 3.0)  # under the limits, beyond the driver's margin
SIGMA_MAX_M: Final = 0.65
WITHIN_M: Final = 2.0
NOISES: Final = (0.5, 2.0)
QUICK_STATIONS: Final = 4
SIGMA: Final = "standard deviation of the error"
WITHIN: Final = "errors at all check points"
BIN_M: Final = 0.25
SHOWN_M: Final = 5.0  # of the errors


@dataclass(frozen=True, slots=True)
class CaseRuns:
    """The runs of one case."""

    name: str
    rides: tuple[TripRun, ...]

    @property
    def errors_m(self) -> Floats:
        """Of all check points of all runs, m."""
        return np.concatenate([ride.errors_m for ride in self.rides])

    @property
    def sigma_m(self) -> float:
        """Standard deviation of the errors, m."""
        return float(self.errors_m.std())

    @property
    def figures(self) -> dict[str, Any]:
        """What a row says of them."""
        errors_m = self.errors_m
        return {
            "sigma_m": round(self.sigma_m, 3),
            "mean_m": round(float(errors_m.mean()), 3),
            "worst_m": round(worst_m(errors_m), 2),
            f"within_{WITHIN_M:g}_m": f"{int((np.abs(errors_m) <= WITHIN_M).sum())} of {errors_m.size}",
            "out_of_bounds_m": worst_out_m([ride.result for ride in self.rides]),
        }


@dataclass(frozen=True, slots=True)
class AccuracyBench:
    """What all cases share: the line, the map of a first run over it, the seed, and how many runs there are."""

    place: MountainLine
    first_run: CurvatureMap
    seed: int
    runs: int
    wheels: tuple[tuple[float, float], ...]  # what each train has learned of its own the day before

    def runs_of_case(
        self,
        name: str,
        *,
        by_design: bool = False,
        new_wheels: bool = False,
        carries: tuple[PositionSensor, ...] = (PositionSensor.CURVATURE,),
        **changed: object,
    ) -> CaseRuns:
        """The runs of one case: each with rails, train and gyro of its own, and slower than the one before.

        `by_design`: the map is not that of the first run; `new_wheels`: nothing is known of them.
        """
        settings = Curvature().model_copy(update=changed)
        charted = None if by_design else self.first_run
        trips = [
            PlannedTrip(
                self.place,
                carries,
                seed=self.seed + number,
                day=2 + number,
                slower_mps=SLOWER_MPS[number],
                curvature=settings,
                curvature_map=charted,
                wheels=None if new_wheels else self.wheels[number],
            )
            for number in range(self.runs)
        ]
        return CaseRuns(name, tuple(trip.run() for trip in trips))


def bench_of(seed: int, stations: int, runs: int) -> AccuracyBench:
    """The line of the seed, and the map that a first run of another train makes, on another day, by tags as it goes."""
    place = mountain_line(stations=stations)
    first = PlannedTrip(place, seed=seed + RUNS, day=1)
    before = mountain_line(stations=min(stations, QUICK_STATIONS))
    wheels = tuple(PlannedTrip(before, seed=seed + number, day=1).run().wheels for number in range(runs))
    return AccuracyBench(place, map_by_run(first.setup, TRAIN_NUMBER), seed, runs, wheels)


def wheels_alone(bench: AccuracyBench) -> CaseRuns:
    """The null method, over the whole line also where the others run a slice: what wheels lose grows with the way."""
    return replace(bench, place=mountain_line(stations=STATIONS)).runs_of_case(
        "wheels alone", by_design=True, carries=()
    )


def rows_of(
    space: CaseRuns, others: Sequence[CaseRuns], noisy: Sequence[CaseRuns], quick: str
) -> tuple[CaseRow, ...]:
    """The paper's figures beside ours, run by run and together; the other filters; other noise."""
    each = tuple(
        CaseRow(
            f"run {number}, {SLOWER_MPS[number - 1] * 3.6:g} km/h slower",
            None,
            CaseRuns("", (ride,)).figures,
            ride.result.arrived,
            "it arrives",
        )
        for number, ride in enumerate(space.rides, start=1)
    )
    return (
        *each,
        *accuracy(space, quick),
        *(
            CaseRow(
                f"the same with {runs.name}",
                "worse (3.3)",
                runs.figures,
                runs.sigma_m > space.sigma_m,
                "a greater sigma",
            )
            for runs in others
        ),
        *(
            CaseRow(f"the same with {runs.name}", None, runs.figures, all(ride.result.arrived for ride in runs.rides),
                "told; it arrives")
            for runs in noisy
        ),
        bounds_row(
            [ride for runs in (space, *others, *noisy) for ride in runs.rides], "never, in any step of any run"
        ),
    )  # fmt: skip


def accuracy(runs: CaseRuns, quick: str = "") -> tuple[CaseRow, CaseRow]:
    """What figure 5 is of, by whatever the runs know where they are; check points that none has passed are missed."""
    places = sum(len(ride.trip.place.line.tags) for ride in runs.rides)
    within = int((np.abs(runs.errors_m) <= WITHIN_M).sum()) == places
    sigma_m = runs.sigma_m
    return (
        CaseRow(SIGMA, SIGMA_MAX_M, round(sigma_m, 3), sigma_m <= SIGMA_MAX_M,
            f"at most {SIGMA_MAX_M:g} m{quick}"),
        CaseRow(WITHIN, "all within 2 m", runs.figures, within, f"every one of {places} within 2 m"),
    )  # fmt: skip


def parameters(runs: int) -> tuple[Parameter, ...]:
    """What was chosen, and why."""
    settings = Curvature()
    return (
        *SHARED,
        Parameter(
            "runs", runs, "", "section 4; seeds from --seed on, each another train, gyro, day and rails"
        ),
        Parameter(
            "speeds", "0, 3.6, 7.2 and 10.8 below", "km/h", "assumed: the paper's speeds are not given"
        ),
        Parameter("map", "of a first run", "", "3.1; of another train, on another day"),
        Parameter(
            "wheels",
            "known from the day before",
            "",
            f"assumed: each train has passed the first {QUICK_STATIONS} stations then, and learned within what",
        ),
        Parameter("gyro", settings.sample_sigma_degps, "deg/s a sample", _origin("sample_sigma_degps")),
        Parameter("samples of the gyro", settings.sample_rate_hz, "Hz", _origin("sample_rate_hz")),
        Parameter("bias", settings.bias_sigma_degps, "deg/s (sigma)", _origin("bias_sigma_degps")),
        Parameter("rails", str(settings.rails), "", _origin("rails")),
        Parameter("window", settings.window_m, "m", _origin("window_m")),
        Parameter("search", settings.search_m, "m", _origin("search_m")),
    )


def _origin(key: str) -> str:
    return origin_of(Curvature.model_fields[key])


def histogram(errors_m: Floats) -> dict[str, int]:
    """Figure 5: how many errors in each quarter of a metre."""
    most_m = BIN_M * np.ceil(worst_m(errors_m) / BIN_M)
    edges: Floats = np.arange(-most_m, most_m + BIN_M / 2.0, BIN_M)
    counts, _ = np.histogram(errors_m, edges)
    return {f"{low:g} to {low + BIN_M:g}": int(n) for low, n in zip(edges[:-1], counts, strict=True) if n}


def chart(space: CaseRuns, others: Sequence[CaseRuns]) -> ChartPage:
    """Figure 5, with the other filters beside it, and the errors over the way."""
    edges = np.arange(-SHOWN_M, SHOWN_M + BIN_M / 2.0, BIN_M)
    counts = [
        Histogram(
            np.clip(runs.errors_m, -SHOWN_M + 1e-3, SHOWN_M - 1e-3),
            edges,
            f"{runs.name}: sigma {runs.sigma_m:.2f} m",
            colour,
            filled=runs is space,
        )
        for runs, colour in zip((space, *others), (BLUE, RED, "#c08a2b"), strict=True)
    ]
    over_the_way = [
        Plotted(
            [(point.true_m - ride.base_m) / 1000.0 for point in ride.check_points],
            ride.errors_m,
            f"run {number}",
            None,
            ".",
        )
        for number, ride in enumerate(space.rides, start=1)
    ]
    limits_m = (-WITHIN_M, WITHIN_M)
    top = Panel(
        f"error at a check point, m (beyond {SHOWN_M:g} m in the last bins)",
        "check points",
        [*counts, Ruled(x=limits_m)],
        f"Errors at {space.errors_m.size} check points (the paper: sigma 0.65 m, all within 2 m)",
        grid=False,
    )
    below = Panel("kilometrage, km", "error, m", [*over_the_way, Ruled(y=limits_m)], columns=len(space.rides))
    return ChartPage("harada_errors", (9.0, 7.0), [[top], [below]])


def slice_of(options: Options) -> AccuracyBench:
    """The bench, quick: of two runs over the first stations."""
    if options.quick:
        return bench_of(options.seed, QUICK_STATIONS, 2)
    return bench_of(options.seed, STATIONS, RUNS)


def experiment(options: Options) -> Findings:
    """All runs, and figure 5."""
    bench = slice_of(options)
    space = bench.runs_of_case("the filter in space")
    others = [
        bench.runs_of_case("the filter off", filter=Filter.OFF),
        bench.runs_of_case("the filter in time", filter=Filter.TIME),
    ]
    design = bench.runs_of_case("the design as its map", by_design=True)
    noisy = [
        *(bench.runs_of_case(f"{factor:g} times the noise", noise_factor=factor) for factor in NOISES),
        bench.runs_of_case("wheels of which nothing is known", new_wheels=True),
        design,
    ]
    remarks = [
        "Error: estimate less truth in the step in which the front passes a check point; nothing is corrected there.",
        "The map is of a first run on another day, with the check points as known places; the design is told beside.",
    ]
    if space.sigma_m > SIGMA_MAX_M >= design.sigma_m:
        remarks.append(
            f"Missed by {space.sigma_m - SIGMA_MAX_M:.2f} m; by the design as map sigma is {design.sigma_m:.2f} m: it"
            " comes with the map of a first run."
        )
    quarters = histogram(space.errors_m)
    return Findings(
        rows_of(space, others, noisy, " (of a slice)" if options.quick else ""),
        parameters(bench.runs),
        remarks,
        [UnjudgedFigure("histogram of figure 5, m", quarters, "errors in each quarter of a metre")],
        accuracy(wheels_alone(bench)),
        chart(space, others).write,
    )


reproduce: Final = Specification(
    "harada-accuracy",
    "Train position by curvature on 88.5 km of a mountain line (Harada and others, section 4, figure 5)",
    experiment,
    NullMethod("wheels alone", (SIGMA, WITHIN), lambda options: accuracy(wheels_alone(slice_of(options)))),
    LINE,
    f"A short slice: 2 of {RUNS} runs, {QUICK_STATIONS} of {STATIONS} stations; by wheels alone all.",
)
