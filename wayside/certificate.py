"""Invariant: where `finish` returns an order, every train makes all its moves in it, and none ever enters what another
holds; where it says that there is none, there is none.

The proof that all trains of a line can still finish, as a pure function: a train goes from track to track by the moves
of its plan, needs all sections of a move free of others, and holds the last of them afterwards, or nothing off the
line. An order in which all come to their end shows that nobody is stuck; that there is none, who is in whose way. Moves
count as done when they are granted, since what a train holds it can always run.

The search tries the moves in the order that it is given, and takes back only what it has to: a train that leaves the
line is in nobody's way, trains that wait for each other in a circle end a try at once, and no state is tried twice.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final

STEPS_MAX: Final = 2000  # assumed: moves tried before the search gives up, some 10 ms
CORES_MAX: Final = 4  # assumed: so many groups of a few trains are looked at then


@dataclass(frozen=True, slots=True)
class Move:
    """From one track to the next. Sections are bits: `needs` must be free of others, `keeps` is held afterwards."""

    needs: int
    keeps: int
    due_s: float = 0.0  # when it is planned: what is due first is tried first


@dataclass(frozen=True, slots=True)
class Train:
    """A train with what it holds, and the moves that it still has to make."""

    holds: int
    ahead: tuple[Move, ...]


class Proof(Enum):
    """What a search has shown."""

    ORDER = "all can finish"
    NONE = "there is no order in which all can finish"
    UNKNOWN = "none was found within the steps that the search has"


@dataclass(frozen=True, slots=True)
class Found:
    """The answer. `order`: trains by index, a move each; `circle`: trains that were in each other's way, by index."""

    proof: Proof
    order: tuple[int, ...] = ()
    circle: tuple[int, ...] = ()
    steps: int = 0


def finish(trains: Sequence[Train], steps_max: int = STEPS_MAX) -> Found:
    """An order in which all trains can finish; what is due first goes first where it can.

    A search that runs out of steps looks whether a few trains alone cannot finish: then all cannot.
    """
    search = _Search(trains)
    found = search.run(steps_max)
    core = set(found.circle)
    for _ in range(CORES_MAX):
        if found.proof is not Proof.UNKNOWN or not 0 < len(core) < len(trains):
            break
        few = tuple(sorted(core))
        alone = _Search([trains[index] for index in few]).run(steps_max)
        if alone.proof is Proof.NONE:
            return Found(Proof.NONE, (), few, found.steps + alone.steps)
        before = len(core)
        core.update(search.in_the_way(few))
        if len(core) == before:
            break
    return found


def follows(trains: Sequence[Train], order: Sequence[int]) -> bool:
    """Whether the trains can make their moves in this order, one after the other."""
    at = [0] * len(trains)
    holds = [train.holds for train in trains]
    taken = 0
    for held in holds:
        taken |= held
    for index in order:
        ahead = trains[index].ahead
        if at[index] >= len(ahead):
            return False
        move, own = ahead[at[index]], holds[index]
        if move.needs & taken & ~own:
            return False
        taken = (taken & ~own) | move.keeps
        holds[index] = move.keeps
        at[index] += 1
    return True


@dataclass(slots=True)
class _Branch:
    """A state on the way: the moves still to be tried from it, and what takes it back to the state before."""

    choices: list[int]
    mover: int = -1
    held: int = 0


class _Search:
    """Depth first over the places of the trains, the moves due first before others."""

    def __init__(self, trains: Sequence[Train]) -> None:
        self._trains = trains
        self._at = [0] * len(trains)
        self._holds = [train.holds for train in trains]
        self._left = sum(len(train.ahead) for train in trains)
        self._order: list[int] = []
        self._circles: dict[tuple[int, ...], None] = {}
        self._taken = 0
        for held in self._holds:
            self._taken |= held
        # What each train needs from a place on: what is in nobody's plan any more is no obstacle.
        self._wants: list[list[int]] = []
        for train in trains:
            wants = [0]
            for move in reversed(train.ahead):
                wants.append(wants[-1] | move.needs)
            self._wants.append(wants[::-1])

    def run(self, steps_max: int) -> Found:
        """Search; the order found has all moves."""
        if any(self._stuck(index) for index in range(len(self._trains))):
            return self._answer(Proof.NONE, 0)
        seen: set[tuple[int, ...]] = set()
        branches = [_Branch(self._choices(careful=False))]
        steps = 0
        while self._left:
            branch = branches[-1]
            if not branch.choices:
                branches.pop()
                if not branches:
                    return self._answer(Proof.NONE, steps)
                self._take_back(branch)
                continue
            if steps >= steps_max:
                return self._answer(Proof.UNKNOWN, steps)
            index = branch.choices.pop()
            steps += 1
            held = self._make(index)
            key = tuple(self._at)
            if key in seen or self._stuck(index):
                self._take_back(_Branch([], index, held))
                continue
            seen.add(key)
            branches.append(_Branch(self._choices(careful=bool(self._circles)), index, held))
        return self._answer(Proof.ORDER, steps)

    def in_the_way(self, few: Sequence[int]) -> Iterator[int]:
        """Trains that stood in a circle with one of these, the circle seen first."""
        for circle in self._circles:
            if set(circle) & set(few) and not set(circle) <= set(few):
                yield from circle
                return

    def _answer(self, proof: Proof, steps: int) -> Found:
        circle = next(iter(self._circles), ())
        return Found(proof, tuple(self._order) if proof is Proof.ORDER else (), circle, steps)

    def _choices(self, *, careful: bool) -> list[int]:
        """Trains that can move, the first to be tried at the end; one alone where its move costs nobody anything."""
        possible: list[tuple[float, int]] = []
        taken, at, holds = self._taken, self._at, self._holds
        for index, train in enumerate(self._trains):
            if at[index] == len(train.ahead):
                continue
            move = train.ahead[at[index]]
            if move.needs & taken & ~holds[index]:
                continue
            if not move.keeps or (careful and self._unwanted(index, move.keeps)):
                return [index]
            possible.append((-move.due_s, -index))
        possible.sort()
        return [-index for _, index in possible]

    def _unwanted(self, mover: int, keeps: int) -> bool:
        """Whether no other train needs what the mover would hold."""
        wants, at = self._wants, self._at
        return not any(
            keeps & wants[index][at[index]] for index in range(len(self._trains)) if index != mover
        )

    def _make(self, index: int) -> int:
        held = self._holds[index]
        keeps = self._trains[index].ahead[self._at[index]].keeps
        self._taken = (self._taken & ~held) | keeps
        self._holds[index] = keeps
        self._at[index] += 1
        self._left -= 1
        self._order.append(index)
        return held

    def _take_back(self, branch: _Branch) -> None:
        index = branch.mover
        self._taken = (self._taken & ~self._holds[index]) | branch.held
        self._holds[index] = branch.held
        self._at[index] -= 1
        self._left += 1
        self._order.pop()

    def _stuck(self, mover: int) -> bool:
        """Whether the train, where it is now, waits in a circle, or stands at its end where others must pass."""
        ahead, at = self._trains[mover].ahead, self._at[mover]
        held = self._holds[mover]
        if at == len(ahead):
            if not held or self._unwanted(mover, held):
                return False
            stopped = next(
                i for i, wants in enumerate(self._wants) if i != mover and held & wants[self._at[i]]
            )
            self._circles.setdefault((mover, stopped))
            return True
        circle = self._circle(mover)
        if circle:
            self._circles.setdefault(circle)
        return bool(circle)

    def _circle(self, mover: int) -> tuple[int, ...]:
        """From the train to those that hold what its next move needs, and on, until it comes again."""
        before = {mover: -1}
        stack = [mover]
        while stack:
            index = stack.pop()
            at, ahead = self._at[index], self._trains[index].ahead
            if at == len(ahead):
                continue
            blocked = ahead[at].needs & self._taken & ~self._holds[index]
            if not blocked:
                continue
            for other, held in enumerate(self._holds):
                if not held & blocked:
                    continue
                if other == mover:
                    chain = [index]
                    while before[chain[-1]] >= 0:
                        chain.append(before[chain[-1]])
                    return tuple(chain[::-1])
                if other not in before:
                    before[other] = index
                    stack.append(other)
        return ()
