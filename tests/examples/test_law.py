"""The recipe "a driving law" of docs/make-a.md, followed: one file, one row, a scenario that chooses it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from onboard.driving.laws.hold_speed import HOLD_BAND_MPS

HERE = Path(__file__).parent / "law"
LINE_SPEED_MPS = 45.0 / 3.6


def fastest_mps(out: Path) -> float:
    return float(pl.read_parquet(out / "trajectory.parquet")["speed_mps"].max())  # type: ignore[arg-type]


@pytest.mark.system
def test_a_law_that_holds_half_the_limit(clone: Callable[[], Any]) -> None:
    made = clone()
    made.follow("driving law")
    assert made.is_what_is_told("driving law")
    made.holds("tests/documents/test_files.py")
    figures = made.run(HERE / "slow_day.toml")
    assert figures["trains_arrived"] == 1
    assert figures["invariants_broken"] == 0
    assert 0.3 * LINE_SPEED_MPS < fastest_mps(made.root / "out") <= LINE_SPEED_MPS / 2.0 + HOLD_BAND_MPS


def test_without_its_row_no_scenario_can_choose_it(main: Callable[..., Any]) -> None:
    ended = main("run", str(HERE / "slow_day.toml"))
    assert ended.code == 2
    assert "half_limit" in ended.err
