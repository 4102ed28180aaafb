"""One round trip of the Karasuyama line: single faults of every kind, so that every few seconds something fails."""

from collections.abc import Callable, Sequence
from typing import Final

import pytest

from scenario.scenario import Scenario, load_scenario
from simulation.faults.devices import Restart
from simulation.faults.script import ScriptedFault, Trigger
from study.drilling.every_instant import InstantWindow, Variation
from study.drilling.moving import single_faults, staffed

Sweeps = Callable[[Scenario, Sequence[Variation], InstantWindow], list[str]]

pytestmark = [pytest.mark.nightly, pytest.mark.timeout(6 * 3600)]

EVERY_S: Final = 30.0  # of one fault; all of them take half an hour on two processors


def test_single_faults_of_every_kind_over_a_round_trip(bad_in: Sweeps) -> None:
    scenario = staffed(load_scenario("karasuyama_round_trip"))
    assert bad_in(scenario, single_faults(scenario.setup), InstantWindow(EVERY_S, staggered=True)) == []


def test_a_unit_that_starts_again_around_the_arrival_of_another_train(bad_in: Sweeps) -> None:
    """322M's unit on open line out of coverage, around the moment of the drill `karasuyama/28`."""
    scenario = load_scenario("karasuyama_round_trip")
    variation = Variation(
        "restart V1", ((0, ScriptedFault(Restart(target="V1"), Trigger())),), (), frozenset({"V1"})
    )
    window = InstantWindow(0.5, 6 * 3600.0 + 600.0, 6 * 3600.0 + 680.0)
    assert bad_in(scenario, (variation,), window) == []
