"""What follows from less adhesion than the design counts on is told apart; anything else, and collisions, are not.

The stage's trains are guaranteed to stop in 1 s + v / (1 m/s^2), down to 0.8 of the dry rail's adhesion.
"""

import pytest

from network.model import Position
from simulation.events import WORLD, Collision, Danger, PointsMoving, ProofDropped, Unsafe
from simulation.judge.checkers import Checker
from tests.simulation.judge.stage import Stage, authorised, in_track, on_points, second

HELD = Checker.INSIDE_HOLDING.value
PROVEN = Checker.PROVEN_BEFORE_ENTRY.value


def rail(stage: Stage, share: float, unit: str = "A") -> Stage:
    stage.checkers.rail(stage.t_s, unit, share)
    return stage


def outside(stage: Stage) -> set[str]:
    return {found.checker for found in stage.checkers.outside_design}


def beyond(stage: Stage) -> Stage:
    """A comes from T1 onto points 2 that it neither holds nor has proven."""
    return stage.see("A", ("T1+", 250.0), ("normal2+", 5.0))


def test_an_overrun_on_less_than_the_design_adhesion_is_told_apart() -> None:
    for share, broken, apart in ((0.8, {HELD, PROVEN}, set[str]()), (0.79, set[str](), {HELD, PROVEN})):
        stage = beyond(rail(in_track(), share))
        assert (stage.broken(), outside(stage)) == (broken, apart)
        assert bool(stage.checkers.counts) is bool(broken)


def test_what_another_train_comes_into_is_not_of_that_rail() -> None:
    stage = rail(second(in_track()), 0.1, "B")
    assert beyond(stage).broken() == {HELD, PROVEN}


def test_who_lost_the_proof_too_late_to_stop_and_has_no_grip_is_outside() -> None:
    stage = authorised().see("A", ("W+", 249.0), ("W+", 250.0)).entry("A", ProofDropped(points_id="1"))
    rail(stage, 0.1).see("A", ("stem1+", 1.0), speed_mps=9.0)
    assert (stage.broken(), outside(stage)) == (set(), {PROVEN})


def test_it_ends_when_the_train_stands() -> None:
    stage = rail(rail(in_track(), 0.1).see("A", ("T1+", 100.0)), 1.0)
    stage.see("A", ("T1+", 101.0), speed_mps=0.0)
    assert beyond(stage).broken() == {HELD, PROVEN}


@pytest.mark.parametrize(("later_s", "broken"), [(9.0, set[str]()), (12.0, {HELD, PROVEN})])
def test_it_ends_when_the_train_could_have_stopped_with_the_grip_that_it_has_again(
    later_s: float, broken: set[str]
) -> None:
    """From 10 m/s that takes 11 s; the two looks take 2 s of them."""
    stage = rail(rail(in_track(), 0.1).see("A", ("T1+", 100.0)), 1.0)
    stage.t_s += later_s - 2.0
    assert beyond(stage).broken() == broken


def test_what_it_came_into_stays_outside_until_it_has_left_it() -> None:
    stage = beyond(rail(in_track(), 0.1)).see("A", ("normal2+", 6.0), speed_mps=0.0)
    rail(stage, 1.0).holds("A", "P1", "T1").finish()  # told again what it holds: still not this
    stage.world(PointsMoving(points_id="2", target=Position.REVERSE))
    assert stage.broken() == set()
    assert outside(stage) >= {HELD, PROVEN, Checker.NO_THROW_UNDER_TRAIN.value}
    stage.see("A", ("stem2+", 5.0), ("B+", 100.0))
    assert HELD in stage.broken()  # it went on, by no want of grip


def test_a_train_let_in_where_another_has_slid_to_is_outside_and_their_collision_is_not() -> None:
    stage = second(beyond(rail(in_track(), 0.1))).grant("B", "B", "P2").holds("B", "E", "B", "P2")
    stage.prove("B", "2", "normal").see("B", ("B-", 5.0), ("B-", 499.0), ("stem2-", 5.0))
    assert Checker.ONE_TRAIN_A_SECTION.value in outside(stage)
    assert stage.broken() == set()
    stage.entry(WORLD, Collision(text="A and B"))
    assert stage.broken() == {Checker.SUMO_COLLISION.value}


def test_what_does_not_rest_on_the_brakes_is_judged_on_any_rail() -> None:
    assert rail(on_points(), 0.1).holds("A", "P1", "T1").broken() == {Checker.RELEASE_BEHIND_REAR.value}
    assert rail(Stage(), 0.1).bounds(1002.1, 5.0, 2.0).broken() == {Checker.WITHIN_BOUNDS.value}
    freed = rail(in_track(), 0.1).free("A", "T1").finish()
    assert freed.broken() == {HELD}  # under the train, which did nothing


@pytest.mark.parametrize(("share", "told"), [(0.1, {"unsafe"}), (1.0, set[str]())])
def test_what_the_world_calls_unsafe_is_told_apart_too(share: float, told: set[str]) -> None:
    stage = rail(in_track(), share).world(Unsafe(unit_id="A", danger=Danger.NO_POSITION, points_id="2"))
    assert outside(stage) == told


def test_a_stretch_lasts_as_long_as_the_rail_is_worse_than_the_design() -> None:
    stage = in_track()
    for t_s, share in ((100.0, 0.9), (110.0, 0.5), (120.0, 0.3), (130.0, 0.7), (140.0, 0.8), (150.0, 0.2)):
        stage.checkers.rail(t_s, "A", share)
    first, last = stage.checkers.slippery
    assert (first.from_s, first.to_s, first.least) == (110.0, 140.0, 0.3)
    assert (last.from_s, last.to_s, last.least) == (150.0, None, 0.2)
