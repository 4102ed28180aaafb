"""The scenario of a day: a file that extends the one that is varied and says what is different, nothing else.

A day is run from that very file, and `branchline run` runs it again.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from network.files.names import IDENTIFIER_LENGTH_MAX, title_of
from network.files.toml_text import put_value, steps_of, toml_of
from scenario.scenario import Scenario, load_scenario
from study.sweep.records import DaySpec

SHORT: Final = 8  # characters of a digest that tell points apart
_FILE: Final = "sweep"  # of errors: what a sweep file says was checked as it was read


def point_id(spec: DaySpec) -> str:
    """What the scenario of a day's point is called: after the scenario that is varied."""
    stem = Path(spec.scenario).stem[: IDENTIFIER_LENGTH_MAX - SHORT - 1]
    return f"{stem}-{spec.inputs[:SHORT] or 'point'}"


def scenario_text(spec: DaySpec, *, seeded: bool = True) -> str:
    """The file of a day; without `seeded` that of its point, for any seed."""
    said = (*spec.point, *spec.drawn) if seeded else spec.point
    head: dict[str, Any] = {
        "extends": spec.scenario,
        "id": point_id(spec),
        "name": title_of(_name(spec)),
    }
    if seeded:
        head["seed"] = spec.seed
    for key, value in said:
        put_value(head, steps_of(key, _FILE, key), value)
    return toml_of(head)


def scenario_of(spec: DaySpec, folder: Path) -> Scenario:
    """The scenario of a day, read from the file that is written into a folder. InputError."""
    file = folder / f"{point_id(spec)}.toml"
    file.write_text(scenario_text(spec), "utf-8")
    return load_scenario(str(file))


def _name(spec: DaySpec) -> str:
    said = ", ".join(f"{key} = {value}" for key, value in spec.point)
    return f"{Path(spec.scenario).stem}: {said}" if said else Path(spec.scenario).stem
