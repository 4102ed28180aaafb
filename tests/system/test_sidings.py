"""Lines on which trains get into each other's way: lost with who asks first, and not with the certificate.

Three trains and two loops, and the layouts of SUMO's reports 17834 and 17926. The drills come in pairs; each fails when
its certificate is switched off, or on.
"""

from dataclasses import replace
from typing import Final

import pytest

from scenario.scenario import Scenario, load_scenario
from simulation.result import Ending
from study.drilling.drill import find_drill, run_drill, shipped_drills
from study.measures.register_holds import section_holds
from study.measures.wait_text import text_of
from study.measures.waits import waits_of
from study.record.wait import Cause
from study.runner.run import FinishedRun, PartyLink
from tests.nightly import others_nightly
from tests.plain import drill_on_plain, run_on_plain
from wayside.said import Certified, Granted, HeldBack, NoOrderKnown

WITHOUT: Final = ("01_one_siding", "02_two_sidings", "03_two_loops")
WITH: Final = {
    "01b_one_siding_certified": "W2 waits for S3 to come to section ASA.1",
    "02b_two_sidings_certified": "B waits for S3 to come to section OKA.1",
    "03b_two_loops_certified": "D2 waits for S3 to come to section IZU.2",
}


def test_the_drills_come_in_pairs() -> None:
    shipped = {name.removeprefix("sidings/") for name in shipped_drills() if name.startswith("sidings/")}
    assert shipped == {*WITHOUT, *WITH}


@pytest.mark.nightly
@pytest.mark.parametrize("name", WITHOUT)
def test_without_the_certificate_nobody_gets_on(name: str) -> None:
    drill = drill_on_plain(f"sidings/{name}")
    assert drill.passed
    assert drill.run.result.ended_because is Ending.STALLED
    assert not any(isinstance(e.event, Certified | HeldBack) for e in drill.run.result.journal.entries)


@pytest.mark.parametrize("name", others_nightly(WITH, ["02b_two_sidings_certified"]))
def test_with_it_all_arrive_and_it_is_told_why_each_waited(name: str) -> None:
    drill = drill_on_plain(f"sidings/{name}")
    assert [f"{v.text}: {v.happened}" for v in drill.verdicts if not v.passed] == []
    assert drill.run.broken == ()
    held = [e.event for e in drill.run.result.journal.entries if isinstance(e.event, HeldBack)]
    assert held and all("could not all finish" in note.why for note in held)
    result, setup = drill.run.result, drill.run.scenario.setup
    found = waits_of(result, setup, section_holds(result, setup.line, setup.lengths_m))
    (told,) = {w.party: w for w in found if w.cause is Cause.NO_WAY_ON}.values()
    train, _, rest = WITH[name].partition(" waits ")
    assert (told.train, f"for {told.party} to come to section {told.section}") == (train, rest)
    assert "not all trains could still finish" in text_of(told).en


@pytest.mark.nightly
@pytest.mark.parametrize("name", WITH)
def test_each_drill_fails_with_the_certificate_switched_off(name: str) -> None:
    scenario = certified(load_scenario(find_drill(f"sidings/{name}")), on=False)
    assert run_on_plain(scenario).result.ended_because is Ending.STALLED


@pytest.mark.nightly
def test_the_manager_as_a_process_decides_alike() -> None:
    name = f"sidings/{next(iter(WITH))}"
    alone, process = (
        run_drill(name, link).run.result.digest for link in (PartyLink.SIMULATED, PartyLink.ZENOH)
    )
    assert alone == process


def certified(scenario: Scenario, *, on: bool) -> Scenario:
    """The scenario with the certificate on, or off."""
    dispatch = scenario.setup.dispatch.model_copy(update={"certificate": on})
    return replace(scenario, setup=replace(scenario.setup, dispatch=dispatch))


def kept_to_plan(name: str) -> tuple[FinishedRun, FinishedRun]:
    """A day without and with the certificate."""
    scenario = load_scenario(name)

    def day(on: bool) -> FinishedRun:
        return run_on_plain(certified(scenario, on=on))

    return day(on=False), day(on=True)


def changes_nothing(without: FinishedRun, with_it: FinishedRun) -> None:
    """The same motion; the journal has a certificate more for each grant, and nobody was held."""
    assert with_it.result.motion_digest == without.result.motion_digest
    notes = [entry.event for entry in with_it.result.journal.entries]
    granted, proven = ([n for n in notes if isinstance(n, kind)] for kind in (Granted, Certified))
    assert bool(proven) == bool(granted)
    assert not any(isinstance(note, HeldBack | NoOrderKnown) for note in notes)


def test_on_a_day_that_goes_as_planned_it_changes_nothing(turn_back: str) -> None:
    changes_nothing(*kept_to_plan(turn_back))


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["karasuyama_weekday", "busy_line", "isumi_weekday", "kururi_weekday"])
def test_nor_on_whole_days(name: str) -> None:
    changes_nothing(*kept_to_plan(name))
