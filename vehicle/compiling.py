"""Which piece is being compiled now, told to whoever shows it to a person: it takes seconds on a new machine."""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType
from typing import Final, NamedTuple


class Compilation(NamedTuple):
    """An entry that is being compiled, and how far it is."""

    name: str
    functions: int  # that it reaches, itself among them; few of them may turn out not to be called
    written: int  # of these, as intermediate code
    linked: bool  # all are written; what is left is to make machine code of them


WATCHERS: Final[list[Callable[[Compilation], None]]] = []
_written: Final[set[FunctionType]] = set()  # of the piece at hand
_at_hand: Compilation = Compilation("", 0, 0, linked=True)


def begin_piece(name: str, functions: int) -> None:
    """An entry that no store had is compiled from here on."""
    _written.clear()
    _tell(Compilation(name, functions, 0, linked=False))


def note_written(function: FunctionType) -> None:
    """One of its functions is there as intermediate code, for some types of arguments."""
    _written.add(function)
    _tell(_at_hand._replace(written=len(_written)))


def note_linked() -> None:
    """All are; machine code is made of them."""
    _tell(_at_hand._replace(linked=True))


def _tell(piece: Compilation) -> None:
    global _at_hand  # noqa: PLW0603 - numba compiles one piece at a time
    _at_hand = piece
    for watcher in WATCHERS:
        watcher(piece)
