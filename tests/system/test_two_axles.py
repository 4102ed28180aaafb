"""A tachometer that errs is compared with another axle: the front stays inside its bounds from the first metre on."""

from pathlib import Path
from typing import Final

import pytest

from onboard.notes import TachometerFault, TagRead
from papers import position_run
from papers.fusion_runs import base_setup
from papers.position_run import Moment, PositionRun
from simulation.judge.checkers import Checker
from simulation.world.premises import FalsePositions
from simulation.world.trains import Trains
from study.runner.run import CarrierKind
from tests.system.switchboard import RunWith

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


@pytest.mark.parametrize("before_m", [3.0, 8.0])
def test_a_tag_read_as_the_output_has_just_gone_has_the_front_inside(
    before_m: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At 14 m/s it has run up to 1.4 m since, of which nothing was counted: by the count alone it is 0.4 m outside."""
    monkeypatch.setattr(position_run, "HOURS_MAX", 0.1)  # it stands then, and waits for people
    setup = base_setup("karasuyama_weekday")
    tag = PositionRun(setup).mission.tags[0]

    def goes_silent(trains: Trains, slot: int) -> None:
        trains.tachometers[slot].gain = 0.0

    run = PositionRun(setup, [Moment(tag.position_m - before_m, goes_silent)])
    result = run.run()
    assert any(isinstance(note, TagRead) and note.tag_id == tag.tag_id for _, _, note in result.notes)
    assert result.out_m <= 0.0


def test_without_another_axle_bounds_break(tmp_path: Path, run_with: RunWith) -> None:
    file = tmp_path / "axles.toml"
    file.write_text(SHOWS_A_FIFTH)
    _, objections = run_with(str(file), "compares_no_axles", carrier=CarrierKind.PLAIN)
    assert Checker.WITHIN_BOUNDS in objections
