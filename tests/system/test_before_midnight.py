"""A day whose first train leaves at midnight begins before it, and goes as the same day at ten o'clock does."""

import re
from pathlib import Path
from typing import Any, Final

from console.session import Session
from network.clock import clock
from network.files.shipped import shipped_timetable
from scenario.scenario import Scenario, load_scenario
from scenario.script_file import time_of
from simulation.setup import STEPS_PER_S
from study.drilling.drill import run_drill
from study.runner.run import PartyLink

TEN_S: Final = 36_000  # the first departure of the shipped timetable
DEEDS: Final[tuple[tuple[int, dict[str, Any]], ...]] = (
    (-560, {"kind": "restart", "target": "block-manager"}),
    (-500, {"kind": "power_off", "target": "B-W", "duration_s": 60.0}),
    (-450, {"kind": "power_off", "target": "K1"}),
    (60, {"kind": "restart", "target": "block-manager"}),
)


def two_trains_from(folder: Path, first_s: int, more: str = "") -> Scenario:
    """The two trains of the test line on a day whose first departure is at `first_s`."""

    def moved(match: re.Match[str]) -> str:
        return f'"{clock(time_of("", "", match[1]) - TEN_S + first_s)}"'

    folder.mkdir()
    text = shipped_timetable("rtri_two_trains").read_text("utf-8")
    (folder / "moved.toml").write_text(re.sub(r'"(\d\d:\d\d:\d\d)"', moved, text), "utf-8")
    head = 'extends = "rtri_test_line"\nid = "moved"\nname = "moved"\ntimetable = "moved.toml"\n'
    file = folder / "day.toml"
    file.write_text(f"{head}{more}\n[people]\nreact = true\n", "utf-8")
    return load_scenario(str(file))


def worked(folder: Path, first_s: int) -> list[tuple[str, str]]:
    """Who did what, in order, on that day with the deeds; a saved session of it replays to the byte."""
    with Session(two_trains_from(folder, first_s)) as session:
        for at_s, table in DEEDS:
            session.run_to((first_s + at_s) * STEPS_PER_S)
            session.fail(table)
        done = session.run_to_end()
        saved = folder / "saved.toml"
        saved.write_text(session.drill_text("saved", "saved"), "utf-8")
        told = [(entry.who, type(entry.event).__name__) for entry in session.journal.entries]
    assert run_drill(str(saved), PartyLink.SIMULATED).run.result.digest == done.digest
    return told


def test_a_day_that_begins_before_midnight_goes_as_any_other(tmp_path: Path) -> None:
    assert worked(tmp_path / "midnight", 0) == worked(tmp_path / "ten", TEN_S)
