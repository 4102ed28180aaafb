"""The tables of the page that are not drawn: margins, telegrams, events, what was changed, what trains have learned."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import polars as pl

from study.measures.missing import planned_times
from study.measures.punctuality import punctuality
from study.measures.station_papers import track_occupation
from study.report.battery import battery_tables
from study.report.data import Run, place_name
from study.report.drill import DrillShown, Mark, MarkKind
from study.report.driving import driving_tables
from study.report.energy import energy_tables
from study.report.tabular import Column, Kind, Table, table_of
from study.report.tasc import KMHPS_PER_MPS2, Tuned
from study.run.summary import TELEGRAM_COUNTS
from study.wording.parties import party
from study.wording.telegrams import telegram

CHANGES_SHOWN: Final = 200
EVENTS_SHOWN_MAX: Final = 4000
REFUSED_AGAIN_S: Final = 30.0  # who is refused asks again within this
# Of an event whose kind is here the page can do without, where there are too many.
_LESSER_KINDS: Final = ("telegram", "refusal", "train", "reversal")


def tables_shown(
    run: Run, facts: Mapping[str, Any], tuned: Mapping[str, Tuned], drill: DrillShown | None
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


def _occupation(run: Run) -> Table:
    """Stays at the tracks of the stations, planned and as run."""
    stays = track_occupation(run.tables.stops, run.line, run.timetable)
    return table_of(
        "occupation",
        stays.to_dicts(),
        {
            "station": (Kind.PLACE, 0),
            "track": (Kind.TEXT, 0),
            "train": (Kind.TRAIN, 0),
            "next_train": (Kind.TRAIN, 0),
            "unit": (Kind.TEXT, 0),
            "kind": (Kind.CALL, 0),
            "planned_from_s": (Kind.CLOCK, 1),
            "planned_to_s": (Kind.CLOCK, 1),
            "from_s": (Kind.CLOCK, 1),
            "to_s": (Kind.CLOCK, 1),
        },
    )


def _punctuality(run: Run) -> Table:
    """Arrivals and departures of each station against the plan."""
    rows = punctuality(planned_times(run.tables.stops, run.timetable), run.line).with_columns(
        (100.0 * pl.col("on_time_share")).alias("on_time_percent"),
        ("what_" + pl.col("what")).alias("what"),
        pl.when("whole_minutes").then(pl.lit("minutes")).otherwise(pl.lit("seconds_too")).alias("plan_in"),
    )
    return table_of(
        "punctuality",
        rows.to_dicts(),
        {
            "station": (Kind.PLACE, 0),
            "what": (Kind.WORD, 0),
            "planned": (Kind.NUMBER, 0),
            "came": (Kind.NUMBER, 0),
            "on_time_percent": (Kind.NUMBER, 1),
            "mean_s": (Kind.SIGNED, 1),
            "sigma_s": (Kind.NUMBER, 1),
            "p95_s": (Kind.SIGNED, 1),
            "worst_s": (Kind.SIGNED, 1),
            "worst_train": (Kind.TRAIN, 0),
            "plan_in": (Kind.WORD, 0),
        },
    )


def _drill(drill: DrillShown) -> tuple[Table, ...]:
    """What was done to the line, what was expected, and what became of it."""
    items, judged = drill.of(MarkKind.FAULT, MarkKind.ACT), drill.of(MarkKind.EXPECTATION)

    def named(marks: Sequence[Mark]) -> tuple[Column, Column]:
        return (
            Column("mark", Kind.TEXT, [mark.label for mark in marks]),
            Column("what", Kind.SAID, [mark.said.both for mark in marks]),
        )

    over = [["–", "–"] if mark.kind is MarkKind.ACT else mark.became.both for mark in items]
    verdicts = Column("verdict", Kind.WORD, ["met" if mark.passed else "not_met" for mark in judged])
    happened = Column("happened", Kind.SAID, [mark.became.both for mark in judged])
    found = [
        Table(
            "expectations",
            (*named(judged), verdicts, happened),
            ((drill.score, drill.score_ja or drill.score),),
        )
    ]
    if items:
        begun = Column("begun", Kind.CLOCK, [mark.from_s for mark in items])
        found.insert(0, Table("drill_items", (*named(items), begun, Column("over", Kind.SAID, over))))
    return tuple(found)


def _changes(changes: Sequence[Mapping[str, Any]]) -> tuple[Table, ...]:
    """What a what-if has changed of the files it names; nothing where it changed nothing."""
    if not changes:
        return ()
    shown = changes[:CHANGES_SHOWN]
    rest = len(changes) - len(shown)
    notes = ((f"and {rest:,} more in summary.json", f"ほか {rest:,} 件は summary.json にある"),)
    columns = (
        *(Column(key, Kind.TEXT, [str(change[key]) for change in shown]) for key in ("file", "key")),
        *(Column(key, Kind.TEXT, [_value(change[key]) for change in shown]) for key in ("old", "new")),
    )
    return (Table("changes", columns, notes if rest else ()),)


def _value(value: object) -> str:
    """A value as the files write it, tables in one line; a dash where there is none."""
    return "–" if value is None else json.dumps(value, ensure_ascii=False)


def _margins(run: Run) -> tuple[Table, ...]:
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
    by_hop = table_of(
        "margins",
        [cells for _, cells in sorted(rows, key=lambda row: row[0])],
        {
            "from_station": (Kind.PLACE, 0),
            "to_station": (Kind.PLACE, 0),
            "trains": (Kind.NUMBER, 0),
            "planned_least_s": (Kind.NUMBER, 0),
            "planned_most_s": (Kind.NUMBER, 0),
            "least_s": (Kind.NUMBER, 0),
            "attainable_s": (Kind.NUMBER, 0),
            "margin_s": (Kind.SIGNED, 0),
            "margin_percent": (Kind.SIGNED, 0),
            "train": (Kind.TRAIN, 0),
            "run_from_s": (Kind.NUMBER, 0),
            "run_to_s": (Kind.NUMBER, 0),
            "left_s": (Kind.SIGNED, 0),
        },
        _cannot_be_kept(run, margins),
    )
    each = table_of(
        "legs",
        margins.to_dicts(),
        {
            "train": (Kind.TRAIN, 0),
            "from_station": (Kind.PLACE, 0),
            "to_station": (Kind.PLACE, 0),
            "planned_s": (Kind.NUMBER, 0),
            "least_s": (Kind.NUMBER, 1),
            "attainable_s": (Kind.NUMBER, 1),
            "margin_s": (Kind.SIGNED, 1),
            "run_s": (Kind.NUMBER, 1),
            "left_s": (Kind.SIGNED, 1),
        },
    )
    return by_hop, each


def _cannot_be_kept(run: Run, margins: pl.DataFrame) -> tuple[tuple[str, str], ...]:
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


def _learned(tuned: Mapping[str, Tuned]) -> tuple[Table, ...]:
    """What the trains have learned of their brakes; nothing where none learned."""
    if not tuned:
        return ()
    rows = [(unit, one.learned) for unit, one in sorted(tuned.items())]
    return (
        Table(
            "learned",
            (
                Column("unit", Kind.TEXT, [unit for unit, _ in rows]),
                Column("stops_counted", Kind.NUMBER, [one.stops for _, one in rows]),
                Column("left_out", Kind.NUMBER, [one.left_out for _, one in rows]),
                Column("dead_time_designed", Kind.NUMBER, [one.design_dead_time_s for _, one in rows], 1),
                Column("dead_time_learned", Kind.NUMBER, [one.dead_time_s for _, one in rows], 1),
                Column(
                    "offset_learned", Kind.SIGNED, [one.offset_mps2 * KMHPS_PER_MPS2 for _, one in rows], 1
                ),
            ),
        ),
    )


_TELEGRAM_NAMES: Final = {"kind": telegram, "source": party, "destination": party}


def _telegrams(telegrams: pl.DataFrame) -> tuple[Table, ...]:
    counts = [*TELEGRAM_COUNTS, "bytes"]
    found: list[Table] = []
    for key, label in (("kind", "telegram_kind"), ("source", "sent_by"), ("destination", "sent_to")):
        sums = telegrams.group_by(key).agg(pl.col(counts).sum()).sort(key)
        found.append(
            Table(
                f"telegrams_{key}",
                (
                    Column(label, Kind.SAID, [_TELEGRAM_NAMES[key](name).both for name in sums[key]]),
                    *(Column(name, Kind.NUMBER, sums[name].to_list()) for name in counts),
                ),
            )
        )
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
    return Table(
        "events",
        (
            Column("time", Kind.CLOCK, shown["t_s"].to_list(), 1),
            Column("source", Kind.SAID, [party(name).both for name in shown["source"]]),
            Column("event_kind", Kind.WORD, [f"event_{kind}" for kind in shown["kind"]]),
            Column("text", Kind.SAID, [[en, ja or en] for en, ja in shown["text", "text_ja"].iter_rows()]),
        ),
        notes if rest else (),
    )
