"""Bounds are judged in a run but while a faulty tachometer has made the position false (decision 004).

No other axle is shown here: with one the position is not false in the first place (decision 072, `test_two_axles`).
"""

from pathlib import Path

import pytest

from onboard.notes import TagRead
from simulation.judge.checkers import Checkers
from simulation.world.premises import FalsePositions
from study.runner.run import FinishedRun
from tests.plain import run_on_plain
from tests.system.switchboard import SWITCHES

DEPARTS_S = 36_000.0
BEGINS_S = 36_005.0
LASTS_S = 20.0


@pytest.fixture(autouse=True)
def one_axle(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is compared with the tachometer."""
    SWITCHES["compares_no_axles"](monkeypatch)


@pytest.fixture
def judged_s(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Times at which bounds were judged."""
    times: list[float] = []
    bounds = Checkers.bounds

    def heard(self: Checkers, t_s: float, unit_id: str, *stated: float) -> None:
        times.append(t_s)
        bounds(self, t_s, unit_id, *stated)

    monkeypatch.setattr(Checkers, "bounds", heard)
    return times


def run(tmp_path: Path, factor: float) -> FinishedRun:
    file = tmp_path / "scale.toml"
    file.write_text(
        'extends = "rtri_test_line"\nid = "scale"\n'
        f'[[fault]]\nkind = "scale"\ntarget = "K1"\nfactor = {factor}\nstart = "10:00:05"\nduration_s = {LASTS_S}\n'
    )
    return run_on_plain(file)


def test_they_rest_from_the_fault_to_the_first_tag_after_it(judged_s: list[float], tmp_path: Path) -> None:
    """Three per cent over the first 300 m is less than 10 m: the unit still believes the tag, and never notices."""
    done = run(tmp_path, 0.97)
    tags_s = [e.t_s for e in done.result.journal.entries if isinstance(e.event, TagRead)]
    healed_s = BEGINS_S + LASTS_S
    told_anew_s = min(t_s for t_s in tags_s if t_s > healed_s)
    assert [t_s for t_s in judged_s if BEGINS_S < t_s <= told_anew_s] == []
    assert min(judged_s) < DEPARTS_S  # it stands, and is judged
    assert max(judged_s) > told_anew_s
    assert done.result.violations == ()


def test_they_do_not_rest_for_a_fault_that_they_promise_to_cover(
    judged_s: list[float], tmp_path: Path
) -> None:
    done = run(tmp_path, 0.99)
    assert sum(BEGINS_S < t_s < BEGINS_S + LASTS_S for t_s in judged_s) > 2
    assert done.result.violations == ()


def test_judged_without_a_rest_the_false_position_is_a_breach(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FalsePositions, "is_false", lambda _self, _slot: False)
    assert {v.checker for v in run(tmp_path, 0.9).result.violations} == {"within-bounds"}
