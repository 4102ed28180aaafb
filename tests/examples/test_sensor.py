"""The recipe "a sensor" of docs/make-a.md, followed: a radar with settings and a fault, and the one rule takes it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import polars as pl
import pytest

HERE = Path(__file__).parent / "sensor"


def made_in(clone: Any) -> Any:  # noqa: ANN401 - of the fixture
    clone.follow("sensor")
    assert clone.is_what_is_told("sensor")
    return clone


def widest_m(out: Path) -> float:
    """The widest interval of the position on the way."""
    rows = pl.read_parquet(out / "trajectory.parquet")
    return float((rows["bound_ahead_m"] + rows["bound_behind_m"]).max())  # type: ignore[arg-type]


def test_with_settings_and_a_fault_it_is_six_files_and_all_that_is_checked_holds(
    clone: Callable[[], Any],
) -> None:
    made = made_in(clone())
    assert len(made.touched) <= 6
    made.holds(
        "tests/documents/test_files.py",
        "tests/documents/test_sensors.py",
        "tests/documents/test_faults.py",
        "tests/scenario/test_key_examples.py",
        "tests/simulation/faults/test_table.py",
    )
    for page, text in (
        ("sensors", "## Radar"),
        ("faults", "`radar_knocked`"),
        ("files/scenario", "`[radar]`"),
    ):
        assert text in (made.root / f"docs/{page}.md").read_text("utf-8")


@pytest.mark.nightly
def test_types_and_everything_generated_hold_too(clone: Callable[[], Any]) -> None:
    made_in(clone()).checked()


@pytest.mark.system
def test_a_speed_sensor_with_a_constant_bias_narrows_the_bounds_and_keeps_the_truth_in_them(
    clone: Callable[[], Any], main: Callable[..., Any]
) -> None:
    """Wheels may be wrong by 2 % of the way, at 12 m/s 0.24 m/s; the radar by 0.06 m/s."""
    made = made_in(clone())
    with_radar = made.run(HERE / "radar_day.toml")
    narrow_m = widest_m(made.root / "out")
    assert with_radar["trains_arrived"] == 1
    assert with_radar["invariants_broken"] == 0  # the true position within the stated bounds, in every step
    without = main("run", "rtri_test_line", "--json", "--out", "without")
    assert without.code == 0
    assert narrow_m < 0.7 * widest_m(made.root / "without")


@pytest.mark.nightly
@pytest.mark.system
def test_one_that_is_worse_than_it_says_is_found_out(clone: Callable[[], Any]) -> None:
    """0.8 m/s wrong where 0.06 is stated: the truth leaves the bounds, and in the end the rule refuses the reading."""
    made = made_in(clone())
    figures = made.run(HERE / "radar_knocked.toml")
    assert figures["invariants_broken"] > 0
    assert '"fix_refused"' in (made.root / "out/journal.jsonl").read_text("utf-8")
