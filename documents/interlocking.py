"""Writes docs/interlocking.md from the code and from real runs: `python -m documents.interlocking [FILE]`.

The machines' tables and state diagrams come from the machines, invariants from their modules, the sequence and table 3
from runs of the paper's test line; hazards are data here, and a test holds every name in them to what exists.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from documents.interlocking_defects import CAUGHT
from documents.interlocking_hazards import HAZARDS, REMAINING
from documents.interlocking_runs import restart_rows, run_without_failure, sequence, stop_limits
from documents.page import write_page
from documents.state_diagrams import machine_diagram
from onboard.authority import machine as authority
from onboard.crossings import machine as crossings
from onboard.duty import machine as duty
from radio.table import TableCell, rows
from simulation.judge.checkers import Checker
from simulation.world import crossing_equipment, point_machine
from wayside import block_manager, level_crossing, point_terminal

FILE: Final = Path("docs/interlocking.md")
_RUN_HEAD: Final = "## A run"
_HAZARDS_HEAD: Final = "## Hazards"

INVARIANTS: Final = (
    ("wayside.block_manager", "block manager (閉そく管理装置)"),
    ("wayside.acts", "what persons may enter there"),
    ("wayside.reentry", "re-entry after a restart"),
    ("wayside.entering", "leave to come in (不同時進入)"),
    ("wayside.point_terminal", "point terminal (制御端末装置)"),
    ("simulation.world.point_machine", "point machine (電気転てつ機)"),
    ("wayside.level_crossing", "level crossing (踏切制御装置)"),
    ("simulation.world.crossing_equipment", "lamps and barriers of a level crossing (踏切警報機, 遮断機)"),
    ("onboard.duty.machine", "on-board unit (車上装置): its duty"),
    ("onboard.duty.on_sight", "on-board unit: running on sight"),
    ("onboard.authority.machine", "on-board unit: sections and points"),
    ("onboard.authority.sign_on", "on-board unit: on and off the line"),
    ("onboard.authority.route", "on-board unit: routes"),
    ("onboard.authority.points", "on-board unit: points"),
    ("onboard.authority.report", "on-board unit: giving back"),
    ("onboard.crossings.machine", "on-board unit: level crossings"),
    ("onboard.duty.arrival", "on-board unit: what lies behind"),
    ("onboard.duty.entering", "on-board unit: coming in"),
    ("onboard.authority.agreement", "on-board unit: contradictions with the register"),
    ("onboard.duty.fitness", "on-board unit: vehicle and brakes"),
    ("onboard.authority.letters", "on-board unit: tokens and correlations"),
    ("onboard.localisation.tachometer", "on-board unit: position"),
    ("onboard.localisation.places", "on-board unit: virtual tags"),
    ("onboard.driving.supervision", "on-board unit: speed"),
    ("onboard.localisation.reader", "tag reader (車上子)"),
)


@dataclass(frozen=True, slots=True)
class TableLine:
    """One printed row of a machine's table: the states in which an event has the same outcome."""

    states: tuple[str, ...]
    event: str
    outcome: str


def document(runs: str | None = None) -> str:
    """The whole document. Runs the paper's test line some twenty times, unless `runs` says what they show."""
    parts = [_HEAD, "## What always holds", _invariants(), "## The machines", _MACHINES]
    for title, cells in (
        ("Block manager", block_manager.table_rows()),
        ("Point terminal", rows(point_terminal.TABLE)),
        ("Point machine", rows(point_machine.TABLE)),
        ("Level crossing", rows(level_crossing.TABLE)),
        ("Barriers of a level crossing", rows(crossing_equipment.TABLE)),
        ("On-board unit: duty", rows(duty.TABLE)),
        ("On-board unit: authority", rows(authority.TABLE)),
        ("On-board unit: level crossings", rows(crossings.TABLE)),
    ):
        parts += [f"### {title}", machine_diagram(title), _machine(cells)]
    parts += [_shown_by_runs() if runs is None else runs]
    parts += [_HAZARDS_HEAD, _HAZARDS_INTRO, _hazards()]
    parts += ["### Rules taken away", _CAUGHT_INTRO, _caught(), "### What remains", bullets(REMAINING)]
    return "\n\n".join(part.strip("\n") for part in parts) + "\n"


def runs_in(page: str) -> str:
    """The part of a page that only runs can tell."""
    return _RUN_HEAD + page.partition(_RUN_HEAD)[2].partition(_HAZARDS_HEAD)[0]


def _shown_by_runs() -> str:
    run = run_without_failure()
    parts = [
        _RUN_HEAD,
        _RUN,
        sequence(run),
        _LIMITS,
        table(("time", "stop limit", "because"), stop_limits(run)),
        *("## After a restart of the on-board unit", _TABLE_3, table(_RESTART_HEAD, restart_rows())),
    ]
    return "\n\n".join(part.strip("\n") for part in parts)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def bullets(texts: Iterable[str]) -> str:
    """A Markdown list."""
    return "\n".join(f"- {text}" for text in texts)


def merged_rows(rows: Iterable[TableCell]) -> tuple[TableLine, ...]:
    """Rows of one event and handler in one line, in the order of their first."""
    states: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        states.setdefault((row.event, row.outcome), []).append(row.state)
    return tuple(TableLine(tuple(found), event, outcome) for (event, outcome), found in states.items())


def invariant_of(module: str) -> str:
    """The first sentences of a module that states its invariant first. Raises ValueError for another."""
    text = importlib.import_module(module).__doc__ or ""
    start = text.find("Invariant:")
    if start < 0:
        raise ValueError(f"{module} does not state its invariant")
    words = " ".join(text[start:].split("\n\n")[0].split()).removeprefix("Invariant: ")
    return words[0].upper() + words[1:]


def _invariants() -> str:
    rows = [(who, invariant_of(module), f"`{module}`") for module, who in INVARIANTS]
    return table(("party", "invariant", "module"), rows)


def _machine(rows: Iterable[TableCell]) -> str:
    lines = merged_rows(rows)
    return table(
        ("event", "in state", "what happens"),
        [(f"`{line.event}`", _states(line.states), line.outcome) for line in lines],
    )


def _states(states: tuple[str, ...]) -> str:
    """States, those with a phase grouped by it."""
    if not all(", " in state for state in states):
        return "; ".join(states)
    phases: dict[str, list[str]] = {}
    for state in states:
        phase, _, standing = state.partition(", ")
        phases.setdefault(phase, []).append(standing)
    return "; ".join(f"{phase}: {', '.join(found)}" for phase, found in phases.items())


def _hazards() -> str:
    head = ("hazard", "cause", "what prevents it", "watched by", "shown by")
    rows = [
        (
            hazard.hazard,
            hazard.cause,
            f"{hazard.prevention} (`{'`, `'.join(hazard.modules)}`)",
            ", ".join(f"`{Checker(name).value}`" for name in hazard.watched_by),
            "; ".join([*(f"drill `{name}`" for name in hazard.drills), *hazard.defects]),
        )
        for hazard in HAZARDS
    ]
    return table(head, rows)


def _caught() -> str:
    rows = [(caught.rule, f"`{caught.module}`", f"`tests/{caught.test}`") for caught in CAUGHT]
    return table(("rule", "module", "test that fails without it"), rows)


_HEAD: Final = """
# Interlocking

Written by `make docs` from the code and from real runs; a test compares it, so change the code, not this page.

Who may be where is decided by three kinds of party that talk by radio only: one block manager for the line, a point
terminal at each end of a station, an on-board unit in each train. The frame is that of Sugiyama, Fukuda and Kitano
(RTRI), "Evaluation of Functions of a Train Control System by Using the On-board Interlocking"; sections and tags are
named as in its figure 3. A train asks for all sections up to its next track at once, has the points in them thrown by
itself, and moves its stop limit (停止限界点) on as grants and proofs come in. What that paper leaves open, and how it
was decided, is [a page of its own](interlocking-gaps.md).
"""
_MACHINES: Final = """
Each is a pure function of its state and one event. What a table does not name is refused and changes nothing; lines
join the states in which an event does the same. A telegram reaches a machine only through the envelope's checks
(`radio.envelope`): code, addressee, boot, time and sequence.

The diagrams are drawn by exploring each machine's own step, breadth first up to a bound, on the smallest line on which
it has something to do; an arrow is an event that leads from one state of the table to another.
"""
_RUN: Final = """
From track 1 of station A (section 3) to track 1 of station B (section 8), without any failure, as `branchline run
rtri_test_line` gives it. Times are the run's own; tokens are written boot.number; a telegram repeated while it waits
for its answer is drawn once.
"""
_LIMITS: Final = "So the stop limit moved:"
_TABLE_3: Final = """
What table 3 of the paper lists, as our unit does it: the unit loses its power and has it back 60 s later, standing by
then where the first column says, with nothing known of its position or of what it holds. Each line is a pair of runs,
with the radio reaching and with no radio until 400 s after the failure. Unlike in the paper, position tags stand before
each mark, so that a position is found in more places (the paper's note on additional tags).
"""
_RESTART_HEAD: Final = (
    "where it stands",
    "position found",
    "stop limit then",
    "how it gets in",
    "while the radio does not reach",
)
_HAZARDS_INTRO: Final = """
What must never happen is a derailment or a collision. Checkers see the true positions from SUMO and the journal, share
no code with what they watch, and fail the run. Defects are those of `tests/system/test_defects.py`, each a behaviour
switched off on purpose and caught; the drills of the paper's line fail, too, when what they check is switched off
(`tests/system/test_drill_defects.py`, which names what is left out).
"""
_CAUGHT_INTRO: Final = """
Besides the defects above, which run whole lines, each of these rules was taken away by itself, and the test named
failed. Of thirty-one behaviours taken away the random cases of `tests/system/chaos` find twenty within sixty runs each.
"""


if __name__ == "__main__":
    write_page(document, FILE)
