"""The diagrams are what the machines do: their arrows are rows of the tables."""

from functools import cache
from typing import Any

import pytest

from documents.state_diagrams import DIAGRAMS, diagram, machine_diagram
from onboard.authority import machine as authority
from onboard.crossings import machine as crossings
from onboard.duty import machine as duty
from onboard.duty.records import AtMark, DutyPhase
from radio.table import TableCell, rows
from simulation.world import crossing_equipment, point_machine
from verify.breadth import Explored, explore
from verify.lone_unit import event_name, events_from, phase_name, steps
from wayside import block_manager, level_crossing, point_terminal
from wayside.register import UnitStanding

TABLES: dict[str, tuple[TableCell, ...]] = {
    "Block manager": block_manager.table_rows(),
    "Point terminal": rows(point_terminal.TABLE),
    "Point machine": rows(point_machine.TABLE),
    "On-board unit: authority": rows(authority.TABLE),
    "Level crossing": rows(level_crossing.TABLE),
    "Barriers of a level crossing": rows(crossing_equipment.TABLE),
    "On-board unit: level crossings": rows(crossings.TABLE),
}
NOT_IN_THE_TABLE = {"restart", "Expired", "AcceptPicture", "ConfirmOutside", "ConfirmHolding"}


@cache
def found_of(machine: str) -> Explored[Any]:
    """What exploring it finds, once for all tests."""
    return DIAGRAMS[machine][0]()


@cache
def drawn(machine: str) -> str:
    return machine_diagram(machine)


@pytest.mark.parametrize("machine", TABLES)
def test_every_arrow_is_a_row_of_the_table(machine: str) -> None:
    rows = {(row.state, row.event) for row in TABLES[machine]}
    arrows = {(here, event) for here, event, _ in found_of(machine).edges if event not in NOT_IN_THE_TABLE}
    assert arrows
    assert arrows <= rows


def test_every_arrow_of_the_duty_is_a_row_of_its_table() -> None:
    for run in list(found_of("On-board unit: duty").states)[:500]:
        for step in steps(run):
            if step.run.state.phase is not run.state.phase:
                assert (run.state.phase, type(step.event)) in duty.TABLE, event_name(step.event)


def test_every_phase_and_every_standing_is_drawn() -> None:
    assert {phase.value for phase in DutyPhase} <= names("On-board unit: duty")
    assert {standing.value for standing in UnitStanding} == names("Block manager")


def names(machine: str) -> set[str]:
    return {line.split('"')[1] for line in drawn(machine).splitlines() if line.startswith("    state ")}


def test_a_row_switched_off_is_an_arrow_less(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "on_sight --> finished: AtMark" in drawn("On-board unit: duty")
    table = {key: handler for key, handler in duty.TABLE.items() if key != (DutyPhase.ON_SIGHT, AtMark)}
    monkeypatch.setattr(duty, "TABLE", table)
    assert "AtMark" not in machine_diagram("On-board unit: duty")


def test_a_diagram_is_the_same_each_time() -> None:
    """Three states in a ring and one that nothing leads out of."""
    ring = {"a": ["b"], "b": ["c"], "c": ["a", "d"], "d": []}
    found = explore(["a"], lambda state: ((f"to {after}", after) for after in ring[state]), str, 10)
    assert found.complete
    assert found.steps == 4
    assert diagram(found, "a").splitlines()[6:-1] == [
        "    [*] --> a",
        "    a --> b: to b",
        "    b --> c: to c",
        "    c --> a: to a",
        "    c --> d: to d",
    ]


def test_the_bound_is_kept() -> None:
    found = explore([0], lambda n: (("up", n + 1),), str, 5)
    assert found.states == frozenset(range(5))
    assert not found.complete


def test_what_is_drawn_is_what_follows() -> None:
    found = found_of("On-board unit: duty")
    for run in list(found.states)[:200]:
        for event, after in events_from(run):
            if phase_name(after) != phase_name(run):
                assert (phase_name(run), event, phase_name(after)) in found.edges
