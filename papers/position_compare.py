"""`branchline reproduce position-compare`: one run of 21 km with every sensor set, and everything that may fail.

Each set runs once with nothing failing, once with each fault that concerns it alone, and once with all of them in
turn; faults that no sensor claims to withstand are run too, and shown apart. What the line has for the sensors, and
what fails where, is in `position_sets`.

Error is the estimate less the truth; a bound is broken where the truth is outside in any
step of 0.1 s.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as PlotFigure
from numpy.typing import NDArray

from papers.charts import BAND
from papers.parameter_sets import LINE
from papers.position_run import half_widths_m
from papers.position_sets import (
    BEACONS_EVERY_M,
    HIDDEN_M,
    MARKERS_EVERY_M,
    MOVED_M,
    SETS,
    TROUBLES,
    TUNNEL_M,
    SensorSet,
    SensorSetRun,
    Trouble,
    run_with,
    troubles_concerning,
)
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.specification import Findings, Specification, none_of
from simulation.settings import PositionSensor
from study.report.style import INK, PALE, RED, RULE, WIDTH_IN, write_figure

NAME: Final = "position-compare"
QUICK: Final = ("GNSS, 3 m", "all")
FAR_M: Final = 500.0  # this far from the last fix the way counts as without one
CUT_M: Final = 1e-6  # by which bounds must be narrower than what wheels alone leave, to count as cut
OUTAGES_M: Final = tuple(range(1_000, 21_000, 1_500))
OUTAGE_M: Final = 700.0
OUTAGE_S: Final = 30.0
LEAST_OUTAGES: Final = 5
LEAST_MPS: Final = 8.0  # slower passages of an outage end at a stop, and say nothing of 30 s of running
GNSS_LOST_M: Final = 10.0
LIDAR_RMSE_M: Final = 5.0
ACTS_M: Final = 1e-3
CLAIMED_M: Final = 5.0  # as published accuracies have it: a figure that holds nearly always
HELD: Final = "runs inside the model in which the truth leaves the bounds"
Floats = NDArray[np.float64]
ROW_IN: Final = 1.45  # of the plot
FAULT: Final = "#fbe3c8"
LINEAR_M: Final = 1.0  # the scale is linear within so much of 0, and logarithmic beyond
LIMIT_M: Final = 1_000.0  # a train whose bounds are wider knows nothing
TICKS_M: Final = (-100.0, -10.0, -1.0, 0.0, 1.0, 10.0, 100.0)
PER_LINE: Final = 9


@dataclass(frozen=True, slots=True)
class Measures:
    """What one run comes to; lengths in m, shares of 1."""

    carried: str
    case: str
    inside_the_model: bool
    sigma_m: float
    error_95_m: float
    error_most_m: float
    half_median_m: float
    half_95_m: float
    without_fix_share: float
    unknown_share: float
    outside_s: int
    nearest_to_outside_m: float  # by how much the truth was outside at worst, or (negative) inside at least
    arrived: bool

    def in_one_line(self) -> str:
        """The figures in one line of a table."""
        return (
            f"sigma {self.sigma_m:.2f}, 95 % {self.error_95_m:.2f}, most {self.error_most_m:.1f};"
            f" half {self.half_median_m:.1f} / {self.half_95_m:.1f}; no fix {self.without_fix_share:.0%};"
            f" unknown {self.unknown_share:.0%}; outside {max(self.nearest_to_outside_m, 0.0):.2f}"
        )


def far_from_a_fix(ran: SensorSetRun) -> float:
    """Share of the way further than `FAR_M` from where bounds were last narrower than wheels alone leave them."""
    trace, half_m = ran.result.trace, half_widths_m(ran.result.trace)
    at_m = np.asarray(trace["position_m"], dtype=np.float64)
    run_m = np.diff(at_m)
    cut = np.diff(half_m) < np.maximum(run_m, 0.0) * LINE.unit.wheel_error_share / 2.0 - CUT_M
    last_m = np.maximum.accumulate(np.where(cut, at_m[1:], at_m[0]))
    far = at_m[1:] - last_m > FAR_M
    return float(run_m[far].sum() / max(run_m.sum(), 1.0))


def measures_of(ran: SensorSetRun) -> Measures:
    """The measures of a run, from a sample a second while it moves and from the worst of all steps."""
    result, trace = ran.result, ran.result.trace
    trace = trace[trace["speed_mps"] > 0.0]  # a train that waits is one place, however long
    error_m = np.asarray(trace["estimate_error_m"], dtype=np.float64)
    half_m = half_widths_m(trace)
    outside = (error_m > trace["bound_behind_m"]) | (-error_m > trace["bound_ahead_m"])
    return Measures(
        carried=ran.carried.name,
        case=ran.case,
        inside_the_model=ran.held,
        sigma_m=float(np.sqrt(np.mean(error_m**2))),
        error_95_m=float(np.percentile(np.abs(error_m), 95.0)),
        error_most_m=float(np.abs(error_m).max()),
        half_median_m=float(np.median(half_m)),
        half_95_m=float(np.percentile(half_m, 95.0)),
        without_fix_share=far_from_a_fix(ran),
        unknown_share=1.0 - result.known_steps / max(result.steps, 1),
        outside_s=int(np.sum(outside)),
        nearest_to_outside_m=float(result.out_m) if result.known_steps else np.nan,
        arrived=result.arrived,
    )


def runs_of(carried: SensorSet, seed: int, quick: bool) -> list[SensorSetRun]:
    """All runs of a set: nothing fails, each fault alone, all in turn; last those beyond the model."""
    cases: list[tuple[Trouble, ...]] = [(), troubles_concerning(carried)]
    if not quick:
        cases[1:1] = [(each,) for each in troubles_concerning(carried)]
        cases += [(each,) for each in troubles_concerning(carried, held=False)]
    return [run_with(carried, case, seed) for case in cases]


def row_of(measures: Measures) -> CaseRow:
    """A run as a row: bounds that hold are the criterion, where the fault is inside the model."""
    if not measures.inside_the_model:
        case = f"beyond the model: {measures.carried}: {measures.case}"
        return CaseRow(case, None, measures.in_one_line(), True, "told only")
    holds, criterion = measures.nearest_to_outside_m <= 0.0, "the truth inside in every step"
    return CaseRow(f"{measures.carried}: {measures.case}", None, measures.in_one_line(), holds, criterion)


def held_row(found: Sequence[Measures]) -> CaseRow:
    """Whether bounds hold in all runs whose faults are inside the model."""
    broken = sum(not each.nearest_to_outside_m <= 0.0 for each in found if each.inside_the_model)
    return none_of(HELD, broken)


def acting_row(runs: Sequence[SensorSetRun]) -> CaseRow:
    """Every fault changes what the unit believes or notes somewhere: one that does nothing shows nothing."""
    idle: list[str] = []
    for carried in SETS:
        own = [ran for ran in runs if ran.carried is carried]
        if not own:
            continue
        plain, plain_notes = own[0].result.trace, [note for _, _, note in own[0].result.notes]
        for ran in own[1:]:
            trace = ran.result.trace
            if [note for _, _, note in ran.result.notes] != plain_notes:
                continue
            if trace.size == plain.size and all(
                np.allclose(trace[name], plain[name], atol=ACTS_M)
                for name in ("position_m", "estimate_error_m", "bound_ahead_m", "bound_behind_m")
            ):
                idle.append(f"{carried.name}: {ran.case}")
    return CaseRow("faults that leave their run as it was", None, ", ".join(idle) or "none", not idle, "none")


# beside what others have published --------------------------------------------------------------------------------


def outages(carried: SensorSet, seed: int) -> Floats:
    """Largest error (m) within 30 s of each loss of GNSS, of a train that has wheels and whatever else the set has."""
    lost = tuple(
        Trouble("jammed", PositionSensor.GNSS, float(at_m), at_m + OUTAGE_M, "gnss_jammed")
        for at_m in OUTAGES_M
    )
    trace = run_with(carried, lost, seed).result.trace
    at_m = np.asarray(trace["position_m"], dtype=np.float64)
    error_m = np.abs(np.asarray(trace["estimate_error_m"], dtype=np.float64))
    largest: list[float] = []
    for lost_m in OUTAGES_M:
        first = int(np.searchsorted(at_m, lost_m))
        after = slice(first, first + round(OUTAGE_S) + 1)
        run_m = float(at_m[after][-1] - at_m[after][0]) if at_m[after].size else 0.0
        if LEAST_MPS * OUTAGE_S < run_m < OUTAGE_M:
            largest.append(float(error_m[after].max()))
    return np.array(largest)


def published_rows(runs: Sequence[SensorSetRun], seed: int) -> tuple[CaseRow, ...]:
    """Figures of others, measured on trains, beside ours, which are simulated: reported together, judged by theirs."""
    rows: list[CaseRow] = []
    for carried in SETS:
        alone = set(carried.carries) - {PositionSensor.CURVATURE}
        if alone != {PositionSensor.GNSS}:
            continue
        largest_m = outages(carried, seed)
        rows.append(
            CaseRow(
                f"largest error within 30 s after GNSS is lost, wheels, {carried.name}",
                "below 10 m, measured, inertial sensors and map without wheels (arXiv 2406.02339)",
                f"{largest_m.max():.1f} m in {largest_m.size} outages, simulated",
                bool(largest_m.size >= LEAST_OUTAGES and largest_m.max() < GNSS_LOST_M),
                f"below {GNSS_LOST_M:g} m",
            )
        )
    for ran in runs:
        if ran.carried.carries == (PositionSensor.LIDAR,) and not ran.troubles:
            sigma_m = measures_of(ran).sigma_m
            rows.append(
                CaseRow(
                    "root mean square error with LiDAR and known places",
                    "5 m, measured, LiDAR, inertial sensors and kilometre posts (Sensors 25(15), 4637)",
                    f"{sigma_m:.2f} m, simulated, markers and wheels",
                    sigma_m <= LIDAR_RMSE_M,
                    f"at most {LIDAR_RMSE_M:g} m",
                )
            )
    return tuple(rows)


def parameters() -> tuple[Parameter, ...]:
    """What the line is given, and what is assumed of it."""
    hidden = ", ".join(f"{from_m / 1e3:g}-{to_m / 1e3:g}" for from_m, to_m in HIDDEN_M)
    return (
        Parameter(
            "tunnel", f"{TUNNEL_M[0] / 1e3:g}-{TUNNEL_M[1] / 1e3:g}", "km", "assumed: the line has none"
        ),
        Parameter("part of the sky hidden", hidden, "km", "assumed: stations, trees and a cutting"),
        Parameter("a beacon each", BEACONS_EVERY_M, "m", "assumed: about as Harada, table 1"),
        Parameter("markers each", MARKERS_EVERY_M, "m", "assumed: between stations"),
        Parameter("moved tags and beacons", MOVED_M, "m", "assumed: a tag laid anew beside a repaired joint"),
    )


def write_table(runs: Sequence[Measures], folder: Path) -> Path:
    """Write the measures of all runs as a CSV below `folder`, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "position_compare.csv"
    names = [field.name for field in fields(Measures)]
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(names)
        writer.writerows([getattr(run, name) for name in names] for run in runs)
    return file


def numbers() -> Mapping[str, int]:
    """The number that stands for a fault in the plot."""
    return {trouble.name: number for number, trouble in enumerate((t for t in TROUBLES if t.held), start=1)}


def draw_comparison(runs: Sequence[SensorSetRun]) -> PlotFigure:
    """Left what nothing disturbs, right everything that may fail, in turn; all of the same scale."""
    sets = [carried for carried in SETS if any(ran.carried is carried for ran in runs)]
    figure = PlotFigure(figsize=(WIDTH_IN, 1.2 + ROW_IN * len(sets)), layout="constrained")
    grid = figure.subplots(len(sets), 2, sharex=True, sharey=True, squeeze=False)
    for carried, (left, right) in zip(sets, grid, strict=True):
        plain = next(ran for ran in runs if ran.carried is carried and not ran.troubles)
        troubled = next((ran for ran in runs if ran.carried is carried and len(ran.troubles) > 1), plain)
        for axes, ran in ((left, plain), (right, troubled)):
            _draw_run(axes, ran)
        left.set_ylabel(carried.name, rotation=0, ha="right", va="center", fontsize=8.5)
    grid[0][0].set_title("nothing fails")
    grid[0][1].set_title("faults, one after the other")
    for axes in grid[-1]:
        axes.set_xlabel("way from Karasuyama, km")
    handles, labels = grid[0][0].get_legend_handles_labels()
    words = [f"{number} {name}" for name, number in numbers().items()]
    lines = ["   ".join(words[first : first + PER_LINE]) for first in range(0, len(words), PER_LINE)]
    figure.legend(handles, labels, loc="outside upper right", ncols=4)
    figure.suptitle(
        "Error of the estimated position, and the bounds that must hold it, m (linear to 1 m, then by powers of ten)",
        x=0.01,
        ha="left",
        fontsize=9.5,
        color=INK,
    )
    figure.supxlabel(
        "\n".join(["faults, in force where the right side is shaded:", *lines]), fontsize=8.0, color=INK
    )
    return figure


def _draw_run(axes: Axes, ran: SensorSetRun) -> None:
    trace = ran.result.trace
    km = trace["position_m"] / 1e3
    axes.axvspan(TUNNEL_M[0] / 1e3, TUNNEL_M[1] / 1e3, ymin=0.95, color=PALE, lw=0, label="tunnel")
    for number, (from_m, to_m) in enumerate(HIDDEN_M):
        label = "part of the sky hidden" if number == 0 else None
        axes.axvspan(from_m / 1e3, to_m / 1e3, ymin=0.95, color=RULE, lw=0, label=label)
    for trouble in ran.troubles:
        axes.axvspan(trouble.from_m / 1e3, max(trouble.to_m, trouble.from_m + 60.0) / 1e3, color=FAULT, lw=0)
        axes.annotate(
            str(numbers()[trouble.name]),
            (trouble.from_m / 1e3, -LIMIT_M),
            fontsize=7.0,
            color=INK,
            xytext=(1.0, 2.0),
            textcoords="offset points",
        )
    axes.fill_between(
        km,
        -trace["bound_ahead_m"],
        trace["bound_behind_m"],
        color=BAND,
        lw=0,
        label="bounds: the error lies in here",
    )
    axes.plot(km, trace["estimate_error_m"], color=RED, lw=0.9, label="error")
    axes.axhline(0.0, color=PALE, lw=0.4)
    axes.set_yscale("symlog", linthresh=LINEAR_M, linscale=0.8)
    axes.set_ylim(-LIMIT_M, LIMIT_M)
    axes.set_yticks(TICKS_M, [f"{tick:g}" for tick in TICKS_M])
    axes.minorticks_off()
    axes.set_xlim(0.0, 21.4)
    axes.grid(visible=True, axis="y")


def claimed_row(found: Sequence[Measures]) -> CaseRow:
    """The null method: the same runs, judged as if the claimed accuracy were their bounds."""
    return held_row([replace(each, nearest_to_outside_m=each.error_most_m - CLAIMED_M) for each in found])


def runs_with(options: Options) -> list[SensorSetRun]:
    """All runs of all sets, or of those of the short slice."""
    sets = [carried for carried in SETS if not options.quick or carried.name in QUICK]
    return [ran for carried in sets for ran in runs_of(carried, options.seed, options.quick)]


def experiment(options: Options) -> Findings:
    """All runs of all sets, the table, and the plot."""
    runs = runs_with(options)
    found = [measures_of(ran) for ran in runs]
    beside = () if options.quick else published_rows(runs, options.seed)
    sets = len({ran.carried.name for ran in runs})
    return Findings(
        (*map(row_of, found), acting_row(runs), *beside, held_row(found)),
        parameters(),
        [
            "ours is simulated; published figures are of measured runs with other trains, lines and sensors",
            "sigma, 95 %, most: error of the estimate, m; half: median and 95 % of the bounds' half width, m; no fix:"
            f" share of the way further than {FAR_M:g} m from a fix; unknown: share of the time without a position;"
            " outside: by how much the truth left the bounds, m",
        ],
        (
            UnjudgedFigure("runs", len(runs), f"of {sets} sets, {len(TROUBLES)} faults"),
            *(
                UnjudgedFigure(
                    f"outside, {each.carried}: {each.case}, m",
                    round(each.nearest_to_outside_m, 2),
                    "beyond the model",
                )
                for each in found
                if not each.inside_the_model
            ),
        ),
        [claimed_row(found)],
        lambda folder: (
            *write_figure("position_compare", lambda: draw_comparison(runs), folder),
            write_table(found, folder),
        ),
    )


reproduce: Final = Specification(
    NAME,
    "One run of 21 km with every sensor set: error and bound over distance, and what faults do to them",
    experiment,
    NullMethod(
        f"an accuracy of {CLAIMED_M:g} m claimed in place of bounds",
        (HELD,),
        lambda options: [claimed_row([measures_of(ran) for ran in runs_with(options)])],
    ),
    LINE,
    f"quick: {' and '.join(QUICK)} alone, no fault by itself, nothing beside what others published",
)
