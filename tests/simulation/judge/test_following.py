"""How checkers follow a train: over joints, astride them, turning back, and at the edge of the net."""

import ast
from pathlib import Path

import pytest

import simulation.judge.checkers
from network.model import Position
from simulation.events import PointsMoving, ProofDropped, Reported
from tests.simulation.judge.stage import TRAIN_M, Stage, authorised, in_track, on_points


def test_a_lasting_breach_is_one_violation_with_its_first_time() -> None:
    stage = Stage()
    for _ in range(3):
        stage.t_s += 1.0
        stage.bounds(1010.0, 5.0, 2.0)
    (violation,) = stage.checkers.violations
    assert violation.t_s == 1.0
    assert "+10.000 m" in violation.text
    assert stage.checkers.counts == {"within-bounds": 3}


def test_change_ends_astride_a_joint() -> None:
    """20 m in T1 and 20 m on the leg: the new front is 20 m into the leg, seen from T1."""
    stage = on_points()
    stage.see("A", ("T1+", 20.0), speed_mps=0.0)
    stage.turn("A")
    stage.see("A", ("T1+", 20.0), speed_mps=0.0)  # SUMO turns the train in its next step
    stage.see("A", ("normal1-", 20.0), speed_mps=0.0)
    stage.world(PointsMoving(points_id="1", target=Position.REVERSE))
    assert stage.broken() == {"no-throw-under-train"}


def test_after_a_change_of_ends_the_other_end_clears() -> None:
    """From T1 back to W: T1 is clear when 30 + 10 m of points and then nothing of 40 m is left of it."""
    stage = in_track()
    stage.turn("A")
    stage.prove("A", "1", "normal")
    stage.see("A", ("T1-", 250.0), ("normal1-", 5.0), ("stem1-", 5.0), ("W-", 0.5))
    stage.holds("A", "W", "P1")
    assert stage.broken() == set()
    stage.entry("A", Reported(section_ids=("W",), token=1))
    assert stage.broken() == {"release-behind-rear"}


def test_an_unseen_short_edge_is_still_entered() -> None:
    stage = authorised()
    stage.entry("A", ProofDropped(points_id="1"))
    stage.see("A", ("normal1+", 5.0))
    assert stage.broken() == {"proven-before-entry"}


def test_rear_outside_the_net_and_touching_a_joint() -> None:
    """A train longer than what it has run is only where the net is; a front on the joint is not beyond it."""
    stage = Stage()
    stage.put("A", "W+", front_m=20.0, length_m=100.0)
    stage.see("A", ("W+", 300.0), ("stem1+", 0.0))
    assert stage.broken() == set()
    stage.see("A", ("stem1+", 0.1))
    assert stage.broken() == {"inside-holding", "proven-before-entry"}


def test_a_train_enters_on_edges_of_the_net() -> None:
    stage = Stage()
    with pytest.raises(ValueError, match="no edge"):
        stage.checkers.entered("A", TRAIN_M, ())
    with pytest.raises(KeyError):
        stage.checkers.entered("A", TRAIN_M, ("nowhere+",))


def test_checkers_share_nothing_with_what_they_check() -> None:
    allowed = ("network.model", "simulation.judge.checkers", "sumo_cfg.truth_map")
    files = sorted(Path(simulation.judge.checkers.__file__).parent.glob("*.py"))
    assert files
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            ours = [
                n for n in names if n.split(".")[0] in {"network", "onboard", "wayside", "sumo_cfg", "radio"}
            ]
            assert all(name.startswith(allowed) for name in ours), (file.name, names)
