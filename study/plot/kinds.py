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
from study.plot.choice import Seen
from study.plot.energy_parts import draw_energy_parts
from study.plot.margins import draw_margins
from study.plot.stairway import draw_stairway_of, stairway_table
from study.report.charts import draw_delays, draw_energy, draw_stop_errors
from study.report.curve import draw_run_curve
from study.report.drill import Mark
from study.report.graph import draw_train_graph
from study.report.occupancy import draw_occupancy
from study.report.running_times import draw_running_times
from study.run.setup_back import setup_of


class Chosen(Enum):
    """What may be chosen of a kind; its option on the command line."""

    TRAIN = "--train"
    STATION = "--station"
    TIME = "--from, --to"
    RUNS = "--with"


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of plot. `needs` must be chosen for its picture; its table does without."""

    name: str
    title: str
    title_ja: str
    table: Callable[[Seen], pl.DataFrame]
    draw: Callable[[Seen], Figure | None]
    takes: frozenset[Chosen] = frozenset()
    needs: frozenset[Chosen] = frozenset()


def _marks(run: Seen) -> tuple[Mark, ...]:
    """The marks of a drill, in the language chosen."""
    drill, language = run.read.shown.drill, run.choice.language
    return () if drill is None else tuple(replace(m, text=m.said.in_(language)) for m in drill.marks)


def _times_of_stops(run: Seen) -> pl.DataFrame:
    stops = run.shown(run.tables.stops)
    return run.within(stops, "planned_arrival_s", "planned_departure_s", "arrival_s", "departure_s")


def _run_curve_table(run: Seen) -> pl.DataFrame:
    return run.shown(run.tables.trajectory)


def _run_curve(run: Seen) -> Figure | None:
    found = next((key for key in run.courses if key[1] == run.choice.train), None)
    return None if found is None else draw_run_curve(run, *found)


def _blocks_table(run: Seen) -> pl.DataFrame:
    return run.within(run.shown(run.tables.blocks), "granted_s", "released_s", "entered_s", "cleared_s")


def _running_times_table(run: Seen) -> pl.DataFrame:
    return pl.DataFrame(
        [time.as_dict() for time in standard_times(setup_of(run.read))], infer_schema_length=None
    )


def _running_times(run: Seen) -> Figure | None:
    setup = setup_of(run.read)
    return draw_running_times(run.line, standard_times(setup), planned_runs(setup))


def _stop_errors(run: Seen) -> Figure | None:
    return draw_stop_errors(run, run.read.summary)


_ALL: Final = frozenset({Chosen.TRAIN, Chosen.STATION, Chosen.TIME})
_TIME: Final = frozenset({Chosen.TIME})
_TRAIN: Final = frozenset({Chosen.TRAIN})
_STATION: Final = frozenset({Chosen.STATION})
_KINDS: Final = (
    Kind(
        "train-graph",
        "Train graph, plan thin and run thick",
        "列車ダイヤ（細線：計画、太線：実績）",
        _times_of_stops,
        lambda run: draw_train_graph(run, _marks(run))[0],
        _TIME,
    ),
    Kind("run-curve", "Run curve", "運転曲線", _run_curve_table, _run_curve, _TRAIN, _TRAIN),
    Kind(
        "track-occupation",
        "Track occupation",
        "番線使用",
        stations.occupation_table,
        stations.draw_occupation,
        _ALL,
    ),
    Kind(
        "station-timetable",
        "Station timetable",
        "駅時刻表",
        stations.timetable_table,
        stations.draw_timetable,
        _STATION | _TIME,
        _STATION,
    ),
    Kind(
        "punctuality",
        "Punctuality by station",
        "駅別定時性",
        stations.punctuality_table,
        stations.draw_punctuality,
        _STATION | _TIME,
    ),
    Kind("delays", "Lateness of every call, s", "列車別・駅別の遅れ [s]", _times_of_stops, draw_delays),
    Kind(
        "waits",
        "Why each stock waited",
        "待ちの理由",
        days.waits_table,
        days.draw_waits,
        _ALL,
    ),
    Kind("duties", "Duties", "運用", days.duties_table, days.draw_duties),
    Kind(
        "energy-train",
        "Energy by train; above, net kWh a train-km",
        "列車別電力量（数値は正味kWh/列車キロ）",
        lambda run: run.tables.energy,
        draw_energy,
    ),
    Kind(
        "energy-leg",
        "Net energy by leg",
        "区間別電力量（正味）",
        lambda run: run.shown(run.tables.energy_legs),
        energy.draw_energy_legs,
        _TRAIN,
    ),
    Kind(
        "energy-parts",
        "Where the energy of each leg went",
        "区間別電力量の内訳",
        lambda run: run.shown(run.tables.energy_legs),
        draw_energy_parts,
        _TRAIN,
    ),
    Kind(
        "energy-hour",
        "Energy by hour",
        "時間帯別電力量",
        energy.energy_hours_table,
        energy.draw_energy_hours,
        _TIME,
    ),
    Kind(
        "battery",
        "State of charge of each set",
        "編成別の充電状態",
        battery.battery_table,
        battery.draw_battery,
        _TIME,
    ),
    Kind(
        "laws",
        "One hop as driven: speed, gradient, notches",
        "一駅間の運転：速度・勾配・ノッチ",
        laws.hops_table,
        laws.draw_laws,
        _TRAIN | _STATION | {Chosen.RUNS},
        _TRAIN,
    ),
    Kind(
        "position",
        "Where it believed to be: error and bounds",
        "位置の誤差と範囲",
        position.position_table,
        position.draw_position,
        _TRAIN,
        _TRAIN,
    ),
    Kind(
        "margins",
        "Margins by hop",
        "区間別余裕時分",
        lambda run: run.shown(run.tables.margins),
        draw_margins,
        _TRAIN,
    ),
    Kind(
        "section-occupancy",
        "Sections, held pale and occupied solid",
        "閉そく区間の確保（淡）と在線（濃）",
        _blocks_table,
        draw_occupancy,
        _TIME,
    ),
    Kind(
        "stairway",
        "Blocking-time stairway",
        "閉そく占有時分",
        stairway_table,
        draw_stairway_of,
        _TIME | _TRAIN,
    ),
    Kind(
        "headway",
        "Least headways by station",
        "駅別の運転時隔",
        fullness.headways_table,
        fullness.draw_headways,
        _STATION,
    ),
    Kind(
        "occupation",
        "Occupancy by part of the line (UIC 406)",
        "線路容量の利用率（UIC 406）",
        fullness.occupation_table,
        fullness.draw_occupations,
        _TIME,
    ),
    Kind(
        "stop-errors",
        "Stop errors",
        "停止誤差",
        lambda run: run.shown(run.tables.stops).filter(pl.col("stop_error_m").is_not_null()),
        _stop_errors,
    ),
    Kind(
        "running-times",
        "Minimum running times",
        "基準運転時分",
        _running_times_table,
        _running_times,
    ),
)
KINDS: Final[Mapping[str, Kind]] = MappingProxyType({kind.name: kind for kind in _KINDS})


def kind_of(name: str) -> Kind:
    """The kind of that name; InputError otherwise."""
    if name not in KINDS:
        raise InputError("command line", "KIND", name, one_of(KINDS, name))
    return KINDS[name]
