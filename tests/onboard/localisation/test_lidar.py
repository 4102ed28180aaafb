"""The reader of the LiDAR: a pattern is a fix where the map has it, and nothing moves the estimate off the truth."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.localisation.fix import MISSED, NOTHING, REFUSED, TAKEN
from onboard.localisation.lidar import LAID_WITHIN_M, PASSED_BY_M, SEEN_WITHIN_MPS, SETBACK_M, lidar
from onboard.localisation.lidar_points import CYCLE_S, KEPT_S, SPOTS
from onboard.localisation.marker_patterns import HALF_M
from onboard.localisation.table import READERS_ROW, READINGS
from onboard.records import PATTERN, PLACE, PLACE_BEACON, PLACE_MARKERS, UNIT, Chart

STEP_S = 0.1
GROUPS = ((1000.0, 3), (1030.0, 9), (2000.0, 5), (2500.0, 3), (2800.0, 7))


class Ride:
    """A train at one speed over a map with `GROUPS`, seeing perfectly unless told otherwise."""

    def __init__(
        self, true_m: float, speed_mps: float, bound_m: float, error_m: float = 0.0, known: int = 1
    ) -> None:
        self.unit: Any = np.zeros(1, UNIT).view(np.recarray)[0]
        self.own: Any = np.zeros(1, READERS_ROW).view(np.recarray)[0].lidar
        self.own.fitted = 1
        places = [
            (PLACE_BEACON, 1010.0, 3, 1, 1, 0.0),
            *((PLACE_MARKERS, at_m, n, 1, 1, 0.0) for at_m, n in GROUPS),
        ]
        rows = np.array(sorted(places, key=lambda row: row[1]), dtype=PLACE)
        self.chart = Chart(np.zeros(1, dtype=PATTERN), rows)
        unit = self.unit
        unit.odometer_scale, unit.position_known, unit.paths_taken_up, unit.places_rows = (
            1.0,
            known,
            1,
            len(rows),
        )
        unit.position_m, unit.bound_ahead_m, unit.bound_behind_m = true_m + error_m, bound_m, bound_m
        unit.odometer_m = true_m
        self.true_m, self.speed_mps = true_m, speed_mps
        self.outcomes: list[int] = []

    def step(self, group_m: float, pattern: int, bears_m: float = 0.15) -> int:
        """One step nearer to markers at `group_m`, as they lie."""
        reading: Any = np.zeros(1, READINGS).view(np.recarray)[0].lidar
        run_m = self.speed_mps * STEP_S
        self.true_m += run_m
        self.unit.position_m += run_m
        self.unit.odometer_m += run_m
        ahead_m = group_m - self.true_m
        reading.looks, reading.pattern = int(0.0 < ahead_m < 34.0), pattern
        for k in range(SPOTS):
            row_m = ahead_m + (SPOTS - 1 - k) * CYCLE_S * self.speed_mps + SETBACK_M
            reading.row_m[k], reading.bears_m[k] = row_m, bears_m
            reading.run_m[k] = self.speed_mps * KEPT_S
            reading.mean_m[k] = row_m + HALF_M + 0.5 * KEPT_S * self.speed_mps
        outcome = int(lidar(self.own, reading, self.unit, self.chart, STEP_S))
        self.outcomes.append(outcome)
        return outcome

    def over(self, group_m: float, pattern: int, beyond_m: float = 0.0, **how: float) -> set[int]:
        """Run from before a group to `beyond_m` behind it."""
        self.outcomes = []
        while self.true_m < group_m + beyond_m:
            self.step(group_m, pattern, **how)
        return set(self.outcomes)

    @property
    def holds(self) -> bool:
        return (
            self.unit.position_m - self.unit.bound_behind_m - 1e-9
            <= self.true_m
            <= self.unit.position_m + self.unit.bound_ahead_m + 1e-9
        )


def test_a_pattern_where_the_map_has_it_is_a_fix() -> None:
    ride = Ride(1950.0, 10.0, 20.0, 7.0)
    assert ride.over(2000.0, 5) == {NOTHING, TAKEN}
    assert ride.unit.position_m == pytest.approx(ride.true_m, abs=0.05)
    assert ride.unit.bound_ahead_m + ride.unit.bound_behind_m < 2.0 * (LAID_WITHIN_M + 0.25 * SEEN_WITHIN_MPS)
    assert ride.holds


def test_a_pattern_of_another_place_is_refused() -> None:
    ride = Ride(1950.0, 10.0, 20.0, 7.0)
    before_m = float(ride.unit.position_m) - ride.true_m
    assert ride.over(2000.0, 7) == {NOTHING, REFUSED}
    assert float(ride.unit.position_m) - ride.true_m == pytest.approx(before_m)


def test_without_speed_nothing_is_read() -> None:
    """Markers that come into sight 8 m ahead are passed before both means are filled."""
    ride = Ride(1992.0, 10.0, 20.0)
    assert ride.over(2000.0, 5) == {NOTHING}


def test_points_that_bear_no_spread_are_not_read() -> None:
    assert Ride(1950.0, 10.0, 20.0).over(2000.0, 5, bears_m=-1.0) == {NOTHING}


def test_a_group_between_others_waits_for_one_that_agrees() -> None:
    """Within these bounds the train could be at either of the two groups 30 m apart."""
    ride = Ride(950.0, 10.0, 40.0, 10.0)
    assert ride.over(1000.0, 3) == {NOTHING, REFUSED}
    assert ride.unit.bound_ahead_m == 40.0
    ride.over(1030.0, 9)
    assert TAKEN in ride.outcomes
    assert ride.unit.position_m == pytest.approx(ride.true_m, abs=0.1)


def test_two_groups_laid_in_each_others_place_move_nothing() -> None:
    ride = Ride(950.0, 10.0, 40.0, 10.0)
    ride.over(1000.0, 9)
    ride.over(1030.0, 3)
    assert TAKEN not in ride.outcomes
    assert ride.holds


def test_who_does_not_know_its_place_finds_it_by_two_groups() -> None:
    ride = Ride(1950.0, 10.0, 0.0, 500.0, known=0)
    assert TAKEN not in ride.over(2000.0, 5)
    assert ride.unit.position_known == 0
    assert TAKEN in ride.over(2500.0, 3)
    assert ride.unit.position_known == 1
    assert ride.holds


def test_a_group_passed_unread_is_missed_once() -> None:
    ride = Ride(1940.0, 10.0, 1.0)
    ride.over(2000.0, 0)
    ride.outcomes = []
    while ride.true_m < 2000.0 + PASSED_BY_M + 15.0:
        ride.step(2500.0, 3)
    assert ride.outcomes.count(MISSED) == 1
    read = Ride(1940.0, 10.0, 1.0)
    read.over(2000.0, 5)
    read.outcomes = []
    while read.true_m < 2000.0 + PASSED_BY_M + 15.0:
        read.step(2500.0, 3)
    assert MISSED not in read.outcomes


def test_the_speed_is_told_once_both_means_are_filled_and_while_markers_are_seen() -> None:
    ride = Ride(1960.0, 10.0, 1.0)
    told: list[tuple[float, float, float]] = []
    while ride.true_m < 2003.0:
        ride.step(2000.0, 5)
        told.append((ride.true_m, float(ride.unit.seen_speed_mps), float(ride.unit.seen_within_mps)))
    first = next(at_m for at_m, _, within in told if within > 0.0)
    assert first == pytest.approx(1970.0 + 10.0, abs=2.0)  # from 30 m on, 49 cycles at 10 m/s
    assert all(speed == pytest.approx(10.0, abs=0.2) for _, speed, within in told if within > 0.0)
    assert told[-1][2] == 0.0


@given(
    group=st.sampled_from(GROUPS),
    laid=st.integers(1, 24),
    speed_mps=st.floats(2.0, 20.0),
    bound_m=st.floats(0.5, 200.0),
    error_share=st.floats(-1.0, 1.0),
    bears_m=st.floats(-1.0, 0.24),
)
def test_no_single_pattern_right_or_wrong_moves_the_estimate_off_the_truth(
    group: tuple[float, int], laid: int, speed_mps: float, bound_m: float, error_share: float, bears_m: float
) -> None:
    """Whatever pattern lies in a group's place."""
    ride = Ride(group[0] - 45.0, speed_mps, bound_m, error_share * bound_m)
    ride.over(group[0], laid, bears_m=bears_m)
    wrong_here = laid != group[1]
    if wrong_here and TAKEN in ride.outcomes:
        possible = [
            at_m for at_m, _ in GROUPS if abs(at_m - group[0] - error_share * bound_m) < bound_m + 1.0
        ]
        raise AssertionError(f"a wrong pattern was believed; possible: {possible}")
    assert ride.holds
