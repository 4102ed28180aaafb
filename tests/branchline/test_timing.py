"""`branchline running-times`: what it prints and what it writes."""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rich.cells import cell_len


def test_legs_and_margins_are_the_same_in_json_and_csv(main: Callable[..., Any], tmp_path: Path) -> None:
    ended = main("running-times", "karasuyama_weekday", "--json", "--out", "out")
    assert ended.code == 0, ended.err
    figures = ended.figures()
    for name, rows in (("running_times", figures["legs"]), ("margins", figures["margins"])):
        with (tmp_path / f"out/{name}.csv").open(encoding="utf-8") as file:
            written = list(csv.DictReader(file))
        assert len(written) == len(rows) > 10
        assert [row["from"] for row in written] == [row["from"] for row in rows]
    tightest = min(figures["margins"], key=lambda row: row["margin_s"])
    assert (tightest["number"], tightest["from"], tightest["to"]) == ("343M", "SHN", "NIT")
    assert tightest["planned_s"] == 120.0
    assert (tmp_path / "out/running_times.png").read_bytes()[:4] == b"\x89PNG"
    told = main("running-times", "karasuyama_weekday")
    assert "Shimotsuke-Hanaoka - Niita" in told.out
    assert "343M" in told.out


TWO = "name,name_ja,km,tracks\n旭,旭,0.0,1\nO'Brien,緑,1.5,1\n東京スカイツリー前,東,3.1,1\n"


def test_columns_stand_below_each_other_and_an_interval_that_is_too_short_is_no_least(
    main: Callable[..., Any], tmp_path: Path
) -> None:
    """Japanese characters are two columns wide. There and back over 3 km at 85 km/h takes five minutes."""
    (tmp_path / "two.csv").write_text(TWO, "utf-8")
    assert main("new", "line", "two.csv", "two.toml", "--scenario", "day.toml").code == 0
    for asked in (("running-times",), ("capacity", "--theory", "--cut", "interval", "--equipment")):
        block = (out := main(*asked, "day.toml").out).split("\n\n")[0].splitlines()[2:]
        columns = {cell_len(row[: row.index(".")]) for row in block}
        assert (len(block) > 1, len(columns), "nan" in out) == (True, 1, False)
    every = ("new", "timetable", "t.toml", "--line", "two.toml", "--every")
    assert "expected a longer interval; 35 minutes are enough for one set" in main(*every, "10").err
    assert main(*every, "20").code == 0


@pytest.mark.parametrize(
    ("asked", "option"),
    [
        (("running-times", "karasuyama_weekday"), "--out"),
        (("headway", "karasuyama_weekday", "--theory"), "--out"),
        (("capacity", "karasuyama_weekday", "--theory"), "--out"),
        (("blocking", "karasuyama_weekday", "--theory"), "--out"),
        (("best", "interval", "karasuyama_weekday"), "--proof"),
        (("best", "roster", "karasuyama_weekday"), "--proof"),
        (("best", "equipment", "karasuyama_weekday"), "--proof"),
        (("verify", "explore", "0/0/0/0"), "--out"),
        (("verify", "explore", "0/0/0/0"), "--chart"),
        (("verify", "promela"), "--out"),
        (("import", "mini-tokyo", "source.json"), ""),
    ],
)
def test_a_place_that_cannot_be_written_is_told_before_anything_is_computed(
    main: Callable[..., Any], tmp_path: Path, asked: tuple[str, ...], option: str
) -> None:
    """Below a file there is no folder; whatever is computed says so on stderr, or is what reads the source."""
    (tmp_path / "file").write_text("", "utf-8")
    ended = main(*asked, *filter(None, (option, "file/out.csv")))
    assert (ended.code, ended.err.count("\n")) == (2, 1), ended
    assert f"{option or 'OUT'} is 'file/out.csv'" in ended.err
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
