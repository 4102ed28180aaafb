"""A column of margins, a field of its row's type and its value: report, comparison and its files have it."""

from dataclasses import dataclass
from typing import Annotated

import polars as pl
import pytest

from study.compare.comparison import compare_two
from study.compare.grids import columns_of, rows_grid
from study.measures.summary import summarise
from study.record.figure import Figure, Kind, ShownIn, rows_in
from study.record.margins import HopMargin
from study.record.tables import ROWS
from study.report import papers
from study.report.data import ReportedRun
from study.wording.phrase import Phrase
from tests.study.compare.sides import side, with_tables

SEEN = ShownIn.REPORT | ShownIn.ROWS_COMPARED | ShownIn.ROWS_LISTED


@dataclass(frozen=True, slots=True)
class WhistledMargin(HopMargin):
    """A margin, and for how long the train whistled on its hop."""

    whistle_s: Annotated[
        float | None, Figure(Phrase("whistling", "汽笛"), "s", 1, seen=SEEN, kind=Kind.SIGNED)
    ] = None


def test_a_column_is_a_field_and_its_value(weekday: ReportedRun, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ROWS, "margins", WhistledMargin)
    monkeypatch.setattr(papers, "HopMargin", WhistledMargin)

    def run(whistle_s: float) -> ReportedRun:
        whistled = weekday.tables.margins.with_columns(whistle_s=pl.lit(whistle_s))
        return with_tables(weekday, margins=whistled)

    old, new = run(2.0), run(3.5)
    assert rows_in(WhistledMargin, new.tables.margins)[0].whistle_s == 3.5
    tables = papers.tables_shown(new, summarise(new.tables, new.timetable), {}, None)
    column = next(table for table in tables if table.id == "legs").columns[-1].as_dict()
    assert (column["heading"], column["digits"]) == (["whistling, s", "汽笛 秒"], 1)
    assert set(column["values"]) == {3.5}
    base, late = side(old), side(new, "new")
    grid = rows_grid(compare_two(base, late, 1.0), "margins", late, "ja")
    assert grid.header[-3:] == ("汽笛 秒：旧", "新", "差")
    assert grid.rows[0][-3:] == ("2.0", "3.5", "+1.5")
    assert columns_of("margins")[-2:] == ("whistle_s_old", "whistle_s_new")
