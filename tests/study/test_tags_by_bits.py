"""A line run that reads its tags bit by bit (`[sensors] tags = "bits"`)."""

from __future__ import annotations

from dataclasses import replace

import pytest

from onboard.notes import PositionFault
from study.run.run import CarrierKind, Link, Run, execute
from study.scenario.scenario import load_scenario

pytestmark = pytest.mark.system


def _run(**sensors: object) -> Run:
    scenario = load_scenario("rtri_test_line", 1)
    setup = replace(scenario.setup, sensors=scenario.setup.sensors.model_copy(update=sensors))
    return execute(replace(scenario, setup=setup), Link.SIMULATED, carrier=CarrierKind.PLAIN)


def test_a_run_that_reads_bits_goes_as_one_that_reads_ids() -> None:
    """At table 7's rates a passage fails once in millions."""
    assert _run(tags="bits").result.motion_digest == _run().result.motion_digest


def test_a_run_whose_tags_cannot_be_read_stops_its_trains_and_breaks_nothing() -> None:
    run = _run(tags="bits", tag_bit_error_factor=1000.0)
    assert [entry for entry in run.result.journal.entries if isinstance(entry.event, PositionFault)]
    assert run.result.violations == ()
    assert run.result.collisions == ()
    assert run.result.motion_digest != _run().result.motion_digest
