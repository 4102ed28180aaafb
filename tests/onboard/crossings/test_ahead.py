"""The crossings of a path in metres and seconds: section 3 of the test line begins at 0.36 km, so that the road of 6 m
at 0.75 km lies from 387 to 393 m of the path of T1.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from network.model import CrossingClass, CrossingControl, Direction, LevelCrossing, Line
from onboard.crossings.ahead import CrossingsAhead, no_contact_passed
from onboard.crossings.machine import CrossingPlace
from onboard.mission import Mission
from onboard.motion import UnitMotion

ROAD_M, WIDTH_M, LENGTH_M = 387.0, 6.0, 40.0
CROSSING = LevelCrossing(
    "C", "C", CrossingClass.BARRIERS, CrossingControl.RADIO, "6", 750.0, WIDTH_M, 8.0, 15.0, 20.0
)


@pytest.fixture
def ahead(
    at_start: Callable[[], UnitMotion], monkeypatch: pytest.MonkeyPatch, rtri: Line, mission: Mission
) -> CrossingsAhead:
    """Those of T1's path, its train where the test puts it."""
    motion = at_start()
    monkeypatch.setattr(motion.crossings, "_by_radio", [CROSSING])
    motion.crossings.take_up(mission)
    motion.row.bound_ahead_m = motion.row.bound_behind_m = 3.0
    return motion.crossings


def place_at(ahead: CrossingsAhead, position_m: float, speed_mps: float = 10.0) -> CrossingPlace:
    row = ahead._row
    row.position_m, row.speed_mps = position_m, speed_mps
    places = ahead.places(0.0)
    assert places is not None
    return places[0]


def test_its_place_on_the_path_and_the_plan(ahead: CrossingsAhead) -> None:
    """In the third span (3, 5, 6), behind the stop at A; the times are those of the line."""
    place = place_at(ahead, 200.0)
    assert (place.crossing_id, place.span, place.stop) == ("C", 2, 0)
    assert (place.warning_s, place.closing_s, place.least_s) == (35.0, 15.0, 15.0)
    assert ahead.nearer(690.0, "C") == ROAD_M - 2.0
    assert ahead.nearer(300.0, "C") == 300.0
    assert ahead.nearer(690.0, "") == 690.0


@pytest.mark.parametrize(
    ("position_m", "entered", "under", "beyond", "clear"),
    [
        (381.9, False, False, False, False),  # with its bound 0.1 m short of where it must stop
        (382.1, True, False, False, False),
        (390.1, True, True, False, False),
        (396.1, True, True, True, False),
        (ROAD_M + WIDTH_M + LENGTH_M + 2.9, True, True, True, False),
        (ROAD_M + WIDTH_M + LENGTH_M + 3.1, True, True, True, True),
    ],
)
def test_bounds_count_against_the_train(
    ahead: CrossingsAhead, position_m: float, entered: bool, under: bool, beyond: bool, clear: bool
) -> None:
    place = place_at(ahead, position_m)
    assert (place.entered, place.under, place.beyond, place.clear) == (entered, under, beyond, clear)


def test_the_front_may_come_as_soon_as_its_bound_says(ahead: CrossingsAhead) -> None:
    """Held at 10 m/s it needs a second for 10 m, and 3 m of bound are 0.3 s; faster, it is there before."""
    ahead._row.cruise_mps = 10.0
    before, after = place_at(ahead, 200.0), place_at(ahead, 210.0)
    assert before.arrives_s == pytest.approx((ROAD_M - 203.0) / 10.0, abs=0.3)
    assert before.arrives_s - after.arrives_s == pytest.approx(1.0, abs=0.01)
    assert before.fastest_s < before.arrives_s
    ahead._row.bound_ahead_m = 33.0
    wide = place_at(ahead, 200.0)
    assert before.arrives_s - wide.arrives_s == pytest.approx(3.0, abs=0.02)


def test_who_is_faster_than_meant_is_there_as_soon_as_it_rolls(ahead: CrossingsAhead) -> None:
    """At 10 m/s where 8 are meant: it does not brake to these, and nothing but its resistance makes it slower."""
    ahead._row.cruise_mps = 8.0
    place = place_at(ahead, 200.0)
    assert (ROAD_M - 203.0) / 10.0 <= place.arrives_s < (ROAD_M - 203.0) / 9.5


def test_it_must_know_before_it_would_brake(ahead: CrossingsAhead) -> None:
    """From 10 m/s at 0.6 m/s^2: 8.3 s to lose the speed at half of it, 2 s of the brake, 26 m of room."""
    ahead._row.cruise_mps = 10.0
    place = place_at(ahead, 200.0)
    assert place.arrives_s - place.proof_s == pytest.approx(10.0 / 1.2 + 2.0 + 26.0 / 10.0, abs=0.05)


def test_it_clears_when_its_safe_rear_does(ahead: CrossingsAhead) -> None:
    """At 400 m its safe rear is at 357 m, 36 m before the far edge."""
    assert not place_at(ahead, 400.0).clear
    assert ahead.clears_at_m() == pytest.approx(393.0)
    assert not place_at(ahead, 435.9).clear
    assert place_at(ahead, 436.0).clear
    assert ahead.clears_at_m() == math.inf
    assert ahead.places(0.0) == ()  # it has been told
    assert not place_at(ahead, 435.0).clear
    assert place_at(ahead, 436.0).clear


def test_what_is_under_the_train_stays_under_it_when_it_turns(ahead: CrossingsAhead, back: Mission) -> None:
    """Its front is at 410 m, its rear at 370 m: turned, it has that edge of the road 17 m behind its new front."""
    place_at(ahead, 410.0, 0.0)
    row = ahead._row
    row.position_m = back.path.to_path_m("6", 750.0 - 3.0 + 23.0 - LENGTH_M)
    ahead.take_up(replace(back))
    place = place_at(ahead, float(row.position_m), 0.0)
    assert place.under
    assert not place.clear


@pytest.mark.parametrize(("start_m", "unwarned"), [(439.0, True), (441.0, False)])
def test_a_contact_warns_of_a_train_that_begins_before_it(
    mission: Mission, back: Mission, start_m: float, unwarned: bool
) -> None:
    """T1 begins at 440 m; who came over the contact as the train before, the same way, has been warned of."""
    starts_m = {Direction.DOWN: start_m, Direction.UP: 1200.0}
    crossing = replace(CROSSING, control=CrossingControl.CONTACTS, starts_m=starts_m)
    assert no_contact_passed(crossing, mission, None) is unwarned
    assert no_contact_passed(crossing, mission, back) is unwarned
    assert no_contact_passed(crossing, mission, mission) is unwarned
