"""Closed road and warnings: a journal whose figures are counted by hand, and what holds for every journal."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation.events import BarrierState
from simulation.journal import Journal
from study.collect.crossings import hours_of
from study.measures.road_closures import FrontAtCrossing, RoadClosure, roads_closed
from tests.study.collect.crossed import END_S, barriers, crossed, front, lamps


def test_a_road_is_closed_from_the_first_lamp_until_the_barriers_are_up() -> None:
    assert roads_closed(crossed().entries, END_S).closures == (
        RoadClosure("C1", 3580.0, 3628.0),
        RoadClosure("C1", 4000.0, 4128.0),
        RoadClosure("C2", 7190.0, 7240.0),
        RoadClosure("C4", 9000.0, END_S),
    )


def test_each_front_has_its_warning_and_a_start_within_it_is_told_apart() -> None:
    fronts = roads_closed(crossed().entries, END_S).fronts
    assert fronts == (
        FrontAtCrossing("C1", "K1", 3610.0, 10.0, warned_s=30.0, closed_s=15.0, ran_s=20.0),
        FrontAtCrossing("C1", "K2", 4035.0, 10.0, warned_s=35.0, closed_s=20.0, ran_s=1035.0),
        FrontAtCrossing("C1", "K1", 4060.0, 10.0, warned_s=60.0, closed_s=45.0, ran_s=470.0),
        FrontAtCrossing("C1", "K2", 4109.0, 10.0, warned_s=35.0, closed_s=20.0, ran_s=1109.0),
        FrontAtCrossing("C2", "K2", 7230.5, 10.0, warned_s=40.5, closed_s=None, ran_s=4230.5),
        FrontAtCrossing("C3", "K1", 7300.0, 10.0, warned_s=0.0, closed_s=None, ran_s=3710.0),
    )
    assert [one.from_stand for one in fronts] == [True, False, False, False, False, False]


def test_hours_by_hand() -> None:
    """C1: 20 s of 48 s lie before one o'clock, 28 s and 128 s after it; C2: 10 s of 50 s before two."""
    found = [
        (it.crossing, it.hour, it.closed_s, it.closures, it.closure_s_max, it.trains)
        for it in hours_of(roads_closed(crossed().entries, END_S), [("C1", 1), ("C1", 2), ("C5", 0)])
    ]
    assert found == [
        ("C1", 0, 20.0, 1, 48.0, 0),
        ("C1", 1, 156.0, 1, 128.0, 4),
        ("C1", 2, 0.0, 0, None, 0),  # nothing came: open for all of that hour
        ("C2", 1, 10.0, 1, 50.0, 0),
        ("C2", 2, 40.0, 0, None, 1),
        ("C3", 2, 0.0, 0, None, 1),
        ("C4", 2, 1000.0, 1, 1000.0, 0),
        ("C5", 0, 0.0, 0, None, 0),
    ]


def test_a_front_without_a_warning_counts_as_none_in_mean_and_least() -> None:
    journal = crossed()
    front(journal, 7400.0, "C2", "K1")
    found = {(it.crossing, it.hour): it for it in hours_of(roads_closed(journal.entries, END_S))}
    both, four = found["C2", 2], found["C1", 1]
    assert (both.warned_s_min, both.warned_s_mean, both.warned_s_max) == (0.0, pytest.approx(20.25), 40.5)
    assert (four.warned_s_min, four.warned_s_mean, four.warned_s_max) == (30.0, pytest.approx(40.0), 60.0)


_CHANGES = st.one_of(st.booleans(), st.sampled_from(BarrierState), st.just("front"))
_STEPS = st.tuples(st.integers(0, 60_000), st.sampled_from(("C1", "C2")), _CHANGES)


@given(st.lists(_STEPS, max_size=30), st.integers(0, 60_000))
def test_hours_add_up_to_the_closures_and_none_has_more_than_its_seconds(
    steps: list[tuple[int, str, bool | BarrierState | str]], rest_tenths: int
) -> None:
    journal, tenths = Journal(), 0
    for gap_tenths, crossing, change in steps:
        tenths += gap_tenths
        match change:
            case bool(lit):
                lamps(journal, tenths / 10.0, crossing, lit=lit)
            case BarrierState() as state:
                barriers(journal, tenths / 10.0, crossing, state)
            case _:
                front(journal, tenths / 10.0, crossing, "K1")
    end_s = (tenths + rest_tenths) / 10.0
    roads = roads_closed(journal.entries, end_s)
    hours = hours_of(roads)
    assert all(0.0 <= it.closed_s <= 3600.0 for it in hours)
    assert all(it.closed_s <= max(end_s - 3600.0 * it.hour, 0.0) + 0.05 for it in hours)
    assert sum(it.closed_s for it in hours) == pytest.approx(roads.closed_s, abs=0.05 * len(hours) + 0.01)
    assert sum(it.closures for it in hours) == len(roads.closures)
    assert sum(it.trains for it in hours) == len(roads.fronts)
    for crossing in ("C1", "C2"):
        own = [one for one in roads.closures if one.crossing_id == crossing]
        assert all(before.to_s <= after.from_s for before, after in pairwise(own))
