"""Beacons by interval and window (Harada, 2.2): what is used, what fails, and what may never move the bounds."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.localisation.beacons import MISSES, BeaconReading, BeaconsRow, BeaconWindow, beacons
from onboard.localisation.fix import FOREIGN, MISSED, NOTHING, REFUSED, TAKEN
from onboard.localisation.table import READERS_ROW, READINGS
from onboard.records import PATTERN, PLACE, PLACE_BEACON, PLACE_MARKERS, UNIT, Chart, UnitRow
from vehicle.record import put_settings

STEP_S = 0.1
STEP_M = 2.0
GROWTH = 0.02
# A, then X that nobody goes by, B, C, D: intervals of 440, 600 and 520 m as in table 1 and figure 1.
A_M, X_M, B_M, C_M, D_M = 300.0, 670.0, 740.0, 1340.0, 1860.0
DATABASE = ((A_M, 1), (X_M, 0), (B_M, 1), (C_M, 1), (D_M, 1))


@dataclass
class Ride:
    """A unit that goes by beacons; `over` is by how much its wheels count too much."""

    unit: UnitRow
    own: BeaconsRow
    chart: Chart
    true_m: float = 0.0

    def step(
        self, run_m: float, over_m: float = 0.0, number: int | None = None, beyond_m: float = -1.0
    ) -> int:
        """Run on, count `over_m` too much, notice a beacon `beyond_m` ago (negative: none)."""
        unit = self.unit
        self.true_m += run_m
        unit.odometer_m += run_m + over_m
        unit.position_m += run_m + over_m
        unit.bound_ahead_m += GROWTH * run_m
        unit.bound_behind_m += GROWTH * run_m + over_m
        reading: Any = np.zeros(1, READINGS).view(np.recarray)[0].beacons
        if beyond_m >= 0.0:
            reading.noticed, reading.odometer_m = 1, unit.odometer_m - beyond_m
            reading.told, reading.number = int(number is not None), number or 0
        return self.read(reading)

    def read(self, reading: BeaconReading) -> int:
        return beacons(self.own, reading, self.unit, self.chart, STEP_S)

    def run_to(self, at_m: float, there_m: Sequence[float], over_share: float = 0.0) -> list[int]:
        """Run on to a place; beacons lie at `there_m`. What came of them and of windows."""
        outcomes = list[int]()
        while self.true_m < at_m:
            passed = [p for p in there_m if self.true_m < p <= self.true_m + STEP_M]
            beyond_m = self.true_m + STEP_M - passed[0] if passed else -1.0
            outcomes.append(self.step(STEP_M, over_share * STEP_M, None, beyond_m))
        return [outcome for outcome in outcomes if outcome != NOTHING]

    @property
    def error_m(self) -> float:
        return float(self.unit.position_m) - self.true_m

    @property
    def out_m(self) -> float:
        return max(
            -self.error_m - float(self.unit.bound_ahead_m), self.error_m - float(self.unit.bound_behind_m)
        )


def ride(
    database: Sequence[tuple[float, int]] = DATABASE,
    *,
    told: bool = False,
    trusts: bool = False,
    bound_m: float = 2.0,
) -> Ride:
    unit: Any = np.zeros(1, UNIT).view(np.recarray)[0]
    unit.position_known = unit.paths_taken_up = 1
    unit.bound_ahead_m = unit.bound_behind_m = bound_m
    unit.odometer_scale, unit.bound_growth = 1.0, GROWTH
    places = np.array(
        [
            (PLACE_MARKERS, 10.0, 1, 1, 1, 0.0),
            *((PLACE_BEACON, m, 7 + i, told, u, 0.0) for i, (m, u) in enumerate(database)),
        ],
        dtype=PLACE,
    )
    unit.places_rows = places.size
    own: Any = np.zeros(1, READERS_ROW).view(np.recarray)[0].beacons
    own.fitted, own.trusts = 1, int(trusts)
    put_settings(own.settings, BeaconWindow())
    made = Ride(unit, own, Chart(np.zeros(1, dtype=PATTERN), places))
    made.step(0.0)
    return made


THERE_M = tuple(m for m, _ in DATABASE)


@pytest.mark.parametrize("trusts", [True, False])
def test_on_wheels_that_count_a_little_too_much_every_beacon_corrects(trusts: bool) -> None:
    on = ride(trusts=trusts)
    assert on.run_to(2000.0, THERE_M, over_share=0.01) == [TAKEN] * 4
    assert abs(on.error_m) < 3.0
    assert on.own.misses == 0


def test_what_is_noticed_before_the_window_counts_for_nothing() -> None:
    on = ride(trusts=True)
    assert on.run_to(600.0, (A_M, 400.0, 500.0)) == [TAKEN]
    assert abs(on.error_m) < 1e-9


def test_figure_1_slipping_wheels_have_x_taken_for_b_and_two_misses_end_it() -> None:
    on = ride(trusts=True)
    assert on.run_to(A_M + STEP_M, THERE_M) == [TAKEN]
    assert on.run_to(B_M + 10.0, THERE_M, over_share=0.12) == [TAKEN]  # 44 m over at X: inside B's window
    assert on.error_m == pytest.approx(B_M - X_M, abs=12.0)
    assert on.out_m > 50.0  # and nobody knows
    assert on.run_to(C_M + 10.0, THERE_M) == []
    assert on.own.misses == 1
    assert on.run_to(D_M + 200.0, THERE_M) == [MISSED]
    assert on.run_to(4000.0, (2300.0, 2400.0, 3000.0)) == []  # it is over
    on.unit.paths_taken_up += 1  # another path: it begins anew
    on.step(0.0)
    assert (on.own.misses, on.own.failed_on) == (0, 1)


def test_bounded_the_same_slip_misleads_the_estimate_and_leaves_the_bounds() -> None:
    on = ride()
    on.run_to(A_M + STEP_M, THERE_M)
    before = on.unit.position_m - on.unit.bound_behind_m
    on.run_to(D_M + 200.0, THERE_M, over_share=0.12)
    assert on.out_m <= 0.0
    assert before < on.true_m


def test_bounded_a_beacon_where_the_bounds_do_not_reach_is_refused_and_the_right_one_taken() -> None:
    on = ride()
    on.run_to(B_M - 40.0, (A_M,))
    # in the window of 44 m, where the train cannot be yet
    assert on.run_to(B_M - 20.0, (B_M - 30.0,)) == [REFUSED]
    assert on.run_to(B_M + 10.0, (B_M,)) == [TAKEN]
    assert abs(on.error_m) < 1.0


def test_one_missed_window_is_no_failure() -> None:
    on = ride(trusts=True)
    assert on.run_to(2000.0, (A_M, C_M, D_M)) == [TAKEN] * 3
    assert MISSES == 2


def test_a_window_of_the_file_counts_before_the_rule() -> None:
    on = ride(trusts=True)
    on.chart.places["window_m"][3] = 15.0  # of B, whose rule gives 44 m
    assert on.run_to(B_M + 50.0, (A_M, B_M - 20.0)) == [TAKEN]
    assert on.own.misses == 1


def test_without_a_position_nothing_is_matched_until_a_place_is_known() -> None:
    on = ride(trusts=True)
    on.unit.position_known = 0
    assert on.run_to(A_M + 10.0, THERE_M) == []
    on.unit.position_known = 1
    assert on.run_to(B_M + 10.0, (B_M,)) == [TAKEN]


def test_a_train_without_a_receiver_goes_by_none() -> None:
    on = ride(trusts=True)
    on.own.fitted = 0
    assert on.run_to(2000.0, THERE_M) == []


def test_a_number_is_a_place_and_cuts_the_bounds() -> None:
    on = ride(told=True)
    on.run_to(B_M - 1.0, ())
    assert on.own.misses == 1  # A was silent
    outcome = on.step(2.0, 0.0, 9, 0.5)
    assert outcome == TAKEN
    assert abs(on.error_m) <= 3.1
    assert on.out_m <= 0.0
    assert on.unit.bound_ahead_m + on.unit.bound_behind_m < 7.0


@pytest.mark.parametrize(("short_m", "long_m"), [(1.5, 0.0), (0.0, 1.5)])
def test_a_number_read_in_a_step_that_may_be_counted_wrongly_leaves_room_for_that(
    short_m: float, long_m: float
) -> None:
    """With 1 m of the receiver, 2 m of the place, and 1.5 m to the side where wheels that slide may have gone."""
    on = ride(told=True, bound_m=50.0)
    on.run_to(B_M, ())
    on.unit.step_short_m, on.unit.step_long_m = short_m, long_m
    assert on.step(0.0, 0.0, 9, 0.0) == TAKEN
    low_m = on.unit.position_m - on.unit.bound_behind_m
    assert (low_m, on.unit.position_m + on.unit.bound_ahead_m) == pytest.approx(
        (B_M - 3.0 - long_m, B_M + 3.0 + short_m)
    )


def test_numbers_that_the_database_has_not_are_told_and_those_that_nobody_goes_by_are_not() -> None:
    on = ride(told=True)
    assert on.step(1.0, 0.0, 99, 0.0) == FOREIGN
    assert on.step(1.0, 0.0, 8, 0.0) == NOTHING  # X
    assert on.step(1.0, 0.0, 9, 0.0) == REFUSED  # B, far off


def test_a_number_tells_the_place_to_a_unit_that_has_none() -> None:
    on = ride(told=True)
    on.unit.position_known, on.true_m = 0, B_M
    assert on.step(0.0, 0.0, 9, 0.0) == TAKEN
    assert on.unit.position_known == 1
    assert on.out_m <= 0.0


@given(
    there_m=st.lists(st.floats(20.0, 1900.0), max_size=12),
    over_share=st.floats(-0.02, 0.3),
    bound_m=st.floats(0.5, 150.0),
)
def test_beacons_without_numbers_never_move_the_bounds(
    there_m: list[float], over_share: float, bound_m: float
) -> None:
    """Whatever lies on the track, and however wheels slip: the interval stays as wheels alone have it."""
    on, alone = ride(bound_m=bound_m), ride(bound_m=bound_m)
    counted = max(over_share, 0.0)
    on.run_to(2000.0, there_m, counted)
    alone.run_to(2000.0, (), counted)
    for ride_ in (on, alone):
        assert ride_.out_m <= 1e-6
    for sign, bound in ((1.0, "bound_ahead_m"), (-1.0, "bound_behind_m")):
        end_m = on.unit.position_m + sign * getattr(on.unit, bound)
        assert end_m == pytest.approx(alone.unit.position_m + sign * getattr(alone.unit, bound), abs=1e-6)
