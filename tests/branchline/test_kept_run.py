"""A run directory that an earlier version wrote (`kept_run`) opens in every command, also after a column is added."""

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Final

import polars as pl
import pytest

from study.record.directory import FORMAT, digests_of_tables
from study.record.figure import Figure
from study.record.tables import ROWS
from study.wording.phrase import Phrase
from tests.nightly import others_nightly

KEPT: Final = Path(__file__).parents[1] / "study" / "record" / "kept_run"
COMMANDS: Final = (
    ("plot", "RUN", "train-graph", "--out", "graph.svg"),
    ("plot", "RUN", "energy-parts", "--out", "parts.csv"),
    ("compare", "RUN", "RUN", "--out", "compared"),
    ("export", "oudia", "RUN", "day.oud2"),
    ("capacity", "RUN", "--json"),
    ("blocking", "RUN", "--json"),
)


def with_a_column(monkeypatch: pytest.MonkeyPatch, table: str, **default: None) -> None:
    """The table has one more column from now on; without a default no directory may lack it."""
    later = Annotated[float | None, Figure(Phrase("whistling", "汽笛"), "s", 1)]
    row = type("Later", (ROWS[table],), {"__annotations__": {"whistle_s": later}, **default})
    monkeypatch.setitem(ROWS, table, dataclass(frozen=True, kw_only=True)(row))


@pytest.mark.parametrize(
    ("command", "added"),
    others_nightly(
        product(COMMANDS, [False, True]), {(c, n % 2 > 0) for n, c in enumerate(COMMANDS)}, columns=True
    ),
)
def test_a_directory_kept_opens(
    main: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...], added: bool
) -> None:
    for table in ROWS if added else ():
        with_a_column(monkeypatch, table, whistle_s=None)
    ended = main(*(str(KEPT) if part == "RUN" else part for part in command))
    assert ended.code == 0, ended.err


def test_what_a_directory_lacks_is_missed_by_the_command_that_needs_it(
    main: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A column without a default is such a lack: who asks for the table says so, others do not mind."""
    with_a_column(monkeypatch, "driving")
    assert main("plot", str(KEPT), "train-graph", "--out", "graph.svg").code == 0
    ended = main("compare", str(KEPT), str(KEPT))
    assert ended.code == 2 and len(ended.err.splitlines()) == 1
    assert "driving.parquet" in ended.err and "whistle_s" in ended.err and "earlier version" in ended.err


def test_a_directory_of_a_later_format_is_refused_by_its_number_and_one_without_opens(
    main: Callable[..., Any], tmp_path: Path
) -> None:
    copy = shutil.copytree(KEPT, tmp_path / "copy")
    summary = json.loads((copy / "summary.json").read_text("utf-8"))
    assert summary["format"] == FORMAT
    before_it_was_counted = {key: value for key, value in summary.items() if key != "format"}
    for written, code in (({"format": FORMAT + 1}, 2), ({"format": FORMAT}, 0), ({}, 0)):
        (copy / "summary.json").write_text(json.dumps(before_it_was_counted | written), "utf-8")
        ended = main("plot", str(copy), "waits", "--out", "waits.csv")
        assert ended.code == code
        assert ("format is 2; expected at most 1" in ended.err) is (code == 2)


def test_a_run_in_which_no_train_came_anywhere(main: Callable[..., Any], tmp_path: Path) -> None:
    copy = shutil.copytree(KEPT, tmp_path / "copy")
    stops = pl.read_parquet(copy / "stops.parquet")
    nowhere = stops.with_columns(arrival_s=pl.lit(None, pl.Float64), departure_s=pl.lit(None, pl.Float64))
    nowhere.write_parquet(copy / "stops.parquet")
    shown = json.loads((copy / "shown.json").read_text("utf-8"))
    shown["tables"] = digests_of_tables(copy)
    (copy / "shown.json").write_text(json.dumps(shown), "utf-8")
    ended = main("export", "gtfs", str(copy), "day.zip")
    assert ended.code == 2 and "SOURCE" in ended.err and "in which a train ran" in ended.err
