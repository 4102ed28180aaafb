"""The collector of circles runs rarely while a day runs, and as before afterwards."""

import gc
from collections.abc import Iterator

import pytest

from scenario.scenario import load_scenario
from study.runner.collector import MORE_OBJECTS
from study.runner.run import CarrierKind, PartyLink, execute

PYTHONS_OWN = (700, 10, 10)


@pytest.fixture
def _as_python_has_it() -> Iterator[None]:
    before = gc.get_threshold()
    gc.set_threshold(*PYTHONS_OWN)
    yield
    gc.set_threshold(*before)


@pytest.mark.usefixtures("_as_python_has_it")
def test_a_run_has_it_wait_for_more() -> None:
    found: list[int] = []

    def stop() -> bool:
        found.append(gc.get_threshold()[0])
        return True

    day = load_scenario("karasuyama_round_trip")
    execute(day, PartyLink.SIMULATED, carrier=CarrierKind.PLAIN, stop=stop)
    assert found == [MORE_OBJECTS]
    assert gc.get_threshold() == PYTHONS_OWN
