"""`branchline running-times`: what it prints and what it writes."""

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
