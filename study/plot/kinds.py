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
    title: str
    title_ja: str
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
        "Train graph, plan thin and run thick",
        "列車ダイヤ（細線：計画、太線：実績）",
        _times_of_stops,
        lambda run: draw_train_graph(run, _marks(run))[0],
        _TIME,
    ),
    PlotKind("run-curve", "Run curve", "運転曲線", _run_curve_table, _run_curve, _TRAIN, _TRAIN),
    PlotKind(
        "track-occupation",
        "Track occupation",
        "番線使用",
        stations.occupation_table,
        stations.draw_occupation,
        _ALL,
    ),
    PlotKind(
        "station-timetable",
        "Station timetable",
        "駅時刻表",
        stations.timetable_table,
        stations.draw_timetable,
        _STATION | _TIME,
        _STATION,
    ),
    PlotKind(
        "punctuality",
        "Punctuality by station",
        "駅別定時性",
        stations.punctuality_table,
        stations.draw_punctuality,
        _STATION | _TIME,
    ),
    PlotKind("delays", "Lateness of every call, s", "列車別・駅別の遅れ [s]", _times_of_stops, draw_delays),
    PlotKind(
        "waits",
        "Why each stock waited",
        "待ちの理由",
        days.waits_table,
        days.draw_waits,
        _ALL,
    ),
    PlotKind("duties", "Duties", "運用", days.duties_table, days.draw_duties),
    PlotKind(
        "energy-train",
        "Energy by train; above, net kWh a train-km",
        "列車別電力量（数値は正味kWh/列車キロ）",
        lambda run: run.tables.energy,
        draw_energy,
    ),
    PlotKind(
        "energy-leg",
        "Net energy by leg",
        "区間別電力量（正味）",
        lambda run: run.shown(run.tables.energy_legs),
        energy.draw_energy_legs,
        _TRAIN,
    ),
    PlotKind(
        "energy-parts",
        "Where the energy of each leg went",
        "区間別電力量の内訳",
        lambda run: run.shown(run.tables.energy_legs),
        draw_energy_parts,
        _TRAIN,
    ),
    PlotKind(
        "energy-hour",
        "Energy by hour",
        "時間帯別電力量",
        energy.energy_hours_table,
        energy.draw_energy_hours,
        _TIME,
    ),
    PlotKind(
        "battery",
        "State of charge of each set",
        "編成別の充電状態",
        battery.battery_table,
        battery.draw_battery,
        _TIME,
    ),
    PlotKind(
        "laws",
        "One hop as driven: speed, gradient, notches",
        "一駅間の運転：速度・勾配・ノッチ",
        laws.hops_table,
        laws.draw_laws,
        _TRAIN | _STATION | {PlotOption.RUNS},
        _TRAIN,
    ),
    PlotKind(
        "position",
        "Where it believed to be: error and bounds",
        "位置の誤差と範囲",
        position.position_table,
        position.draw_position,
        _TRAIN,
        _TRAIN,
    ),
    PlotKind(
        "margins",
        "Margins by hop",
        "区間別余裕時分",
        lambda run: run.shown(run.tables.margins),
        draw_margins,
        _TRAIN,
    ),
    PlotKind(
        "section-occupancy",
        "Sections, held pale and occupied solid",
        "閉そく区間の確保（淡）と在線（濃）",
        _blocks_table,
        draw_occupancy,
        _TIME,
    ),
    PlotKind(
        "stairway",
        "Blocking-time stairway",
        "閉そく占有時分",
        stairway_table,
        draw_stairway_of,
        _TIME | _TRAIN,
    ),
    PlotKind(
        "headway",
        "Least headways by station",
        "駅別の運転時隔",
        fullness.headways_table,
        fullness.draw_headways,
        _STATION,
    ),
    PlotKind(
        "occupation",
        "Occupancy by part of the line (UIC 406)",
        "線路容量の利用率（UIC 406）",
        fullness.occupation_table,
        fullness.draw_occupations,
        _TIME,
    ),
    PlotKind(
        "stop-errors",
        "Stop errors",
        "停止誤差",
        lambda run: run.shown(run.tables.stops).filter(pl.col("stop_error_m").is_not_null()),
        _stop_errors,
    ),
    PlotKind(
        "running-times",
        "Minimum running times",
        "基準運転時分",
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
