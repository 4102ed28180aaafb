"""Drills with the certificate on: failures and persons do to a certified line what they do to any other.

What the drill expects comes about as without, nothing moves otherwise where nobody was in anybody's way, and the days
that the certificate keeps from a deadlock are kept from it too when the manager, a unit or a link fails meanwhile.
"""

from pathlib import Path
from typing import Final

import pytest

from onboard.duty_parameters import ReleaseRule
from scenario.scenario import Scenario, load_scenario
from simulation.result import Ending
from study.drilling.drill import find_drill, shipped_drills
from study.drilling.verdict import judge
from study.runner.outcome import unfinished
from study.runner.run import FinishedRun
from tests.nightly import others_nightly
from tests.plain import run_on_plain
from tests.system.test_sidings import certified, changes_nothing
from wayside.said import HeldBack

FEW: Final = (
    "rtri/09_manager_power",
    "rtri/14b_manager_and_units_on_open_line",
    "rtri/28_unit_restart_at_departure",
    "rtri/53b_two_wrong_persons",
)
ALL: Final = tuple(name for name in shipped_drills() if name.startswith("rtri/"))

DELAYS: Final = {
    "01b_one_siding_certified": "01_one_siding",
    "02b_two_sidings_certified": "02_two_sidings",
    "03b_two_loops_certified": "03_two_loops",
}
FAILURES: Final = {
    "manager": (
        '[[fault]]\nkind = "restart"\ntarget = "block-manager"\nstart = "{start}"\n'
        '[[act]]\nkind = "reenter_assisted"\nstart = "{start}"\nafter_s = 90.0\n'
    ),
    "unit": '[[fault]]\nkind = "restart"\ntarget = "S3"\nstart = "{start}"\n',
    "link": '[[fault]]\nkind = "cut"\ntarget = "S2 <-> block-manager"\nstart = "{start}"\nduration_s = 240.0\n',
}


def day(scenario: Scenario) -> FinishedRun:
    """The day on plain track."""
    return run_on_plain(scenario)


def unmet(run: FinishedRun) -> list[str]:
    """What the drill expected and did not come about."""
    verdicts = judge(run.scenario.setup.script.expectations, run.result, run.tables)
    return [f"{verdict.text}: {verdict.happened}" for verdict in verdicts if not verdict.passed]


@pytest.mark.timeout(1800)
@pytest.mark.parametrize("name", others_nightly(ALL, FEW[::2]))
def test_a_drill_of_the_paper_s_line_goes_as_without(name: str) -> None:
    """Without it orders of a dispatcher and parts of routes are not given: what has them goes as it is expected to."""
    scenario = load_scenario(find_drill(name))
    setup, with_it = scenario.setup, day(certified(scenario, on=True))
    if setup.dispatch.certificate or setup.operation.release is ReleaseRule.SECTION:
        assert (unmet(with_it), with_it.broken) == ([], ())
        return
    without = day(certified(scenario, on=False))
    assert unmet(with_it) == unmet(without)
    assert with_it.broken == without.broken
    assert unfinished(with_it.result) == unfinished(without.result)
    changes_nothing(without, with_it)


def failing_meanwhile(tmp_path: Path, name: str, failure: str, start: str) -> FinishedRun:
    """A day of the sidings on which something fails besides what makes it late."""
    late = Path(find_drill(f"sidings/{DELAYS[name]}")).read_text(encoding="utf-8")
    delay = late[late.index("[[fault]]") : late.index("[[expect]]")]
    file = tmp_path / "failing.toml"
    head = f'extends = "{find_drill(f"sidings/{name}")}"\nid = "failing"\n'
    file.write_text(head + delay + FAILURES[failure].format(start=start), encoding="utf-8")
    return day(load_scenario(str(file)))


def all_arrive(run: FinishedRun) -> None:
    assert run.result.ended_because is Ending.FINISHED
    assert (unmet(run), run.broken, unfinished(run.result)) == ([], (), ())
    assert any(isinstance(entry.event, HeldBack) for entry in run.result.journal.entries)


@pytest.mark.parametrize("failure", others_nightly(FAILURES, ["manager"]))
def test_all_arrive_when_something_fails_besides(tmp_path: Path, failure: str) -> None:
    all_arrive(failing_meanwhile(tmp_path, "03b_two_loops_certified", failure, "10:18"))


@pytest.mark.nightly
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("name", DELAYS)
@pytest.mark.parametrize("failure", FAILURES)
@pytest.mark.parametrize("start", ["10:05", "10:11", "10:25", "10:40", "11:00"])
def test_all_arrive_whenever_it_fails(tmp_path: Path, name: str, failure: str, start: str) -> None:
    all_arrive(failing_meanwhile(tmp_path, name, failure, start))
