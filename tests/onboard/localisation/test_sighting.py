"""A frame of the camera as a fix: intervals are cut, never moved off the truth; a sign not seen is told."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.localisation.fix import MISSED, NOTHING, REFUSED, TAKEN
from onboard.localisation.sighting import (
    CONTRADICTIONS,
    EXPOSED_WITHIN_S,
    FLOOR_M,
    LENS_OVER_SIGN_M,
    NOT_SEEN_M,
    PITCH_BOUND_RAD,
    SIGN_BEYOND_MARK_M,
    accuracy_m,
    front_by_frame,
    sign,
)
from onboard.localisation.table import READER_NAMES, READERS_ROW, READINGS, ReadersRow, ReadingsRow, read_all
from onboard.records import EVENT_FIX, NO_PLACES, PATTERN, Chart, UnitRow
from simulation.sensors.line_sightings import PLACES_M, line_sightings

MARK_M = 500.0
STEP_S = 0.1
LATEST_S = max(float(figures.exposed_after_s.max()) for figures in line_sightings().values())
CHART = Chart(np.zeros(1, dtype=PATTERN), NO_PLACES)  # signs go by neither


def going_by_sign() -> ReadersRow:
    readers: ReadersRow = np.zeros(1, READERS_ROW).view(np.recarray)[0]
    readers.sign.mark_m = MARK_M
    return readers


def frame(distance_m: float) -> ReadingsRow:
    readings: ReadingsRow = np.zeros(1, READINGS).view(np.recarray)[0]
    readings.sign.taken, readings.sign.distance_m = 1, distance_m
    return readings


def stands_at(unit: UnitRow, position_m: float, bound_m: float) -> None:
    unit.position_m, unit.bound_ahead_m, unit.bound_behind_m = position_m, bound_m, bound_m


@given(
    true_m=st.floats(425.0, 500.0),
    estimate_share=st.floats(-1.0, 1.0),
    bound_m=st.floats(0.01, 40.0),
    seen_share=st.floats(-1.0, 1.0),
    speed_mps=st.floats(0.0, 20.0),
)
def test_the_true_front_stays_within_the_bounds(
    unit: UnitRow,
    true_m: float,
    estimate_share: float,
    bound_m: float,
    seen_share: float,
    speed_mps: float,
) -> None:
    stands_at(unit, true_m + estimate_share * bound_m, bound_m)
    unit.train_mps, unit.fix_correction_m = speed_mps, 0.0
    before_m = float(unit.position_m)
    real_m = MARK_M + SIGN_BEYOND_MARK_M - true_m
    slack_m = accuracy_m(real_m, speed_mps)
    shown_m = real_m + 0.5 * seen_share * slack_m  # the slack is that at the distance shown, so half of it
    readers = going_by_sign()
    assert sign(readers.sign, frame(shown_m).sign, unit, CHART, STEP_S) == TAKEN
    assert unit.fix_correction_m == pytest.approx(unit.position_m - before_m)
    assert unit.position_m - unit.bound_behind_m <= true_m + 1e-9
    assert true_m - 1e-9 <= unit.position_m + unit.bound_ahead_m
    assert unit.bound_ahead_m + unit.bound_behind_m <= 2.0 * bound_m + 1e-9


def test_what_cannot_be_is_not_believed(unit: UnitRow) -> None:
    stands_at(unit, 450.0, 1.0)
    # it would be at 480 m
    assert sign(going_by_sign().sign, frame(30.0).sign, unit, CHART, STEP_S) == REFUSED
    assert unit.position_m == 450.0


def test_near_the_mark_a_sign_never_seen_is_missed_and_one_seen_once_is_not(unit: UnitRow) -> None:
    own = going_by_sign().sign
    stands_at(unit, MARK_M - NOT_SEEN_M - 1.0, 1.0)
    assert sign(own, frame(np.inf).sign, unit, CHART, STEP_S) == NOTHING
    unit.position_m += 2.0
    assert sign(own, frame(np.inf).sign, unit, CHART, STEP_S) == MISSED
    assert sign(own, frame(MARK_M + SIGN_BEYOND_MARK_M - unit.position_m).sign, unit, CHART, STEP_S) == TAKEN
    assert sign(own, frame(np.inf).sign, unit, CHART, STEP_S) == NOTHING


@pytest.mark.parametrize("change", ["no frame", "no mark", "no position"])
def test_without_frame_mark_or_position_there_is_no_fix(unit: UnitRow, change: str) -> None:
    stands_at(unit, 450.0, 30.0)
    readers, readings = going_by_sign(), frame(60.0)
    match change:
        case "no frame":
            readings.sign.taken = 0
        case "no mark":
            readers.sign.mark_m = np.inf
        case _:
            unit.position_known = 0
    before = (float(unit.position_m), int(unit.position_known))
    assert sign(readers.sign, readings.sign, unit, CHART, STEP_S) == NOTHING
    assert (float(unit.position_m), int(unit.position_known)) == before


def test_an_event_tells_that_something_else_came_of_the_readings(unit: UnitRow) -> None:
    readers, number = going_by_sign(), READER_NAMES.index("sign")
    stands_at(unit, 450.0, 3.0)
    none: Any = np.zeros(1, READINGS).view(np.recarray)[0]
    course = [(none, NOTHING, 0), (frame(60.0), TAKEN, EVENT_FIX), (frame(60.0), TAKEN, 0)]
    course += [(frame(20.0), REFUSED, EVENT_FIX), (none, REFUSED, 0), (frame(60.0), TAKEN, EVENT_FIX)]
    for readings, outcome, event in course:
        assert read_all(readers, readings, unit, CHART, STEP_S) == event
        assert readers.outcome[number] == outcome


def test_what_a_fix_moved_is_kept_beside_its_outcome(unit: UnitRow) -> None:
    readers, number = going_by_sign(), READER_NAMES.index("sign")
    stands_at(unit, 450.0, 3.0)
    read_all(readers, frame(59.0), unit, CHART, STEP_S)
    assert readers.moved_m[number] == pytest.approx(unit.position_m - 450.0)
    assert 0.0 < readers.moved_m[number] <= 1.0


def test_near_the_mark_a_sign_is_as_good_as_a_tag() -> None:
    """Oda, table 1: about 0.1 m; a tag here counts as 0.5 m."""
    assert accuracy_m(SIGN_BEYOND_MARK_M, 0.0) < 0.25
    assert accuracy_m(70.0, 12.0) > 1.0


def test_a_sighting_moves_the_estimate_and_no_end_of_the_bounds(unit: UnitRow) -> None:
    stands_at(unit, 450.0, 5.0)
    readers = going_by_sign()
    assert sign(readers.sign, frame(57.0).sign, unit, CHART, STEP_S) == TAKEN
    assert 450.5 < unit.position_m < 453.5
    assert unit.position_m - unit.bound_behind_m == pytest.approx(445.0)
    assert unit.position_m + unit.bound_ahead_m == pytest.approx(455.0)


def test_what_contradicts_the_sightings_before_is_refused_until_the_third_in_a_row(unit: UnitRow) -> None:
    """The estimate is sure to a decimetre or two by then, its bounds are not: one false frame moves nothing."""
    readers = going_by_sign()
    stands_at(unit, 485.0, 20.0)
    for _ in range(5):
        assert sign(readers.sign, frame(25.0).sign, unit, CHART, STEP_S) == TAKEN
    settled_m = float(unit.position_m)
    for false in range(CONTRADICTIONS - 1):
        assert sign(readers.sign, frame(12.0 + false).sign, unit, CHART, STEP_S) == REFUSED
        assert unit.position_m == settled_m
    assert sign(readers.sign, frame(25.0).sign, unit, CHART, STEP_S) == TAKEN  # which begins the count anew
    outcomes = [sign(readers.sign, frame(12.0).sign, unit, CHART, STEP_S) for _ in range(CONTRADICTIONS)]
    assert outcomes == [REFUSED] * (CONTRADICTIONS - 1) + [TAKEN]
    assert unit.position_m == pytest.approx(498.0, abs=0.5)


def test_a_tag_sets_the_estimate_anew(unit: UnitRow) -> None:
    """Whatever sightings had come to: its interval is what is left, and the next sighting is weighed against that."""
    readers = going_by_sign()
    stands_at(unit, 480.0, 20.0)
    for _ in range(5):
        sign(readers.sign, frame(30.0).sign, unit, CHART, STEP_S)
    assert readers.sign.slack_m < 3.0
    stands_at(unit, 476.5, 0.5)  # as a tag leaves it
    nothing: Any = np.zeros(1, READINGS).view(np.recarray)[0]
    sign(readers.sign, nothing.sign, unit, CHART, STEP_S)
    assert readers.sign.slack_m == pytest.approx(0.5)
    unit.bound_ahead_m += 0.1  # as the tachometer widens it
    unit.bound_behind_m += 0.1
    sign(readers.sign, nothing.sign, unit, CHART, STEP_S)
    assert readers.sign.slack_m == pytest.approx(0.6)


@given(
    true_m=st.floats(400.0, 500.0),
    speed_mps=st.floats(0.0, 25.0),
    pitch_share=st.floats(-1.0, 1.0),
    exposed_share=st.floats(0.0, 1.0),
)
def test_the_front_lies_where_a_frame_says_whatever_row_and_pitch(
    unit: UnitRow, true_m: float, speed_mps: float, pitch_share: float, exposed_share: float
) -> None:
    """By geometry: the sign's row by pinhole, exposed at any moment of the time allowed, with any pitch allowed."""
    unit.train_mps = speed_mps
    sign_m = MARK_M + SIGN_BEYOND_MARK_M
    exposed_m = sign_m - true_m - speed_mps * exposed_share * LATEST_S
    if exposed_m < 1.0:
        return
    shown_m = LENS_OVER_SIGN_M / (LENS_OVER_SIGN_M / exposed_m - pitch_share * PITCH_BOUND_RAD)
    front_m, within_m = front_by_frame(unit, sign_m, shown_m)
    # the bound's slope is taken at the distance shown: what is left over of second order is part of the pitch's own
    second_m = (PITCH_BOUND_RAD / LENS_OVER_SIGN_M) ** 2 * max(shown_m, exposed_m) ** 3
    assert abs(front_m - true_m) <= within_m + second_m - FLOOR_M + 1e-9


def test_rows_are_exposed_within_the_time_allowed() -> None:
    """In every light, at every place where a frame is looked at: readout of the row, and half of the exposure."""
    for figures in line_sightings().values():
        for place_m, after_s in zip(PLACES_M, figures.exposed_after_s, strict=True):
            assert 0.0 < after_s <= EXPOSED_WITHIN_S, place_m
