"""The directory of a comparison: a page that opens offline, JSON, tables and pictures, all of it or nothing."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl

from study.compare.comparison import Comparisons
from study.compare.graph import draw_both
from study.compare.grids import columns_of, measures_grid
from study.compare.measures import TABLES, columns_in
from study.compare.parts import parts_against
from study.compare.times import MovedTime, UnmatchedTime
from study.record.directory import COMPARE_FILE, replacing_folder
from study.record.parts import PagePart
from study.report.face import FACE, japanese_face
from study.report.style import drawing
from study.report.template import rendered

PAGE_FILE: Final = "compare.html"
GRAPH: Final = "train_graph_"  # and the number of the run
_PICTURES: Final = (".svg", ".png")
_PNG_DPI: Final = 130
_TIMES: Final = tuple(field.name for field in fields(MovedTime))
_MEETS: Final = ("down_train", "up_train", "fate", "old_at", "old_s", "new_at", "new_s", "by_s", "why")
_ONCE: Final = tuple(field.name for field in fields(UnmatchedTime))
_CSVS: Final = ("measures", "inputs", "times", "once", "meets", *TABLES)


def owns_file(name: str) -> bool:
    """Whether a file of that name may stand in the directory of a comparison."""
    number, dot, ending = name.removeprefix(GRAPH).partition(".")
    picture = name.startswith(GRAPH) and number.isdecimal() and f"{dot}{ending}" in _PICTURES
    return picture or name in (PAGE_FILE, COMPARE_FILE, *(f"{table}.csv" for table in _CSVS))


def write_comparison(found: Comparisons, out: Path) -> Path:
    """Write the directory; a comparison that is there is replaced. Returns the path of the page.

    Raises InputError for a directory that holds anything else or cannot be written.
    """
    with replacing_folder(out, owns_file, "a comparison") as folder:
        folder.mkdir()
        (folder / COMPARE_FILE).write_text(json_text(found), "utf-8")
        _write_tables(found, folder)
        with drawing(), mpl.rc_context({"svg.hashsalt": GRAPH}):
            for index, pair in enumerate(found.pairs):
                figure = draw_both(found.sides[0], found.sides[index + 1], pair)
                for ending in _PICTURES:
                    metadata = {"Date": None} if ending == ".svg" else {}
                    path = folder / f"{GRAPH}{index + 1}{ending}"
                    figure.savefig(path, dpi=_PNG_DPI, metadata=metadata)
            (folder / PAGE_FILE).write_text(_page(found), "utf-8")
    return out / PAGE_FILE


def json_text(found: Comparisons) -> str:
    """The whole comparison as JSON."""
    return json.dumps(found.as_dict(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _page(found: Comparisons) -> str:
    """The page; with more than two runs the figures of all come first."""
    base, others = found.sides[0], found.sides[1:]
    parts: list[PagePart] = []
    if len(others) > 1:
        parts.append(
            PagePart(
                "All runs", f"Differences are from {base.label}.", grids=(measures_grid(found),), folded=""
            )
        )
    for index, side in enumerate(others):
        for part in parts_against(found, index):
            title = (
                part.title if len(others) == 1 else f"{side.label}: {part.title[0].lower()}{part.title[1:]}"
            )
            parts.append(PagePart(title, part.caption, part.figures, part.grids, part.folded, part.notes))
    page = rendered(
        "compare.html.j2",
        title=base.run.line.name,
        subtitle=" · ".join(f"{side.label}: {side.name}" for side in found.sides),
        parts=parts,
    )
    return page.replace(FACE, japanese_face(page), 1)


def _write_tables(found: Comparisons, folder: Path) -> None:
    """CSV files of all runs; `run` says which one a row is about."""
    labels = [side.label for side in found.sides]
    measures = ((m.group, m.name, m.unit, *m.values) for m in found.measures)
    _write(folder / "measures.csv", ("group", "measure", "unit", *labels), measures)
    inputs = (
        (pair.new, c.file, c.key, _json(c.old), _json(c.new), " ".join(c.by))
        for pair in found.pairs
        for c in pair.inputs
    )
    _write(folder / "inputs.csv", ("run", "file", "key", "old", "new", "set_by"), inputs)
    for name, columns, rows in (
        ("times", _TIMES, [(pair.new, row.as_dict()) for pair in found.pairs for row in pair.times.moved]),
        ("once", _ONCE, [(pair.new, row.as_dict()) for pair in found.pairs for row in pair.times.once]),
        ("meets", _MEETS, [(pair.new, row.as_dict()) for pair in found.pairs for row in pair.meets]),
    ):
        texts = ((label, *(row[column] for column in columns)) for label, row in rows)
        _write(folder / f"{name}.csv", ("run", *columns), texts)
    for table in TABLES:
        values = (
            (pair.new, *row.names, *(value for column in columns_in(table) for value in row.values[column]))
            for pair in found.pairs
            for row in pair.rows[table]
        )
        _write(folder / f"{table}.csv", ("run", *columns_of(table)), values)


def _write(path: Path, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(header)
        writer.writerows(rows)


def _json(value: object) -> str:
    return "" if value is None else json.dumps(value, ensure_ascii=False)
