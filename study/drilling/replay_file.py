"""A script written as a drill file that `branchline drill` runs to the same journal, to the byte."""

from __future__ import annotations

from pathlib import Path

from network.clock import clock
from network.files.names import title_of
from network.files.toml_text import value_text
from scenario.scenario import Scenario
from simulation.faults.script import Act, Script, ScriptedFault
from simulation.setup import STEPS_PER_S


def replay_of(scenario: Scenario, script: Script, own_id: str, title: str, *, beside: bool = False) -> str:
    """The drill that has this script in a scenario: a file that `branchline drill` runs to the same journal.

    `beside`: behind the scenario's own faults and acts, not in their place.
    """
    nothing: list[str] = []
    head: dict[str, object] = {
        "extends": _called(scenario),
        "id": own_id,
        "name": title_of(title),
        "seed": scenario.setup.seed,
        **({"people.react": True} if scenario.setup.people.react else {}),
        # Without these lists, those of the file that it extends would hold.
        **{
            key: nothing
            for key, items in (("fault", script.faults), ("act", script.acts))
            if not items and not beside
        },
        "expect": nothing,
    }
    tables = [("fault", _fault(failure)) for failure in script.faults]
    tables += [("act", _act(act)) for act in script.acts]
    lines = [f"{key} = {value_text(value)}" for key, value in head.items()]
    for key, table in tables:
        heading = f"patch.{key}.add" if beside else key
        lines += ["", f"[[{heading}]]", *(f"{name} = {value_text(value)}" for name, value in table.items())]
    return "\n".join(lines) + "\n"


def _called(scenario: Scenario) -> str:
    """A shipped scenario by its name, any other by its file, wherever the drill will lie."""
    called = scenario.called
    return str(Path(called).resolve()) if called == scenario.file else called


def _fault(failure: ScriptedFault) -> dict[str, object]:
    fault = failure.fault
    table: dict[str, object] = {
        "kind": fault.kind,
        "target": str(fault.target),
        "start": _start(failure),
        **fault.parameters(),
    }
    return table | ({} if failure.duration_s is None else {"duration_s": failure.duration_s})


def _act(act: Act) -> dict[str, object]:
    table: dict[str, object] = {"kind": act.kind.value, "start": _start(act), "person": act.person}
    own = {
        "target": act.target,
        "sections": list(act.sections),
        "position": act.position,
        "place": act.place,
        "behind": act.behind,
        "train": act.train,
        "notch": act.notch,
        "step": act.step,
        "block": act.block,
    }
    table |= {key: value for key, value in own.items() if value}
    table |= {} if act.pace_s is None else {"pace_s": act.pace_s}
    return table | {"hold_s": act.hold_s}


def _start(item: ScriptedFault | Act) -> str:
    return clock_of(round((item.trigger.at_s or 0.0) * STEPS_PER_S))


def clock_of(step: int) -> str:
    """The time of a step as files have it, to a tenth of a second; before midnight with a minus."""
    whole, tenth = divmod(abs(step), STEPS_PER_S)
    return ("-" if step < 0 else "") + clock(whole) + (f".{tenth}" if tenth else "")
