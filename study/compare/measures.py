"""The figures by which runs are compared, a row each, and the tables behind them: margins, energy, telegrams, stops."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Final, TypeAlias

import polars as pl

from simulation.result import DRAWN
from study.compare.meets import meets_of
from study.compare.side import ComparedRun
from study.compare.times import CallEvent
from study.measures.driving import driving_sums
from study.measures.missing import planned_times
from study.measures.summary import energy_summary, trains_counted
from study.record.crossings import CrossingHour
from study.record.driving import EARLY, DrivenHop
from study.record.figure import Adds, ShownIn, rows_in, seen_in, summed_figures
from study.record.figure import Figure as Said
from study.record.journal_rows import TelegramsOfWay
from study.record.tables import ROWS
from study.report.data import place_said
from study.wording import compared as words
from study.wording.phrase import NOTHING, Phrase, joined_phrases

# Minutes in which punctuality is given, and the 15 s in which Japanese timetables are planned.
NOT_LATE_S: Final = (
    5  # brakes take 1.4 s to release, and whole seconds are read off clocks: nobody calls that late
)
WITHIN_S: Final = (NOT_LATE_S, 15, 60, 180, 300)
_TRAINS: Final = ("planned", "ran their whole journey", "cancelled", "shortened")
# kinds of events
_COUNTED: Final = {"intervention": "interventions", "refusal": "refusals", "fault": "faults"}
_CROSSINGS: Final = "level crossings"  # a group that is left out where no run has any
Value: TypeAlias = float | None


@dataclass(frozen=True, slots=True)
class RunFigure:
    """One figure of one run: `where` says of which train and place, for the extremes."""

    group: str
    name: str
    unit: str
    digits: int
    value: Value
    where: Phrase = NOTHING


@dataclass(frozen=True, slots=True)
class Measure:
    """One figure of every run, in their order; None where a run has none."""

    group: str
    name: str
    unit: str
    digits: int
    values: tuple[Value, ...]
    where: tuple[Phrase, ...]

    def by(self, index: int) -> Value:
        """How much more it is in a run than in the first; None where either has none."""
        base, value = self.values[0], self.values[index]
        return None if base is None or value is None else value - base

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self) | {"where": tuple(place.en for place in self.where)}


@dataclass(frozen=True, slots=True)
class ComparedRow:
    """What one thing of a table was and is: its name's parts, then column: (old, new)."""

    names: tuple[str, ...]
    values: Mapping[str, tuple[Value, Value]] = field(default_factory=dict[str, tuple[Value, Value]])

    def by(self, column: str) -> Value:
        """How much more it is in the new run; a thing that is in one run only counts from nothing."""
        old, new = self.values[column]
        return None if old is None and new is None else (new or 0.0) - (old or 0.0)


def measures_of(sides: Sequence[ComparedRun]) -> tuple[Measure, ...]:
    """Every figure of all runs."""
    columns = [tuple(figures_of(side)) for side in sides]
    without = () if any(_has_crossings(side) for side in sides) else (_CROSSINGS,)
    return tuple(
        Measure(
            row[0].group,
            row[0].name,
            row[0].unit,
            row[0].digits,
            tuple(figure.value for figure in row),
            tuple(figure.where for figure in row),
        )
        for row in zip(*columns, strict=True)
        if row[0].group not in without
    )


def figures_of(side: ComparedRun) -> Iterator[RunFigure]:
    """The figures of one run, always the same ones in the same order."""
    tables = side.run.tables
    counts = trains_counted(tables.stops, side.run.timetable, side.summary.get("latest_end_s"))
    for name, count in zip(_TRAINS, counts.values(), strict=True):
        yield RunFigure("trains", name, "", 0, float(count))
    yield RunFigure("trains", "meets as run", "", 0, float(len(meets_of(side.run))))
    for what in (CallEvent.ARRIVAL, CallEvent.DEPARTURE):
        yield from _punctuality(side, what)
    yield from _margins(side)
    yield from _energy(side)
    yield from _driving(side)
    for name, figure in seen_in(TelegramsOfWay, ShownIn.TOTALS_COMPARED).items():
        yield RunFigure(
            "telegrams", figure.name.en, figure.unit, figure.digits, float(tables.telegrams[name].sum())
        )
    yield RunFigure("telegrams", "volume", "kB", 1, float(tables.telegrams["bytes"].sum()) / 1000.0)
    yield from _stop_errors(side)
    yield from _crossings(side)
    for kind, name in _COUNTED.items():
        yield RunFigure("events", name, "", 0, float(tables.events.filter(pl.col("kind") == kind).height))
    for key, name in (("invariants_broken", "invariants broken"), ("collisions", "collisions")):
        yield RunFigure("safety", name, "", 0, _number(side.summary.get(key)))


def _punctuality(side: ComparedRun, what: CallEvent) -> Iterator[RunFigure]:
    """What share of the planned was late by at most so much; passings are departures.

    What never came was not on time, and is as late as `study.measures.missing` has it.
    """
    times = planned_times(side.run.tables.stops, side.run.timetable, side.summary.get("latest_end_s"))
    planned = times.filter(pl.col("what") == what.value)
    came, late = planned.filter("came"), pl.col("late_s")
    group = f"{what.value}s"
    yield RunFigure(group, "planned", "", 0, float(planned.height))
    for most_s in WITHIN_S:
        kept = came.filter(late <= most_s).height
        form = words.NOT_LATE if most_s == NOT_LATE_S else words.AT_MOST
        name = form.fill(most=words.span(most_s)).en
        yield RunFigure(group, name, "%", 1, 100.0 * kept / planned.height if planned.height else None)
    yield RunFigure(group, "never came", "", 0, float(planned.height - came.height))
    yield RunFigure(group, "mean lateness", "s", 1, _number(planned["late_s"].mean()))
    worst = planned.sort(late, descending=True, maintain_order=True).head(1)
    where = _at_station(side, worst)
    yield RunFigure(group, "worst lateness", "s", 1, _number(planned["late_s"].max()), where)


def _margins(side: ComparedRun) -> Iterator[RunFigure]:
    margins = side.run.tables.margins
    for column, name, unit in (
        ("margin_s", "smallest planned", "s"),
        ("margin_percent", "smallest planned", "%"),
        ("left_s", "least left as run", "s"),
    ):
        least = margins.filter(pl.col(column).is_finite()).sort(column, maintain_order=True).head(1)
        where = _on_hop(side, least)
        yield RunFigure("margins", name, unit, 1, least[column][0] if least.height else None, where)
    yield RunFigure("margins", "mean left as run", "s", 1, _number(margins["left_s"].mean()))
    short = margins.filter(pl.col("margin_s") < 0.0).height
    yield RunFigure("margins", "hops that the plan cannot keep", "", 0, float(short))


def _energy(side: ComparedRun) -> Iterator[RunFigure]:
    tables = side.run.tables
    whole = energy_summary(tables)
    for name in (*DRAWN, "net"):
        yield RunFigure("energy", name, "kWh", 1, whole["all"][name])
    yield RunFigure("energy", "of it standing", "kWh", 1, whole["standing"]["net"])
    yield RunFigure("energy", "of it layovers", "kWh", 1, whole["layovers"]["net"])
    traction = whole["all"]["traction"]
    share = 100.0 * whole["all"]["regenerated"] / traction if traction > 0.0 else None
    yield RunFigure("energy", "regenerated, of traction", "%", 1, share)
    yield RunFigure("energy", "distance", "train-km", 1, whole["train_km"])
    for key, unit in (("net_kwh_per_train_km", "kWh/train-km"), ("net_kwh_per_car_km", "kWh/car-km")):
        yield RunFigure("energy", "net", unit, 3, whole[key]["trains"])
        yield RunFigure("energy", "net, with layovers", unit, 3, whole[key]["all"])


def _driving(side: ComparedRun) -> Iterator[RunFigure]:
    """Means over the hops as `study.measures.driving.driving_sums` has them; none of a run without any."""
    whole = driving_sums(rows_in(DrivenHop, side.run.tables.driving), side.run.tables.margins["left_s"])
    for name, figure in (*seen_in(DrivenHop, ShownIn.TOTALS_COMPARED).items(), ("early_s", EARLY)):
        value = None if whole is None else whole[name]
        yield RunFigure("driving", figure.name.en, figure.unit, figure.digits, value)


def _has_crossings(side: ComparedRun) -> bool:
    return any(crossing.has_device for crossing in side.run.line.crossings.values())


def _crossings(side: ComparedRun) -> Iterator[RunFigure]:
    """Of all level crossings together; none on a line without any that has a device."""
    hours = rows_in(CrossingHour, side.run.tables.crossings)
    whole = summed_figures(hours) if hours else {}
    closed_s = whole.get("closed_s", 0.0 if _has_crossings(side) else None)
    yield RunFigure(_CROSSINGS, "road closed", "min", 1, None if closed_s is None else closed_s / 60.0)
    for name, said in seen_in(CrossingHour, ShownIn.TOTALS_COMPARED).items():
        yield RunFigure(_CROSSINGS, said.name.en, said.unit, said.digits, whole.get(name))


def _stop_errors(side: ComparedRun) -> Iterator[RunFigure]:
    stops = side.run.tables.stops
    error_m = stops["stop_error_m"].drop_nulls()
    worst = stops.filter(pl.col("stop_error_m").is_not_null()).sort(
        pl.col("stop_error_m").abs(), descending=True, maintain_order=True
    )
    where = _at_station(side, worst)
    yield RunFigure("stops at the mark", "measured", "", 0, float(len(error_m)))
    yield RunFigure("stops at the mark", "mean error", "m", 3, _number(error_m.mean()))
    sigma = error_m.std() if len(error_m) > 1 else None
    yield RunFigure("stops at the mark", "sigma of error", "m", 3, _number(sigma))
    yield RunFigure("stops at the mark", "largest error", "m", 3, _number(error_m.abs().max()), where)


def _at_station(side: ComparedRun, stops: pl.DataFrame) -> Phrase:
    """Train and station of the first row."""
    if stops.is_empty():
        return NOTHING
    return words.AT_STATION.fill(train=stops["train"][0], place=place_said(side.run, stops["station"][0]))


def _on_hop(side: ComparedRun, margins: pl.DataFrame) -> Phrase:
    """Train and hop of the first row."""
    if margins.is_empty():
        return NOTHING
    ends = joined_phrases(
        (place_said(side.run, margins[f"{end}_station"][0]) for end in ("from", "to")), " – ", "～"
    )
    return joined_phrases((Phrase(margins["train"][0]), ends), " ", " ")


# what is compared row by row
TABLES: Final = ("margins", "energy", "driving", "telegrams", "crossings", "stops")


def names_in(table: str) -> Mapping[str, Said]:
    """The columns that name a row of a table."""
    return seen_in(ROWS[table], ShownIn.ROWS_NAMED)


def columns_in(table: str) -> Mapping[str, Said]:
    """The columns of a table that are compared."""
    return seen_in(ROWS[table], ShownIn.ROWS_COMPARED)


def compare_rows(base: ComparedRun, new: ComparedRun, table: str) -> tuple[ComparedRow, ...]:
    """The rows of a table that are not the same in both runs, matched by their names."""
    olds, news = _rows(base, table), _rows(new, table)
    found: list[ComparedRow] = []
    for names in dict.fromkeys((*olds, *news)):
        old, late = olds.get(names, {}), news.get(names, {})
        if old != late:
            values = {column: (old.get(column), late.get(column)) for column in columns_in(table)}
            found.append(ComparedRow(names, values))
    return tuple(found)


def _rows(side: ComparedRun, table: str) -> dict[tuple[str, ...], dict[str, Value]]:
    names, columns = tuple(names_in(table)), tuple(columns_in(table))
    frame: pl.DataFrame = getattr(side.run.tables, table)
    # several rows of a name are one
    if all(figure.adds is Adds.SUM for figure in columns_in(table).values()):
        frame = frame.group_by(names, maintain_order=True).agg(pl.col(columns).sum())
    else:
        frame = frame.filter(pl.any_horizontal(pl.col(columns).is_not_null()))
        frame = frame.unique(names, keep="first", maintain_order=True)
    return {
        tuple(str(row[name]) for name in names): {column: _number(row[column]) for column in columns}
        for row in frame.iter_rows(named=True)
    }


def sorted_by(rows: Sequence[ComparedRow], column: str) -> tuple[ComparedRow, ...]:
    """Rows by how much a column has changed, most first."""
    size: Callable[[ComparedRow], float] = lambda row: -abs(row.by(column) or 0.0)  # noqa: E731
    return tuple(sorted(rows, key=size))


def _number(value: object) -> Value:
    """A finite number; a table may hold an endless running time, which no file of ours can."""
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None
