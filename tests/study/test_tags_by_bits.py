"""A line run that reads its tags bit by bit (`[sensors] tags = "bits"`)."""

from dataclasses import replace

import pytest

from onboard.notes import PositionFault, TagRead
from scenario.scenario import load_scenario
from simulation.events import TagPassed
from study.runner.run import FinishedRun
from tests.nightly import others_nightly
from tests.plain import drill_on_plain, run_on_plain


def _run(**sensors: object) -> FinishedRun:
    scenario = load_scenario("rtri_test_line", 1)
    setup = replace(scenario.setup, sensors=scenario.setup.sensors.model_copy(update=sensors))
    return run_on_plain(replace(scenario, setup=setup))


def test_a_run_that_reads_bits_goes_as_one_that_reads_ids() -> None:
    """At table 7's rates a passage fails once in millions."""
    assert _run(tags="bits").result.motion_digest == _run().result.motion_digest


def test_a_run_whose_tags_cannot_be_read_stops_its_trains_and_breaks_nothing() -> None:
    run = _run(tags="bits", tag_bit_error_factor=1000.0)
    assert [entry for entry in run.result.journal.entries if isinstance(entry.event, PositionFault)]
    assert run.result.violations == ()
    assert run.result.collisions == ()
    assert run.result.motion_digest != _run().result.motion_digest


@pytest.mark.parametrize("line", others_nightly(["rtri", "karasuyama"], ["rtri"]))
def test_in_noise_tags_are_missed_and_none_is_read_as_another(line: str) -> None:
    drill = drill_on_plain(f"{line}/45_tags_by_bits")
    passed = [
        (e.t_s, e.event.unit_id, e.event.tag_id)
        for e in drill.run.result.journal.entries
        if isinstance(e.event, TagPassed)
    ]
    read = [
        (e.t_s, e.who, e.event.tag_id)
        for e in drill.run.result.journal.entries
        if isinstance(e.event, TagRead)
    ]
    assert set(read) < set(passed)
    faults = {e.event.why for e in drill.run.result.journal.entries if isinstance(e.event, PositionFault)}
    assert not {why for why in faults if why.endswith("where none can be")}
    assert drill.run.broken == ()
