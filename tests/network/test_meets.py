"""Where trains meet on the train graph, by hand-made trajectories on a line of three stations."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.meets import Trajectory, meets_of
from network.model import Direction
from tests.network.sample import LINE

A_M, H_M, B_M = (LINE.stations[name].position_m for name in "AHB")
TEN = 36_000.0


def down(*corners: tuple[float, float], number: str = "D") -> Trajectory:
    return Trajectory(number, Direction.DOWN, tuple(t for t, _ in corners), tuple(m for _, m in corners))


def up(*corners: tuple[float, float], number: str = "U") -> Trajectory:
    return Trajectory(number, Direction.UP, tuple(t for t, _ in corners), tuple(m for _, m in corners))


def test_same_speeds_opposite_ends_meet_half_way_at_half_time() -> None:
    (meet,) = meets_of(LINE, [down((TEN, A_M), (TEN + 600, B_M)), up((TEN, B_M), (TEN + 600, A_M))])
    assert (meet.down_train, meet.up_train) == ("D", "U")
    assert meet.time_s == pytest.approx(TEN + 300)
    assert meet.position_m == pytest.approx((A_M + B_M) / 2)
    assert (meet.low_station, meet.high_station, meet.station) == ("H", "B", None)
    assert str(meet) == "D and U meet between H and B at 10:05:00"


def test_a_train_that_stands_is_met_where_it_stands() -> None:
    waits = down((TEN - 60, A_M), (TEN + 120, A_M), (TEN + 600, B_M))
    (meet,) = meets_of(LINE, [waits, up((TEN - 540, B_M), (TEN + 60, A_M), (TEN + 180, A_M))])
    assert (meet.station, meet.time_s) == ("A", TEN + 60)
    assert str(meet) == "D and U meet at A at 10:01:00"


def test_who_has_gone_or_goes_the_same_way_is_not_met() -> None:
    runs = down((TEN, A_M), (TEN + 600, B_M))
    assert meets_of(LINE, [runs, up((TEN - 600, B_M), (TEN, A_M))]) == ()  # touch, no overlap
    assert meets_of(LINE, [runs, up((TEN + 900, B_M), (TEN + 1500, A_M))]) == ()
    assert meets_of(LINE, [runs, up((TEN + 540, H_M), (TEN + 900, A_M))]) == ()  # has long passed it
    ends = down((TEN, A_M), (TEN + 600, H_M))
    assert meets_of(LINE, [ends, up((TEN + 300, B_M), (TEN + 900, H_M))]) == ()  # it ends before that comes
    assert meets_of(LINE, [runs, down((TEN + 60, A_M), (TEN + 660, B_M), number="E")]) == ()


@given(st.integers(-500, 500), st.integers(0, 86_400))
def test_the_same_day_later_has_the_same_meets(shift_s: int, later_s: int) -> None:
    def found(by_s: float) -> list[tuple[float, float]]:
        one = down((TEN + by_s, A_M), (TEN + by_s + 600, B_M))
        other = up((TEN + by_s + shift_s, B_M), (TEN + by_s + shift_s + 600, A_M))
        return [(meet.time_s - by_s, meet.position_m) for meet in meets_of(LINE, [one, other])]

    now = found(0.0)
    assert len(now) == 1  # trains that are on the line together going towards each other meet once
    assert [pytest.approx(each) for each in now] == found(float(later_s))
