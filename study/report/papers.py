"""The tables of the page that are not drawn: margins, telegrams, events, what was changed, what trains have learned."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import polars as pl

from study.measures.missing import planned_times
from study.measures.punctuality import punctuality
from study.measures.station_papers import track_occupation
from study.record.calls import CALL, TRACK, CallAsRun
from study.record.columns import FROM, STATION, TO, TRAIN, TRAINS, UNIT, clock, said, seconds
from study.record.figure import Adds, Figure, Kind, ShownIn, figures_of, seen_in
from study.record.margins import HopMargin
from study.record.marks import DrillShown, Mark, MarkKind
from study.record.sections import SectionHeld
from study.record.shown import LearnedTrain
from study.record.told import EventTold, TelegramsOfWay
from study.report.battery import battery_tables
from study.report.data import ReportedRun, place_name
from study.report.driving import driving_tables
from study.report.energy import energy_tables
from study.report.tabular import Column, Table, table_of
from study.report.tasc import KMHPS_PER_MPS2
from study.wording.parties import party
from study.wording.phrase import NOTHING, Phrase
from study.wording.telegrams import telegram

CHANGES_SHOWN: Final = 200
EVENTS_SHOWN_MAX: Final = 4000
REFUSED_AGAIN_S: Final = 30.0  # who is refused asks again within this
# Of an event whose kind is here the page can do without, where there are too many.
_LESSER_KINDS: Final = ("telegram", "refusal", "train", "reversal")


def tables_shown(
    run: ReportedRun, facts: Mapping[str, Any], tuned: Mapping[str, LearnedTrain], drill: DrillShown | None
) -> tuple[Table, ...]:
    """Every table of the page that is made here and not from what is drawn."""
    return (
        *(() if drill is None else _drill(drill)),
        *_changes(facts.get("changes", ())),
        _occupation(run),
        _punctuality(run),
        *energy_tables(run, facts),
        *driving_tables(run),
        *battery_tables(run, facts),
        *_margins(run),
        *_learned(tuned),
        *_telegrams(run.tables.telegrams),
        _events(run.tables.events),
    )


_OCCUPATION: Final = {
    "station": STATION,
    "track": TRACK,
    "train": TRAIN,
    "next_train": replace(TRAIN, name=Phrase("goes on as", "次列車")),
    "unit": UNIT,
    "kind": CALL,
    "planned_from_s": clock("planned from", "計画 着", 1),
    "planned_to_s": clock("planned to", "計画 発", 1),
    "from_s": clock("from", "開始", 1),
    "to_s": clock("to", "終了", 1),
}


def _occupation(run: ReportedRun) -> Table:
    """Stays at the tracks of the stations, planned and as run."""
    stays = track_occupation(run.tables.stops, run.line, run.timetable)
    return table_of("occupation", stays.to_dicts(), _OCCUPATION)


_PUNCTUALITY: Final = {
    "station": STATION,
    "what": Figure(Phrase("what", "着発・内容"), kind=Kind.WORD),
    "planned": Figure(Phrase("planned", "計画本数")),
    "came": Figure(Phrase("came", "実績本数")),
    "on_time_percent": Figure(Phrase("less than 1 min late", "遅れ1分未満"), "%", 1),
    "mean_s": Figure(Phrase("mean, s after plan", "平均遅れ 秒"), digits=1, kind=Kind.SIGNED),
    "sigma_s": seconds("σ", "標準偏差", 1),
    "p95_s": seconds("95 %", "95%", 1, Kind.SIGNED),
    "worst_s": seconds("worst", "最大", 1, Kind.SIGNED),
    "worst_train": replace(TRAIN, name=Phrase("of train", "列車")),
    "plan_in": Figure(Phrase("plan in", "計画の単位"), kind=Kind.WORD),
}


def _punctuality(run: ReportedRun) -> Table:
    """Arrivals and departures of each station against the plan."""
    rows = punctuality(planned_times(run.tables.stops, run.timetable), run.line).with_columns(
        (100.0 * pl.col("on_time_share")).alias("on_time_percent"),
        ("what_" + pl.col("what")).alias("what"),
        pl.when("whole_minutes").then(pl.lit("minutes")).otherwise(pl.lit("seconds_too")).alias("plan_in"),
    )
    return table_of("punctuality", rows.to_dicts(), _PUNCTUALITY)


def _drill(drill: DrillShown) -> tuple[Table, ...]:
    """What was done to the line, what was expected, and what became of it."""
    items, judged = drill.of(MarkKind.FAULT, MarkKind.ACT), drill.of(MarkKind.EXPECTATION)

    def named(marks: Sequence[Mark]) -> tuple[Column, Column]:
        return (
            Column("mark", Figure(NOTHING, kind=Kind.TEXT), [mark.label for mark in marks]),
            Column("what", said("what", "着発・内容"), [mark.said.both for mark in marks]),
        )

    over = [["–", "–"] if mark.kind is MarkKind.ACT else mark.became.both for mark in items]
    verdict = Figure(Phrase("verdict", "判定"), kind=Kind.WORD)
    verdicts = Column("verdict", verdict, ["met" if mark.passed else "not_met" for mark in judged])
    happened = Column("happened", said("what happened", "経過"), [mark.became.both for mark in judged])
    found = [
        Table(
            "expectations",
            (*named(judged), verdicts, happened),
            ((drill.score, drill.score_ja or drill.score),),
        )
    ]
    if items:
        begun = Column("begun", clock("begun", "開始"), [mark.from_s for mark in items])
        found.insert(
            0, Table("drill_items", (*named(items), begun, Column("over", said("over", "終了"), over)))
        )
    return tuple(found)


_CHANGE: Final = {
    key: Figure(Phrase(key, ja), kind=Kind.TEXT)
    for key, ja in (("file", "ファイル"), ("key", "キー"), ("old", "旧"), ("new", "新"))
}


def _changes(changes: Sequence[Mapping[str, Any]]) -> tuple[Table, ...]:
    """What a what-if has changed of the files it names; nothing where it changed nothing."""
    if not changes:
        return ()
    shown = changes[:CHANGES_SHOWN]
    rest = len(changes) - len(shown)
    notes = ((f"and {rest:,} more in summary.json", f"ほか {rest:,} 件は summary.json にある"),)
    written = [
        {
            **{key: str(change[key]) for key in ("file", "key")},
            **{key: _value(change[key]) for key in ("old", "new")},
        }
        for change in shown
    ]
    return (table_of("changes", written, _CHANGE, notes if rest else ()),)


def _value(value: object) -> str:
    """A value as the files write it, tables in one line; a dash where there is none."""
    return "–" if value is None else json.dumps(value, ensure_ascii=False)


def _between(name: str, which: str, which_ja: str) -> Figure:
    """The least or the most of a time of several trains."""
    figure = _MARGIN[name]
    return Figure(Phrase(f"{figure.heading.en}, {which}", f"{figure.name.ja} {which_ja} 秒"))


_MARGIN: Final = figures_of(HopMargin)
_OF_A_HOP: Final = {
    "from_station": FROM,
    "to_station": TO,
    "trains": TRAINS,
    "planned_least_s": _between("planned_s", "least", "最短"),
    "planned_most_s": _between("planned_s", "most", "最長"),
    **{
        name: replace(_MARGIN[name], digits=0)
        for name in ("least_s", "attainable_s", "margin_s", "margin_percent", "train")
    },
    "run_from_s": _between("run_s", "least", "最短"),
    "run_to_s": _between("run_s", "most", "最長"),
    "left_s": replace(_MARGIN["left_s"], digits=0),
}


def _margins(run: ReportedRun) -> tuple[Table, ...]:
    """Margins by hop and direction with the train of the smallest, and those of every train; none without times."""
    margins = run.tables.margins
    if margins.is_empty():
        return ()
    order = {station.id: station.position_m for station in run.stations}
    rows: list[tuple[tuple[int, float], dict[str, Any]]] = []
    for (from_id, to_id), hop in margins.group_by("from_station", "to_station", maintain_order=True):
        least = hop.sort("margin_s", maintain_order=True).row(0, named=True)
        direction = run.directions[least["train"]]
        cells = {
            "from_station": from_id,
            "to_station": to_id,
            "trains": len(hop),
            "planned_least_s": hop["planned_s"].min(),
            "planned_most_s": hop["planned_s"].max(),
            **{key: least[key] for key in ("least_s", "attainable_s", "margin_s", "margin_percent", "train")},
            "run_from_s": hop["run_s"].min(),
            "run_to_s": hop["run_s"].max(),
            "left_s": hop["left_s"].min(),
        }
        rows.append(((-int(direction), direction * order[str(from_id)]), cells))
    by_hop = [cells for _, cells in sorted(rows, key=lambda row: row[0])]
    return (
        table_of("margins", by_hop, _OF_A_HOP, _cannot_be_kept(run, margins)),
        table_of("legs", margins.to_dicts(), seen_in(HopMargin, ShownIn.REPORT)),
    )


def _cannot_be_kept(run: ReportedRun, margins: pl.DataFrame) -> tuple[tuple[str, str], ...]:
    """A sentence for each hop that is planned faster than a train can run it."""
    found: list[tuple[str, str]] = []
    for row in margins.filter(pl.col("margin_s") < 0.0).iter_rows(named=True):
        ends = [
            " – ".join(place_name(run, row[f"{end}_station"], japanese=japanese) for end in ("from", "to"))
            for japanese in (False, True)
        ]
        planned, least = f"{row['planned_s']:.0f}", f"{row['least_s']:.0f}"
        found.append(
            (
                f"The plan cannot be kept: {row['train']} {ends[0]}, {planned} s planned, at least {least} s needed.",
                f"計画どおりには走れない：{row['train']} {ends[1]}、計画 {planned} 秒、最小 {least} 秒",
            )
        )
    return tuple(found)


def _learned(tuned: Mapping[str, LearnedTrain]) -> tuple[Table, ...]:
    """What the trains have learned of their brakes; nothing where none learned."""
    if not tuned:
        return ()
    rows = [
        {
            "unit": unit,
            "stops_counted": one.learned.stops,
            "left_out": one.learned.left_out,
            "dead_time_designed": one.learned.design_dead_time_s,
            "dead_time_learned": one.learned.dead_time_s,
            "offset_learned": one.learned.offset_mps2 * KMHPS_PER_MPS2,
        }
        for unit, one in sorted(tuned.items())
    ]
    return (table_of("learned", rows, _LEARNED),)


_LEARNED: Final = {
    "unit": UNIT,
    "stops_counted": Figure(Phrase("stops counted", "採用した停止")),
    "left_out": Figure(Phrase("left out", "除外")),
    "dead_time_designed": seconds("dead time designed", "設計むだ時間", 1),
    "dead_time_learned": seconds("learned", "学習値", 1),
    "offset_learned": Figure(Phrase("offset learned", "学習補正"), "km/h/s", 1, kind=Kind.SIGNED),
}
_TELEGRAM_NAMES: Final = {"kind": telegram, "source": party, "destination": party}


def _telegrams(telegrams: pl.DataFrame) -> tuple[Table, ...]:
    figures = figures_of(TelegramsOfWay)
    counts = {name: figure for name, figure in figures.items() if figure.adds is Adds.SUM}
    found: list[Table] = []
    for key, named in _TELEGRAM_NAMES.items():
        sums = telegrams.group_by(key).agg(pl.col(*counts).sum()).sort(key)
        rows = [row | {key: named(row[key]).both} for row in sums.iter_rows(named=True)]
        found.append(table_of(f"telegrams_{key}", rows, {key: figures[key], **counts}))
    return tuple(found)


def _refusals_once(events: pl.DataFrame) -> pl.DataFrame:
    """Who is refused asks again: the same refusal by the same party is one line where it first was, with its count."""
    refused = pl.col("kind") == "refusal"
    again = [pl.col("source"), pl.col("text")]
    soon = (pl.col("t_s") - pl.col("t_s").shift(1).over(again)).fill_null(math.inf) <= REFUSED_AGAIN_S
    spells = events.with_columns((~soon).cum_sum().over(again).alias("spell"))
    one = [*again, "kind", "spell"]
    first = spells.with_columns(pl.len().over(one).alias("times")).filter(~(refused & soon))
    many = refused & (pl.col("times") > 1)
    texts = [
        pl.when(many & (pl.col(name) != ""))
        .then(pl.format(form, pl.col(name), pl.col("times")))
        .otherwise(name)
        for name, form in (("text", "{} (× {})"), ("text_ja", "{}（{} 回）"))
    ]
    return first.with_columns(*texts).select(events.columns)


def _events(events: pl.DataFrame) -> Table:
    """What a person should hear of, by time; of very many, those of lesser kinds are counted and left out first."""
    known = _refusals_once(events.filter(pl.col("t_s").is_finite()).sort("t_s", maintain_order=True))
    shown = known
    if len(known) > EVENTS_SHOWN_MAX:
        lesser = pl.col("kind").is_in(_LESSER_KINDS)
        room = max(EVENTS_SHOWN_MAX - len(known.filter(~lesser)), 0)
        keep = ~lesser | (lesser.cum_sum() <= room)
        shown = known.filter(keep).head(EVENTS_SHOWN_MAX)
    rest = len(known) - len(shown)
    notes = ((f"and {rest:,} more in events.parquet", f"ほか {rest:,} 件は events.parquet にある"),)
    rows = [
        {
            "t_s": row["t_s"],
            "source": party(row["source"]).both,
            "kind": f"event_{row['kind']}",
            "text": [row["text"], row["text_ja"] or row["text"]],
        }
        for row in shown.iter_rows(named=True)
    ]
    return table_of("events", rows, seen_in(EventTold, ShownIn.REPORT), notes if rest else ())


_CALLS: Final = figures_of(CallAsRun)
_OF_A_CALL: Final = ("planned_arrival_s", "arrival_s", "planned_departure_s", "departure_s", "stop_error_m")
# Tables whose rows the page has already, of what it draws.
ROWS_OF_THE_PAGE: Final[Mapping[str, Mapping[str, Figure]]] = {
    "trains": {
        "train": TRAIN,
        "unit": UNIT,
        "direction": Figure(Phrase("direction", "方向"), kind=Kind.WORD),
        "revenue": _CALLS["revenue"],
        "from": replace(STATION, name=Phrase("from", "始発")),
        "to": replace(STATION, name=Phrase("to", "終着")),
        **{
            name: _CALLS[name]
            for name in ("planned_departure_s", "departure_s", "planned_arrival_s", "arrival_s")
        },
        "late_s": seconds("late", "遅れ", 0, Kind.SIGNED),
        "run": Figure(Phrase("Run", "走行"), kind=Kind.WORD),
    },
    "calls": {"train": TRAIN, **{name: _CALLS[name] for name in ("station", "track", "kind", *_OF_A_CALL)}},
    "errors": {
        "train": TRAIN,
        "unit": UNIT,
        **{name: _CALLS[name] for name in ("station", "arrival_s", "stop_error_m")},
    },
    "blocks": seen_in(SectionHeld, ShownIn.REPORT),
    "waits": {
        "unit": UNIT,
        "from_s": clock("from", "開始"),
        "until": clock("until", "まで"),
        "why": Figure(Phrase("why", "理由"), kind=Kind.SAID),
    },
}
