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


TWO = "name,name_ja,km,tracks\n旭,旭,0.0,1\nO'Brien,緑,3.1,1\n東京スカイツリー前,東,9.4,1\n"


@pytest.mark.parametrize("asked", [("running-times",), ("capacity", "--theory", "--cut", "interval")])
def test_columns_stand_below_each_other_whatever_names_are_written_in(
    main: Callable[..., Any], tmp_path: Path, asked: tuple[str, ...]
) -> None:
    """Japanese characters are two columns wide on a terminal."""
    (tmp_path / "two.csv").write_text(TWO, "utf-8")
    assert main("new", "line", "two.csv", "two.toml", "--scenario", "day.toml").code == 0
    told = main(asked[0], "day.toml", *asked[1:])
    block = told.out.split("\n\n")[0].splitlines()[2:]
    assert len(block) > 1 and len({cell_len(row[: row.index(".")]) for row in block}) == 1


def test_an_interval_that_is_too_short_is_not_called_the_least_that_works(
    main: Callable[..., Any], tmp_path: Path
) -> None:
    """There and back over 3 km at 85 km/h takes five minutes: 15 min work, and 20 are enough in any case."""
    (tmp_path / "two.csv").write_text("name,km,tracks\nA,0.0,1\nB,3.1,1\n", "utf-8")
    main("new", "line", "two.csv", "two.toml")
    asked = ("new", "timetable", "t.toml", "--line", "two.toml", "--every")
    assert main(*asked, "10").err.endswith("expected a longer interval; 30 minutes are enough for one set\n")
    assert main(*asked, "15").code == 0
