"""A case that fails, made small and written as a drill that needs nothing of this folder: it has what staff did."""

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from simulation.faults.script import Act
from tests.system.chaos.case import Case
from tests.system.chaos.course import clock_tenths
from tests.system.chaos.run_one import Outcome, outcome_of
from tests.system.chaos.toml_text import Table, toml_of

RUNS_MAX: Final = 24
EVERYONE_ARRIVES: Final = {"text": "every train arrives", "property": "everyone_arrives"}


def scripted(case: Case, outcome: Outcome) -> Case:
    """The same case with what its staff did as acts, each at its time."""
    return case.without_staff((*case.acts, *map(_table, outcome.acts)))


def _table(act: Act) -> dict[str, Any]:
    table = {
        "kind": act.kind.value,
        "start": clock_tenths(act.trigger.at_s or 0.0),
        "person": act.person,
        "target": act.target,
        "sections": list(act.sections),
        "position": act.position,
        "place": act.place,
    }
    return {key: value for key, value in table.items() if value}


def shrunk(case: Case, kind: str, nets: Path) -> tuple[Case, Outcome]:
    """The smallest case found that ends in the same kind of failure, with what its staff did written down.

    Only faults and what a crew did of itself are taken away: staff go on putting right what is left, for without them
    anything would fail. If it does not fail so with their acts written down, it comes back with its staff.
    """
    outcome, found, runs = outcome_of(case, nets), True, 0
    while found and runs < RUNS_MAX:
        found = False
        for smaller in _smaller_ones(case):
            runs += 1
            tried = outcome_of(smaller, nets)
            if tried.kind == kind:
                case, outcome, found = smaller, tried, True
                break
    if "substitute" in case.head:  # which needs staff who react
        return case, outcome
    written = scripted(case, outcome)
    for acts in (_said_once(written.acts), written.acts):
        tried = replace(written, acts=acts)
        again = outcome_of(tried, nets)
        if again.kind == kind:
            return tried, again
    return case, outcome


def _said_once(acts: tuple[Table, ...]) -> tuple[Table, ...]:
    """Without what the same person says again."""
    by_words = {toml_of({k: v for k, v in act.items() if k != "start"}): act for act in reversed(acts)}
    return tuple(act for act in acts if act in by_words.values())


def _smaller_ones(case: Case) -> Iterator[Case]:
    for i in reversed(range(len(case.acts))):
        yield replace(case, acts=(*case.acts[:i], *case.acts[i + 1 :]))
    for i in reversed(range(len(case.faults))):
        yield replace(case, faults=(*case.faults[:i], *case.faults[i + 1 :]))
    for key in ("air", "operation", "sensors", "lidar", "dispatch"):
        if key in case.head:
            yield replace(case, head={k: v for k, v in case.head.items() if k != key})


def write(case: Case, outcome: Outcome, folder: Path) -> Path:
    """Into a folder of its own, with what goes wrong in the first lines; returns the drill."""
    last = [line.strip() for detail in outcome.details for line in detail.strip().splitlines()[-1:]]
    says = "\n".join([outcome.kind, *last[:8]])
    if not (case.faults or case.acts):  # else it would be no drill
        case = replace(case, head={**case.head, "expect": [EVERYONE_ARRIVES]})
    return case.write(folder / case.name, says)


def slug(kind: str) -> str:
    """A kind as the name of a folder."""
    return re.sub(r"[^a-z0-9]+", "_", kind.lower()).strip("_")[:70]
