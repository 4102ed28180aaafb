"""Drills: a scenario with faults, acts and expectations, run and judged expectation by expectation."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from network.errors import InputError
from network.files.toml_input import one_of
from simulation.loop import Progress
from study.run.run import Link, Run, execute
from study.run.verdict import Verdict, judge
from study.scenario.scenario import load_scenario


@dataclass(frozen=True, slots=True)
class Drill:
    """A finished drill."""

    run: Run
    verdicts: tuple[Verdict, ...]

    @property
    def passed(self) -> bool:
        """Whether every expectation was met."""
        return all(verdict.passed for verdict in self.verdicts)

    def as_dict(self) -> dict[str, Any]:
        """What `branchline drill --json` prints."""
        return {
            "drill": self.run.scenario.id,
            "name": self.run.scenario.name,
            "passed": self.passed,
            "expectations": [
                {"text": v.text, "passed": v.passed, "happened": v.happened} for v in self.verdicts
            ],
            "summary": self.run.summary,
        }


def shipped_drills() -> tuple[str, ...]:
    """Names of the drills that come with the program, as folder/file."""
    folder = _folder()
    return tuple(
        sorted(path.relative_to(folder).with_suffix("").as_posix() for path in folder.rglob("*.toml"))
    )


def find_drill(name: str) -> str:
    """What `load_scenario` takes for a drill: its file. InputError otherwise."""
    shipped = _folder() / f"{name}.toml"
    if name in shipped_drills():
        return str(shipped)
    if name.endswith(".toml") and Path(name).is_file():
        return name
    expected = f"an existing file, or a shipped drill: {one_of(shipped_drills(), name)}"
    raise InputError(name, "", None, expected)


def run_drill(name: str, link: Link, seed: int | None = None, progress: Progress | None = None) -> Drill:
    """Run a drill. InputError for a file that is no drill, because it expects nothing."""
    scenario = load_scenario(find_drill(name), seed)
    expectations = scenario.setup.script.expectations
    if not expectations:
        raise InputError(
            scenario.file, "expect", None, "at least one [[expect]]: a drill says what must happen"
        )
    run = execute(scenario, link, progress=progress)
    return Drill(run, judge(expectations, run.result, run.tables))


def _folder() -> Path:
    return Path(str(files("study"))) / "drills"
