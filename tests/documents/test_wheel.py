"""The wheel: it brings compiled code for any processor, which serves wherever it is installed."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from documents.machine_code import days
from documents.wheel import build_wheel
from onboard.driving.laws.table import LAW_NAMES
from simulation.settings import PositionSensor
from vehicle.compiled import SHIPPED

WEEKDAY = "karasuyama_weekday"
WHEEL_MAX_B = 20_000_000


def test_every_law_and_what_shipped_trains_carry_is_compiled_for_it() -> None:
    setups = [day.setup for day in days(())]
    assert {law for setup in setups for law in setup.laws.values()} == set(LAW_NAMES)
    carried = {
        sensor for setup in setups for stock in setup.trains for sensor in setup.sensors.carried_by(stock)
    }
    assert set(PositionSensor) - carried == {PositionSensor.BEACONS}, "of papers alone"


def _branchline(venv: Path, folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """The command as it is installed there; what it compiles is kept in `folder`."""
    own = {name: value for name, value in os.environ.items() if name not in {"PYTHONPATH", "NUMBA_CPU_NAME"}}
    command = [venv / "bin/branchline", *arguments]
    return subprocess.run(
        command,
        cwd=folder,
        env=own | {"NUMBA_CACHE_DIR": str(folder / "kept")},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.nightly
def test_it_runs_the_weekday_in_a_bare_environment_without_compiling(tmp_path: Path) -> None:
    wheel = build_wheel(tmp_path, [WEEKDAY])
    assert wheel.stat().st_size < WHEEL_MAX_B
    venv, folder = tmp_path / "venv", tmp_path / "elsewhere"
    folder.mkdir()
    subprocess.run([sys.executable, "-m", "venv", venv], check=True)
    subprocess.run([venv / "bin/pip", "install", "--quiet", wheel], check=True)
    for command in (("check", WEEKDAY), ("run", WEEKDAY, "--json")):
        done = _branchline(venv, folder, *command)
        assert done.returncode == 0, done.stderr
        assert "compiling" not in done.stderr
    assert not (folder / "kept" / SHIPPED.name).exists()
    summary = json.loads(done.stdout)
    here = json.loads(_branchline(Path(sys.prefix), folder, "run", WEEKDAY, "--out", "here", "--json").stdout)
    assert [summary[of] for of in ("digest", "motion_digest")] == [
        here[of] for of in ("digest", "motion_digest")
    ]
