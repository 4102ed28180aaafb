"""A handle at full power, or anywhere: what lies outside brakes for limits, and nothing passes the stop limit."""

from collections.abc import Callable

import pytest

from onboard.driving.laws.table import LAW_NAMES, LAWS
from tests.onboard.driving.laws.test_laws import Ride, ride

__all__ = ["ride"]


@pytest.mark.parametrize("notch", [1.0, 3.0, 99.0])
def test_full_power_passes_neither_limit_nor_stop_limit(ride: Callable[..., Ride], notch: float) -> None:
    """A limit of 12 m/s and an authority that ends 1300 m on: nobody brakes but the unit."""
    course = ride("by_hand", limit_mps=12.0)
    course.board.laws.by_hand.notch = notch  # type: ignore[attr-defined]
    course.board.unit.target_stop_m, course.board.unit.stop_limit_m = 1300.0, 1400.0
    speeds, notches = course.run(2500)
    assert max(speeds) <= 12.5
    assert max(notches) <= course.board.kind.power_notches
    assert course.board.unit.position_m <= 1400.0
    assert speeds[-1] == 0.0


def test_the_train_has_the_notch_of_the_handle_and_its_strongest_beyond(ride: Callable[..., Ride]) -> None:
    for asked in (2.0, -3.0, -99.0):
        course = ride("by_hand", speed_mps=6.0)
        course.board.laws.by_hand.notch = asked  # type: ignore[attr-defined]
        _, notches = course.run(1)
        assert notches == [max(asked, -course.board.kind.brake_notches)]


def test_no_scenario_chooses_it() -> None:
    assert [law.name for law in LAWS if law.by_person] == ["by_hand"]
    assert "by_hand" not in LAW_NAMES
