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
from study.record.columns import FROM, STATION, TO, TRAIN, TRAINS, UNIT, clock, said_in_both, seconds
from study.record.figure import Adds, Figure, Kind, ShownIn, figures_of, seen_in
from study.record.journal_rows import EventInWords, TelegramsOfWay
from study.record.margins import HopMargin
from study.record.marks import DrillShown, Mark, MarkKind
from study.record.sections import SectionHeld
from study.record.shown import LearnedTrain
from study.report.battery import battery_tables
from study.report.crossings import crossing_tables_shown
from study.report.data import ReportedRun, place_said
from study.report.driving import driving_tables
from study.report.energy import energy_tables
from study.report.tabular import Column, Table, table_of
from study.report.tasc import KMHPS_PER_MPS2
from study.wording.catalogue import phrase, phrase_or_name
from study.wording.outcome import MET, NOT_MET
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
        _punctuality(run, facts.get("latest_end_s")),
        *energy_tables(run, facts),
        *driving_tables(run),
        *battery_tables(run, facts),
        *crossing_tables_shown(run),
        *_margins(run),
        *_learned(tuned),
        *_telegrams(run.tables.telegrams),
        _events(run.tables.events),
    )


_OCCUPATION: Final = {
    "station": STATION,
    "track": TRACK,
    "train": TRAIN,
    "next_train": replace(TRAIN, name=phrase("goes on as")),
    "unit": UNIT,
    "kind": CALL,
    "planned_from_s": clock("planned from", 1),
    "planned_to_s": clock("planned to", 1),
    "from_s": clock("from", 1),
    "to_s": clock("to", 1),
}


def _occupation(run: ReportedRun) -> Table:
    """Stays at the tracks of the stations, planned and as run."""
    stays = track_occupation(run.tables.stops, run.line, run.timetable, run.tables.waits)
    return table_of("occupation", phrase("Every stay at a track"), stays.to_dicts(), _OCCUPATION)


_PUNCTUALITY: Final = {
    "station": STATION,
    "what": said_in_both("what"),
    "planned": Figure(phrase("planned", "count")),
    "came": Figure(phrase("came")),
    "on_time_percent": Figure(phrase("less than 1 min late"), "%", 1),
    "mean_s": Figure(phrase("mean, s after plan"), digits=1, kind=Kind.SIGNED),
    "sigma_s": seconds("σ", 1),
    "p95_s": seconds("95 %", 1, Kind.SIGNED),
    "worst_s": seconds("worst", 1, Kind.SIGNED),
    "worst_train": replace(TRAIN, name=phrase("of train")),
    "plan_in": said_in_both("plan in"),
}


_OF_CALLS: Final = {"arrival": phrase("arrivals"), "departure": phrase("departures")}


def _punctuality(run: ReportedRun, end_s: float | None) -> Table:
    """Arrivals and departures of each station against the plan."""
    times = planned_times(run.tables.stops, run.timetable, end_s)
    rows = [
        row
        | {
            "on_time_percent": 100.0 * row["on_time_share"],
            "what": _OF_CALLS[row["what"]].both,
            "plan_in": phrase("whole minutes" if row["whole_minutes"] else "seconds too").both,
        }
        for row in punctuality(times, run.line).iter_rows(named=True)
    ]
    return table_of("punctuality", phrase("Punctuality by station"), rows, _PUNCTUALITY)


def _drill(drill: DrillShown) -> tuple[Table, ...]:
    """What was done to the line, what was expected, and what became of it."""
    items, judged = drill.of_kinds(MarkKind.FAULT, MarkKind.ACT), drill.of_kinds(MarkKind.EXPECTATION)

    def named(marks: Sequence[Mark]) -> tuple[Column, Column]:
        return (
            Column("mark", Figure(NOTHING, kind=Kind.TEXT), [mark.label for mark in marks]),
            Column("what", said_in_both("what", context="drill"), [mark.said.both for mark in marks]),
        )

    over = [["–", "–"] if mark.kind is MarkKind.ACT else mark.became.both for mark in items]
    verdicts = Column(
        "verdict", said_in_both("verdict"), [(MET if mark.passed else NOT_MET).both for mark in judged]
    )
    happened = Column("happened", said_in_both("what happened"), [mark.became.both for mark in judged])
    found = [
        Table(
            "expectations",
            phrase("Expectations"),
            (*named(judged), verdicts, happened),
            (Phrase(drill.score, drill.score_ja),),
        )
    ]
    if items:
        begun = Column("begun", clock("begun"), [mark.from_s for mark in items])
        found.insert(
            0,
            Table(
                "drill_items",
                phrase("Faults and acts"),
                (*named(items), begun, Column("over", said_in_both("over"), over)),
            ),
        )
    return tuple(found)


_MORE_IN: Final = phrase("and {count} more in {file}")
_CHANGE: Final = {key: Figure(phrase(key), kind=Kind.TEXT) for key in ("file", "key", "old", "new")}


def _changes(changes: Sequence[Mapping[str, Any]]) -> tuple[Table, ...]:
    """What a what-if has changed of the files it names; nothing where it changed nothing."""
    if not changes:
        return ()
    shown = changes[:CHANGES_SHOWN]
    rest = len(changes) - len(shown)
    notes = (_MORE_IN.fill(count=f"{rest:,}", file="summary.json"),)
    written = [
        {
            **{key: str(change[key]) for key in ("file", "key")},
            **{key: _value(change[key]) for key in ("old", "new")},
        }
        for change in shown
    ]
    return (table_of("changes", phrase("What was changed"), written, _CHANGE, notes if rest else ()),)


def _value(value: object) -> str:
    """A value as the files write it, tables in one line; a dash where there is none."""
    return "–" if value is None else json.dumps(value, ensure_ascii=False)


def _between(name: str, form: str) -> Figure:
    """The least or the most of a time of several trains, s."""
    return Figure(phrase(form).fill(time=_MARGIN[name].name), "s")


_LEAST, _MOST = "{time}, least", "{time}, most"
_MARGIN: Final = figures_of(HopMargin)
_OF_A_HOP: Final = {
    "from_station": FROM,
    "to_station": TO,
    "trains": TRAINS,
    "planned_least_s": _between("planned_s", _LEAST),
    "planned_most_s": _between("planned_s", _MOST),
    **{
        name: replace(_MARGIN[name], digits=0)
        for name in ("least_s", "attainable_s", "margin_s", "margin_percent", "train")
    },
    "run_from_s": _between("run_s", _LEAST),
    "run_to_s": _between("run_s", _MOST),
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
        table_of("margins", phrase("Margins by hop"), by_hop, _OF_A_HOP, _cannot_be_kept(run, margins)),
        table_of(
            "legs", phrase("Margins of each train"), margins.to_dicts(), seen_in(HopMargin, ShownIn.REPORT)
        ),
    )


def _cannot_be_kept(run: ReportedRun, margins: pl.DataFrame) -> tuple[Phrase, ...]:
    """A sentence for each hop that is planned faster than a train can run it."""
    return tuple(
        phrase(
            "The plan cannot be kept: {train} {here} – {there}, {planned_s:.0f} s planned,"
            " at least {least_s:.0f} s needed."
        ).fill(
            train=row["train"],
            here=place_said(run, row["from_station"]),
            there=place_said(run, row["to_station"]),
            planned_s=row["planned_s"],
            least_s=row["least_s"],
        )
        for row in margins.filter(pl.col("margin_s") < 0.0).iter_rows(named=True)
    )


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
    return (table_of("learned", phrase("Learned"), rows, _LEARNED),)


_LEARNED: Final = {
    "unit": UNIT,
    "stops_counted": Figure(phrase("stops counted")),
    "left_out": Figure(phrase("left out")),
    "dead_time_designed": seconds("dead time designed", 1),
    "dead_time_learned": seconds("learned", 1, context="value"),
    "offset_learned": Figure(phrase("offset learned"), "km/h/s", 1, kind=Kind.SIGNED),
}
_TELEGRAMS_BY: Final = {
    "kind": phrase("Telegrams by kind"),
    "source": phrase("Telegrams by sender"),
    "destination": phrase("Telegrams by receiver"),
}
_TELEGRAM_NAMES: Final = {"kind": telegram, "source": party, "destination": party}


def _telegrams(telegrams: pl.DataFrame) -> tuple[Table, ...]:
    figures = figures_of(TelegramsOfWay)
    counts = {name: figure for name, figure in figures.items() if figure.adds is Adds.SUM}
    found: list[Table] = []
    for key, named in _TELEGRAM_NAMES.items():
        sums = telegrams.group_by(key).agg(pl.col(*counts).sum()).sort(key)
        rows = [row | {key: named(row[key]).both} for row in sums.iter_rows(named=True)]
        found.append(table_of(f"telegrams_{key}", _TELEGRAMS_BY[key], rows, {key: figures[key], **counts}))
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
    repeated = phrase("{} (× {})")
    texts = [
        pl.when(many & (pl.col(name) != ""))
        .then(pl.format(form, pl.col(name), pl.col("times")))
        .otherwise(name)
        for name, form in (("text", repeated.en), ("text_ja", repeated.ja))
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
    notes = (_MORE_IN.fill(count=f"{rest:,}", file="events.parquet"),)
    rows = [
        {
            "t_s": row["t_s"],
            "source": party(row["source"]).both,
            "kind": phrase_or_name(row["kind"], "event kind").both,
            "text": [row["text"], row["text_ja"] or row["text"]],
        }
        for row in shown.iter_rows(named=True)
    ]
    return table_of(
        "events", phrase("Events"), rows, seen_in(EventInWords, ShownIn.REPORT), notes if rest else ()
    )


_CALLS: Final = figures_of(CallAsRun)
_OF_A_CALL: Final = ("planned_arrival_s", "arrival_s", "planned_departure_s", "departure_s", "stop_error_m")
# Tables whose rows the page has already, of what it draws.
ROWS_OF_THE_PAGE: Final[Mapping[str, tuple[Phrase, Mapping[str, Figure]]]] = {
    "trains": (
        phrase("Plan and run of every train"),
        {
            "train": TRAIN,
            "unit": UNIT,
            "direction": Figure(phrase("direction"), kind=Kind.WORD),
            "revenue": _CALLS["revenue"],
            "from": replace(STATION, name=phrase("from", "journey")),
            "to": replace(STATION, name=phrase("to", "journey")),
            **{
                name: _CALLS[name]
                for name in ("planned_departure_s", "departure_s", "planned_arrival_s", "arrival_s")
            },
            "late_s": seconds("late", 0, Kind.SIGNED),
            "run": Figure(phrase("Run"), kind=Kind.WORD),
        },
    ),
    "calls": (
        phrase("Every call"),
        {"train": TRAIN, **{name: _CALLS[name] for name in ("station", "track", "kind", *_OF_A_CALL)}},
    ),
    "errors": (
        phrase("Stop errors of every stop"),
        {
            "train": TRAIN,
            "unit": UNIT,
            **{name: _CALLS[name] for name in ("station", "arrival_s", "stop_error_m")},
        },
    ),
    "blocks": (phrase("Every grant"), seen_in(SectionHeld, ShownIn.REPORT)),
    "waits": (
        phrase("Waits"),
        {
            "unit": UNIT,
            "from_s": clock("from"),
            "until": clock("until"),
            "why": Figure(phrase("why"), kind=Kind.SAID),
        },
    ),
}
