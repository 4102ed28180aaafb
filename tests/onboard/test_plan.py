"""From a mission to its plan: what each tag proves to be behind the train, and what a driver sees at a mark."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import Direction, SectionKind, TagPurpose
from network.timetable import Call, Stabled, TimetableTrain
from onboard.mission import Mission, plan_mission
from onboard.plan import DutyPlan, plan_of

LENGTH_M = 40.0
lengths_m = st.floats(15.0, 120.0)


@pytest.fixture(scope="module")
def over_halts() -> Mission:
    """Down the Karasuyama line from Hoshakuji to Ogane, calling at a halt on open line between them."""
    line = load_line(shipped_line("karasuyama"))
    calls = (Call("HSK", None, None, 0), Call("NIT", None, 300, 360), Call("OGN", None, 900, None))
    train = TimetableTrain("T", Direction.DOWN, True, calls, Stabled(), Stabled())
    return plan_mission(line, train, "HSK.1", None, None)


def spans_behind(mission: Mission, rear_m: float) -> int:
    return sum(span.end_m <= rear_m for span in mission.spans)


@given(length_m=lengths_m)
def test_a_tag_proves_only_what_the_whole_train_has_left(mission: Mission, length_m: float) -> None:
    """The front is over the tag, so the rear is a train's length behind; the reader's field counts against it."""
    for tag, laid in zip(plan_of(mission, length_m).tags, mission.tags, strict=True):
        assert tag.tag_id == laid.tag_id
        assert tag.clear <= spans_behind(mission, laid.position_m - length_m)
        assert tag.clear >= spans_behind(mission, laid.position_m - length_m - 1.0)


def test_tags_prove_more_the_further_the_train_has_come(mission: Mission, over_halts: Mission) -> None:
    for one in (mission, over_halts):
        clear = [tag.clear for tag in plan_of(one, LENGTH_M).tags]
        assert clear == sorted(clear)


def test_the_arrival_tag_proves_the_points_to_be_behind(mission: Mission) -> None:
    """Tag 801 lies at 632 m of the path, section 7 ends at 580 m: figure 3's (1) frees all behind section 8."""
    (arrival,) = [
        t for t in plan_of(mission, LENGTH_M).tags if t.purpose is TagPurpose.ARRIVAL and t.tag_id == 801
    ]
    assert arrival.clear == 4
    long = plan_of(mission, 632.0 - 580.0)  # its rear is just over the joint
    assert next(tag for tag in long.tags if tag.tag_id == 801).clear == 3
    assert next(tag for tag in long.tags if tag.tag_id == 803).clear == 4  # 658 m, before the mark


def test_where_tags_up_to_the_mark_prove_all_behind_it_the_odometer_does_not_count(mission: Mission) -> None:
    assert [stop.by_eye for stop in plan_of(mission, LENGTH_M).stops] == [False, False]


def test_where_no_tag_up_to_the_mark_proves_it_the_driver_must_see(mission: Mission) -> None:
    without = replace(mission, tags=tuple(tag for tag in mission.tags if tag.position_m < 600.0))
    begins, ends = plan_of(without, LENGTH_M).stops
    assert ends.by_eye
    assert not begins.by_eye  # nothing is behind that could be freed
    beyond = replace(
        mission, tags=(*without.tags, replace(mission.tags[-1], position_m=mission.targets[1].mark_m + 1))
    )
    assert plan_of(beyond, LENGTH_M).stops[1].by_eye  # a tag that is read only after the stop


@given(length_m=lengths_m)
def test_at_a_mark_a_driver_sees_no_more_behind_than_there_is(mission: Mission, length_m: float) -> None:
    """Its front may be some metres short of the mark."""
    for stop, target in zip(plan_of(mission, length_m).stops, mission.targets, strict=True):
        assert stop.clear <= spans_behind(mission, target.mark_m - length_m - 5.0)


def test_at_a_halt_on_open_line_nothing_is_freed(over_halts: Mission) -> None:
    plan = plan_of(over_halts, LENGTH_M)
    halts = [stop for stop in plan.stops if plan.spans[stop.span].kind is SectionKind.BETWEEN]
    assert [stop.place for stop in halts] == ["NIT"]
    mark_m = over_halts.targets[1].mark_m
    assert spans_behind(over_halts, mark_m - 100.0) > 0  # there would be something
    assert [(stop.clear, stop.by_eye) for stop in halts] == [(0, False)]
    assert plan.stops[-1].clear > 0


def test_the_route_from_where_a_train_stands(over_halts: Mission, mission: Mission) -> None:
    """On its track the one that begins there, at a halt the one that leads through, at the end none."""
    plan = plan_of(over_halts, LENGTH_M)
    out, halt, end = (plan.leg_at(stop.span) for stop in plan.stops)
    assert out is not None
    assert out == halt
    assert plan.spans[plan.stops[1].span].section_id in out.section_ids
    assert end is None
    paper = plan_of(mission, LENGTH_M)
    assert [None if (leg := paper.leg_at(i)) is None else leg.route_id for i in range(5)] == [
        *["3>8"] * 4,
        None,
    ]


def test_a_train_longer_than_the_way_frees_nothing(mission: Mission) -> None:
    plan: DutyPlan = plan_of(mission, math.ceil(mission.path.length_m))
    assert {tag.clear for tag in plan.tags} == {stop.clear for stop in plan.stops} == {0}
