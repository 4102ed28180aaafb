"""The accidents as they were happen where and when they did, and do not happen otherwise: published figures alone."""

from dataclasses import replace

import polars as pl
import pytest

from documents.accidents import (
    ACCIDENTS,
    BAD_AIBLING,
    FILE,
    ROOT,
    SHIGARAKI,
    Accident,
    kilometres,
    meeting_of,
    refusals,
    run_of,
)
from scenario.scenario import load_scenario
from simulation.events import SignalPassed
from simulation.judge.log import Checker
from simulation.line_signals_settings import LineSignals
from simulation.setup import Setup
from study.runner.run import FinishedRun
from tests.nightly import others_nightly
from tests.plain import drill_on_plain


def run_as_expected(name: str) -> FinishedRun:
    """The drill's run, all that it expects being met."""
    drill = drill_on_plain(name)
    assert [f"{v.text}: {v.happened}" for v in drill.verdicts if not v.passed] == []
    return drill.run


@pytest.mark.parametrize("accident", ACCIDENTS, ids=lambda accident: accident.name)
def test_it_happens_as_it_was_by_acts_and_equipment(accident: Accident) -> None:
    run = run_as_expected(accident.as_it_was)
    meeting = meeting_of(run)
    assert meeting is not None
    assert abs(meeting.at_s - accident.at_s) <= accident.within_s
    assert 1000.0 * abs(meeting.km - accident.km) <= accident.within_m
    assert {v.checker for v in run.result.violations} >= {Checker.ONE_TRAIN_A_SECTION.value}
    assert f"| as it was | **{meeting.words(accident)}** |" in (ROOT / FILE).read_text("utf-8")


OTHERWISE = [
    drill for accident in ACCIDENTS for drill in accident.ways.values() if drill != accident.as_it_was
]
EVERY_RUN = ("shigaraki/04_detector_works", "mangfall/03_by_the_centre")


@pytest.mark.parametrize("drill", others_nightly(OTHERWISE, EVERY_RUN))
def test_worked_otherwise_nothing_collides(drill: str) -> None:
    run = run_as_expected(drill)
    assert meeting_of(run) is None
    assert not [v for v in run.result.violations if v.checker != Checker.EVERYONE_ARRIVES.value]
    if run.scenario.setup.line_signals is None:
        assert len(run.result.trains_arrived) == len(run.result.trains_planned)
        assert any(said.startswith("block-manager refused") for said in refusals(run))


def test_past_a_substitute_aspect_a_train_is_slow_over_the_points() -> None:
    run = run_of(BAD_AIBLING.as_it_was)
    rows = run.tables.trajectory.filter(pl.col("unit") == "ET325")
    clear_m = run.scenario.setup.line.pieces["AIB-KOL"].from_m + run.scenario.setup.lengths_m["ET325"]
    over_points = rows.filter(pl.col("kilometrage_m") < clear_m)["speed_mps"].to_numpy() * 3.6
    assert 38.0 < over_points.max() < 41.0  # power takes 0.9 s to end; 45 km/h by the points alone
    assert rows["speed_mps"].to_numpy().max() * 3.6 > 80.0


def test_the_signal_that_an_act_sets_is_what_lets_a_train_go() -> None:
    """Without the act at Kibukawa, 501D stands there; nothing but acts, equipment and physics moves a train."""

    def without(setup: Setup) -> Setup:
        settings = setup.line_signals
        assert isinstance(settings, LineSignals)
        acts = tuple(act for act in settings.act if act.who != "signalman KBK")
        return replace(setup, line_signals=settings.model_copy(update={"act": acts}), until_s=10.6 * 3600.0)

    run = run_of(SHIGARAKI.as_it_was, without)
    passed = {e.event.unit_id for e in run.result.journal.entries if isinstance(e.event, SignalPassed)}
    assert passed == {"SKR"}


def test_kilometres_are_those_that_are_published() -> None:
    own, official = kilometres(load_scenario("shigaraki_1991").setup.line)
    assert official == [0.0, 6.5, 9.6, 10.2, 12.4, 13.4, 14.7]
    assert own == pytest.approx(official, abs=0.15)


@pytest.mark.nightly
@pytest.mark.parametrize("accident", ACCIDENTS, ids=lambda accident: accident.name)
def test_it_rests_on_no_single_figure(accident: Accident) -> None:
    """Each change that the study shows moves the collision by less than two minutes, and none undoes it."""
    for change in accident.changes.values():
        meeting = meeting_of(run_of(accident.as_it_was, change))
        assert meeting is not None
        assert abs(meeting.at_s - accident.at_s) < 120.0
