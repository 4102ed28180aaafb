"""The accidents as they were happen where and when they did, and do not happen otherwise: published figures alone."""

from __future__ import annotations

from dataclasses import replace

import pytest

from documents.accidents import ACCIDENTS, CHANGES, SHIGARAKI, Accident, meeting_of, published_km, refusals, run_of
from scenario.scenario import load_scenario
from simulation.events import SignalPassed
from simulation.judge.log import Checker
from study.drilling.drill import find_drill
from tests.nightly import others_nightly

pytestmark = pytest.mark.system


@pytest.mark.parametrize("accident", ACCIDENTS, ids=lambda accident: accident.name)
def test_it_happens_as_it_was_by_acts_and_equipment(accident: Accident) -> None:
    scenario = load_scenario(find_drill(accident.as_it_was))
    result = run_of(scenario)
    meeting = meeting_of(result, scenario.setup.line)
    assert meeting is not None
    assert abs(meeting.at_s - accident.at_s) <= accident.within_s
    assert 1000.0 * abs(meeting.km - accident.km) <= accident.within_m
    assert {v.checker for v in result.violations} >= {Checker.ONE_TRAIN_A_SECTION.value}


OTHERWISE = [
    (accident, label)
    for accident in ACCIDENTS
    for label, drill in accident.ways.items()
    if drill != accident.as_it_was
]


@pytest.mark.parametrize(("accident", "label"), others_nightly(OTHERWISE, OTHERWISE[:2], columns=True))
def test_worked_otherwise_nothing_collides(accident: Accident, label: str) -> None:
    scenario = load_scenario(find_drill(accident.ways[label]))
    result = run_of(scenario)
    assert meeting_of(result, scenario.setup.line) is None
    assert not [v for v in result.violations if v.checker != Checker.EVERYONE_ARRIVES.value]
    if scenario.setup.line_signals is None:
        assert len(result.trains_arrived) == len(result.trains_planned)
        assert any(said.startswith("block-manager refused") for said in refusals(result))


def test_the_signal_that_an_act_sets_is_what_lets_a_train_go() -> None:
    """Without the act at Kibukawa, 501D stands there; nothing but acts, equipment and physics moves a train."""
    scenario = load_scenario(find_drill(SHIGARAKI.as_it_was))
    settings = scenario.setup.line_signals
    assert settings is not None
    acts = tuple(act for act in settings.act if act.who != "signalman KBK")
    setup = replace(
        scenario.setup, line_signals=settings.model_copy(update={"act": acts}), until_s=10.6 * 3600.0
    )
    result = run_of(replace(scenario, setup=setup))
    passed = {e.event.unit_id for e in result.journal.entries if isinstance(e.event, SignalPassed)}
    assert passed == {"SKR"}


def test_kilometres_are_those_that_are_published() -> None:
    line = load_scenario("shigaraki_1991").setup.line
    stations = {"KBK": 0.0, "ONT": 6.5, "SKG": 9.6, "SGR": 14.7}
    for station, km in stations.items():
        own_km = line.stations[station].position_m / 1000.0
        assert published_km(line, own_km) == pytest.approx(km)


@pytest.mark.nightly
@pytest.mark.parametrize("accident", ACCIDENTS, ids=lambda accident: accident.name)
def test_it_rests_on_no_single_figure(accident: Accident) -> None:
    """Each change that the study shows moves the collision by less than two minutes, and none undoes it."""
    scenario = load_scenario(find_drill(accident.as_it_was))
    for change in CHANGES[accident.name].values():
        setup = change(scenario.setup)
        meeting = meeting_of(run_of(replace(scenario, setup=setup)), setup.line)
        assert meeting is not None
        assert abs(meeting.at_s - accident.at_s) < 120.0
