"""The recipe "a sensor" of docs/make-a.md, followed: a radar with a constant bias, taken or refused by the one rule."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import polars as pl
import pytest

HERE = Path(__file__).parent / "sensor"
SHOWS = "simulation/sensors/radar.py"


def made_in(clone: Any) -> Any:  # noqa: ANN401 - of the fixture
    clone.add(HERE / "radar.py", SHOWS)
    clone.write(
        "simulation/sensors/table.py",
        ("from simulation.sensors import tachometer as tacho\n", "from simulation.sensors import radar\n"),
        (
            "    Sensor(sign_camera.sign_camera, sign_camera.SignCameraRow, sign_camera.fit),\n",
            "    Sensor(radar.radar, radar.RadarRow, radar.fit),\n",
        ),
    )
    clone.add(HERE / "radar_run.py", "onboard/localisation/radar_run.py")
    clone.write(
        "onboard/localisation/table.py",
        (
            "from onboard.localisation.fix import NOTHING, TAKEN, told\n",
            "from onboard.localisation.radar_run import RadarReading, RadarRunRow, radar_run\n",
        ),
        ("Reader(sign, SignReading, SignRow),", " Reader(radar_run, RadarReading, RadarRunRow),"),
    )
    return clone


def widest_m(out: Path) -> float:
    """The widest interval of the position on the way."""
    rows = pl.read_parquet(out / "trajectory.parquet")
    return float((rows["bound_ahead_m"] + rows["bound_behind_m"]).max())  # type: ignore[arg-type]


@pytest.mark.system
def test_a_speed_sensor_with_a_constant_bias_narrows_the_bounds_and_keeps_the_truth_in_them(
    clone: Callable[[], Any], main: Callable[..., Any]
) -> None:
    """Wheels may be wrong by 2 % of the way, at 12 m/s 0.24 m/s; the radar by 0.06 m/s."""
    made = made_in(clone())
    assert made.is_what_is_told("sensor")
    with_radar = made.run("rtri_test_line")
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
    file = made.root / SHOWS
    file.write_text(
        file.read_text("utf-8").replace(
            "own.bias_mps = BIAS_MAX_MPS * (2.0 * drawn - 1.0)", "own.bias_mps = 0.8"
        ),
        "utf-8",
    )
    figures = made.run("rtri_test_line")
    assert figures["invariants_broken"] > 0
    assert '"fix_refused"' in (made.root / "out/journal.jsonl").read_text("utf-8")
