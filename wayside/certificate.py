"""Invariant: where `finishing_order` returns an order, every train comes to its end in it, and none ever enters what
another holds; where it says that there is none, there is none.

The proof that all trains of a line can still finish, as a pure function: a train goes from track to track by the moves
of its plan, one after the other or with a choice between tracks, needs all sections of a move free of others, and holds
the last of them afterwards, or nothing off the line. An order in which all come to their end shows that nobody is
stuck; that there is none, who is in whose way. Moves count as done when they are granted, since what a train holds it
can always run.

The search tries the moves in the order that it is given, and takes back only what it has to. Where it comes to an end
it keeps for ever which few trains could not go on from where they were: from there others need not be tried, and no
state in which these stand so again (nogoods with backjumping, as in Dechter, Constraint Processing, ch. 6). From the
first such end on it also knows of every two trains where they get into each other's way (`wayside.pairs`), runs a train
at once that comes to where it is in nobody's way, and begins anew from time to time in another order of trains, as a
search that began badly may take for ever. Every restart keeps what was learned, so that all of it comes to an end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import reduce
from typing import Final

import msgspec

from wayside.moves import Train
from wayside.pairs import Pairs

STEPS_MAX: Final = 4000  # assumed: moves tried beyond one for each that is to be made, some 40 ms
ANEW_STEPS: Final = 300  # assumed: then the search begins anew, a third later each time
LATER: Final = 1.3


class CertificateProof(Enum):
    """What a search has shown."""

    ORDER = "all can finish"
    NONE = "there is no order in which all can finish"
    UNKNOWN = "none was found within the steps that the search has"


class CertificateAnswer(msgspec.Struct, frozen=True):
    """The answer. `order`: trains by index, a move each, and `moves`: which of its moves that is; `circle`: trains that
    were in each other's way, by index. Where there is no order, they alone have none.
    """

    proof: CertificateProof
    order: tuple[int, ...] = ()
    circle: tuple[int, ...] = ()
    steps: int = 0
    moves: tuple[int, ...] = ()


def finishing_order(trains: Sequence[Train], steps_max: int = STEPS_MAX) -> CertificateAnswer:
    """An order in which all trains can finish; what is due first goes first where it can."""
    return _Search(trains).run(steps_max)


def follows(trains: Sequence[Train], order: Sequence[int]) -> bool:
    """Whether the trains can make their moves in this order, one after the other; for trains that have no choice."""
    line = _Line(trains)
    for index in order:
        if line.ended(index) or line.blocked(index, line.at[index]):
            return False
        line.make(index, line.at[index])
    return True


class _Line:
    """Where all trains are, and what they hold."""

    def __init__(self, trains: Sequence[Train]) -> None:
        self._trains = trains
        self.choices = [train.choices_at() for train in trains]
        self.at = [0] * len(trains)
        self.holds = [train.holds for train in trains]
        self.running = sum(bool(choices[0]) for choices in self.choices)
        self.taken = 0
        self.shared = 0  # what several wait for outside is taken until the last has gone
        for held in self.holds:
            self.shared |= self.taken & held
            self.taken |= held

    def ended(self, index: int) -> bool:
        """Whether it has come to its end."""
        return not self.choices[index][self.at[index]]

    def blocked(self, index: int, move: int) -> int:
        """What others hold of what a move needs."""
        return self._trains[index].ahead[move].needs & self.taken & ~self.holds[index]

    def make(self, index: int, move: int) -> tuple[int, int]:
        """A move of it; where it was, and what it held before."""
        before = self.at[index], self.holds[index]
        self._hold(index, self._trains[index].ahead[move].keeps)
        self.at[index] = move + 1
        self.running -= self.ended(index)
        return before

    def take_back(self, index: int, before: tuple[int, int]) -> None:
        """Its last move."""
        self.running += self.ended(index)
        self.at[index] = before[0]
        self._hold(index, before[1])

    def _hold(self, index: int, sections: int) -> None:
        held, self.holds[index] = self.holds[index], sections
        self.taken = (self.taken & ~held) | sections
        if held & self.shared:
            for other in self.holds:
                self.taken |= other


@dataclass(slots=True)
class _Branch:
    """A state on the way: moves that can be made and were not tried, as train and move, the first to be tried at the
    end; the move that led to it, and what takes that back.

    `alone`: the one move costs nobody anything; `stuck`: trains, as bits, that cannot go on as far as was tried, and
    `seen` those of them of which it is known who blocks their other moves; `over`: they are enough.
    """

    choices: list[tuple[int, int]]
    alone: bool = False
    mover: int = -1
    move: int = -1
    before: tuple[int, int] = (0, 0)
    stuck: int = 0
    seen: int = 0
    over: bool = False


@dataclass(slots=True)
class _Learned:
    """A few trains, and all places found in which they alone cannot finish."""

    trains: tuple[int, ...]
    bits: int
    places: set[tuple[int, ...]] = field(default_factory=set[tuple[int, ...]])


class _Search:
    """Depth first over the places of the trains, the moves due first before others."""

    def __init__(self, trains: Sequence[Train]) -> None:
        self._trains = trains
        self._line = _Line(trains)
        self._pairs: Pairs | None = None
        self._learned: dict[int, _Learned] = {}
        self._learned_of: list[list[_Learned]] = [[] for _ in trains]
        self._circle: tuple[int, ...] = ()  # the trains that were first seen to be stuck
        self._anew = 0
        # What a train may need from a place on, as what is in nobody's plan any more is no obstacle; and what it needs
        # whichever way it goes.
        self._wants = [_needed(train, int.__or__) for train in trains]
        self._musts = [
            _needed(train, int.__and__) if train.choices else wants
            for train, wants in zip(trains, self._wants, strict=True)
        ]

    def run(self, steps_max: int) -> CertificateAnswer:
        """Search; the order found has all moves."""
        for index in range(len(self._trains)):
            if stuck := self._stuck(index):
                return CertificateAnswer(CertificateProof.NONE, circle=_indices(stuck))
        least = sum(len(train.ahead) for train in self._trains)
        steps, anew = 0, float(least + ANEW_STEPS)
        while True:
            branches = [self._branch()]
            until = steps + int(anew)
            while self._line.running:
                branch = branches[-1]
                choice = self._next(branch)
                if choice is None:
                    self._learn(branch.stuck)
                    branches.pop()
                    if not branches:
                        return CertificateAnswer(CertificateProof.NONE, (), _indices(branch.stuck), steps)
                    self._line.take_back(branch.mover, branch.before)
                    self._failed(branches[-1], branch.mover, branch.stuck)
                    continue
                if steps >= least + steps_max:
                    return CertificateAnswer(CertificateProof.UNKNOWN, (), self._circle, steps)
                if steps >= until:
                    break
                steps += 1
                mover, move = choice
                branch.choices.remove(choice)
                before = self._line.make(mover, move)
                if stuck := self._stuck(mover):
                    self._line.take_back(mover, before)
                    self._failed(branch, mover, stuck)
                else:
                    following = self._branch()
                    following.mover, following.move, following.before = mover, move, before
                    branches.append(following)
            else:
                return CertificateAnswer(
                    CertificateProof.ORDER,
                    tuple(branch.mover for branch in branches[1:]),
                    self._circle,
                    steps,
                    tuple(branch.move for branch in branches[1:]),
                )
            for branch in reversed(branches[1:]):
                self._line.take_back(branch.mover, branch.before)
            self._anew, anew = self._anew + 1, LATER * anew

    # which train next -------------------------------------------------------------------------------------------

    def _branch(self) -> _Branch:
        """The moves that can be made; one alone where it costs nobody anything."""
        line = self._line
        possible: list[tuple[float, int, int]] = []
        for index, train in enumerate(self._trains):
            for move in line.choices[index][line.at[index]]:
                if line.blocked(index, move):
                    continue
                if self._runs_clear(index, move):
                    return _Branch([(index, move)], alone=True)
                due = self._mixed(index, move) if self._anew else train.ahead[move].due_s
                possible.append((-due, -index, -move))
        possible.sort()
        return _Branch([(-index, -move) for _, index, move in possible])

    def _runs_clear(self, index: int, move: int) -> bool:
        """Whether it leaves the line, or once there was a dead end can run on to where it is in nobody's way: off the
        line whichever way it goes, else where it has no choice on the way, as another may be its only good one.
        """
        ahead, choices = self._trains[index].ahead, self._line.choices[index]
        others = self._line.taken & (~self._line.holds[index] | self._line.shared)
        ways, seen = [(move, len(choices[self._line.at[index]]) == 1)], {move}
        while ways:
            move, only = ways.pop()
            then, keeps = choices[move + 1], ahead[move].keeps
            if ahead[move].needs & others:
                continue
            if not keeps and (only or not then):
                return True
            if self._pairs is None:
                return False
            if only and self._another(index, keeps, self._wants) is None:
                return True
            ways += [(following, only and len(then) == 1) for following in then if following not in seen]
            seen.update(then)
        return False

    def _another(self, holder: int, sections: int, needs: list[list[int]]) -> int | None:
        at = self._line.at
        for index, needed in enumerate(needs):
            if index != holder and sections & needed[at[index]]:
                return index
        return None

    def _mixed(self, index: int, move: int) -> float:
        """Another order of trains at each new beginning, at each move otherwise; the same in every run."""
        mixed = (index + 1) * 0x9E3779B1 ^ (move + 1) * 0x85EBCA6B ^ self._anew * 0xC2B2AE35
        return float((mixed * 0x27D4EB2F >> 7) & 0xFFFF)

    def _next(self, branch: _Branch) -> tuple[int, int] | None:
        """The move to be tried next; None: whatever comes next, those that are `stuck` cannot all finish."""
        if branch.over:
            return None
        if not branch.stuck:
            if branch.choices:
                return branch.choices[-1]
            branch.stuck = 1 << next(
                index for index in range(len(self._trains)) if not self._line.ended(index)
            )
        while True:
            for choice in reversed(branch.choices):
                if branch.stuck >> choice[0] & 1:
                    return choice
            if not branch.stuck & ~branch.seen:
                return None
            for index in _indices(branch.stuck & ~branch.seen):
                branch.seen |= 1 << index
                for move in self._line.choices[index][self._line.at[index]]:
                    holders = self._holders(index, move)
                    if holders and not any(branch.stuck >> holder & 1 for holder in holders):
                        branch.stuck |= 1 << holders[0]

    def _holders(self, index: int, move: int) -> tuple[int, ...]:
        """The trains that hold what a move of one needs."""
        blocked = self._line.blocked(index, move)
        return tuple(i for i, held in enumerate(self._line.holds) if i != index and held & blocked)

    # what is learned --------------------------------------------------------------------------------------------

    def _failed(self, branch: _Branch, mover: int, stuck: int) -> None:
        """After that move these trains cannot finish; nor before, if it is none of theirs or costs nobody anything."""
        self._circle = self._circle or _indices(stuck)
        self._pairs = self._pairs or Pairs(self._trains)
        if branch.alone or not stuck >> mover & 1:
            branch.stuck, branch.over = stuck, True
        else:
            branch.stuck |= stuck

    def _learn(self, stuck: int) -> None:
        learned = self._learned.get(stuck)
        if learned is None:
            learned = self._learned[stuck] = _Learned(_indices(stuck), stuck)
            for index in learned.trains:
                self._learned_of[index].append(learned)
        learned.places.add(tuple([self._line.at[index] for index in learned.trains]))

    def _stuck(self, mover: int) -> int:
        """Trains, as bits, that cannot finish now that this one is where it is, as far as is seen at once; 0: none."""
        at, held = self._line.at, self._line.holds[mover]
        other: int | None = None
        if self._pairs is not None:
            other = self._pairs.dead(at, mover)
        if other is None and held and self._line.ended(mover):
            other = self._another(mover, held, self._musts)
        if other is not None:
            return 1 << mover | 1 << other
        for learned in self._learned_of[mover]:
            if tuple([at[index] for index in learned.trains]) in learned.places:
                return learned.bits
        return self._in_a_circle(mover)

    def _in_a_circle(self, mover: int) -> int:
        """From the train to those that hold what its next move needs, and on, until it comes again."""
        before = {mover: -1}
        stack = [mover]
        while stack:
            index = stack.pop()
            choices = self._line.choices[index][self._line.at[index]]
            # one that has a choice may have a way out, and is seen to be stuck at the dead end
            if len(choices) != 1:
                continue
            for other in self._holders(index, choices[0]):
                if other == mover:
                    return sum(1 << i for i in _chain(before, index))
                if other not in before:
                    before[other] = index
                    stack.append(other)
        return 0


def _needed(train: Train, either: Callable[[int, int], int]) -> list[int]:
    """For each place what the train needs from there on."""
    choices = train.choices_at()
    needed = [0] * len(choices)
    for place in range(len(train.ahead) - 1, -1, -1):
        ways = [train.ahead[move].needs | needed[move + 1] for move in choices[place]]
        needed[place] = reduce(either, ways) if ways else 0
    return needed


def _chain(before: dict[int, int], index: int) -> Iterator[int]:
    while index >= 0:
        yield index
        index = before[index]


def _indices(bits: int) -> tuple[int, ...]:
    return tuple(index for index in range(bits.bit_length()) if bits >> index & 1)
