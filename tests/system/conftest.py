"""Switches that take one behaviour away, by name, and the runs in which the tests of this folder use them.

A switch patches the function that carries the behaviour; pytest puts it back. `MISBEHAVIOUR` is not a defect of ours
but what somebody else does wrong, against whom a behaviour protects.
"""

import pytest

from scenario.scenario import load_scenario
from study.drilling.drill import find_drill, shipped_drills
from study.drilling.verdict import judge
from study.runner.run import CarrierKind, FinishedRun, PartyLink, execute
from tests.plain import carrier_of
from tests.system import (  # noqa: F401 - they enter themselves
    switches_crossings,
    switches_on_board,
    switches_radio,
    switches_wayside,
    switches_wide,
)
from tests.system.switchboard import FOLDER, SWITCHES, RunWith, Switch


@pytest.fixture(scope="session")
def switch_names() -> frozenset[str]:
    return frozenset(SWITCHES)


@pytest.fixture
def run_with(monkeypatch: pytest.MonkeyPatch) -> RunWith:
    """Run a scenario or drill with switches thrown; the run, and who objects: checkers, unmet expectations.

    On plain track, which takes half of the time: that SUMO carries the same run is `test_defects`' to say. With a road,
    which SUMO alone carries, on that.
    """

    def run(
        scenario: str, *switches: str | Switch, carrier: CarrierKind | None = None
    ) -> tuple[FinishedRun, set[str]]:
        for given in switches:
            if given:
                throw = SWITCHES[given] if isinstance(given, str) else given
                throw(monkeypatch)
        file = FOLDER / f"{scenario}.toml"
        name = str(file) if file.is_file() else scenario
        loaded = load_scenario(find_drill(name) if name in shipped_drills() else name)
        done = execute(loaded, PartyLink.SIMULATED, carrier=carrier or carrier_of(loaded))
        verdicts = judge(loaded.setup.script.expectations, done.result, done.tables)
        return done, {v.checker for v in done.result.violations} | {v.text for v in verdicts if not v.passed}

    return run
