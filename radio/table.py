"""The tables of the protocol machines as rows of text, for documentation that cannot go stale."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum
from typing import Any, NamedTuple


class TableCell(NamedTuple):
    """One cell of a machine's table: in `state`, `event` is handled by `handler`; `outcome` says what happens."""

    state: str
    event: str
    handler: str
    outcome: str


def rows(table: Mapping[Any, Callable[..., Any]]) -> tuple[TableCell, ...]:
    """A table as rows, in its order; its keys are states (one or more) and the type of the event.

    The outcome is the first paragraph of the handler's docstring. Raises ValueError if it has none.
    """
    return tuple(_row(key, handler) for key, handler in table.items())


def _row(key: tuple[Enum | type, ...], handler: Callable[..., Any]) -> TableCell:
    states = [part.value for part in key if isinstance(part, Enum)]
    (event,) = (part.__name__ for part in key if isinstance(part, type))
    if not handler.__doc__:
        raise ValueError(f"{handler.__name__} has no docstring to say what it does")
    outcome = " ".join(handler.__doc__.split("\n\n")[0].split())
    return TableCell(", ".join(states), event, handler.__name__.lstrip("_"), outcome)
