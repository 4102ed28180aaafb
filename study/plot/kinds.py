"""The kinds of plots: what each shows, what may be chosen of it, its table and its picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import polars as pl

from network.errors import InputError
from network.files.toml_input import one_of
from study.plot.choice import ChosenRun
from study.record.marks import Mark
from study.wording.catalogue import phrase
from study.wording.phrase import Phrase

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class PlotOption(Enum):
    """What may be chosen of a kind; its option on the command line."""

    TRAIN = "--train"
    STATION = "--station"
    TIME = "--from, --to"
    RUNS = "--with"


@dataclass(frozen=True, slots=True)
class PlotKind:
    """A kind of plot. `needs` must be chosen for its picture; its table does without."""

    name: str
    title: Phrase
    table: Callable[[ChosenRun], pl.DataFrame]
    draw: Callable[[ChosenRun], Figure | None]
    takes: frozenset[PlotOption] = frozenset()
    needs: frozenset[PlotOption] = frozenset()


def _marks(run: ChosenRun) -> tuple[Mark, ...]:
    """The marks of a drill, in the language chosen."""
    drill, language = run.read.shown.drill, run.choice.language
    return () if drill is None else tuple(replace(m, text=m.said.in_(language)) for m in drill.marks)


def _times_of_stops(run: ChosenRun) -> pl.DataFrame:
    stops = run.chosen_rows(run.tables.stops)
    return run.rows_in_window(stops, "planned_arrival_s", "planned_departure_s", "arrival_s", "departure_s")


def _run_curve_table(run: ChosenRun) -> pl.DataFrame:
    return run.chosen_rows(run.tables.trajectory)


def _drawn_by(module: str, name: str) -> Callable[[ChosenRun], Any]:
    """A function of a module that is imported when it is called: who draws one kind waits for no other."""

    def drawn(run: ChosenRun) -> Any:  # noqa: ANN401 - a table, or a figure
        return getattr(import_module(f"study.{module}"), name)(run)

    return drawn


def _train_graph(run: ChosenRun) -> Figure | None:
    from study.report.graph import draw_train_graph

    return draw_train_graph(run, _marks(run))[0]


def _run_curve(run: ChosenRun) -> Figure | None:
    from study.report.curve import draw_run_curve

    found = next((key for key in run.courses if key[1] == run.choice.train), None)
    return None if found is None else draw_run_curve(run, *found)


def _blocks_table(run: ChosenRun) -> pl.DataFrame:
    return run.rows_in_window(
        run.chosen_rows(run.tables.blocks), "granted_s", "released_s", "entered_s", "cleared_s"
    )


def _running_times_table(run: ChosenRun) -> pl.DataFrame:
    from study.measures.standard_times import standard_times
    from study.record.setup_back import setup_of

    return pl.DataFrame(
        [time.as_dict() for time in standard_times(setup_of(run.read))], infer_schema_length=None
    )


def _running_times(run: ChosenRun) -> Figure | None:
    from study.measures.standard_times import planned_runs, standard_times
    from study.record.setup_back import setup_of
    from study.report.running_times import draw_running_times

    setup = setup_of(run.read)
    return draw_running_times(run.line, standard_times(setup), planned_runs(setup))


def _stop_errors(run: ChosenRun) -> Figure | None:
    from study.report.charts import draw_stop_errors

    return draw_stop_errors(run, run.read.summary)


def _delays(run: ChosenRun) -> Figure | None:
    from study.report.charts import draw_delays

    return draw_delays(replace(run, line=run.named_line), run.read.summary.get("latest_end_s"))


_ALL: Final = frozenset({PlotOption.TRAIN, PlotOption.STATION, PlotOption.TIME})
_TIME: Final = frozenset({PlotOption.TIME})
_TRAIN: Final = frozenset({PlotOption.TRAIN})
_STATION: Final = frozenset({PlotOption.STATION})
_KINDS: Final = (
    PlotKind(
        "train-graph",
        phrase("Train graph, plan thin and run thick"),
        _times_of_stops,
        _train_graph,
        _TIME,
    ),
    PlotKind("run-curve", phrase("Run curve"), _run_curve_table, _run_curve, _TRAIN, _TRAIN),
    PlotKind(
        "track-occupation",
        phrase("Track occupation"),
        _drawn_by("plot.stations", "occupation_table"),
        _drawn_by("plot.stations", "draw_occupation"),
        _ALL,
    ),
    PlotKind(
        "station-timetable",
        phrase("Station timetable"),
        _drawn_by("plot.stations", "timetable_table"),
        _drawn_by("plot.stations", "draw_timetable"),
        _STATION | _TIME,
        _STATION,
    ),
    PlotKind(
        "punctuality",
        phrase("Punctuality by station"),
        _drawn_by("plot.stations", "punctuality_table"),
        _drawn_by("plot.stations", "draw_punctuality"),
        _STATION | _TIME,
    ),
    PlotKind(
        "delays",
        phrase("Lateness of every call, s; –: it did not come"),
        _times_of_stops,
        _delays,
    ),
    PlotKind(
        "waits",
        phrase("Why each stock waited"),
        _drawn_by("plot.days", "waits_table"),
        _drawn_by("plot.days", "draw_waits"),
        _ALL,
    ),
    PlotKind(
        "duties",
        phrase("Duties"),
        _drawn_by("plot.days", "duties_table"),
        _drawn_by("plot.days", "draw_duties"),
    ),
    PlotKind(
        "energy-train",
        phrase("Energy by train; above, net kWh a train-km"),
        lambda run: run.tables.energy,
        _drawn_by("report.charts", "draw_energy"),
    ),
    PlotKind(
        "energy-leg",
        phrase("Net energy by leg"),
        lambda run: run.chosen_rows(run.tables.energy_legs),
        _drawn_by("plot.energy", "draw_energy_legs"),
        _TRAIN,
    ),
    PlotKind(
        "energy-parts",
        phrase("Where the energy of each leg went"),
        lambda run: run.chosen_rows(run.tables.energy_legs),
        _drawn_by("plot.energy_parts", "draw_energy_parts"),
        _TRAIN,
    ),
    PlotKind(
        "energy-hour",
        phrase("Energy by hour"),
        _drawn_by("plot.energy", "energy_hours_table"),
        _drawn_by("plot.energy", "draw_energy_hours"),
        _TIME,
    ),
    PlotKind(
        "level-crossings",
        phrase("Closed minutes of level crossings by hour"),
        _drawn_by("plot.crossings", "crossings_table"),
        _drawn_by("plot.crossings", "draw_crossings"),
        _TIME,
    ),
    PlotKind(
        "battery",
        phrase("State of charge of each set"),
        _drawn_by("plot.battery", "battery_table"),
        _drawn_by("plot.battery", "draw_battery"),
        _TIME,
    ),
    PlotKind(
        "laws",
        phrase("One hop as driven: speed, gradient, notches"),
        _drawn_by("plot.laws", "hops_table"),
        _drawn_by("plot.laws", "draw_laws"),
        _TRAIN | _STATION | {PlotOption.RUNS},
        _TRAIN,
    ),
    PlotKind(
        "position",
        phrase("Where it believed to be: error and bounds"),
        _drawn_by("plot.position", "position_table"),
        _drawn_by("plot.position", "draw_position"),
        _TRAIN,
        _TRAIN,
    ),
    PlotKind(
        "margins",
        phrase("Margins by hop"),
        lambda run: run.chosen_rows(run.tables.margins),
        _drawn_by("plot.margins", "draw_margins"),
        _TRAIN,
    ),
    PlotKind(
        "section-occupancy",
        phrase("Sections, held pale and occupied solid"),
        _blocks_table,
        _drawn_by("report.occupancy", "draw_occupancy"),
        _TIME,
    ),
    PlotKind(
        "stairway",
        phrase("Blocking-time stairway"),
        _drawn_by("plot.stairway", "stairway_table"),
        _drawn_by("plot.stairway", "draw_stairway_of"),
        _TIME | _TRAIN,
    ),
    PlotKind(
        "headway",
        phrase("Least headways by station"),
        _drawn_by("plot.fullness", "headways_table"),
        _drawn_by("plot.fullness", "draw_headways"),
        _STATION,
    ),
    PlotKind(
        "occupation",
        phrase("Occupancy by part of the line (UIC 406)"),
        _drawn_by("plot.fullness", "occupation_table"),
        _drawn_by("plot.fullness", "draw_occupations"),
        _TIME,
    ),
    PlotKind(
        "stop-errors",
        phrase("Stop errors"),
        lambda run: run.chosen_rows(run.tables.stops).filter(pl.col("stop_error_m").is_not_null()),
        _stop_errors,
    ),
    PlotKind(
        "running-times",
        phrase("Minimum running times"),
        _running_times_table,
        _running_times,
    ),
)
KINDS: Final[Mapping[str, PlotKind]] = MappingProxyType({kind.name: kind for kind in _KINDS})


def kind_of(name: str) -> PlotKind:
    """The kind of that name; InputError otherwise."""
    if name not in KINDS:
        raise InputError("command line", "KIND", name, one_of(KINDS, name))
    return KINDS[name]
