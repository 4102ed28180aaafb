"""`branchline running-times`: what it prints, what it writes, and that it writes all or nothing."""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any


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


def test_a_directory_of_somebody_else_is_left_alone(main: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out/thesis.txt").write_text("mine", "utf-8")
    ended = main("running-times", "rtri_test_line", "--out", "out")
    assert ended.code == 2
    assert "thesis.txt" in ended.err
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["thesis.txt"]
