"""Where a train lies on its way, by hand: pieces of the RTRI test line (1 to 300 m, points to 360 m, 3 to 470 m)."""

import pytest

from network.model import Direction
from simulation.carriers.trail import Trail
from tests.simulation.carriers.roads import LINE

WAY = ["1", "P2.stem", "P2.normal", "3", "P5.normal"]


def place_m(trail: Trail, piece_id: str, position_m: float, run_m: float) -> float | None:
    places_m = (trail.place_m(each, position_m) for each in trail.within(run_m) if each.piece_id == piece_id)
    return next(places_m, None)


def test_what_is_ahead_is_as_far_as_the_kilometrage_says() -> None:
    trail = Trail(LINE, WAY, Direction.DOWN, 100.0, 40.0)  # its front at 180 m, 100 m on the way
    assert place_m(trail, "1", 200.0, 0.0) == pytest.approx(120.0)
    assert place_m(trail, "3", 400.0, 300.0) == pytest.approx(320.0)
    assert place_m(trail, "3", 400.0, 150.0) is None  # piece 3 begins 180 m ahead
    assert place_m(trail, "4", 400.0, 300.0) is None  # the other track


def test_the_rear_is_followed_over_joints_and_forgotten_behind_them() -> None:
    trail = Trail(LINE, WAY, Direction.DOWN, 100.0, 100.0)
    trail.follow("P2.normal", 20.0)  # 330 m: the rear at 230 m
    assert trail.front_m == pytest.approx(250.0)
    assert place_m(trail, "1", 230.0, 0.0) == pytest.approx(150.0)
    trail.follow("3", 60.0)  # 420 m: the rear at 320 m
    assert place_m(trail, "1", 230.0, 0.0) is None
    with pytest.raises(ValueError, match="4 is not on the way"):
        trail.follow("4", 1.0)


def test_one_put_down_over_a_joint_lies_on_what_is_behind() -> None:
    trail = Trail(LINE, ["3"], Direction.UP, 20.0, 60.0)  # upwards at 450 m, its rear at 510 m
    assert place_m(trail, "P5.normal", 500.0, 0.0) == pytest.approx(-30.0)


def test_it_turns_where_it_stands_and_another_way_may_lie_ahead() -> None:
    trail = Trail(LINE, WAY, Direction.DOWN, 200.0, 40.0)
    trail.follow("3", 60.0)  # from 380 m to 420 m
    trail.turn(["3", "P2.normal", "P2.stem"])
    assert trail.direction is Direction.UP
    from_front_m = {m: place_m(trail, "3", m, 0.0) for m in (380.0, 400.0, 420.0)}
    assert {
        m: way_m - trail.front_m for m, way_m in from_front_m.items() if way_m is not None
    } == pytest.approx({380.0: 0.0, 400.0: -20.0, 420.0: -40.0})
    trail.lead(["3", "P2.normal"])
    trail.follow("P2.normal", 10.0)  # 350 m
    assert place_m(trail, "3", 365.0, 0.0) == pytest.approx(trail.front_m - 15.0)
