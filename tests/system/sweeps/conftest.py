"""A sweep that must find nothing bad."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import pytest

from scenario.scenario import Scenario
from study.drilling.every_instant import InstantWindow, Variation, sweep
from study.drilling.grid_report import classes_of, figures_of, owns_file, text_of, write_sweep
from study.record.directory import replacing_folder

JOBS: Final = 1  # the other worker has the other line

Sweeps = Callable[[Scenario, Sequence[Variation], InstantWindow], list[str]]


@pytest.fixture
def bad_in(tmp_path: Path) -> Sweeps:
    """Sweep, and tell what is bad, each with the drill that shows it."""

    def run(scenario: Scenario, variations: Sequence[Variation], window: InstantWindow) -> list[str]:
        swept = sweep(scenario.setup, variations, window, JOBS)
        out = tmp_path / "sweep"
        with replacing_folder(out, owns_file, "a sweep") as folder:
            write_sweep(scenario, swept, variations, figures_of(scenario, swept, ()), folder)
        return [f"{text_of(found)}; {out / found.replay}" for found in classes_of(swept) if found.bad]

    return run
