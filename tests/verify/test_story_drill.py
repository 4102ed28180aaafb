"""Stories of the exploration told on a running line, where SUMO and the judge find what the search found."""

from functools import cache
from pathlib import Path
from shutil import copytree
from typing import Final

import pytest

from scenario.scenario import load_scenario
from study.record.directory import reserved
from study.runner.run import end_room_bytes, fill_run
from tests.nightly import others_nightly
from tests.plain import drill_on_plain, run_on_plain
from verify.evidence import story_drill
from verify.evidence.story_drill import DAY, DRILL, LINE, TIMES, UntoldError, broken_by, told_on_line
from verify.explore import ExploredSpace, explored
from verify.explored_line import UNITS, Budgets, ExploredLine
from verify.restored import restored

STAYS: Final = ("leaver-counts-as-on-the-line", Budgets(delay=1), False, "u2 has not left the line")
UNDETECTED: Final = ("proves-undetected", Budgets(), False, "u2 was sent the wrong way at points PX")
FALLS_OUT: Final = (
    ("sign-off-frees", Budgets(power=1), False, "collision from behind of u1"),
    UNDETECTED,
    ("sign-off-frees", Budgets(loss=1), True, "inside-holding: u2 is in section P"),
    ("booted-holds-nothing", Budgets(power=2), True, "inside-holding: u1 is in section P"),
    STAYS,
    ("emergency-kept", Budgets(sensor=1), False, "no-dead-state: u2 stands in section P"),
    ("emergency-kept", Budgets(points=1), False, "no-dead-state: u1 stands in section"),
)


@cache
def found_with(name: str, budgets: Budgets, *, collisions_alone: bool) -> ExploredSpace:
    with restored(name):
        return explored(ExploredLine(budgets=budgets), collisions_alone=collisions_alone)


@pytest.mark.parametrize(
    ("name", "budgets", "collisions_alone", "breaks"),
    others_nightly(FALLS_OUT, [STAYS], columns=True),
)
def test_a_former_defect_falls_out_on_the_line_and_not_of_the_machines_as_they_are(
    name: str, budgets: Budgets, collisions_alone: bool, breaks: str, tmp_path: Path
) -> None:
    found = found_with(name, budgets, collisions_alone=collisions_alone)
    with restored(name):
        told = told_on_line(found, tmp_path / "story")
    assert any(text.startswith(breaks) for text in told.broken), told.broken
    assert broken_by(told.drill) == ()
    assert all(v.passed for v in drill_on_plain(told.drill).verdicts)


def test_what_the_line_does_not_break_is_no_drill(tmp_path: Path) -> None:
    """Of a defect that is not there when the line runs."""
    found = found_with(UNDETECTED[0], UNDETECTED[1], collisions_alone=False)
    with pytest.raises(UntoldError, match="the line breaks no rule"):
        told_on_line(found, tmp_path / "story")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("first", UNITS[:2])
def test_on_the_day_of_no_trouble_everybody_comes_and_goes(first: str, tmp_path: Path) -> None:
    """Trains that call but once: they arrive where they begin, grow late there, and need no room on a disk."""
    folder = tmp_path / "day"
    copytree(str(LINE), folder)
    (folder / TIMES).write_text(story_drill._times(first, 300), "utf-8")
    scenario = load_scenario(str(folder / DAY))
    run = run_on_plain(scenario)
    assert broken_by(folder / DAY) == ()
    assert run.summary["trains_arrived"] == run.summary["trains_planned"] == 4
    with reserved(tmp_path / "run") as place:
        place.hold_room(end_room_bytes(scenario.setup))
        assert fill_run(run, place).is_file()
    assert DRILL not in {path.name for path in folder.iterdir()}
