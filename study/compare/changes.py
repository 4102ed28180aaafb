"""What two runs were made from, figure by figure: where their inputs differ, and whose scenario set it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from network.files.edits import Change, differences
from network.files.toml_input import validate
from scenario.scenario_file import ScenarioFile
from study.compare.side import ComparedRun
from vehicle.train_patch import figures_alone

# What a scenario is called, and prose; what it names and what it patches is compared itself.
_NO_SETTING: Final = ("extends", "id", "name", "assumed", "patch")
# How a run was asked for on the command line.
_ASKED: Final = ("link", "carrier")
COMMAND_LINE: Final = "command line"


class InputChange(Change):
    """One figure of the inputs that is not the same; None where it is not there.

    `by` are the labels of the runs whose scenario, or a patch of it, has set what stands there.
    """

    by: tuple[str, ...]


def input_changes(base: ComparedRun, new: ComparedRun) -> tuple[InputChange, ...]:
    """Where the inputs of two runs differ: scenario, line, timetable, trains that both have, command line."""
    a, b = base.inputs, new.inputs
    settings = _settings(a.scenario), _settings(b.scenario)
    found = [
        *differences("scenario", *settings),
        *differences(_file(a.scenario["line"], b.scenario["line"]), a.line, b.line),
        *differences(_file(a.scenario["timetable"], b.scenario["timetable"]), a.timetable, b.timetable),
    ]
    for name in sorted({*a.trains} & {*b.trains}):
        found += differences(_file(name, name), figures_alone(a.trains[name]), figures_alone(b.trains[name]))
    for stock_id in sorted({*a.stock} & {*b.stock}):
        train_of = {"old": a.stock[stock_id], "new": b.stock[stock_id]}
        if a.stock[stock_id] != b.stock[stock_id]:
            found.append(Change(file="scenario", key=f"train of {stock_id}", **train_of))
    found += differences("learned", dict(a.learned), dict(b.learned))
    for key in _ASKED:
        if base.summary.get(key) != new.summary.get(key):
            found.append(
                Change(file=COMMAND_LINE, key=f"--{key}", old=base.summary.get(key), new=new.summary.get(key))
            )
    return tuple(InputChange(**dict(c), by=_by(c, base, new)) for c in found)


def _settings(scenario: Mapping[str, Any]) -> dict[str, Any]:
    """The scenario's own tables with all defaults: what one leaves out and the other says may be the same."""
    whole = validate(scenario, "scenario", ScenarioFile).model_dump(mode="json", by_alias=True)
    return {key: value for key, value in whole.items() if key not in _NO_SETTING}


def _file(old: str, new: str) -> str:
    """The file's name; both where they differ."""
    names = dict.fromkeys(f"{Path(name).name.removesuffix('.toml')}.toml" for name in (old, new))
    return " | ".join(names)


def _by(change: Change, base: ComparedRun, new: ComparedRun) -> tuple[str, ...]:
    """The runs whose own account of changes has this key and value."""
    return tuple(
        side.label
        for side, value in ((base, change.old), (new, change.new))
        if any(own.key == change.key and own.new == value for own in side.inputs.changes)
    )
