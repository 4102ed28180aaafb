"""Where trains get to know where they are, by what they carry, and which stops their drivers have to make on sight."""

from dataclasses import replace
from itertools import pairwise

import pytest

from network.model import Direction, MarkerGroup
from onboard.fixes import EYE_WITHIN_M
from scenario.scenario import load_scenario
from simulation.settings import PositionSensor
from simulation.setup import Setup
from simulation.world.roster import drawn_up
from study.feasibility.equipment import equipment_of
from study.feasibility.finding import Severity
from study.feasibility.fixes import (
    CURVATURE_WITHIN_M,
    MARKERS_WITHIN_M,
    PositionKnown,
    fixes_on,
    measured_growth,
)
from study.feasibility.planned import planned_day


@pytest.fixture(scope="module")
def setup() -> Setup:
    return load_scenario("karasuyama_round_trip").setup


def carrying(setup: Setup, carries: tuple[PositionSensor, ...]) -> Setup:
    return replace(setup, sensors=setup.sensors.model_copy(update={"carries": carries, "carries_of": {}}))


def fixes(setup: Setup, *carries: PositionSensor) -> tuple[PositionKnown, ...]:
    given = carrying(setup, carries)
    duty = drawn_up(given, given.line)["V2"][0]
    assert duty.mission.direction is Direction.DOWN
    return fixes_on(given, "V2", duty.mission)


def test_tags_tell_at_their_own_places(setup: Setup) -> None:
    duty = drawn_up(setup, setup.line)["V2"][0]
    told = fixes(setup, PositionSensor.TAGS)
    assert [fix.at_m for fix in told] == [tag.position_m for tag in duty.mission.tags]
    share, accuracy_m = measured_growth(setup.unit), setup.unit.tag_accuracy_m
    for before, fix in pairwise(told):
        assert fix.within_m == pytest.approx(accuracy_m + share * (fix.at_m - before.at_m))


def test_where_no_tag_may_lie_each_leaves_its_own_accuracy(setup: Setup) -> None:
    trusting = replace(setup, unit=setup.unit.model_copy(update={"tags_wrong_together": 0}))
    assert {fix.within_m for fix in fixes(trusting, PositionSensor.TAGS)} == {setup.unit.tag_accuracy_m}


def test_markers_tell_at_their_first_row(setup: Setup) -> None:
    mission = drawn_up(setup, setup.line)["V2"][0].mission
    piece_id, at_m = mission.path.locate(1000.0)
    groups = {
        number: MarkerGroup(number, number, piece_id, at_m, (direction,))
        for number, direction in enumerate(Direction, start=1)
    }
    laid = replace(setup, line=replace(setup.line, markers=groups))
    told = [fix for fix in fixes(laid, PositionSensor.LIDAR) if fix.within_m == MARKERS_WITHIN_M]
    assert [fix.at_m for fix in told] == pytest.approx([1000.0])


def test_satellites_tell_wherever_the_sky_is_open(setup: Setup) -> None:
    told = [fix for fix in fixes(setup, PositionSensor.GNSS) if fix.within_m != EYE_WITHIN_M]
    assert {fix.within_m for fix in told} == {setup.gnss.receiver.protection_m}
    assert len(told) > 300


def test_curvature_tells_behind_transition_curves(setup: Setup) -> None:
    told = [fix for fix in fixes(setup, PositionSensor.CURVATURE) if fix.within_m == CURVATURE_WITHIN_M]
    assert 20 < len(told) < 200
    alone = [fix for fix in fixes(setup, PositionSensor.LIDAR) if fix.within_m != EYE_WITHIN_M]
    assert alone == []


def brought(setup: Setup, *carries: PositionSensor) -> set[str]:
    """Stations to which a driver would have to bring his train on sight."""
    given = carrying(setup, carries)
    found = equipment_of(given, planned_day(given))
    told = [one for one in found if "on sight" in one.text]
    assert {one.severity for one in told} <= {Severity.TIGHT}
    return {one.place for one in told}


def test_a_train_that_sees_no_markers_is_brought_to_its_terminus_on_sight(setup: Setup) -> None:
    assert "KRS" in brought(setup, PositionSensor.LIDAR)


@pytest.mark.parametrize("carries", [PositionSensor.TAGS, PositionSensor.CURVATURE, PositionSensor.GNSS])
def test_others_come_to_their_marks_by_themselves(setup: Setup, carries: PositionSensor) -> None:
    assert brought(setup, carries) == set()
