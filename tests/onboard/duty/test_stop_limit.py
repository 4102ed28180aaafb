"""Section 2.2 of Sugiyama et al.: before the departure points, before the arrival points, on the track."""

from typing import Final

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from network.model import Position
from onboard.authority.records import Authority, OpenCommand
from onboard.duty.stop_limit import (
    cleared_sections,
    entered_on_proof,
    next_rear_span,
    points_perhaps_under,
    stop_limit,
)
from onboard.mission import Mission
from onboard.plan import DutyPlan, PointsNeeded, plan_of
from tests.onboard.duty.stage import P5, P7

ALL: Final = ("3", "5", "6", "7", "8")  # joints 0 to 4; the end of the path is joint 5


@pytest.fixture(scope="module")
def plan(mission: Mission) -> DutyPlan:
    return plan_of(mission, 40.0)


def authority(*section_ids: str, proven: tuple[PointsNeeded, ...] = ()) -> Authority:
    return Authority(held=section_ids, on_line=True, proven=proven)


@pytest.mark.parametrize(
    ("held", "proven", "joint", "before", "why"),
    [
        ((), (), 0, "3", "not held"),
        (("3",), (), 1, "5", "not held"),
        (ALL, (), 1, "5", "points not proven"),  # departure points
        (ALL, (P7,), 1, "5", "points not proven"),
        (ALL, (P5,), 3, "7", "points not proven"),  # arrival points
        (ALL, (P5, P7), 5, None, "end of the path"),  # the arrival track
        (("3", "5"), (P5,), 2, "6", "not held"),  # partly held
        (("3", "5", "7", "8"), (P5, P7), 2, "6", "not held"),  # never across a gap
        (("6", "7", "8"), (P7,), 5, None, "end of the path"),  # given back behind
        (("8",), (), 5, None, "end of the path"),
        (("99",), (), 0, "3", "not held"),
    ],
)
def test_stop_limit(
    plan: DutyPlan,
    held: tuple[str, ...],
    proven: tuple[PointsNeeded, ...],
    joint: int,
    before: str | None,
    why: str,
) -> None:
    limit = stop_limit(plan, authority(*held, proven=proven))
    assert (limit.joint, limit.before, limit.why) == (joint, before, why)


def test_a_gap_that_the_front_has_left_does_not_end_its_way(plan: DutyPlan) -> None:
    """Section 3 far behind, 6 and 7 given back, the front in 8; with its front short of 6 it stops there."""
    held = authority("3", "5", "8")
    assert stop_limit(plan, held, frozenset({"5"})).before == "6"
    assert stop_limit(plan, held, frozenset({"5"}), left=2).before == "6"
    assert stop_limit(plan, held, frozenset({"5"}), left=4).joint == len(plan.spans)


def test_a_proof_for_the_other_position_does_not_count(plan: DutyPlan) -> None:
    other = replace(P5, position=Position.REVERSE)
    assert stop_limit(plan, authority(*ALL, proven=(other, P7))).before == "5"


def test_points_entered_on_their_proof_hold_the_train_back_no_more(plan: DutyPlan) -> None:
    held = authority(*ALL)
    assert stop_limit(plan, held, frozenset({"5"})).before == "7"
    assert stop_limit(plan, authority("3"), frozenset({"5"})).before == "5"  # held they must be all the same


@given(held=st.sets(st.sampled_from(ALL)), proven=st.sets(st.sampled_from((P5, P7))))
def test_everything_before_the_limit_is_held_and_proven(
    plan: DutyPlan, held: set[str], proven: set[PointsNeeded]
) -> None:
    """From the first section held on; and one more section or proof never draws the limit nearer."""
    state = authority(*(s for s in ALL if s in held), proven=tuple(sorted(proven)))
    limit = stop_limit(plan, state)
    first = next((i for i, span in enumerate(plan.spans) if span.section_id in held), len(plan.spans))
    for span in plan.spans[first : limit.joint]:
        assert span.section_id in held
        assert set(span.points) <= proven
    assert stop_limit(plan, replace(state, proven=(P5, P7))).joint >= limit.joint
    if first == 0:
        assert stop_limit(plan, replace(state, held=ALL)).joint >= limit.joint


def test_sections_that_the_safe_rear_has_left(plan: DutyPlan) -> None:
    state = authority("3", "6", "7", "8")
    assert [cleared_sections(plan, state, clear) for clear in range(6)] == [
        (),
        ("3",),
        ("3",),
        ("3", "6"),
        ("3", "6", "7"),
        ("3", "6", "7", "8"),
    ]


def test_the_span_that_the_rear_leaves_next(plan: DutyPlan) -> None:
    assert next_rear_span(plan, authority(*ALL), 5) == 0
    assert next_rear_span(plan, authority("6", "7", "8"), 5) == 2
    assert next_rear_span(plan, authority("8"), 5) is None  # the last one is kept
    assert next_rear_span(plan, authority(), 5) is None


@pytest.mark.parametrize(("freed", "rear"), [(0, None), (2, None), (3, 2), (4, 2)])
def test_no_rear_is_watched_before_a_tag_proves_its_section_to_be_behind(
    plan: DutyPlan, freed: int, rear: int | None
) -> None:
    assert next_rear_span(plan, authority("6", "7", "8"), freed) == rear


def test_before_a_section_not_swept_it_stops_and_then_passes_it_on_sight(plan: DutyPlan) -> None:
    state = replace(authority(*ALL, proven=(P5, P7)), unswept=("6", "7"))
    limit = stop_limit(plan, state)
    assert (limit.joint, limit.before, limit.why) == (2, "6", "to be passed on sight")
    assert stop_limit(plan, state, sweeps=True).joint == len(plan.spans)
    first = replace(state, unswept=("3",))  # a train that stands in it already
    assert stop_limit(plan, first).joint == 0
    assert stop_limit(plan, replace(state, proven=()), sweeps=True).before == "5"  # points all the same


@pytest.mark.parametrize(
    ("sure", "proven", "entered"),
    [
        (1, (P5, P7), set()),
        (2, (P5, P7), {"5"}),
        (2, (P7,), set()),
        (4, (P5, P7), {"5", "7"}),
        (5, (P7,), {"7"}),
    ],
)
def test_points_that_the_front_surely_came_onto_by_their_proof(
    plan: DutyPlan, sure: int, proven: tuple[PointsNeeded, ...], entered: set[str]
) -> None:
    assert entered_on_proof(plan, authority(*ALL, proven=proven), sure) == entered


@pytest.mark.parametrize(("perhaps", "under"), [(1, ()), (2, ("5",)), (3, ("5",)), (4, ("5", "7"))])
def test_points_under_way_that_the_front_may_be_on(
    plan: DutyPlan, perhaps: int, under: tuple[str, ...]
) -> None:
    throwing = replace(authority(*ALL), commands=(OpenCommand(P5, sent=True), OpenCommand(P7)))
    assert points_perhaps_under(plan, throwing, perhaps) == under
    assert points_perhaps_under(plan, authority(*ALL), perhaps) == ()
