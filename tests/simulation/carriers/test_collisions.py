"""Collisions on plain track: what SUMO finds, in the same step and the same words; and what it has no eyes for."""

from collections.abc import Callable
from dataclasses import dataclass

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from network.model import Direction
from simulation.carriers.plain_track import PlainTrack
from simulation.carriers.sumo import SumoCarrier
from simulation.carriers.touching import OVERLAP_M, Look
from tests.simulation.carriers.encounters import LINE, STEP_S, Came, Going, carried, going, meetings, net_in

pytest.importorskip("sumo", reason="netconvert comes with the extra `net`")
DOWN, UP = Direction.DOWN, Direction.UP
Carry = Callable[..., Came]


@pytest.fixture(scope="module")
def on_sumo(tmp_path_factory: pytest.TempPathFactory) -> Carry:
    net = net_in(tmp_path_factory.mktemp("net"))

    def carry(trains: tuple[Going, ...], stretch: int = 50, begin_s: float = 0.0) -> Came:
        carrier = SumoCarrier(net, begin_s)
        try:
            return carried(carrier, trains, stretch)
        finally:
            carrier.close()

    return carry


def on_plain(trains: tuple[Going, ...], stretch: int = 50, look: Look = Look.AS_SUMO) -> Came:
    return carried(PlainTrack.of_line(LINE, STEP_S, look), trains, stretch)


@dataclass(frozen=True)
class Case:
    """Trains, and after which step they collide by hand (0: never); `seen_by` alone finds it."""

    trains: tuple[Going, ...]
    step: int
    seen_by: Look


def towards(front_m: float, end_m: float = 1000.123456) -> float:
    """Where the front of an up train is on its way, from its kilometrage."""
    return end_m - front_m


# The loop: west to 300 m, stem to 310, legs to 340, tracks to 600, legs to 630, stem to 640, east. At 10 m/s from a
# stand a train has run n - 0.5 m after n steps.
CASES = {
    "head-on": Case(
        (going(0, DOWN, 0, 50.0, 18.0, (80, 10.0)), going(1, UP, 0, towards(80.0), 18.0, (80, 10.0))),
        16,  # 2n - 1 >= 30
        Look.HEAD_ON,
    ),
    "head-on, faster than they are long": Case(
        (going(0, DOWN, 0, 50.0, 3.0, (80, 70.0)), going(1, UP, 0, towards(260.0), 3.0, (80, 70.0))),
        16,  # 14n - 7 >= 210
        Look.HEAD_ON,
    ),
    "head-on with one that stands on the other leg and the stem": Case(
        (going(0, DOWN, 0, 290.0, 40.0, (80, 10.0)), going(1, UP, 1, towards(305.0), 18.0)),
        16,  # n - 0.5 >= 15
        Look.HEAD_ON,
    ),
    "into the rear of one that stands": Case(
        (going(0, DOWN, 0, 60.0, 18.0, (80, 10.0)), going(1, DOWN, 0, 100.0, 18.0)),
        23,  # n - 0.5 > 22.001
        Look.FROM_BEHIND,
    ),
    "into a rear that is still on the stem": Case(
        (going(0, DOWN, 0, 290.0, 40.0, (80, 10.0)), going(1, DOWN, 1, 320.0, 18.0)),
        13,  # n - 0.5 > 12.001
        Look.FROM_BEHIND,
    ),
    "where tracks join, into the side": Case(
        (going(0, DOWN, 0, 590.0, 18.0, (80, 20.0)), going(1, DOWN, 1, 628.0, 18.0, (10, 10.0))),
        21,  # 2n - 1 >= 40: the stem, on which the other stands, its rear on its leg
        Look.FROM_BEHIND,
    ),
    "one put on another": Case(
        (going(0, DOWN, 0, 400.0, 18.0), going(1, UP, 0, towards(395.0), 18.0)), 1, Look.HEAD_ON
    ),
    "one that turned, into the next": Case(
        (
            going(0, DOWN, 0, 500.0, 18.0, (20, 0.0), (60, 10.0), turns_at=20),
            going(1, DOWN, 0, 450.0, 18.0),
        ),
        53,  # 20 and n - 0.5 >= 32
        Look.HEAD_ON,
    ),
    "on tracks side by side": Case(
        (going(0, DOWN, 0, 350.0, 18.0, (80, 20.0)), going(1, UP, 1, towards(590.0), 18.0, (80, 20.0))),
        0,
        Look.NOTHING,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_found_in_the_step_in_which_it_happens(name: str, on_sumo: Carry) -> None:
    case = CASES[name]
    sumo, plain = on_sumo(case.trains), on_plain(case.trains)
    assert sumo.step == plain.step == case.step
    assert sumo == plain
    assert len(plain.said) == (1 if case.step else 0)


@pytest.mark.parametrize("name", CASES)
def test_a_look_that_is_left_out_finds_nothing(name: str) -> None:
    case = CASES[name]
    assert on_plain(case.trains, look=Look.AS_SUMO & ~case.seen_by).step == 0
    assert on_plain(case.trains, look=case.seen_by).step == case.step


@pytest.mark.parametrize("stretch", [1, 7, 600])
def test_stretches_change_nothing(stretch: int, on_sumo: Carry) -> None:
    for case in CASES.values():
        assert on_plain(case.trains, stretch) == on_plain(case.trains) == on_sumo(case.trains, stretch)


def test_a_run_may_begin_before_midnight(on_sumo: Carry) -> None:
    trains = CASES["head-on"].trains
    assert on_sumo(trains, begin_s=-120.0) == on_sumo(trains)


@given(trains=meetings(), stretch=st.integers(1, 60))
def test_two_trains_collide_as_on_sumo(trains: tuple[Going, ...], stretch: int, on_sumo: Carry) -> None:
    plain = on_plain(trains, stretch)
    assume(not plain.turned_ahead)
    assert plain == on_sumo(trains, stretch)


@pytest.mark.nightly
@given(trains=meetings(), stretch=st.integers(1, 60))
@settings(max_examples=10_000)
def test_ten_thousand_meetings(trains: tuple[Going, ...], stretch: int, on_sumo: Carry) -> None:
    plain = on_plain(trains, stretch)
    assume(not plain.turned_ahead)
    assert plain == on_sumo(trains, stretch)


@given(trains=meetings(trains=3), stretch=st.integers(1, 60))
def test_of_three_trains_none_is_found_later_than_on_sumo(
    trains: tuple[Going, ...], stretch: int, on_sumo: Carry
) -> None:
    plain = on_plain(trains, stretch)
    assume(not plain.turned_ahead)
    sumo = on_sumo(trains, stretch)
    assert sumo == plain or 0 < plain.step <= (sumo.step or plain.step)


def test_sumo_overlooks_the_middle_one_of_three(on_sumo: Carry) -> None:
    """The first has its front beyond the piece, and SUMO holds the hindmost alone against it."""
    trains = (
        going(0, DOWN, 0, 290.0, 18.0, (30, 10.0)),
        going(1, DOWN, 1, 305.0, 18.0),
        going(2, DOWN, 0, 100.0, 18.0),
    )
    assert on_plain(trains[:2]).step == on_sumo(trains[:2]).step == 1
    assert on_plain(trains).step == 1
    assert on_sumo(trains).step > 1


def test_sumo_takes_one_that_turned_ahead_of_another_for_one_behind_it(on_sumo: Carry) -> None:
    """A hundred metres apart they collide on SUMO, which puts who turns behind all that go that way on the piece."""
    trains = (going(0, DOWN, 0, 450.0, 18.0), going(1, UP, 0, towards(550.0), 18.0, turns_at=10))
    assert on_sumo(trains).step == 11
    assert on_plain(trains).step == 0
    assert on_plain(trains).turned_ahead


@given(more_m=st.floats(-0.005, 0.005))
def test_from_behind_a_millimetre_is_let_pass(more_m: float, on_sumo: Carry) -> None:
    """It runs 5 m and so much more, to a rear 5 m ahead: in two steps, half in each."""
    if abs(more_m - OVERLAP_M) < 1e-9:
        return
    trains = (going(0, DOWN, 0, 60.0, 18.0, (1, 50.0 + 10.0 * more_m)), going(1, DOWN, 0, 83.0, 18.0))
    assert on_plain(trains).step == on_sumo(trains).step == (2 if more_m > OVERLAP_M else 0)


@given(more_m=st.floats(-0.005, 0.005))
def test_head_on_to_touch_is_enough(more_m: float, on_sumo: Carry) -> None:
    if abs(more_m) < 1e-9:
        return
    trains = (going(0, DOWN, 0, 60.0, 18.0, (1, 50.0 + 10.0 * more_m)), going(1, UP, 0, towards(65.0), 18.0))
    assert on_plain(trains).step == on_sumo(trains).step == (2 if more_m > 0.0 else 0)


def test_sumo_has_no_eyes_for_trains_beside_each_other(on_sumo: Carry) -> None:
    """One stands on the reverse leg, short of its end at 340 m; the other comes over the normal leg beside it."""
    trains = (going(0, DOWN, 0, 380.0, 18.0), going(1, DOWN, 1, 335.0, 18.0))
    beside = (going(0, DOWN, 0, 290.0, 18.0, (80, 10.0)), going(1, UP, 1, towards(335.0), 18.0))
    assert on_sumo(trains) == on_plain(trains) == on_plain(trains, look=Look.FOULING | Look.AS_SUMO)
    assert on_sumo(beside).step == on_plain(beside).step == 0
    assert on_plain(beside, look=Look.FOULING).step == 21  # n - 0.5 >= 20: the leg


def test_a_train_that_is_gone_is_run_into_no_more() -> None:
    track = PlainTrack.of_line(LINE, STEP_S)
    track.insert("K1", ("west",), DOWN, 100.0, 18.0)
    track.insert("K2", ("west",), DOWN, 60.0, 18.0)
    track.remove("K1")
    assert track.run([("K2", [30.0] * 10)], 10) == 0
    track.insert("K1", ("west",), DOWN, 100.0, 18.0)
    assert track.run([], 600) == 1
    assert track.run([], 600) == 0
    (said,) = track.collisions()
    assert "from behind" in said


def test_the_rear_is_where_the_train_came_from() -> None:
    """Its body is over the reverse leg: what stands there is hit, what stands on the normal leg is not."""
    for side, hit in ((0, 0), (1, 1)):
        track = PlainTrack.of_line(LINE, STEP_S)
        track.insert("K1", ("stem1", "reverse1", "track2"), DOWN, 5.0, 60.0)
        track.run([("K1", [10.0] * 30)], 30)
        track.reroute("K1", ("reverse1", "track2"), DOWN)
        track.insert("K2", (("normal1", "reverse1")[side],), UP, 10.0, 5.0)
        assert track.run([], 10) == hit
