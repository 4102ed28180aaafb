"""The study of level crossings, on slices of its days: by contacts the run from there, by radio the bounds."""

from dataclasses import replace

import pytest

from documents.crossings_study import WarningBefore, warnings_of
from documents.studies import scenario_of
from scenario.scenario import load_scenario
from study.report.data import ReportedRun
from study.runner.run import PartyLink, execute
from tests.nightly import others_nightly

UNTIL_S = 21_600.0  # 06:00: the first trains
CONTACT_M = 632.0  # 35 s at 65 km/h


def first_trains(name: str) -> list[WarningBefore]:
    scenario = load_scenario(scenario_of(f"level_crossings/{name}"))
    scenario = replace(scenario, setup=replace(scenario.setup, until_s=UNTIL_S))
    run = execute(scenario, PartyLink.SIMULATED)
    return warnings_of(ReportedRun(run.scenario.setup.line, run.scenario.setup.timetable, run.tables))


def test_by_contacts_a_warning_lasts_as_long_as_the_way_from_there() -> None:
    """No train is faster than 65 km/h, so none warns for less than 35 s. Far from any stop one has run from the
    contact on at about the speed that it has at the road.
    """
    found = first_trains("by_contacts")
    assert len(found) > 10
    for one in found:
        assert one.run_s is not None
        assert one.warned_s >= one.run_s - 0.2
        assert one.warned_s >= CONTACT_M / (65.0 / 3.6) - 0.2
    even = [one for one in found if one.crossing_id in ("X02", "X09") and not one.from_stand]
    assert len(even) >= 2
    for one in even:
        assert one.warned_s == pytest.approx(CONTACT_M / one.speed_mps, rel=0.05)


@pytest.mark.parametrize("name", others_nightly(["by_tags", "by_gnss"], ["by_gnss"]))
def test_by_radio_it_is_constant_to_a_second_and_the_bound_over_the_speed(name: str) -> None:
    """And for a train that is as far ahead as its bound, so long; the ministry's least is 25 s."""
    found = first_trains(name)
    settled = [one for one in found if one.settled]
    assert len(settled) > 10
    assert all(one.constant for one in settled)
    assert min(one.warned_s for one in found) >= 25.0
    longer_s = [one.warned_s - one.wanted_s for one in settled]
    bounds_s = [one.beyond_m / one.speed_mps for one in settled]
    assert max(bounds_s) > 1.0
    assert sum(longer_s) / len(longer_s) == pytest.approx(sum(bounds_s) / len(bounds_s), abs=0.7)


def test_what_is_longer_by_more_than_a_second_and_its_bound_is_not_constant() -> None:
    one = WarningBefore(
        37.9, 35.0, 10.0, settled=True, from_stand=False, beyond_m=20.0, run_s=None, crossing_id="C", at_s=0.0
    )
    assert one.constant
    assert not replace(one, warned_s=38.1).constant
    assert not replace(one, beyond_m=18.0).constant
    assert not replace(one, warned_s=33.9).constant
