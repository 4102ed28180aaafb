import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Direction
from simulation.carriers.plain_track import PlainTrack

STEP_S = 0.1
LENGTHS_M = {"a": 100.0, "b": 50.0, "c": 200.0}


def with_train(offset_m: float = 60.0) -> PlainTrack:
    track = PlainTrack(LENGTHS_M, STEP_S)
    track.insert("V1", ("a", "b", "c"), Direction.DOWN, offset_m, 40.0)
    return track


@given(st.lists(st.floats(0.0, 3.0), min_size=1, max_size=100))
def test_distance_is_the_trapezoid_of_the_speeds(speeds: list[float]) -> None:
    track = with_train()
    assert track.run([("V1", speeds)], len(speeds)) == 0
    run_m = sum((v + w) / 2.0 * STEP_S for v, w in zip([0.0, *speeds], speeds, strict=False))
    truth = track.truth("V1")
    before_m = {"a": 0.0, "b": 100.0, "c": 150.0}[truth.piece_id]
    assert before_m + truth.offset_m == pytest.approx(60.0 + run_m)
    assert truth.offset_m >= 0.0
    assert truth.offset_m < LENGTHS_M[truth.piece_id]
    assert truth.speed_mps == speeds[-1]


def test_only_as_many_steps_as_asked_for_are_executed() -> None:
    track = with_train()
    track.run([("V1", [10.0, 10.0, 99.0])], 2)
    assert track.truth("V1").offset_m == pytest.approx(60.0 + 0.5 + 1.0)


def test_a_joint_belongs_to_the_piece_being_entered_and_the_last_piece_has_no_end() -> None:
    track = with_train(99.0)
    track.run([("V1", [10.0])], 1)
    assert track.truth("V1").piece_id == "a"
    track.run([("V1", [0.0])], 1)
    truth = track.truth("V1")
    assert truth.piece_id == "b"
    assert truth.offset_m == pytest.approx(0.0, abs=1e-9)
    track.reroute("V1", ("b",), Direction.DOWN)
    track.run([("V1", [100.0] * 10)], 10)
    assert track.truth("V1").piece_id == "b"


def test_changing_ends_puts_the_front_where_the_rear_was() -> None:
    """Front at 60 m of a 100 m piece, 40 m long: the rear is at 20 m, that is 80 m from the other end."""
    track = with_train()
    track.reverse("V1", ("a",), Direction.UP)
    truth = track.truth("V1")
    assert truth.direction is Direction.UP
    assert truth.offset_m == pytest.approx(80.0)
    track.reverse("V1", ("a", "b"), Direction.DOWN)
    assert track.truth("V1").offset_m == pytest.approx(60.0)


def test_removing_and_no_collisions() -> None:
    track = with_train()
    track.remove("V1")
    with pytest.raises(KeyError):
        track.truth("V1")
    assert track.collisions() == ()
    track.close()
