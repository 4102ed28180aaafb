"""A tachometer that errs is compared with another axle: the front stays inside its bounds from the first metre on."""

from collections.abc import Callable
from pathlib import Path
from typing import Final

import pytest

from onboard.notes import TachometerFault
from simulation.judge.checkers import Checker
from simulation.world.premises import FalsePositions
from study.runner.run import CarrierKind, FinishedRun

RunWith = Callable[..., tuple[FinishedRun, set[str]]]

DEPARTS_S: Final = 36_000.0
SHOWS_A_FIFTH: Final = """
extends = "rtri_test_line"
id = "axles"
[[fault]]
kind = "scale"
target = "K1"
factor = 0.2
start = "09:59:00"
"""


@pytest.fixture(autouse=True)
def judged_throughout(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bounds are judged whatever the tachometer does."""
    monkeypatch.setattr(FalsePositions, "is_false", lambda _self, _slot: False)


def test_a_fifth_of_the_speed_is_doubted_in_the_first_seconds_and_the_front_stays_inside(
    tmp_path: Path, run_with: RunWith
) -> None:
    file = tmp_path / "axles.toml"
    file.write_text(SHOWS_A_FIFTH)
    done, objections = run_with(str(file), carrier=CarrierKind.PLAIN)
    doubts_s = [e.t_s for e in done.result.journal.entries if isinstance(e.event, TachometerFault)]
    assert DEPARTS_S < doubts_s[0] < DEPARTS_S + 6.0
    assert Checker.WITHIN_BOUNDS not in objections


def test_without_another_axle_bounds_break(tmp_path: Path, run_with: RunWith) -> None:
    file = tmp_path / "axles.toml"
    file.write_text(SHOWS_A_FIFTH)
    _, objections = run_with(str(file), "compares_no_axles", carrier=CarrierKind.PLAIN)
    assert Checker.WITHIN_BOUNDS in objections
