"""Section 2.2 of Sugiyama et al.: before the departure points, before the arrival points, on the track."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Position
from onboard.authority.machine import Authority, Held, PointsNeeded
from onboard.authority.stop_limit import (
    arrival_points,
    cleared_sections,
    departure_points,
    next_rear_trigger_m,
    points_of,
    stop_limit,
)
from onboard.duty.mission import Mission

# Path coordinates of mission T1 begin at km 0.36, where section 3 does (rtri_test_line.toml).
END_OF_3_M, START_OF_7_M, END_OF_7_M, END_OF_8_M = 110.0, 520.0, 580.0, 690.0
P5 = PointsNeeded("P5", Position.NORMAL, "5", "A-E")
P7 = PointsNeeded("P7", Position.NORMAL, "7", "B-W")
ALL = ("3", "5", "6", "7", "8")


def authority(*section_ids: str, proven: tuple[PointsNeeded, ...] = ()) -> Authority:
    return Authority("V1", "BM", held=tuple(Held(s, 1) for s in section_ids), on_line=True, proven=proven)


@pytest.mark.parametrize(
    ("held", "proven", "limit_m", "before"),
    [
        ((), (), 0.0, "3"),
        (("3",), (), END_OF_3_M, "5"),
        (ALL, (), END_OF_3_M, "5"),  # departure points
        (ALL, (P7,), END_OF_3_M, "5"),
        (ALL, (P5,), START_OF_7_M, "7"),  # arrival points
        (ALL, (P5, P7), END_OF_8_M, None),  # the arrival track
        (("3", "5"), (P5,), 170.0, "6"),  # partly held
        (("3", "5", "7", "8"), (P5, P7), 170.0, "6"),  # never across a gap
        (("6", "7", "8"), (P7,), END_OF_8_M, None),  # given back behind
        (("8",), (), END_OF_8_M, None),
        (("99",), (), 0.0, "3"),
    ],
)
def test_stop_limit(
    mission: Mission,
    held: tuple[str, ...],
    proven: tuple[PointsNeeded, ...],
    limit_m: float,
    before: str | None,
) -> None:
    limit = stop_limit(mission, authority(*held, proven=proven))
    assert limit.limit_m == pytest.approx(limit_m)
    assert limit.before_section == before


def test_a_proof_for_the_other_position_does_not_count(mission: Mission) -> None:
    other = replace(P5, position=Position.REVERSE)
    assert stop_limit(mission, authority(*ALL, proven=(other, P7))).before_section == "5"


@given(held=st.sets(st.sampled_from(ALL)), proven=st.sets(st.sampled_from((P5, P7))))
def test_everything_before_the_limit_is_held_and_proven(
    mission: Mission, held: set[str], proven: set[PointsNeeded]
) -> None:
    """From the first section held on; and one more section or proof never draws the limit nearer."""
    state = authority(*(s for s in ALL if s in held), proven=tuple(sorted(proven, key=str)))
    limit = stop_limit(mission, state)
    begun = [span for span in mission.spans if span.section_id in held]
    if begun:
        inside = [s for s in mission.spans if begun[0].start_m <= s.start_m and s.end_m <= limit.limit_m]
        assert all(s.section_id in held and set(points_of(s)) <= proven for s in inside)
    proven_all = replace(state, proven=(P5, P7))
    assert stop_limit(mission, proven_all).limit_m >= limit.limit_m


def test_departure_and_arrival_points(mission: Mission) -> None:
    assert departure_points(mission, "3") == (P5,)
    assert departure_points(mission, "8") == ()
    assert arrival_points(mission, 310.0) == (P7,)  # at the approach tag
    assert arrival_points(mission, END_OF_7_M) == ()


def test_sections_are_given_back_once_the_safe_rear_has_left_them(mission: Mission) -> None:
    state = authority(*ALL)
    assert cleared_sections(mission, state, END_OF_3_M - 0.001) == ()
    assert cleared_sections(mission, state, END_OF_3_M) == ("3",)
    assert cleared_sections(mission, state, END_OF_7_M) == ("3", "5", "6", "7")
    assert next_rear_trigger_m(mission, state) == END_OF_3_M
    assert next_rear_trigger_m(mission, authority("6", "7", "8")) == START_OF_7_M
    assert next_rear_trigger_m(mission, authority("8")) == float("inf")
