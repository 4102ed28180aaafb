"""Points entered without a proof: allowed only where it was lost too late to stop, and the route is locked.

The train of the stage is 40 m long; its brake is guaranteed to give 1 m/s^2 after 1 s, so that from 10 m/s it stops in
10 + 50 = 60 m, and 50 m on it is down to sqrt(100 - 2 x 40) = 4.5 m/s. It stands in W, 300 m long, before points 1.
"""

import pytest

from network.model import Position
from simulation.events import PointsLocked, PointsMoving, PointsUnlocked, ProofDropped, UnitRestarted
from simulation.judge.body import Body, NetTrack
from simulation.judge.checkers import Checker, GuaranteedBrake
from tests.simulation.judge.stage import Stage, authorised, net

ENTRY = {Checker.PROVEN_BEFORE_ENTRY.value}


def lost_at(front_m: float, speed_mps: float = 10.0) -> Stage:
    """A runs at an even speed and loses its proof `300 - front_m` before the points."""
    stage = authorised().see("A", ("W+", front_m - 1.0), ("W+", front_m), speed_mps=speed_mps)
    return stage.entry("A", ProofDropped(points_id="1"))


def enter(stage: Stage, speed_mps: float) -> Stage:
    return stage.see("A", ("stem1+", 1e-2), speed_mps=speed_mps)


def test_lost_within_the_braking_distance_the_train_may_come_onto_the_points_braking() -> None:
    assert enter(lost_at(250.0), 4.4).broken() == set()


def test_lost_farther_away_the_train_could_have_stopped() -> None:
    assert enter(lost_at(240.1), 0.1).broken() == set()
    assert enter(lost_at(239.9), 0.1).broken() == ENTRY


def test_who_does_not_brake_as_is_guaranteed_is_not_excused() -> None:
    assert enter(lost_at(250.0), 4.8).broken() == ENTRY
    late = lost_at(250.0).see("A", ("W+", 280.0), speed_mps=9.0)  # 7.7 m/s at most, 30 m on
    assert enter(late, 4.4).broken() == ENTRY
    # it may yet stop before them
    assert lost_at(250.0).see("A", ("W+", 280.0), speed_mps=9.0).broken() == set()


def test_within_the_reaction_time_it_may_gain_as_it_did_before() -> None:
    """From 8 to 10 m/s in the last second it is at 12 m/s at the end of the next one, 11 m on."""
    gaining = authorised().see("A", ("W+", 270.0), speed_mps=8.0).see("A", ("W+", 289.5), speed_mps=10.0)
    gaining.entry("A", ProofDropped(points_id="1"))
    stage = gaining
    assert enter(stage, 12.1).broken() == set()
    assert enter(lost_at(289.5), 12.1).broken() == ENTRY


@pytest.mark.parametrize("moved", [False, True])
def test_the_route_must_stay_locked_until_the_train_comes(moved: bool) -> None:
    stage = lost_at(250.0)
    if moved:
        stage.world(PointsUnlocked(points_id="1"))
        stage.world(PointsLocked(points_id="1", position=Position.NORMAL))
    assert enter(stage, 4.0).broken() == (ENTRY if moved else set())


def test_the_route_must_stay_locked_until_it_is_over_them() -> None:
    under = enter(lost_at(250.0), 4.0).world(PointsUnlocked(points_id="1"))
    assert under.broken() == {*ENTRY, Checker.POINTS_UNDER_TRAIN.value}
    over = enter(lost_at(299.0), 9.0).see("A", ("normal1+", 29.0), ("T1+", 41.0), speed_mps=2.0)
    over.world(PointsMoving(points_id="1", target=Position.REVERSE))
    assert over.broken() == set()


def test_on_the_points_it_must_brake_too() -> None:
    entered = enter(lost_at(290.0), 9.9)
    assert entered.broken() == set()
    assert entered.see("A", ("normal1+", 25.0), speed_mps=9.0).broken() == ENTRY  # 7.1 m/s at most, 45 m on


def test_a_proof_of_the_other_position_is_none_for_having_been_lost() -> None:
    stage = authorised().prove("A", "1", "reverse").see("A", ("W+", 249.0), ("W+", 250.0))
    stage.entry("A", ProofDropped(points_id="1"))
    stage.see("A", ("stem1+", 1.0), speed_mps=4.0)
    assert stage.broken() == set()
    assert stage.see("A", ("normal1+", 1e-2), speed_mps=0.1).broken() == ENTRY


def test_a_train_that_has_stood_does_not_go_on_without_a_proof() -> None:
    stood = lost_at(250.0).see("A", ("W+", 280.0), speed_mps=0.0)
    assert enter(stood, 1.0).broken() == ENTRY
    again = lost_at(250.0).see("A", ("W+", 280.0), speed_mps=0.0).prove("A", "1", "normal")
    assert enter(again, 10.0).broken() == set()


def test_who_gives_the_section_back_has_no_proof_to_lose() -> None:
    stage = lost_at(250.0).holds("A", "W").holds("A", "W", "P1", "T1")
    assert enter(stage, 4.0).broken() == ENTRY


def test_a_unit_that_starts_again_loses_its_proofs_as_any_other() -> None:
    for front_m, broken in ((250.0, set[str]()), (230.0, ENTRY)):
        stage = authorised().see("A", ("W+", front_m - 1.0), ("W+", front_m))
        stage.entry("A", UnitRestarted(epoch=2))
        assert enter(stage, 4.0).broken() == broken


def test_a_train_without_a_brake_that_is_known_is_never_excused() -> None:
    stage = Stage(())
    stage.put("A", "W+").sign_on("A", "W").grant("A", "P1", "T1")
    stage.holds("A", "W", "P1", "T1").prove("A", "1", "normal").see("A", ("W+", 249.0), ("W+", 250.0))
    assert enter(stage.entry("A", ProofDropped(points_id="1")), 4.0).broken() == ENTRY


def test_gravity_counts_by_the_height_that_the_track_gains() -> None:
    brake = GuaranteedBrake(1.0, 1.0, 9.0)
    level = brake.speed2(10.0, 0.0, 50.0, 0.0)
    assert level == pytest.approx(20.0)
    assert brake.speed2(10.0, 0.0, 50.0, -1.0) - level == pytest.approx(18.0)  # v^2 = 2 g h on the way down
    assert brake.speed2(10.0, 0.0, 9.9, 0.0) == 100.0


def test_a_run_and_its_climb_are_counted_over_the_joints_of_edges() -> None:
    """W climbs 3 m over its 300 m, the stem falls 1 m on its 10 m, and the leg is told to begin at another height."""
    heights = {
        "W+": ((0.0, 50.0), (300.0, 53.0)),
        "stem1+": ((0.0, 53.0), (10.0, 52.0)),
        "normal1+": ((0.0, 7.0), (30.0, 7.0)),
    }
    track = NetTrack(net(), heights)
    body = Body("A", 40.0, ["W+"])
    places = (("W+", 100.0), ("W+", 200.0), ("stem1+", 5.0), ("normal1+", 12.0))
    seen = []
    for edge_id, front_m in places:
        track.follow(body, edge_id, front_m)
        seen.append((body.run_m, track.height_m(body)))
    assert [run_m - seen[0][0] for run_m, _ in seen] == pytest.approx([0.0, 100.0, 205.0, 222.0])
    assert [height_m - seen[0][1] for _, height_m in seen] == pytest.approx([0.0, 1.0, 1.5, 1.0])
