"""A proof withdrawn while a train runs up to the points, at any time: it stops before them, or could not any more."""

from pathlib import Path

import pytest

from onboard.notes import ProofDropped
from simulation.judge.checkers import Checker
from simulation.judge.locking import RouteLocking
from simulation.judge.points import ProvenPoints
from tests.nightly import others_nightly
from tests.system.switchboard import RunWith


@pytest.fixture
def excused(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Whether points were entered by a proof that was lost too late, each time that they were without one."""
    seen: list[bool] = []
    enters = RouteLocking.enters

    def watched(self: RouteLocking, *entry: object) -> str | ProvenPoints:
        found = enters(self, *entry)  # type: ignore[arg-type]
        seen.append(isinstance(found, ProvenPoints))
        return found

    monkeypatch.setattr(RouteLocking, "enters", watched)
    return seen


def script(tmp_path: Path, after_s: float, delay_s: float) -> str:
    """Detection of P7 fails so long after T1 has passed the last tag before it, telegrams to it taking longer."""
    file = tmp_path / "lost.toml"
    file.write_text(
        'extends = "rtri_test_line"\nid = "lost"\ntimetable = "rtri_two_trains"\n'
        '[[fault]]\nkind = "no_detection"\ntarget = "P7"\nstart = "train T1 passes tag 603"\n'
        f'after_s = {after_s}\nduration_s = 20.0\n[[fault]]\nkind = "delay"\ntarget = "* -> K1"\n'
        f'seconds = {delay_s}\nstart = "09:59:00"\nduration_s = 200.0\n'
    )
    return str(file)


# What it takes from the tag to P7, and the train is guaranteed to stop in 30 m from the 7 m/s at which it comes.
@pytest.mark.parametrize("delay_s", others_nightly([0.0, 4.0], [0.0]))
@pytest.mark.parametrize(("after_s", "too_late"), [(8.0, False), (20.0, True), (20.5, True), (21.5, True)])
def test_it_stops_before_the_points_or_could_not_any_more(
    after_s: float,
    too_late: bool,
    delay_s: float,
    tmp_path: Path,
    run_with: RunWith,
    excused: list[bool],
) -> None:
    done, objections = run_with(script(tmp_path, after_s - delay_s, delay_s))
    assert any(isinstance(entry.event, ProofDropped) for entry in done.result.journal.entries)
    assert objections == set()
    assert excused == ([True] * len(excused) if too_late else [])
    assert bool(excused) is too_late


@pytest.mark.parametrize("after_s", [8.0, 20.5])
def test_a_unit_that_does_not_brake_for_it_is_found(
    after_s: float, tmp_path: Path, run_with: RunWith
) -> None:
    _, objections = run_with(script(tmp_path, after_s, 0.0), "does_not_wait_for_proof")
    assert Checker.PROVEN_BEFORE_ENTRY.value in objections
