"""What knowing where the train is means to operations: the Karasuyama weekday by sensor sets, whole and failing.

Each case is a scenario of its own that extends the line's day, read through the same door as a planner's file. What is
compared: bounds on the way, where a section could be given back (at its arrival tag) and at the mark; how long after
the whole train has truly left a section it is free again; where trains stop; how late they are; who had to brake.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Final

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure as PlotFigure
from numpy.typing import NDArray

from host.scratch import scratch
from network.model import SectionKind, TagPurpose
from onboard import notes
from onboard.fixes import EYE
from papers.parameter_sets import LINE
from papers.position_cases import CASES, SOON_S, PositionCase, carried_table
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.specification import Findings, Specification
from scenario.scenario import load_scenario
from simulation.events import TagPassed
from study.measures.localisation import known_positions
from study.report.style import AUXILIARY, INK, RED, REGENERATED, RULE, TRACTION, WIDTH_IN, write_figure
from study.runner.run import FinishedRun, PartyLink, execute

BASE: Final = "karasuyama_weekday"
SLICE: Final = "karasuyama_round_trip"
WHOLE: Final = "everyone arrives, no invariant broken, the truth within the bounds in every step"
LATER: Final = "releases later than with tags, s"
BY_WORD: Final = "wheels and the driver's word"
WHEELS: Final = PositionCase("wheels", BY_WORD, carried_table("lidar"), SOON_S, "the line has no markers")
EARLY_S: Final = -1.0  # telegrams and steps; no set may free a section before the train has left it
Floats = NDArray[np.float64]
LEAST_M: Final = 0.05  # shown where a spread is nothing on a logarithmic axis
_PANELS: Final = (
    ("half-width of the bounds, m", (("on the way", "half_width_m"), ("at ①", "half_width_at_release_m"))),
    ("at the mark, m", (("half-width", "half_width_at_marks_m"), ("stop error", "stop_error_m"))),
)
_COLOURS: Final = (TRACTION, REGENERATED)


@dataclass(frozen=True, slots=True)
class Quantiles:
    """Median, 95 % and the largest of some values; empty: none."""

    median: float | None = None
    p95: float | None = None
    most: float | None = None

    @classmethod
    def of_values(cls, values: Floats) -> Quantiles:
        """Of values, of which none may be left out."""
        if values.size == 0:
            return cls()
        return cls(*(round(float(np.percentile(values, share)), 2) for share in (50.0, 95.0, 100.0)))

    def __str__(self) -> str:
        return "none" if self.median is None else f"{self.median:g} / {self.p95:g} / {self.most:g}"


@dataclass(frozen=True, slots=True)
class SensorDay:
    """What came of a case; `releases_s` counts from the true clearing of a section, by train and section."""

    case: PositionCase
    planned: int
    broken: tuple[str, ...]
    releases_s: Mapping[tuple[str, str], float]
    trains_arrived: int
    half_width_m: Quantiles  # of the bounds on the way
    half_width_at_release_m: Quantiles
    half_width_at_marks_m: Quantiles
    stop_error_m: Quantiles
    late_s_max: float
    late_s_mean: float
    interventions: int
    positions_lost: int
    drivers_asked: int

    def later_than(self, other: SensorDay) -> Floats:
        """By how much each section is released later after its train has left it than with another set, s."""
        both = self.releases_s.keys() & other.releases_s.keys()
        return np.array([self.releases_s[key] - other.releases_s[key] for key in sorted(both)])

    def as_dict(self) -> dict[str, Any]:
        """For the figures and the picture."""
        shown = {name: value for name, value in asdict(self).items() if name not in _NOT_SHOWN}
        return shown | {"release_s": asdict(Quantiles.of_values(np.array(list(self.releases_s.values()))))}


_NOT_SHOWN: Final = ("case", "planned", "broken", "releases_s")


def case_table(days: Mapping[str, SensorDay]) -> dict[str, dict[str, Any]]:
    """What is reported of each case, and by how much its releases are later than with tags."""
    later = {name: asdict(Quantiles.of_values(day.later_than(days["tags"]))) for name, day in days.items()}
    return {name: day.as_dict() | {"release_later_s": later[name]} for name, day in days.items()}


def experiment(options: Options) -> Findings:
    """Every case on the day of `seed`, on SUMO; quick: the three trains of a round trip, and four of the cases."""
    days = {case.name: day_of(case, options) for case in CASES if case.quick or not options.quick}
    meaning = "half-widths and stop errors m, releases s after the rear has left, and later than with tags"
    return Findings(
        rows_of(days),
        (
            Parameter("scenario", _base(options), "", "the line's day; each case extends it"),
            Parameter("cases", len(CASES), "", "papers/position_cases.py: the tables that differ"),
            Parameter(
                "faults", "08:00, 3600 s", "", "assumed: an hour of the morning, when trains meet at Ogane"
            ),
        ),
        [
            "Spreads are median / 95 % / largest. A release counts from when the rear truly left the section;"
            " the departure track and its points are held until the next station by the paper's rule, whatever the"
            " sensors.",
            "Half-widths are of what units state; that the truth lies within is judged in every step by"
            " `within-bounds`.",
            "Faults and slippery rail last an hour from 08:00; `broken` names what is not whole.",
        ],
        [
            UnjudgedFigure(f"{name}: {days[name].case.title}", each, meaning)
            for name, each in case_table(days).items()
        ],
        draw=lambda folder: write_figure("position_operations", lambda: draw_cases(case_table(days)), folder),
    )


def by_wheels(options: Options) -> Iterator[CaseRow]:
    """The null method on a round trip: nothing but wheels, and what the driver sees."""
    trip = replace(options, quick=True)
    tags = next(case for case in CASES if case.name == "tags")
    return rows_of({case.name: day_of(case, trip) for case in (tags, WHEELS)})


def _base(options: Options) -> str:
    return SLICE if options.quick else BASE


def day_of(case: PositionCase, options: Options) -> SensorDay:
    """Run one case and measure it."""
    with scratch("branchline-") as folder:
        file = folder / f"{case.name}.toml"
        file.write_text(case.text(_base(options)), "utf-8")
        run = execute(load_scenario(str(file), options.seed), PartyLink.SIMULATED)
    return case_figures(case, run)


def case_figures(case: PositionCase, run: FinishedRun) -> SensorDay:
    """The figures of a run."""
    tables, summary = run.tables, run.summary
    half = known_positions(tables).select("unit", "t_s", "half_m").sort("t_s")
    stops = tables.stops.filter(pl.col("arrival_s").is_not_null())
    events = [entry.event for entry in run.result.journal.entries]
    late = tables.stops["late_arrival_s"].drop_nulls().to_numpy()
    return SensorDay(
        case,
        summary["trains_planned"],
        run.broken,
        _releases(run),
        summary["trains_arrived"],
        Quantiles.of_values(half["half_m"].to_numpy()),
        Quantiles.of_values(_half_at(half, _passed(run))),
        Quantiles.of_values(_half_at(half, stops.select("unit", t_s="arrival_s"))),
        Quantiles.of_values(np.abs(stops["stop_error_m"].drop_nulls().to_numpy())),
        round(float(summary["late_s_max"] or 0.0), 1),
        round(float(np.maximum(late, 0.0).mean()), 2) if late.size else 0.0,
        sum(isinstance(event, notes.Intervention) and event.level > 0 for event in events),
        sum(isinstance(event, notes.PositionFault) for event in events),
        sum(isinstance(event, notes.FixTaken) and event.reader == EYE for event in events),
    )


def _passed(run: FinishedRun) -> pl.DataFrame:
    """When trains truly passed the arrival tags, at which what lies behind is given back."""
    arrival = {tag.id for tag in run.scenario.setup.line.tags.values() if tag.purpose is TagPurpose.ARRIVAL}
    found = [
        (entry.event.unit_id, entry.t_s)
        for entry in run.result.journal.entries
        if isinstance(entry.event, TagPassed) and entry.event.tag_id in arrival
    ]
    return pl.DataFrame(found, schema={"unit": pl.String, "t_s": pl.Float64}, orient="row")


def _half_at(half: pl.DataFrame, at: pl.DataFrame) -> Floats:
    """Half-widths at times of units, m: of the last second before each in which the position was known and it moved."""
    joined = at.sort("t_s").join_asof(half, on="t_s", by="unit", tolerance=5.0, check_sortedness=False)
    return joined["half_m"].drop_nulls().to_numpy()


def _releases(run: FinishedRun) -> dict[tuple[str, str], float]:
    """By train and section: seconds from the true clearing to the release; a portal is given back by the sign-off."""
    sections = run.scenario.setup.line.sections.values()
    portals = [section.id for section in sections if section.kind is SectionKind.PORTAL]
    blocks = run.tables.blocks.filter(~pl.col("section").is_in(portals))
    done = blocks.drop_nulls(["released_s", "cleared_s"])
    return {
        (train, section): float(released_s - cleared_s)
        for train, section, released_s, cleared_s in done.select(
            "train", "section", "released_s", "cleared_s"
        ).iter_rows()
    }


# what is judged --------------------------------------------------------------------------------------------------


def rows_of(days: Mapping[str, SensorDay]) -> Iterator[CaseRow]:
    """Each case: whole, never released before it is clear, and not much later than with tags."""
    tags = days["tags"]
    for name, day in days.items():
        whole = day.trains_arrived == day.planned and not day.broken
        yield CaseRow(
            f"{name}: {WHOLE}",
            day.planned,
            day.trains_arrived if whole else {"arrived": day.trains_arrived, "broken": day.broken[:3]},
            whole,
            "all checkers, on SUMO",
        )
    for name, day in days.items():
        early_s = min(day.releases_s.values(), default=-math.inf)  # a day without a release shows nothing
        yield CaseRow(
            f"{name}: earliest release, s after the rear has left",
            None,
            round(early_s, 1),
            early_s >= EARLY_S,
            "never before it",
        )
        if day.case.later_s is not None and day is not tags:
            later_s, never = (
                Quantiles.of_values(day.later_than(tags)),
                tags.releases_s.keys() - day.releases_s,
            )
            yield CaseRow(
                f"{name}: {LATER}",
                None,
                str(later_s),
                not never and later_s.p95 is not None and later_s.p95 <= day.case.later_s,
                f"all that are with tags, 95 % at most {day.case.later_s:g} s later: {day.case.why}",
            )


def draw_cases(days: Mapping[str, Mapping[str, Any]]) -> PlotFigure:
    """`days`: the figures of each case by its name, as the reproduction tells them."""
    names = list(days)
    figure = PlotFigure(figsize=(WIDTH_IN, 1.4 + 0.42 * len(names)), layout="constrained")
    panels = figure.subplots(1, 4, sharey=True, gridspec_kw={"width_ratios": [1.3, 1.3, 1.3, 1.0]})
    for axes, (title, series) in zip(panels, _PANELS, strict=False):
        _spreads(axes, title, [(label, [days[n][key] for n in names]) for label, key in series])
    later = [days[n]["release_later_s"] for n in names]
    _spreads(panels[2], "release later than with tags, s", [("by section", later)], logarithmic=False)
    _lateness(panels[3], [days[n] for n in names])
    panels[0].set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
    panels[0].set_ylim(len(names) - 0.4, -0.6)
    for axes in panels:
        axes.spines[:].set_color(RULE)
        axes.tick_params(axis="y", length=0)
        for row in range(len(names)):
            axes.axhline(row + 0.5, color=RULE, lw=0.4, zorder=0.4)
    return figure


def _spreads(
    axes: Axes, title: str, series: list[tuple[str, list[Mapping[str, Any]]]], *, logarithmic: bool = True
) -> None:
    """A dot at the median, a line to 95 %, a tick at the largest."""
    for index, (label, spreads) in enumerate(series):
        aside = 0.16 * (2 * index - len(series) + 1)
        for row, spread in enumerate(spreads):
            if spread["median"] is None:
                continue
            least = LEAST_M if logarithmic else float("-inf")
            median, p95, most = (max(spread[key], least) for key in ("median", "p95", "most"))
            colour = _COLOURS[index]
            axes.plot([median, p95], [row + aside] * 2, color=colour, lw=2.2)
            axes.plot(median, row + aside, "o", color=colour, ms=4, label=label if row == 0 else None)
            axes.plot(most, row + aside, "|", color=colour, ms=7)
    if logarithmic:
        axes.set_xscale("log")
        axes.set_xticks([0.1, 1.0, 10.0, 100.0], ["0.1", "1", "10", "100"])
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)
    else:
        axes.set_xscale("symlog", linthresh=10.0)
        axes.set_xticks([0.0, 10.0, 100.0, 1000.0], ["0", "10", "100", "1000"])
    axes.set_xlabel(title)
    axes.grid(axis="x")


def _lateness(axes: Axes, days: list[Mapping[str, Any]]) -> None:
    """The latest arrival or departure of the day, and how many positions were lost and drivers asked."""
    for row, day in enumerate(days):
        late_min = day["late_s_max"] / 60.0
        axes.barh(row, late_min, 0.5, color=RED if late_min > 1.0 else AUXILIARY)
        words = f" {late_min:.1f}"
        if day["positions_lost"]:
            words += f", {day['positions_lost']} lost"
        axes.annotate(words, (late_min, row), va="center", fontsize=6.5, color=INK)
    axes.set_xlim(0.0, 1.5 * max(1.0, *(day["late_s_max"] / 60.0 for day in days)))
    axes.set_xlabel("latest call, min; positions lost")
    axes.grid(axis="x")


reproduce: Final = Specification(
    "position-operations",
    "A weekday of the Karasuyama line by what trains carry to know where they are",
    experiment,
    NullMethod(BY_WORD, (LATER,), by_wheels),
    LINE,
    "quick: one round trip instead of the day, and only some of the cases.",
)
