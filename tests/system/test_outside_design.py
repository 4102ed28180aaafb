"""A run on less adhesion than the design counts on: what follows is told and fails nothing."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from simulation.judge.checkers import Checker

# The train has to stop before points that are not proven, with the wheels sliding all the way.
SCRIPT = """
extends = "rtri_test_line"
id = "slides"
name = "slides"

[patch.line]
set = { "points.P7.initial" = "reverse" }

[[fault]]
kind = "no_detection"
target = "P7"
start = "09:59:00"
duration_s = 420.0

[[fault]]
kind = "slippery"
target = "K1"
factor = FACTOR
start = "train T1 passes tag 602"
after_s = 10.0
duration_s = 60.0
"""


def slides(main: Callable[..., Any], folder: Path, factor: float) -> tuple[Any, dict[str, Any]]:
    (folder / "slides.toml").write_text(SCRIPT.replace("FACTOR", str(factor)), "utf-8")
    ended = main("run", "slides.toml", "--out", "out")
    return ended, json.loads((folder / "out" / "summary.json").read_text("utf-8"))


def test_an_overrun_without_grip_is_told_and_no_broken_rule(main: Callable[..., Any], tmp_path: Path) -> None:
    ended, summary = slides(main, tmp_path, 0.05)
    had, *followed = summary["outside_design"]
    told = r"K1 had less adhesion than the design counts on once from 10:00:(\d\d) to 10:01:(\d\d), at least 0.05"
    times = re.match(told, had)
    assert times is not None
    assert times[1] == times[2]  # a minute
    assert any(f"{Checker.PROVEN_BEFORE_ENTRY}: K1 came onto P7.stem" in text for text in followed)
    assert not any(
        Checker.PROVEN_BEFORE_ENTRY in text for text in (*summary["violations"], *summary["broken"])
    )
    for text in summary["outside_design"]:
        assert f"outside the design: {text}" in ended.err
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert "Outside the design: K1 had less adhesion" in page


def test_on_the_design_adhesion_nothing_is_told(main: Callable[..., Any], tmp_path: Path) -> None:
    ended, summary = slides(main, tmp_path, 0.8)
    assert (ended.code, summary["outside_design"], summary["violations"]) == (0, [], [])
