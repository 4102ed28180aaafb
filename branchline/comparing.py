"""`branchline compare`: what changed between runs, for a person, as JSON and as a directory of files."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from branchline.ending import print_json
from branchline.options import Json
from branchline.progress import tell
from network.errors import InputError
from study.outcome import Outcome

if TYPE_CHECKING:
    from rich.console import Console

    from study.compare.comparison import Comparisons
    from study.record.parts import TextTable

WIDTH_IN_FILE: Final = 160  # characters
OVER_S: Final = 1.0  # what moved by no more is not listed
SHOWN: Final = 20  # rows of a table on the terminal; the files have all
Over = Annotated[float, typer.Option("--over", help="List only times that moved by more than this, s.")]


def compare(
    base: Annotated[Path, typer.Argument(help="Run directory that the others are compared with.")],
    others: Annotated[list[Path], typer.Argument(help="Run directories of the same line.", metavar="OTHER")],
    over: Over = OVER_S,
    out: Annotated[
        Path | None, typer.Option("--out", help="Directory for compare.html, compare.json, CSV and pictures.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Compare finished runs: inputs, times, meets, punctuality, margins, energy, telegrams."""
    check_over(over)
    from study.compare.comparison import compare as compared
    from study.compare.files import write_comparison
    from study.compare.side import read_sides

    found = compared(read_sides([base, *others]), over)
    page = None
    if out is not None:
        tell("writing the comparison")
        page = write_comparison(found, out.resolve())
    if as_json:
        print_json(found.as_dict(), Outcome.GOOD)
        return
    print_comparison(found)
    if page is not None:
        sys.stdout.write(f"page: {page}\n")


def check_over(over_s: float) -> None:
    """InputError for a threshold that is none."""
    if not (math.isfinite(over_s) and over_s >= 0.0):
        raise InputError("command line", "--over", over_s, "a number of seconds, 0 or more")


def print_comparison(found: Comparisons) -> None:
    """The comparison for a person: of two runs all of it, of more the figures of all and a line of each."""
    from rich.console import Console

    # A file or a pipe has no width; a terminal's own is kept, and long cells fold there.
    console = Console(width=None if sys.stdout.isatty() else WIDTH_IN_FILE)
    if len(found.pairs) == 1:
        _print_pair(console, found)
        _print_figures(console, found)
        return
    _print_figures(console, found)
    console.print()
    _print_lines(console, found)


def _print_figures(console: Console, found: Comparisons) -> None:
    """The figures that differ, a column a run."""
    from study.compare.grids import measures_grid

    grid = measures_grid(found, changed_only=True)
    same = len(found.measures) - len(grid.rows)
    if grid.rows:
        print_grid(console, "Figures", grid, most=len(grid.rows))
    console.print(f"{same} of {len(found.measures)} figures are the same.")


def _print_lines(console: Console, found: Comparisons) -> None:
    """Of each run against the first the sentence that comes first."""
    from study.compare.comparison import verdict_of

    base = found.sides[0]
    for index, pair in enumerate(found.pairs):
        new = found.sides[index + 1]
        text = f"[bold]{_plain(new.label)} against {_plain(base.label)}[/bold]: {_plain(verdict_of(pair)[0])}"
        console.print(text)
    console.print("--out or --json has all of each; so has compare of two runs.")


def _print_pair(console: Console, found: Comparisons) -> None:
    """What changed from one run to the other: sentences, then tables."""
    from study.compare.comparison import verdict_of
    from study.compare.grids import inputs_grid, meets_grid, moved_grid, once_grid, rows_grid
    from study.compare.measures import TABLES

    (base, new), (pair,) = found.sides, found.pairs
    console.print(f"[bold]{_plain(new.label)} against {_plain(base.label)}[/bold]")
    for text in verdict_of(pair):
        console.print(_plain(text))
    console.print()
    if pair.nothing_differs:
        return
    print_grid(console, "Inputs that differ", inputs_grid(pair))
    print_grid(console, "Times that moved", moved_grid(pair, new, largest_first=True))
    print_grid(console, "Came in one run only", once_grid(pair, new))
    print_grid(console, "Meets that moved", meets_grid(pair, base, new))
    for table in TABLES:
        if table != "stops":  # the figures below say enough of them here
            print_grid(console, table.capitalize(), rows_grid(pair, table, new))


def print_grid(console: Console, title: str, grid: TextTable, most: int = SHOWN) -> None:
    """A table, cut; nothing where it is empty."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from study.compare.grids import cut

    if not grid.rows:
        return
    shown, left_out = cut(grid, most)
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD)
    for number, name in enumerate(grid.header):
        to_the_right = grid.numbers_from <= number < grid.numbers_to
        table.add_column(_plain(name), justify="right" if to_the_right else "left", overflow="fold")
    for row in shown.rows:
        table.add_row(*(_plain(cell) for cell in row))
    console.print(table)
    if left_out:
        console.print(f"and {left_out:,} more; --out or --json has all\n")


def _plain(text: str) -> str:
    """A text that rich takes as it is, whatever brackets it has."""
    from rich.markup import escape

    return escape(text)
