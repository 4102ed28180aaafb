"""What a comparison found as tables of text: the same ones for the terminal, the report and the page."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Final

from network.clock import clock
from study.compare.comparison import Comparisons, RunComparison
from study.compare.measures import ComparedRow, Measure, Value, columns_in, names_in, sorted_by
from study.compare.meets import MeetChange, RunMeet
from study.compare.side import ComparedRun
from study.compare.times import CallEvent, MovedTime
from study.record.driving import EARLY
from study.record.figure import Figure, Kind, ShownIn, seen_in
from study.record.parts import TextTable, signed_number
from study.record.tables import ROWS
from study.report.data import place_said
from study.wording.compared import EARLIER, HEADING, LATER, compared_name
from study.wording.phrase import Language, Phrase, joined_phrases
from study.wording.telegrams import telegram

SAME: Final = "="
NONE: Final = "–"
_FIGURES: Final = {
    figure.name.en: figure.name
    for figure in (
        *(figure for row in ROWS.values() for figure in seen_in(row, ShownIn.TOTALS_COMPARED).values()),
        EARLY,
    )
}


def measures_grid(found: Comparisons, language: Language = "en", *, changed_only: bool = False) -> TextTable:
    """A row a figure, a column a run; with two runs their difference stands in a column of its own."""
    labels = [side.label for side in found.sides]
    rows: list[tuple[str, ...]] = []
    for measure in found.measures:
        if changed_only and not any(_by(measure, index) != SAME for index in range(1, len(measure.values))):
            continue
        unit = f", {compared_name(measure.unit).in_(language)}" if measure.unit else ""
        cells = [
            _value(measure, index, language) + (_apart(measure, index) if len(labels) > 2 else "")
            for index in range(len(labels))
        ]
        last = (_by(measure, 1),) if len(labels) == 2 else ()
        rows.append(
            (
                compared_name(measure.group).in_(language),
                f"{(_FIGURES.get(measure.name) or compared_name(measure.name)).in_(language)}{unit}",
                *cells,
                *last,
            )
        )
    header = ("", "", *labels, *((compared_name("difference").in_(language),) if len(labels) == 2 else ()))
    return TextTable(header, tuple(rows), numbers_from=2)


def inputs_grid(found: RunComparison, language: Language = "en") -> TextTable:
    """Inputs that differ, with who patched them."""
    rows = tuple(
        (compared_name(c.file).in_(language), c.key, _json(c.old), _json(c.new), ", ".join(c.by))
        for c in found.inputs
    )
    return TextTable(_heads(language, "file", "key", "old", "new", "set by"), rows)


def moved_grid(
    found: RunComparison, new: ComparedRun, language: Language = "en", *, largest_first: bool = False
) -> TextTable:
    """Every time that moved, in order of time or the largest first."""
    listed = list(found.times.moved)
    if largest_first:
        listed.sort(key=lambda moved: -abs(moved.by_s))
    rows = tuple(
        (
            moved.train,
            compared_name(moved.direction).in_(language),
            place_said(new.run, moved.station).in_(language),
            compared_name(moved.what.value).in_(language),
            _clock(moved.old_s),
            _clock(moved.new_s),
            _later(moved.by_s).in_(language),
            NONE
            if moved.plan_by_s is None
            else signed_number(moved.plan_by_s, 0, compared_name("s").in_(language)),
        )
        for moved in listed
    )
    header = _heads(language, "train", "", "station", "what", "old", "new", "moved", "by plan")
    return TextTable(header, rows, numbers_from=4)


def moved_matrix(found: RunComparison, new: ComparedRun, language: Language = "en") -> TextTable:
    """A row a train that moved, a column a station: seconds of arrival / departure, a dot where it did not move."""
    by_train: dict[str, dict[str, dict[CallEvent, MovedTime]]] = {}
    for moved in found.times.moved:
        by_train.setdefault(moved.train, {}).setdefault(moved.station, {})[moved.what] = moved
    seen = {station for stations in by_train.values() for station in stations}
    places = [station for station in new.run.stations if station.id in seen]
    rows = tuple(
        (
            train,
            compared_name(new.run.directions[train].name.lower()).in_(language),
            *(_cell(by_train[train].get(p.id, {})) for p in places),
        )
        for train in new.run.trains
        if train in by_train
    )
    names = (place_said(new.run, place.id).in_(language) for place in places)
    return TextTable((*_heads(language, "train", ""), *names), rows, numbers_from=2)


def once_grid(found: RunComparison, new: ComparedRun, language: Language = "en") -> TextTable:
    """Arrivals and departures that came in one of the runs only."""
    rows = tuple(
        (
            once.train,
            place_said(new.run, once.station).in_(language),
            compared_name(once.what.value).in_(language),
            found.new if once.in_new else found.base,
            _clock(once.at_s),
        )
        for once in found.times.once
    )
    return TextTable(_heads(language, "train", "station", "what", "only in", "at"), rows, numbers_from=4)


def meets_grid(
    found: RunComparison, base: ComparedRun, new: ComparedRun, language: Language = "en"
) -> TextTable:
    """Meets that moved, came or went."""

    def place(side: ComparedRun, meet: RunMeet | None) -> str:
        if meet is None:
            return NONE
        where = joined_phrases((place_said(side.run, at) for at in meet.at), " – ", "～")
        return f"{where.in_(language)} {_clock(meet.time_s)}"

    def later(change: MeetChange) -> str:
        if change.why.en:
            return change.why.in_(language)
        return NONE if change.by_s is None else _later(change.by_s).in_(language)

    rows = tuple(
        (
            c.down_train,
            c.up_train,
            compared_name(c.fate.value).in_(language),
            place(base, c.old),
            place(new, c.new),
            later(c),
        )
        for c in found.meets
    )
    return TextTable(_heads(language, "down", "up", "meet", "old", "new", "moved"), rows)


def rows_grid(found: RunComparison, table: str, new: ComparedRun, language: Language = "en") -> TextTable:
    """What differs in margins, energy, telegrams or stops, by more than can be left out, most first."""
    shown = seen_in(ROWS[table], ShownIn.ROWS_LISTED)
    by = next(iter({**seen_in(ROWS[table], ShownIn.LISTED_BY), **shown}))
    listed = [row for row in found.rows[table] if any(_is_shown(row, *column) for column in shown.items())]
    rows = tuple(
        (
            *(
                _name(new, figure, name, language)
                for figure, name in zip(names_in(table).values(), row.names, strict=True)
            ),
            *(text for column, figure in shown.items() for text in _old_new_by(row, column, figure.digits)),
        )
        for row in sorted_by(listed, by)
    )
    headings = [
        text
        for figure in shown.values()
        for text in (HEADING.fill(what=figure.heading).in_(language), *_heads(language, "new", "by"))
    ]
    titles = [figure.name.in_(language) for figure in names_in(table).values()]
    return TextTable((*titles, *headings), rows, numbers_from=len(titles))


def _name(side: ComparedRun, figure: Figure, name: str, language: Language) -> str:
    match figure.kind:
        case Kind.PLACE:
            return place_said(side.run, name).in_(language)
        case Kind.SAID:
            return telegram(name).in_(language)
        case _:
            return name


def _heads(language: Language, *names: str) -> tuple[str, ...]:
    return tuple(compared_name(name).in_(language) for name in names)


def columns_of(table: str) -> tuple[str, ...]:
    """The headings of a table's file: what names a row, then old and new of each column."""
    return (
        *names_in(table),
        *(f"{column}_{when}" for column in columns_in(table) for when in ("old", "new")),
    )


def first_rows(grid: TextTable, most: int) -> tuple[TextTable, int]:
    """The first rows of a grid, and how many were left out."""
    return TextTable(grid.header, grid.rows[:most], grid.numbers_from, grid.numbers_to), max(
        len(grid.rows) - most, 0
    )


def _is_shown(row: ComparedRow, column: str, figure: Figure) -> bool:
    """Whether a difference can be read, or one of both has none."""
    old, new = row.values[column]
    return (old is None) != (new is None) or abs(row.by(column) or 0.0) >= 0.5 * 10.0**-figure.digits


def _old_new_by(row: ComparedRow, column: str, digits: int) -> tuple[str, str, str]:
    old, new = row.values[column]
    by = NONE if old is None or new is None else _difference(new - old, digits)
    return _number(old, digits), _number(new, digits), by


def _value(measure: Measure, index: int, language: Language) -> str:
    text, where = _number(measure.values[index], measure.digits), measure.where[index].in_(language)
    return f"{text} ({where})" if where else text


def _apart(measure: Measure, index: int) -> str:
    return "" if index == 0 or _by(measure, index) == SAME else f"  {_by(measure, index)}"


def _by(measure: Measure, index: int) -> str:
    by = measure.by(index)
    if by is None:
        return SAME if measure.values[0] is None and measure.values[index] is None else NONE
    return _difference(by, measure.digits)


def _difference(by: float, digits: int) -> str:
    return signed_number(by, digits) if abs(by) >= 0.5 * 10.0**-digits else SAME


def _number(value: Value, digits: int) -> str:
    return NONE if value is None else f"{value:,.{digits}f}".replace("-", "−")


def _cell(moved: Mapping[CallEvent, MovedTime]) -> str:
    """Arrival and departure of a train at a station; nothing where neither moved."""
    if not moved:
        return ""
    if CallEvent.PASSING in moved:
        return signed_number(moved[CallEvent.PASSING].by_s, 0)
    ends = (CallEvent.ARRIVAL, CallEvent.DEPARTURE)
    return " / ".join(signed_number(moved[what].by_s, 0) if what in moved else "·" for what in ends)


def _later(by_s: float) -> Phrase:
    return (LATER if by_s > 0 else EARLIER).fill(by_s=abs(by_s))


def _clock(time_s: float) -> str:
    """HH:MM:SS.s: runs go by steps of a tenth of a second."""
    tenths = round(time_s * 10)
    return f"{clock(tenths // 10)}.{tenths % 10}"


def _json(value: object) -> str:
    return NONE if value is None else json.dumps(value, ensure_ascii=False)
