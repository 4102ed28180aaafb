"""When the bounds of a position are judged: always, but while a faulty tachometer or a first tag has made it false."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from simulation.world.premises import FalsePositions


class Cab:
    """One train: its tachometer, its unit, and what makes its position false."""

    def __init__(self) -> None:
        self.tachometer: Any = SimpleNamespace(gain=1.0, wheel_factor=1.0, frozen_mps=-1.0)
        self.unit: Any = SimpleNamespace(odometer_scale=1.0, bound_growth=0.02, position_known=1)
        self.premises = FalsePositions([self.tachometer], [self.unit])

    def show(self, gain: float = 1.0, stuck_mps: float = -1.0) -> Cab:
        self.tachometer.gain, self.tachometer.frozen_mps = gain, stuck_mps
        self.premises.fault(0, in_force=(gain, stuck_mps) != (1.0, -1.0))
        return self

    def fix(self, *, holds: bool = True, lies: bool = False) -> Cab:
        self.premises.note_fix(0, holds=holds, lies=lies)
        return self

    @property
    def judged(self) -> bool:
        return not self.premises.is_false(0)


def test_without_a_fault_bounds_are_judged_however_wrong_the_wheels_are() -> None:
    cab = Cab()
    cab.tachometer.wheel_factor = 1.5
    assert cab.judged


@pytest.mark.parametrize(("gain", "judged"), [(1.018, True), (1.022, False), (0.982, True), (0.978, False)])
def test_a_fault_that_the_bounds_promise_to_cover_is_judged(gain: float, judged: bool) -> None:
    """They grow by 2 cm on each metre that is counted."""
    assert Cab().show(gain).judged is judged


def test_wider_bounds_cover_more() -> None:
    cab = Cab()
    cab.unit.bound_growth = 0.2
    assert cab.show(1.1).judged
    assert not cab.show(1.3).judged


@pytest.mark.parametrize(
    ("shows", "runs_on"),
    [((1.3, -1.0), False), ((0.0, -1.0), False), ((1.0, 0.0), False), ((1.0, 8.0), True)],
)
def test_only_one_that_is_stuck_at_a_speed_shows_a_standing_train_as_running(
    shows: tuple[float, float], runs_on: bool
) -> None:
    cab = Cab().show(*shows)
    assert cab.premises.runs_on(0) is runs_on
    assert not cab.show().premises.runs_on(0)


def test_what_is_false_stays_false_after_the_fault_until_a_fix() -> None:
    cab = Cab().show(1.3)
    assert not cab.judged
    assert not cab.show().judged
    assert cab.fix().judged
    assert cab.judged


def test_a_fix_while_the_fault_lasts_is_false_again_with_the_next_metre() -> None:
    cab = Cab().show(1.3)
    assert not cab.judged
    assert not cab.fix().judged


def test_a_fix_that_left_the_truth_outside_ends_nothing_but_the_next_one_does() -> None:
    cab = Cab().show(1.3)
    assert not cab.judged
    cab.show()
    assert not cab.fix(holds=False).judged
    assert cab.fix(holds=False).judged


def test_a_position_that_is_lost_is_not_false_when_it_is_found() -> None:
    cab = Cab().show(1.3)
    assert not cab.judged
    cab.unit.position_known = 0
    assert cab.show().judged
    cab.unit.position_known = 1
    assert cab.judged


def test_a_fault_in_which_no_metre_was_run_makes_nothing_false() -> None:
    assert Cab().show(0.0).show().judged


def test_one_that_is_stuck_runs_on_while_the_train_stands() -> None:
    cab = Cab().show(stuck_mps=5.0).show()
    assert not cab.judged
    cab.premises.position_told(0)
    assert cab.judged


def test_what_the_unit_learned_of_a_faulty_tachometer_is_of_the_fault_too() -> None:
    cab = Cab().show(1.018)
    cab.unit.odometer_scale = 0.97
    assert not cab.show().judged
    cab.unit.odometer_scale = 1.0
    assert not cab.judged
    assert cab.fix().judged
    cab.unit.odometer_scale = 0.97  # nothing false is left behind: from now on this is the unit's own
    assert cab.judged


@pytest.mark.parametrize("lies", [True, False])
def test_the_first_tag_after_a_boot_makes_the_position_false_if_it_lies_until_the_next(*, lies: bool) -> None:
    cab = Cab()
    cab.premises.booted(0)
    assert cab.fix(holds=not lies, lies=lies).judged is not lies
    assert cab.fix().judged


def test_satellites_that_go_on_lying_as_at_first_leave_it_false_until_they_do_not() -> None:
    cab = Cab()
    cab.premises.booted(0)
    for _ in range(5):
        assert not cab.fix(holds=False, lies=True).judged
    assert not cab.fix(holds=False).judged
    assert cab.fix(holds=False).judged


def test_a_later_tag_that_lies_is_what_bounds_are_for() -> None:
    cab = Cab()
    cab.premises.booted(0)
    cab.fix()
    assert cab.fix(holds=False, lies=True).judged
