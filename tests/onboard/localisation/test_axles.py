"""The tachometer against another axle: whichever errs, the front stays inside the bounds, and soon there is a doubt."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from onboard.localisation.axles import APART_M, LAST_AXLE_LIES, NO_AXLE_MPS, TACHOMETER_LIES, forget_axles
from onboard.localisation.tachometer import locate
from onboard.localisation.tags import tag_fix
from onboard.records import EVENT_TACHOMETER, UNIT, UnitRow
from onboard.unit_records import UnitParameters
from vehicle.train_file import load_train, shipped_train

STEP_S = 0.1
PULSE_M = 0.03
TRAIN = load_train(shipped_train("ev_e301")).row.view(np.recarray)[0]
PARAMETERS = UnitParameters()
VARIES = PARAMETERS.wheel_varies_share
POWER_MPS2, COAST_MPS2, BRAKE_MPS2 = 0.6, -0.03, -0.7

Shows = Callable[[float], float]  # of an axle: what it shows at a speed, m/s


def new_unit() -> UnitRow:
    row: UnitRow = np.zeros(1, dtype=UNIT).view(np.recarray)[0]
    row.position_known, row.odometer_scale, row.bound_growth = 1, 1.0, PARAMETERS.wheel_error_share
    row.expected_tag_m = row.rear_trigger_m = np.inf
    row.bound_ahead_m = row.bound_behind_m = PARAMETERS.tag_accuracy_m + PULSE_M
    row.pulse_m, row.axles_differ_share = PULSE_M, VARIES
    forget_axles(row)
    return row


@dataclass
class Ride:
    """A train whose two axles show what they show; counts where it really is, and when its unit doubts."""

    speed_mps: float = 0.0
    shown: bool = True  # the last axle is
    unit: UnitRow = field(default_factory=new_unit)
    true_m: float = 0.0
    turned_m: float = 0.0
    doubts_m: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.unit.speed_mps = self.unit.last_axle_mps = self.speed_mps

    def go(self, mps2: float, seconds: float, tachometer: Shows = abs, last: Shows = abs) -> Iterator[float]:
        """Run so, a step at a time; yields by how much the front is out of its bounds, m (negative: within)."""
        for _ in range(round(seconds / STEP_S)):
            before_mps, self.speed_mps = self.speed_mps, max(self.speed_mps + mps2 * STEP_S, 0.0)
            self.true_m += (before_mps + self.speed_mps) / 2.0 * STEP_S
            self.turned_m += (tachometer(before_mps) + tachometer(self.speed_mps)) / 2.0 * STEP_S
            odometer_m = self.turned_m // PULSE_M * PULSE_M
            last_mps = last(self.speed_mps) if self.shown else NO_AXLE_MPS
            self.unit.notch = float(np.sign(mps2)) if abs(mps2) > 0.1 else 0.0
            if (
                locate(self.unit, TRAIN, odometer_m, tachometer(self.speed_mps), STEP_S, last_mps)
                & EVENT_TACHOMETER
            ):
                self.doubts_m.append(self.true_m)
            yield self.out_m

    @property
    def out_m(self) -> float:
        """How far the front is outside."""
        unit = self.unit
        low_m, high_m = unit.position_m - unit.bound_behind_m, unit.position_m + unit.bound_ahead_m
        return float(max(low_m - self.true_m, self.true_m - high_m))


def times(factor: float) -> Shows:
    """An axle that shows its speed so many times."""
    return lambda mps: factor * mps


def stuck(at_mps: float) -> Shows:
    """One that shows the same for ever."""
    return lambda _mps: at_mps


LIES = st.one_of(st.floats(0.0, 3.0).map(times), st.floats(0.0, 30.0).map(stuck))
PIECES = st.lists(
    st.tuples(st.sampled_from([POWER_MPS2, COAST_MPS2, BRAKE_MPS2]), st.floats(1.0, 30.0)),
    min_size=1,
    max_size=5,
)


@given(PIECES, LIES, st.booleans(), st.floats(-VARIES, VARIES), st.floats(0.0, 25.0))
@example([(POWER_MPS2, 30.0), (BRAKE_MPS2, 30.0)], times(0.2), False, 0.0, 0.0)
@example([(POWER_MPS2, 30.0), (COAST_MPS2, 30.0)], times(0.93), False, VARIES, 0.0)
def test_the_front_is_inside_whichever_axle_lies_and_however(
    pieces: list[tuple[float, float]], lie: Shows, last_lies: bool, off: float, begins_mps: float
) -> None:
    ride = Ride(begins_mps)
    # what the one in order varies by, and what hides below the doubt
    ride.unit.bound_growth = VARIES + abs(off)
    sound = times(1.0 + off)
    tachometer, last = (sound, lie) if last_lies else (lie, sound)
    for mps2, seconds in pieces:
        for out_m in ride.go(mps2, seconds, tachometer, last):
            assert out_m <= PULSE_M


@given(st.lists(st.tuples(st.floats(0.3, 8.0), st.floats(0.9, 1.1), st.booleans()), min_size=2, max_size=6))
@example([(0.6, 0.93, False), (4.0, 1.0, True), (0.4, 0.93, False)])
@example([(0.6, 1.07, False), (4.0, 1.0, True), (0.4, 1.07, False)])
def test_what_axles_differ_by_after_a_fix_is_in_the_bounds_whatever_was_counted_before_it(
    pieces: list[tuple[float, float, bool]],
) -> None:
    """What the bounds held of an earlier difference a fix has cut off: 0.8 m, of which 0.4 m had been taken back."""
    ride = Ride(20.0)
    unit, unit.bound_growth = ride.unit, VARIES
    for seconds, factor, is_fixed in pieces:
        for out_m in ride.go(COAST_MPS2, seconds, times(factor)):
            assert out_m <= 2.0 * PULSE_M
        if is_fixed:
            unit.position_m, unit.bound_ahead_m, unit.bound_behind_m = ride.true_m, PULSE_M, PULSE_M


SLIDES: Final = -1


@pytest.mark.parametrize("since", [0.05, 0.5, 0.95])
@pytest.mark.parametrize(
    ("tachometer", "last", "slide"),
    [
        (times(0.0), abs, 0),
        (times(0.3), abs, 0),
        (times(2.0), abs, 0),
        (abs, times(0.0), 0),
        (times(0.8), times(0.8), SLIDES),
        (times(0.9), abs, SLIDES),
    ],
)
def test_a_tag_passed_in_a_step_that_was_counted_wrongly_has_the_front_where_it_is(
    tachometer: Shows, last: Shows, slide: int, since: float
) -> None:
    """At 20 m/s a step is 2 m: of these the tachometer counts what it shows, and the tag lies somewhere in it."""
    ride = Ride(20.0)
    list(ride.go(0.0, 1.0))
    ride.unit.wheel_slide = slide
    list(ride.go(0.0, 1.0, tachometer, last))
    since_m = since * 20.0 * STEP_S
    fix = tag_fix(ride.unit, ride.true_m - since_m, ride.turned_m - tachometer(since_m), PULSE_M)
    assert fix.position_m - fix.behind_m <= ride.true_m <= fix.position_m + fix.ahead_m


def test_a_tag_passed_while_the_last_axle_counts_for_the_tachometer() -> None:
    ride = Ride(12.0)
    list(ride.go(BRAKE_MPS2, 360.0, stuck(8.0)))
    assert ride.unit.liar == TACHOMETER_LIES
    list(ride.go(POWER_MPS2, 30.0, stuck(8.0)))
    since_m = 1.0
    turned_m = (
        ride.turned_m + float(ride.unit.odometer_off_m) - 8.0 * STEP_S * since_m / (ride.speed_mps * STEP_S)
    )
    fix = tag_fix(ride.unit, ride.true_m - since_m, turned_m, PULSE_M)
    assert fix.position_m - fix.behind_m <= ride.true_m <= fix.position_m + fix.ahead_m


def doubted_after_m(factor: float, begins_mps: float, mps2: float) -> float:
    """The way from the fault to the doubt."""
    ride = Ride(begins_mps)
    for _ in ride.go(mps2, 200.0, times(factor)):
        if ride.doubts_m:
            return ride.doubts_m[0]
    return np.inf


FACTORS = (0.2, 0.5, 0.7, 0.9, 0.93, 0.95, 0.98, 0.99, 1.01, 1.02, 1.05, 1.1, 1.5, 2.0)
PHASES = ((0.0, POWER_MPS2), (25.0, COAST_MPS2), (25.0, BRAKE_MPS2))


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize(("begins_mps", "mps2"), PHASES)
def test_a_factor_is_doubted_within_the_way_that_it_takes_to_err_by_a_metre(
    factor: float, begins_mps: float, mps2: float
) -> None:
    err = abs(1.0 - factor) - VARIES
    step_m = 25.0 * STEP_S
    assert doubted_after_m(factor, begins_mps, mps2) <= (APART_M + 2.0 * PULSE_M) / err + step_m


@pytest.mark.parametrize("factor", [1.0, 1.0 - 0.9 * VARIES, 1.0 + 0.9 * VARIES])
def test_what_the_way_of_a_turn_varies_by_is_no_doubt_and_widens_nothing_else(factor: float) -> None:
    ride = Ride()
    for mps2, seconds in ((POWER_MPS2, 40.0), (COAST_MPS2, 200.0), (BRAKE_MPS2, 40.0)):
        list(ride.go(mps2, seconds, times(factor)))
    assert ride.doubts_m == []
    assert ride.unit.slid_ahead_m == pytest.approx(0.0, abs=2e-3)
    assert ride.unit.slipped_behind_m == pytest.approx(0.0, abs=2e-3)


@pytest.mark.parametrize(("factor", "out_m"), [(0.2, 200.0), (0.93, 20.0)])
def test_without_another_axle_the_front_leaves_its_bounds_and_nobody_knows(
    factor: float, out_m: float
) -> None:
    ride = Ride(shown=False)
    outs_m = [*ride.go(POWER_MPS2, 35.0, times(factor)), *ride.go(COAST_MPS2, 10.0, times(factor))]
    assert ride.doubts_m == []
    assert max(outs_m) > out_m


def test_a_doubt_is_told_once_and_ends_when_axles_have_long_agreed() -> None:
    ride = Ride(20.0)
    list(ride.go(COAST_MPS2, 20.0, times(0.8)))
    assert len(ride.doubts_m) == 1
    list(ride.go(COAST_MPS2, 10.0))
    assert ride.unit.apart == 0
    list(ride.go(COAST_MPS2, 10.0, times(0.8)))
    assert len(ride.doubts_m) == 2


@pytest.mark.parametrize("factor", [0.2, 3.0])
def test_in_doubt_a_train_goes_by_the_faster_axle(factor: float) -> None:
    ride = Ride(10.0)
    list(ride.go(COAST_MPS2, 10.0, times(factor)))
    assert ride.unit.speed_mps == pytest.approx(max(1.0, factor) * ride.speed_mps)


@pytest.mark.parametrize(("tachometer", "last", "liar"), [(stuck(8.0), abs, 1), (abs, stuck(8.0), 2)])
def test_an_axle_that_turns_when_the_train_must_long_stand_counts_no_more(
    tachometer: Shows, last: Shows, liar: int
) -> None:
    assert (TACHOMETER_LIES, LAST_AXLE_LIES) == (1, 2)
    ride = Ride(12.0)
    list(ride.go(BRAKE_MPS2, 60.0, tachometer, last))
    assert ride.unit.speed_mps > 0.0
    list(ride.go(BRAKE_MPS2, 300.0, tachometer, last))
    assert ride.unit.liar == liar
    assert ride.unit.speed_mps == 0.0
    list(ride.go(POWER_MPS2, 10.0, tachometer, last))
    assert ride.unit.speed_mps == pytest.approx(ride.speed_mps)
    assert ride.out_m < 0.0


@pytest.mark.parametrize("begins_mps", [0.8, 4.0, 15.0])
def test_a_silent_tachometer_neither_makes_a_liar_of_the_other_axle_nor_a_stand_of_a_stop(
    begins_mps: float,
) -> None:
    ride = Ride(begins_mps)
    ride.unit.emergency = 1
    for out_m in ride.go(BRAKE_MPS2, begins_mps / -BRAKE_MPS2 + 60.0, times(0.0)):
        assert out_m <= PULSE_M
        assert ride.unit.speed_mps >= ride.speed_mps - 0.05
    assert len(ride.doubts_m) == (1 if begins_mps > 1.0 else 0) or ride.true_m < APART_M
    assert ride.unit.liar == 0
    assert ride.unit.bound_ahead_m < ride.true_m + 5.0


@pytest.mark.parametrize("last_step_mps", [0.001, 0.003, 0.0049, 0.03])
def test_the_last_pulses_of_a_stop_make_no_liar_of_the_axle_that_turns(last_step_mps: float) -> None:
    """Found in a random drill: taken for the liar in a stop, it was not believed as the train ran on over points."""
    ride = Ride(10.0 + last_step_mps)
    for mps2, seconds in ((POWER_MPS2, 0.0), (0.0, 2.0), (-1.0, 30.0), (POWER_MPS2, 20.0)):
        assert all(out_m < 0.0 for out_m in ride.go(mps2, seconds, tachometer=lambda _: 0.0))
    assert ride.unit.liar == 0
    assert ride.unit.speed_mps == pytest.approx(ride.speed_mps)
