"""What commands cost beside the day: the figures of the rounds, and a child that tells the day from the rest."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from study.evaluate import start_bench
from study.evaluate.start_bench import CPU_S_MAX, RUN, bench, report


def test_medians_and_budgets() -> None:
    found = report({RUN: [9.0, 3.5, 4.0], "check": [1.6, 1.4, 1.6]})
    assert [(row["command"], row["cpu_s"], row["cpu_s_min"], row["cpu_s_max"]) for row in found["rows"]] == [
        (RUN, 4.0, 3.5, 9.0),
        ("check", 1.6, 1.4, 1.6),
    ]
    assert [budget["kept"] for budget in found["budgets"]] == [True, False]


@pytest.mark.nightly
def test_the_day_is_taken_off_the_run(turn_back: str, tmp_path: Path) -> None:
    """The child's own figure is positive, and less than what the whole process took."""
    command = [sys.executable, "-m", "study.evaluate.start_bench", "run", turn_back, "--out", "run"]
    before = os.times()
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    after = os.times()
    whole_s = after.children_user - before.children_user + after.children_system - before.children_system
    assert 0.0 < float(done.stderr.splitlines()[-1]) < whole_s
    assert (tmp_path / "run" / "report.html").exists()


def test_every_command_is_measured_and_the_first_round_is_not_counted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[str] = []

    def cpu_s(arguments: tuple[str, ...], folder: Path) -> float:
        asked.append(arguments[0])
        (folder / "run").mkdir(exist_ok=True)
        (folder / "run" / "summary.json").write_text('{"digest": "a"}')
        return 100.0 if len(asked) <= len(CPU_S_MAX) else 1.0

    monkeypatch.setattr(start_bench, "_cpu_s", cpu_s)
    told: list[str] = []
    found = bench("rtri_test_line", 2, told.append)
    assert asked == ["run", "check", "--help", "running-times", "plot"] * 3 and len(told) == 15
    assert {row["cpu_s_max"] for row in found["rows"]} == {1.0} and found["same_digest"]
