"""The steps of all parties, each made once: local states and telegrams are numbers in the order of their finding.

What was made is kept as a list of small tuples, so that whoever makes the same steps again, in that order, comes to the
same numbers: a certificate names states by them, and its checker makes every step anew.

Of a correlation only matters which telegrams and open requests carry the same one, and that a new request carries none
that is in use. So the numbers in use between one unit and the ground are counted anew (`renaming`); 0, 1 and
2 stay, which the manager uses for questions of its own (how many trains have left).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from enum import Enum
from hashlib import blake2b
from typing import Any, Final, Generic, NamedTuple, TypeVar, cast

import msgspec

from verify import tokens
from verify.explored_line import TERMINALS, UNITS, ExploredLine
from verify.happening import Happening
from verify.manager import ManagerModel, ManagerState
from verify.on_air import InAir
from verify.terminal import TerminalModel, TerminalState
from verify.train import ExploredTrain, TrainState
from verify.train_events import events

T = TypeVar("T", bound=Hashable)
Sends = tuple[tuple[int, int], ...]  # to whom, which telegram


class Numbered(Generic[T]):
    """Things and their numbers, in the order in which they were found."""

    def __init__(self) -> None:
        self.things: Final[list[T]] = []
        self._numbers: Final[dict[T, int]] = {}

    def known(self, thing: T) -> int | None:
        """The number of a thing; None where it has none."""
        return self._numbers.get(thing)

    def number(self, thing: T) -> int:
        """The number of a thing."""
        found = self._numbers.get(thing)
        if found is None:
            found = self._numbers[thing] = len(self.things)
            self.things.append(thing)
        return found


class LocalStep(NamedTuple):
    """What comes of a step, in numbers. `granted`: the correlation of the manager's last grant to the unit heard."""

    state: int
    sends: Sends = ()
    granted: int = 0


LocalEvent = Happening[int, int]
Renamed = tuple[tuple[int, int], ...]  # number before, number after


class StepKind(Enum):
    """Which step was made."""

    UNIT_HEARS = 1
    UNIT_EVENTS = 2
    UNIT_RENAMED = 3
    TELEGRAM_RENAMED = 4
    MANAGER_HEARS = 5
    MANAGER_EVENTS = 6
    BOUNDARY_PASSED = 7
    TERMINAL_HEARS = 8
    TERMINAL_EVENTS = 9
    LOCKED_BY_HAND = 10
    UNIT_ANEW = 11
    TELEGRAM_ANEW = 12
    MANAGER_ANEW = 13
    TERMINAL_ANEW = 14
    PERSONS_ERR = 15


class ExploredParties:
    """The parties of a line and their steps."""

    def __init__(self, line: ExploredLine) -> None:
        self.line: Final = line
        self.units: Final = UNITS[: line.trains]
        self._manager: Final = ManagerModel(line)
        self._terminal: Final = tuple(TerminalModel(line, t) for t in TERMINALS)
        self.train_models: Final = tuple(ExploredTrain(line, u) for u in self.units)
        self.managers: Final = Numbered[ManagerState]()
        self.terminals: Final = tuple(Numbered[TerminalState]() for _ in TERMINALS)
        self.trains: Final = tuple(Numbered[TrainState]() for _ in self.units)
        self.telegrams: Final = Numbered[InAir]()
        self.made: Final[list[tuple[Any, ...]]] = []
        self._known: Final[dict[tuple[Any, ...], Any]] = {}
        self.managers.number(self._manager.start())
        for numbered, model in zip(self.terminals, self._terminal, strict=True):
            numbered.number(model.start())
        for trains in self.trains:
            trains.number(TrainState())
        self._kinds: Final[dict[StepKind, Callable[..., Any]]] = {
            StepKind.UNIT_HEARS: self._unit_hears,
            StepKind.UNIT_EVENTS: self._unit_events,
            StepKind.UNIT_RENAMED: self._unit_renamed,
            StepKind.TELEGRAM_RENAMED: self._telegram_renamed,
            StepKind.MANAGER_HEARS: self._manager_hears,
            StepKind.MANAGER_EVENTS: self._manager_events,
            StepKind.BOUNDARY_PASSED: self._boundary_passed,
            StepKind.TERMINAL_HEARS: self._terminal_hears,
            StepKind.TERMINAL_EVENTS: self._terminal_events,
            StepKind.LOCKED_BY_HAND: self._locked_by_hand,
            StepKind.UNIT_ANEW: self._unit_anew,
            StepKind.TELEGRAM_ANEW: self._telegram_anew,
            StepKind.MANAGER_ANEW: self._manager_anew,
            StepKind.TERMINAL_ANEW: self._terminal_anew,
            StepKind.PERSONS_ERR: self._persons_err,
        }

    def make(self, kind: StepKind, *of: Any) -> Any:  # noqa: ANN401 - LocalStep, events or a number, by the kind
        """A step, made once: a `LocalStep`, a tuple of `LocalEvent`, or for what is renamed a number."""
        key = (kind, *of)
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = self._kinds[kind](*of)
            self.made.append((kind.value, *of))
        return found

    def digest(self) -> str:
        """Of all local states and telegrams found, in order."""
        code = blake2b(digest_size=16)
        found: list[list[Any]] = [self.managers.things, *(t.things for t in self.terminals)]
        found += [*(t.things for t in self.trains), self.telegrams.things]
        for thing in (thing for things in found for thing in things):
            code.update(in_one_order(thing).encode())
        return code.hexdigest()

    def manager_grants(self, manager: int) -> int:
        """Units (as bits) to whose last grant a request may still be a repetition."""
        return self._manager.grants(self.managers.things[manager])

    def held_by_register(self, manager: int) -> tuple[int, ...]:
        """By unit: what it holds by the register, as bits."""
        return self._manager.holders(self.managers.things[manager])

    # the steps --------------------------------------------------------------------------------------------------------

    def _unit_hears(self, unit: int, train: int, peer: int, telegram: int) -> LocalStep:
        known = self.trains[unit].things[train]
        after, sends = self.train_models[unit].hear(known, peer, self.telegrams.things[telegram])
        return LocalStep(self.trains[unit].number(after), self._sent(sends))

    def _unit_events(self, unit: int, train: int) -> tuple[LocalEvent, ...]:
        found = events(self.train_models[unit], self.trains[unit].things[train])
        return self._in_numbers(self.trains[unit], found)

    def _unit_renamed(self, unit: int, train: int, renamed: Renamed, counted: int) -> int:
        known, by = self.trains[unit].things[train], dict(renamed)
        numbers = known.numbers
        open_ = tuple((kind, by.get(number, number)) for kind, number in numbers.open)
        changed = known._replace(numbers=numbers._replace(open=open_, correlation=counted))
        return self.trains[unit].number(changed)

    def _telegram_renamed(self, telegram: int, correlation: int) -> int:
        return self.telegrams.number(self.telegrams.things[telegram]._replace(correlation=correlation))

    def _manager_hears(self, manager: int, unit: int, telegram: int, granted: int) -> LocalStep:
        known, heard = self.managers.things[manager], self.telegrams.things[telegram]
        after, sends, correlation = self._manager.hear(known, unit, heard, granted)
        return LocalStep(self.managers.number(after), self._sent(sends), correlation)

    def _manager_events(self, manager: int) -> tuple[LocalEvent, ...]:
        return self._in_numbers(self.managers, self._manager.events(self.managers.things[manager]))

    def _persons_err(self, manager: int) -> tuple[LocalEvent, ...]:
        return self._in_numbers(self.managers, self._manager.errs(self.managers.things[manager]))

    def _boundary_passed(self, manager: int) -> LocalStep:
        after, sends, _ = self._manager.boundary_passed(self.managers.things[manager])
        return LocalStep(self.managers.number(after), self._sent(sends))

    def _terminal_hears(self, index: int, terminal: int, unit: int, telegram: int) -> LocalStep:
        known, heard = self.terminals[index].things[terminal], self.telegrams.things[telegram]
        after, sends = self._terminal[index].hear(known, unit, heard)
        return LocalStep(self.terminals[index].number(after), self._sent(sends))

    def _terminal_events(self, index: int, terminal: int) -> tuple[LocalEvent, ...]:
        numbered = self.terminals[index]
        return self._in_numbers(numbered, self._terminal[index].events(numbered.things[terminal]))

    def _locked_by_hand(self, index: int, terminal: int, locked: int) -> LocalStep:
        known = self.terminals[index].things[terminal]
        after, sends = self._terminal[index].locked_by_hand(known, locked=bool(locked))
        return LocalStep(self.terminals[index].number(after), self._sent(sends))

    def _unit_anew(self, unit: int, train: int, bits: int) -> int:
        return self.trains[unit].number(tokens.train_anew(self.trains[unit].things[train], bits))

    def _telegram_anew(self, telegram: int, bits: int) -> int:
        return self.telegrams.number(tokens.telegram_anew(self.telegrams.things[telegram], bits))

    def _manager_anew(self, manager: int, bits: int) -> int:
        return self.managers.number(tokens.manager_anew(self.managers.things[manager], bits))

    def _terminal_anew(self, index: int, terminal: int, bits: int) -> int:
        numbered = self.terminals[index]
        return numbered.number(tokens.terminal_anew(numbered.things[terminal], bits))

    def _in_numbers(
        self, numbered: Numbered[T], found: Iterable[Happening[T, InAir]]
    ) -> tuple[LocalEvent, ...]:
        return tuple(
            LocalEvent(
                e.name,
                numbered.number(e.state),
                self._sent(e.sends),
                e.trouble,
                e.guard,
                e.left,
                e.locks,
                e.unlocks,
                e.about,
                e.stands,
                e.word,
                e.corrects,
                e.quiet,
            )
            for e in found
        )

    def _sent(self, sends: tuple[tuple[int, InAir], ...]) -> Sends:
        return tuple((to, self.telegrams.number(telegram)) for to, telegram in sends)


FIXED_MAX: Final = (
    2  # correlations that stay as they are: none, and the manager's own, one for each train that left
)


def renaming(in_use: Iterable[int], counted: int) -> tuple[Renamed, int]:
    """How the correlations in use are counted anew, in their order, and the count itself, the greatest of them."""
    greater = sorted({number for number in in_use if number > FIXED_MAX})
    renamed = tuple((number, index + FIXED_MAX + 1) for index, number in enumerate(greater))
    return renamed, min(counted, FIXED_MAX + len(greater))


def in_one_order(thing: Any) -> str:  # noqa: ANN401 - whatever a local state is made of
    """The text of a local state, the same in every process."""
    match thing:
        case frozenset():
            return "{" + ",".join(sorted(map(in_one_order, cast("frozenset[object]", thing)))) + "}"
        case tuple():
            return "(" + ",".join(map(in_one_order, cast("tuple[object, ...]", thing))) + ")"
        case msgspec.Struct():
            fields = (getattr(thing, name) for name in thing.__struct_fields__)
            return type(thing).__name__ + "(" + ",".join(map(in_one_order, fields)) + ")"
        case _ if hasattr(thing, "key"):
            return in_one_order(thing.key)
        case _ if hasattr(thing, "__dataclass_fields__"):
            return type(thing).__name__ + in_one_order(
                tuple(getattr(thing, name) for name in thing.__dataclass_fields__)
            )
        case _:
            return repr(thing)
