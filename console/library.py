"""What can be opened at the desk: the shipped scenarios and drills, and the finished runs of a folder."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Final

import msgspec

from network.errors import InputError
from scenario.scenario import Scenario, load_scenario, shipped_scenarios
from study.drilling.drill import find_drill, sentence_of, shipped_drills
from study.record.directory import INCOMPLETE_FILE, INPUTS_FILE, SUMMARY_FILE
from study.record.read_back import RunRead, read_run

RUNS: Final = Path("runs")


class Opens(Enum):
    """What kind of thing is opened."""

    SCENARIO = "scenario"
    DRILL = "drill"
    RUN = "run"


class LibraryEntry(msgspec.Struct, frozen=True):
    """One thing that can be opened, and what it is."""

    kind: Opens
    name: str
    title: str = ""


class LibraryRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Something of the library is to be opened, by whoever has the instructor's token."""

    kind: Opens
    name: str
    token: str = ""


def library(runs: Path = RUNS) -> tuple[LibraryEntry, ...]:
    """Everything that can be opened, in groups."""
    return (
        *(LibraryEntry(Opens.SCENARIO, name) for name in shipped_scenarios()),
        *(LibraryEntry(Opens.DRILL, name, sentence_of(name)) for name in shipped_drills()),
        *(
            LibraryEntry(Opens.RUN, folder.name)
            for folder in sorted(runs.iterdir() if runs.is_dir() else ())
            if all((folder / name).is_file() for name in (SUMMARY_FILE, INPUTS_FILE))
            and not (folder / INCOMPLETE_FILE).exists()
        ),
    )


def opened(name: str, seed: int | None = None) -> Scenario | RunRead:
    """What a name on the command line means: a run directory, a shipped drill, or a scenario. InputError otherwise."""
    if Path(name).is_dir():
        return read_run(Path(name))
    return load_scenario(find_drill(name) if name in shipped_drills() else name, seed)


def taken_from_library(asked: LibraryRequest, runs: Path = RUNS) -> Scenario | RunRead:
    """What a page asks for: of the library, and nothing else of this machine. InputError for anything else."""
    if not any((entry.kind, entry.name) == (asked.kind, asked.name) for entry in library(runs)):
        raise InputError("desk", "name", asked.name, "something of the library")
    if asked.kind is Opens.RUN:
        return read_run(runs / asked.name)
    return load_scenario(find_drill(asked.name) if asked.kind is Opens.DRILL else asked.name)
