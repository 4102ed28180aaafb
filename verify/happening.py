"""Something that can happen at a party besides telegrams, with its local states or with their numbers."""

from __future__ import annotations

from enum import IntEnum
from typing import Final, Generic, NamedTuple, TypeVar

from network.model import Position
from verify.explored_line import UnwishedFor

S = TypeVar("S")  # local states
M = TypeVar("M")  # telegrams


class GuardKind(IntEnum):
    """What must be so elsewhere for an event to happen."""

    NONE = 0
    LIES = 1  # points lie and are locked as needed, no motor runs
    LIES_NOT = 2
    FREE = 3  # no other train stands in a section


class Guard(NamedTuple):
    """`of`: a terminal's index, or sections as bits; `position`: as needed."""

    kind: GuardKind = GuardKind.NONE
    of: int = 0
    position: Position | None = None


NO_GUARD: Final = Guard()


class Happening(NamedTuple, Generic[S, M]):
    """What happens, the state after it, and telegrams by whom they are for.

    Of a train: `left`: it passes the boundary out; `locks`, `unlocks`: points, by terminal, that its crew locks by
    hand, or gives back. Of the manager: `about`: the unit that a person speaks of, truly where `stands` is all that its
    train stands in and that it shows to hold. Of a unit that speaks for itself that is true only where it `corrects`
    what was said before, and no telegram to the unit is on the air. `word`: a person acts, which takes effect only when
    no telegram of an earlier boot is on the air, nor, where it is `quiet`, any to the unit that they speak of.
    """

    name: str
    state: S
    sends: tuple[tuple[int, M], ...] = ()
    trouble: UnwishedFor = UnwishedFor.NONE
    guard: Guard = NO_GUARD
    left: bool = False
    locks: tuple[int, ...] = ()
    unlocks: tuple[int, ...] = ()
    about: int = -1
    stands: int = 0
    word: bool = False
    corrects: bool = False
    quiet: bool = False
