"""Drills: every one shipped on the test line is met, is the same each time and with real processes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from network.errors import InputError
from simulation.events import MANAGER, WORLD, Author, authors_of
from study.run.drill import Drill, find_drill, run_drill, shipped_drills
from study.run.run import Link, terminals_of
from study.scenario.scenario import load_scenario

RTRI = [name for name in shipped_drills() if name.startswith("rtri/")]
KARASUYAMA = [name for name in shipped_drills() if name.startswith("karasuyama/")]


@pytest.mark.parametrize("name", shipped_drills())
def test_a_shipped_drill_demands_safety_and_arrival_besides_its_own(name: str) -> None:
    scenario = load_scenario(find_drill(name))
    properties = {e.holds.value for e in scenario.setup.script.expectations if e.holds is not None}
    assert {"everyone_arrives", "no_invariant_broken"} <= properties
    assert scenario.id == name.replace("/", "_")


@pytest.mark.system
@pytest.mark.parametrize("name", RTRI)
def test_every_drill_on_the_test_line_is_met(name: str) -> None:
    drill = run_drill(name, Link.SIMULATED)
    assert [f"{v.text}: {v.happened}" for v in drill.verdicts if not v.passed] == []
    assert drill.run.broken == ()
    setup = drill.run.scenario.setup
    writers = {
        **dict.fromkeys(drill.run.result.stock_ids, Author.UNIT),
        **dict.fromkeys(terminals_of(setup.line), Author.TERMINAL),
        MANAGER: Author.MANAGER,
        WORLD: Author.WORLD,
    }
    for entry in drill.run.result.journal.entries:
        assert writers.get(entry.who, Author.PERSON) in authors_of(type(entry.event)), entry


@pytest.mark.system
@pytest.mark.parametrize("name", ["karasuyama/09_manager_power", "karasuyama/33_links_flip"])
def test_a_disturbed_day_is_met(name: str) -> None:
    drill = run_drill(name, Link.SIMULATED)
    assert [f"{v.text}: {v.happened}" for v in drill.verdicts if not v.passed] == []
    assert drill.run.broken == ()


def digest(drill: Drill) -> str:
    return drill.run.result.digest


@pytest.mark.system
@pytest.mark.parametrize(
    "name", ["rtri/09_manager_power", "rtri/12_terminal_power", "rtri/24_manager_frozen"]
)
def test_a_drill_is_the_same_with_processes_that_are_killed(name: str) -> None:
    assert digest(run_drill(name, Link.ZENOH)) == digest(run_drill(name, Link.SIMULATED))


@pytest.mark.system
def test_another_seed_is_another_run_and_the_same_seed_the_same() -> None:
    name = "rtri/27_slippery_rail"
    assert digest(run_drill(name, Link.SIMULATED, 2)) == digest(run_drill(name, Link.SIMULATED, 2))
    assert digest(run_drill(name, Link.SIMULATED, 2)) != digest(run_drill(name, Link.SIMULATED, 3))


@pytest.mark.system
def test_an_expectation_not_met_is_told_and_fails_the_drill(tmp_path: Path) -> None:
    file = tmp_path / "tried.toml"
    file.write_text(
        'extends = "rtri_test_line"\nid = "tried"\n'
        '[[expect]]\ntext = "it breaks"\nevent = { who = "K1", what = "position_fault" }\n'
    )
    drill = run_drill(str(file), Link.SIMULATED)
    assert not drill.passed
    told = json.loads(json.dumps(drill.as_dict()))
    assert told["expectations"] == [{"text": "it breaks", "passed": False, "happened": "never happened"}]


def test_a_drill_that_does_not_exist_is_refused() -> None:
    with pytest.raises(InputError, match="shipped drill"):
        find_drill("rtri/99_nothing")


def test_days_are_shipped_for_the_threats_to_transmission() -> None:
    assert {name.split("_", 1)[1] for name in KARASUYAMA if name.split("/")[1] >= "30"} == {
        "links_delayed",
        "links_duplicate",
        "links_reorder",
        "links_flip",
        "links_loss",
    }
