"""Invariant: where `finish` returns an order, every train makes all its moves in it, and none ever enters what another
holds; where it says that there is none, there is none.

The proof that all trains of a line can still finish, as a pure function: a train goes from track to track by the moves
of its plan, needs all sections of a move free of others, and holds the last of them afterwards, or nothing off the
line. An order in which all come to their end shows that nobody is stuck; that there is none, who is in whose way. Moves
count as done when they are granted, since what a train holds it can always run.

The search tries the moves in the order that it is given, and takes back only what it has to. Where it comes to an end
it keeps for ever which few trains could not go on from where they were: from there others need not be tried, and no
state in which these stand so again (nogoods with backjumping, as in Dechter, Constraint Processing, ch. 6). From the
first such end on it also knows of every two trains where they get into each other's way (`wayside.pairs`), runs a train
at once that comes to where it is in nobody's way, and begins anew from time to time in another order of trains, as a
search that began badly may take for ever. Every restart keeps what was learned, so that all of it comes to an end.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Final

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


@dataclass(frozen=True, slots=True)
class CertificateAnswer:
    """The answer. `order`: trains by index, a move each; `circle`: trains that were in each other's way, by index.
    Where there is no order, they alone have none.
    """

    proof: CertificateProof
    order: tuple[int, ...] = ()
    circle: tuple[int, ...] = ()
    steps: int = 0


def finishing_order(trains: Sequence[Train], steps_max: int = STEPS_MAX) -> CertificateAnswer:
    """An order in which all trains can finish; what is due first goes first where it can."""
    return _Search(trains).run(steps_max)


def follows(trains: Sequence[Train], order: Sequence[int]) -> bool:
    """Whether the trains can make their moves in this order, one after the other."""
    line = _Line(trains)
    for index in order:
        if line.ended(index) or line.blocked(index):
            return False
        line.make(index)
    return True


class _Line:
    """Where all trains are, and what they hold."""

    def __init__(self, trains: Sequence[Train]) -> None:
        self._trains = trains
        self.at = [0] * len(trains)
        self.holds = [train.holds for train in trains]
        self.left = sum(len(train.ahead) for train in trains)
        self.taken = 0
        self._shared = 0  # what several wait for outside is taken until the last has gone
        for held in self.holds:
            self._shared |= self.taken & held
            self.taken |= held

    def ended(self, index: int) -> bool:
        """Whether it has made all its moves."""
        return self.at[index] == len(self._trains[index].ahead)

    def blocked(self, index: int) -> int:
        """What others hold of what its next move needs."""
        return self._trains[index].ahead[self.at[index]].needs & self.taken & ~self.holds[index]

    def make(self, index: int) -> int:
        """Its next move; what it held before."""
        held = self.holds[index]
        self._hold(index, self._trains[index].ahead[self.at[index]].keeps)
        self.at[index] += 1
        self.left -= 1
        return held

    def take_back(self, index: int, held: int) -> None:
        """Its last move."""
        self._hold(index, held)
        self.at[index] -= 1
        self.left += 1

    def _hold(self, index: int, sections: int) -> None:
        held, self.holds[index] = self.holds[index], sections
        self.taken = (self.taken & ~held) | sections
        if held & self._shared:
            for other in self.holds:
                self.taken |= other


@dataclass(slots=True)
class _Branch:
    """A state on the way: trains that can move, the first to be tried at the end, and what takes it back.

    `alone`: the one move costs nobody anything; `stuck`: trains, as bits, that cannot go on as far as was tried, and
    `tried` those of them that were; `over`: they are enough.
    """

    choices: list[int]
    alone: bool
    mover: int = -1
    held: int = 0
    stuck: int = 0
    tried: int = 0
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
        # What each train needs from a place on: what is in nobody's plan any more is no obstacle.
        self._wants: list[list[int]] = []
        for train in trains:
            wants = [0]
            for move in reversed(train.ahead):
                wants.append(wants[-1] | move.needs)
            self._wants.append(wants[::-1])

    def run(self, steps_max: int) -> CertificateAnswer:
        """Search; the order found has all moves."""
        for index in range(len(self._trains)):
            if stuck := self._stuck(index):
                return CertificateAnswer(CertificateProof.NONE, (), _indices(stuck))
        steps, least, anew = 0, self._line.left, float(self._line.left + ANEW_STEPS)
        while True:
            branches = [self._branch()]
            until = steps + int(anew)
            while self._line.left:
                branch = branches[-1]
                mover = self._next(branch)
                if mover is None:
                    self._learn(branch.stuck)
                    branches.pop()
                    if not branches:
                        return CertificateAnswer(CertificateProof.NONE, (), _indices(branch.stuck), steps)
                    self._line.take_back(branch.mover, branch.held)
                    self._failed(branches[-1], branch.mover, branch.stuck)
                    continue
                if steps >= least + steps_max:
                    return CertificateAnswer(CertificateProof.UNKNOWN, (), self._circle, steps)
                if steps >= until:
                    break
                steps += 1
                held = self._line.make(mover)
                if stuck := self._stuck(mover):
                    self._line.take_back(mover, held)
                    self._failed(branch, mover, stuck)
                else:
                    branches.append(self._branch(mover, held))
            else:
                return CertificateAnswer(
                    CertificateProof.ORDER, tuple(b.mover for b in branches[1:]), self._circle, steps
                )
            for branch in reversed(branches[1:]):
                self._line.take_back(branch.mover, branch.held)
            self._anew, anew = self._anew + 1, LATER * anew

    # which train next -------------------------------------------------------------------------------------------

    def _branch(self, mover: int = -1, held: int = 0) -> _Branch:
        """The trains that can move; one alone where its move costs nobody anything."""
        line = self._line
        possible: list[tuple[float, int]] = []
        for index, train in enumerate(self._trains):
            if line.ended(index) or line.blocked(index):
                continue
            if self._runs_clear(index):
                return _Branch([index], True, mover, held)
            due = self._mixed(index) if self._anew else train.ahead[line.at[index]].due_s
            possible.append((-due, -index))
        possible.sort()
        return _Branch([-index for _, index in possible], False, mover, held)

    def _runs_clear(self, index: int) -> bool:
        """Whether it leaves the line, or once there was a dead end can run on to where it is in nobody's way."""
        ahead, others = self._trains[index].ahead, self._line.taken & ~self._line.holds[index]
        for place in range(self._line.at[index], len(ahead)):
            move = ahead[place]
            if move.needs & others:
                return False
            if not move.keeps:
                return True
            if self._pairs is None:
                return False
            if self._wanted_by(index, move.keeps) is None:
                return True
        return False

    def _wanted_by(self, holder: int, sections: int) -> int | None:
        """A train that still needs some of these sections; None: no other does."""
        at = self._line.at
        for index, wants in enumerate(self._wants):
            if index != holder and sections & wants[at[index]]:
                return index
        return None

    def _mixed(self, index: int) -> float:
        """Another order of trains at each new beginning, at each place otherwise; the same in every run."""
        mixed = (index + 1) * 0x9E3779B1 ^ (self._line.at[index] + 1) * 0x85EBCA6B ^ self._anew * 0xC2B2AE35
        return float((mixed * 0x27D4EB2F >> 7) & 0xFFFF)

    def _next(self, branch: _Branch) -> int | None:
        """The train to be tried next; None: whoever goes next, those that are `stuck` cannot all finish."""
        if branch.over:
            return None
        if not branch.stuck:
            if branch.choices:
                return branch.choices[-1]
            branch.stuck = 1 << next(
                index for index in range(len(self._trains)) if not self._line.ended(index)
            )
        while True:
            for index in reversed(branch.choices):
                if branch.stuck & ~branch.tried & 1 << index:
                    return index
            if not branch.stuck & ~branch.tried:
                return None
            for index in _indices(branch.stuck & ~branch.tried):  # none of these can move
                branch.tried |= 1 << index
                if not self._line.ended(index):
                    holders = self._holders(index)
                    if not any(branch.stuck >> holder & 1 for holder in holders):
                        branch.stuck |= 1 << holders[0]

    def _holders(self, index: int) -> tuple[int, ...]:
        """The trains that hold what the next move of one needs."""
        blocked = self._line.blocked(index)
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
            branch.tried |= 1 << mover

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
        elif held and self._line.ended(mover):
            other = self._wanted_by(mover, held)
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
            if self._line.ended(index) or not self._line.blocked(index):
                continue
            for other in self._holders(index):
                if other == mover:
                    return sum(1 << i for i in _chain(before, index))
                if other not in before:
                    before[other] = index
                    stack.append(other)
        return 0


def _chain(before: dict[int, int], index: int) -> Iterator[int]:
    while index >= 0:
        yield index
        index = before[index]


def _indices(bits: int) -> tuple[int, ...]:
    return tuple(index for index in range(bits.bit_length()) if bits >> index & 1)
