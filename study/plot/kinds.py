"""The kinds of plots: what each shows, what may be chosen of it, its table and its picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from types import MappingProxyType
from typing import Final

import polars as pl
from matplotlib.figure import Figure

from network.errors import InputError
from network.files.toml_input import one_of
from study.measures.standard_times import planned_runs, standard_times
from study.plot import battery, days, energy, fullness, laws, position, stations
from study.plot.choice import ChosenRun
from study.plot.energy_parts import draw_energy_parts
from study.plot.margins import draw_margins
from study.plot.stairway import draw_stairway_of, stairway_table
from study.record.marks import Mark
from study.record.setup_back import setup_of
from study.report.charts import draw_delays, draw_energy, draw_stop_errors
from study.report.curve import draw_run_curve
from study.report.graph import draw_train_graph
from study.report.occupancy import draw_occupancy
from study.report.running_times import draw_running_times
from study.wording.catalogue import phrase
from study.wording.phrase import Phrase


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
    stops = run.shown(run.tables.stops)
    return run.within(stops, "planned_arrival_s", "planned_departure_s", "arrival_s", "departure_s")


def _run_curve_table(run: ChosenRun) -> pl.DataFrame:
    return run.shown(run.tables.trajectory)


def _run_curve(run: ChosenRun) -> Figure | None:
    found = next((key for key in run.courses if key[1] == run.choice.train), None)
    return None if found is None else draw_run_curve(run, *found)


def _blocks_table(run: ChosenRun) -> pl.DataFrame:
    return run.within(run.shown(run.tables.blocks), "granted_s", "released_s", "entered_s", "cleared_s")


def _running_times_table(run: ChosenRun) -> pl.DataFrame:
    return pl.DataFrame(
        [time.as_dict() for time in standard_times(setup_of(run.read))], infer_schema_length=None
    )


def _running_times(run: ChosenRun) -> Figure | None:
    setup = setup_of(run.read)
    return draw_running_times(run.line, standard_times(setup), planned_runs(setup))


def _stop_errors(run: ChosenRun) -> Figure | None:
    return draw_stop_errors(run, run.read.summary)


_ALL: Final = frozenset({PlotOption.TRAIN, PlotOption.STATION, PlotOption.TIME})
_TIME: Final = frozenset({PlotOption.TIME})
_TRAIN: Final = frozenset({PlotOption.TRAIN})
_STATION: Final = frozenset({PlotOption.STATION})
_KINDS: Final = (
    PlotKind(
        "train-graph",
        phrase("Train graph, plan thin and run thick"),
        _times_of_stops,
        lambda run: draw_train_graph(run, _marks(run))[0],
        _TIME,
    ),
    PlotKind("run-curve", phrase("Run curve"), _run_curve_table, _run_curve, _TRAIN, _TRAIN),
    PlotKind(
        "track-occupation",
        phrase("Track occupation"),
        stations.occupation_table,
        stations.draw_occupation,
        _ALL,
    ),
    PlotKind(
        "station-timetable",
        phrase("Station timetable"),
        stations.timetable_table,
        stations.draw_timetable,
        _STATION | _TIME,
        _STATION,
    ),
    PlotKind(
        "punctuality",
        phrase("Punctuality by station"),
        stations.punctuality_table,
        stations.draw_punctuality,
        _STATION | _TIME,
    ),
    PlotKind("delays", phrase("Lateness of every call, s"), _times_of_stops, draw_delays),
    PlotKind(
        "waits",
        phrase("Why each stock waited"),
        days.waits_table,
        days.draw_waits,
        _ALL,
    ),
    PlotKind("duties", phrase("Duties"), days.duties_table, days.draw_duties),
    PlotKind(
        "energy-train",
        phrase("Energy by train; above, net kWh a train-km"),
        lambda run: run.tables.energy,
        draw_energy,
    ),
    PlotKind(
        "energy-leg",
        phrase("Net energy by leg"),
        lambda run: run.shown(run.tables.energy_legs),
        energy.draw_energy_legs,
        _TRAIN,
    ),
    PlotKind(
        "energy-parts",
        phrase("Where the energy of each leg went"),
        lambda run: run.shown(run.tables.energy_legs),
        draw_energy_parts,
        _TRAIN,
    ),
    PlotKind(
        "energy-hour",
        phrase("Energy by hour"),
        energy.energy_hours_table,
        energy.draw_energy_hours,
        _TIME,
    ),
    PlotKind(
        "battery",
        phrase("State of charge of each set"),
        battery.battery_table,
        battery.draw_battery,
        _TIME,
    ),
    PlotKind(
        "laws",
        phrase("One hop as driven: speed, gradient, notches"),
        laws.hops_table,
        laws.draw_laws,
        _TRAIN | _STATION | {PlotOption.RUNS},
        _TRAIN,
    ),
    PlotKind(
        "position",
        phrase("Where it believed to be: error and bounds"),
        position.position_table,
        position.draw_position,
        _TRAIN,
        _TRAIN,
    ),
    PlotKind(
        "margins",
        phrase("Margins by hop"),
        lambda run: run.shown(run.tables.margins),
        draw_margins,
        _TRAIN,
    ),
    PlotKind(
        "section-occupancy",
        phrase("Sections, held pale and occupied solid"),
        _blocks_table,
        draw_occupancy,
        _TIME,
    ),
    PlotKind(
        "stairway",
        phrase("Blocking-time stairway"),
        stairway_table,
        draw_stairway_of,
        _TIME | _TRAIN,
    ),
    PlotKind(
        "headway",
        phrase("Least headways by station"),
        fullness.headways_table,
        fullness.draw_headways,
        _STATION,
    ),
    PlotKind(
        "occupation",
        phrase("Occupancy by part of the line (UIC 406)"),
        fullness.occupation_table,
        fullness.draw_occupations,
        _TIME,
    ),
    PlotKind(
        "stop-errors",
        phrase("Stop errors"),
        lambda run: run.shown(run.tables.stops).filter(pl.col("stop_error_m").is_not_null()),
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
