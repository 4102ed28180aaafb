"""A comparison as parts of a page: of the report of a run, or of a page of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from study.compare.comparison import Comparisons, RunComparison, verdict_said
from study.compare.graph import draw_both
from study.compare.grids import (
    inputs_grid,
    measures_grid,
    meets_grid,
    moved_grid,
    moved_matrix,
    once_grid,
    rows_grid,
)
from study.compare.measures import TABLES
from study.compare.side import ComparedRun
from study.record.parts import PagePart, TextTable
from study.report.style import svg_of
from study.wording import compared as words
from study.wording.catalogue import phrase
from study.wording.phrase import NOTHING, Language, Phrase, joined_phrases

OPEN_ROWS: Final = 40  # longer tables are folded
_GRAPH_HELP: Final = (
    "Trains that moved: thick in colour as they ran, thin and dashed as they ran in the other run."
    " Pale: not moved."
)
_INPUTS: Final = phrase("Inputs that differ")
_MOVED: Final = phrase("Times that moved")
_MOVED_HELP: Final = phrase(
    "Seconds by which arrival / departure moved, where by more than {over} s; + is later in {label}."
)
_EVERY_TIME: Final = phrase("Every time that moved")
_ONCE: Final = phrase("Came in one run only")
_ONCE_HELP: Final = phrase("Of trains that run in both.")
_MEETS: Final = phrase("Meets that moved")
_MEETS_HELP: Final = phrase("As run: where and when the fronts passed.")
_ROWS: Final = {
    "margins": (
        phrase("Margins that differ"),
        phrase("As planned over the least running time, and what was left on arrival."),
    ),
    "energy": (
        phrase("Energy by train"),
        phrase("What differs, the largest difference first."),
    ),
    "crossings": (
        phrase("Level crossings by hour"),
        phrase("What differs, the largest difference first."),
    ),
    "driving": (
        phrase("Driving by hop"),
        phrase("Traction less what came back, notches, coasting and arrival; the largest difference first."),
    ),
    "telegrams": (phrase("Telegrams by kind"), NOTHING),
    "stops": (
        phrase("Stops at the mark"),
        phrase("Errors that differ by a millimetre or more; beyond the mark is positive."),
    ),
}


def parts_against(found: Comparisons, index: int = 0, *, graphs: bool = True) -> tuple[PagePart, ...]:
    """What changed from the first run to one of the others, in the order in which a planner reads it.

    The report of a run leaves out the picture of both `graphs`: its own graph shows the other run. Call within
    `study.report.style.drawing`.
    """
    pair, base, new = found.pairs[index], found.sides[0], found.sides[index + 1]
    two = found.of_two(index)
    first = _part(
        words.CHANGED.fill(label=base.label),
        joined_phrases(verdict_said(pair), " ", ""),
        lambda language: measures_grid(two, language),
    )
    if pair.nothing_differs:
        return (first,)
    over, seen = f"{pair.over_s:g}", new.label
    listed = [
        _part(_INPUTS, _inputs_text(pair), lambda language: inputs_grid(pair, language)),
        _part(
            _MOVED,
            _MOVED_HELP.fill(over=over, label=seen),
            lambda language: moved_matrix(pair, new, language),
        ),
        _part(_EVERY_TIME, NOTHING, lambda language: moved_grid(pair, new, language)),
        _part(_ONCE, _ONCE_HELP, lambda language: once_grid(pair, new, language)),
        _part(_MEETS, _MEETS_HELP, lambda language: meets_grid(pair, base, new, language)),
        *(_of_table(pair, table, new) for table in TABLES),
    ]
    both = (
        (PagePart("Both train graphs", _GRAPH_HELP, (svg_of(draw_both(base, new, pair), f"both{index}"),)),)
        if graphs
        else ()
    )
    return (first, *both, *(_folded(part) for part in listed if part.grids[0].rows))


def _part(title: Phrase, caption: Phrase, grid: Callable[[Language], TextTable]) -> PagePart:
    """A part with one table, in both languages."""
    return PagePart(
        title.en,
        caption.en,
        grids=(grid("en"),),
        grids_ja=(grid("ja"),),
        title_ja=title.in_("ja"),
        caption_ja=caption.in_("ja"),
    )


def _of_table(pair: RunComparison, table: str, new: ComparedRun) -> PagePart:
    """What differs in one of the tables."""
    title, caption = _ROWS[table]
    return _part(title, caption, lambda language: rows_grid(pair, table, new, language))


def _folded(part: PagePart) -> PagePart:
    """A long table is folded; its line says how long."""
    count = len(part.grids[0].rows)
    folded = words.ROWS.fill(count=f"{count:,}")
    return part if count <= OPEN_ROWS else replace(part, folded=folded.en, folded_ja=folded.in_("ja"))


def _inputs_text(pair: RunComparison) -> Phrase:
    count = len(pair.inputs)
    return words.ONE_DIFFERENCE if count == 1 else words.DIFFERENCES.fill(count=f"{count:,}")
