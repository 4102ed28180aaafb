"""The tables as text: every cell, with something to say."""

from enum import Enum

import pytest

from radio.table import TableCell, rows
from simulation.world import point_machine
from wayside import acts, block_manager, point_terminal


class State(Enum):
    """States of a toy machine."""

    ON = "on"


class Push:
    """An event of a toy machine."""


def _switch() -> None:
    """Goes off
    at once.

    Not for the table.
    """


def test_a_row_says_state_event_and_outcome() -> None:
    assert rows({(State.ON, Push): _switch}) == (TableCell("on", "Push", "switch", "Goes off at once."),)


def test_a_handler_must_say_what_it_does() -> None:
    with pytest.raises(ValueError, match="no docstring"):
        rows({(State.ON, Push): lambda: None})


def test_every_cell_of_every_machine_has_a_row() -> None:
    persons = len(acts.UNIT_ACTS) + len(acts.LINE_ACTS)
    assert len(block_manager.table_rows()) == len(block_manager.TELEGRAMS) + persons
    assert len(rows(point_terminal.TABLE)) == len(point_terminal.TABLE)
    assert len(rows(point_machine.TABLE)) == len(point_machine.TABLE)
    assert block_manager.table_rows()[0][:2] == ("unknown", "RouteRequest")
    assert rows(point_machine.TABLE)[0][:3] == ("at rest", "StartThrow", "start")
