import math
from dataclasses import replace

import pytest

from network.model import Coverage, Line
from onboard.authority.coverage import WELL_INSIDE_M, covered_at, next_coverage_m
from onboard.mission import Mission


@pytest.fixture
def gap(rtri: Line) -> Line:
    """Covered only around the stations: no radio from 0.5 km to 0.7 km."""
    main = replace(rtri.alignments["main"], coverage=(Coverage(0.0, 500.0), Coverage(700.0, 1410.0)))
    return replace(rtri, alignments={"main": main})


def test_coverage_going_down(gap: Line, mission: Mission) -> None:
    begin_m, end_m = 700.0 - 360.0, 500.0 - 360.0  # the path begins at km 0.36, where section 3 does
    assert covered_at(gap, mission.path, end_m)
    assert not covered_at(gap, mission.path, end_m + 0.1)
    assert covered_at(gap, mission.path, begin_m)
    assert next_coverage_m(gap, mission.path, end_m + 0.1) == pytest.approx(begin_m + WELL_INSIDE_M)
    assert next_coverage_m(gap, mission.path, begin_m + 0.5) == pytest.approx(begin_m + WELL_INSIDE_M)
    assert next_coverage_m(gap, mission.path, begin_m + WELL_INSIDE_M) > begin_m + WELL_INSIDE_M


def test_coverage_going_up_begins_at_the_far_edge(gap: Line, back: Mission) -> None:
    begin_m = 1050.0 - 500.0
    assert next_coverage_m(gap, back.path, 400.0) == pytest.approx(begin_m + WELL_INSIDE_M)
    assert covered_at(gap, back.path, begin_m + WELL_INSIDE_M)


def test_no_coverage_ahead(gap: Line, mission: Mission) -> None:
    assert next_coverage_m(gap, mission.path, 341.0) == math.inf


def test_just_inside_a_stretch_it_is_still_the_next_one(gap: Line, mission: Mission) -> None:
    """Radio is awaited until well inside: who asks again in the last metre before that has it ahead of him."""
    begin_m = 700.0 - 360.0
    half_in_m = begin_m + 0.5 * WELL_INSIDE_M
    assert next_coverage_m(gap, mission.path, half_in_m) == pytest.approx(begin_m + WELL_INSIDE_M)
