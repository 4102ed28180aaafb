"""A what-if through the command: what it changed stands in its summary and in its report."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.study.report.page import payload_of, table_in

WHAT_IF = """
extends = "rtri_test_line"
id = "heavy"
name = "A heavy train over slow points"

[patch.line.times]
"points.P7.throw_time_s" = 2.0

[patch.train.ev_e301.times]
mass_empty_t = 1.2

[patch.timetable.set]
"trains.T1.calls.B.arrival" = "10:02:30"

[patch.air.times]
delay_mean_s = 2.0
"""


def test_the_run_says_what_was_changed(main: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "heavy.toml").write_text(WHAT_IF, "utf-8")
    ended = main("run", "heavy.toml", "--json", "--out", "out")
    assert ended.code == 0, ended.err
    told = {
        change["key"]: (change["file"], change["old"], change["new"]) for change in ended.figures()["changes"]
    }
    assert told == {
        "points.P7.throw_time_s": ("rtri_test_line.toml", 6.0, 12.0),
        "body.mass_empty_t": ("ev_e301.toml", 77.9, pytest.approx(77.9 * 1.2)),
        "trains.T1.calls.B.arrival": ("rtri_test_line.toml", "10:02:00", "10:02:30"),
        "air.delay_mean_s": ("rtri_test_line.toml", 0.1, 0.2),
    }
    assert (
        json.loads((tmp_path / "out/summary.json").read_text("utf-8"))["changes"]
        == ended.figures()["changes"]
    )
    page = (tmp_path / "out/report.html").read_text("utf-8")
    assert set(table_in(payload_of(page), "changes")["key"]) == set(told)
