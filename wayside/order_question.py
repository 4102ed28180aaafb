"""The question of order as it is put to a solver, and its answer: what each train has and has still to do.

In blocks and seconds: times are whole seconds from now, sections numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import msgspec

ALL: Final = -1  # the order is asked for all, not for one that asks


class OrderWay(msgspec.Struct, frozen=True, array_like=True):
    """One of several ways to make a move: from the track `here`, with all `needs`, to where it `keeps` a section."""

    here: int
    needs: tuple[int, ...]
    keeps: tuple[int, ...]


class OrderMove(msgspec.Struct, frozen=True, array_like=True):
    """A move: not before `departs_s`, `runs_s` long; then it stays at least `stays_s`. It is to end at `due_s`.

    Where it `counts`, as a train ends there, each second later costs one. `others`: other ways to make it than the
    planned one, from the track `here`.
    """

    needs: tuple[int, ...]
    keeps: tuple[int, ...]
    departs_s: int
    runs_s: int
    stays_s: int
    due_s: int
    counts: bool
    here: int = -1
    others: tuple[OrderWay, ...] = ()


class OrderTrain(msgspec.Struct, frozen=True, array_like=True):
    """A stock: it has `holds` until it has come, in `comes_s`, to where it `keeps` a section, ready `ready_s` later.

    `stood_s`: for how long it is overdue and has not asked; then nobody knows when it is ready.
    """

    holds: tuple[int, ...]
    comes_s: int
    keeps: tuple[int, ...]
    ready_s: int
    moves: tuple[OrderMove, ...]
    stood_s: int = 0


class OrderQuestion(msgspec.Struct, frozen=True, array_like=True):
    """All stock, what is left of the order found last, with the `ends` of its moves, how far is looked ahead, and how
    much the solver may work. `asks`: which of them, if it is asked for one; `late_s`: from when on the plan is left.
    """

    trains: tuple[OrderTrain, ...]
    order: tuple[int, ...]
    ahead_s: int
    work_max: float
    ends: tuple[int, ...] = ()
    asks: int = ALL
    late_s: int = 0


class OrderAnswer(msgspec.Struct, frozen=True, array_like=True):
    """Trains by index in the order in which their moves begin, all delay in it, and below which there is none, s.

    `lacking`: why there is no order; empty where there is one. `ends`: for each of the order the section where its move
    ends, -1 off the line. `otherwise_s`: where one asks, all delay in the mean if it does not as the order has it.
    """

    order: tuple[int, ...] = ()
    delay_s: int = 0
    bound_s: int = 0
    lacking: str = ""
    ends: tuple[int, ...] = ()
    otherwise_s: int | None = None


OrderSolver = Callable[[OrderQuestion], OrderAnswer]


@dataclass(frozen=True, slots=True)
class LastOrder:
    """The answer given last: when, how many moves each stock had made then, and which were overdue (`awaited`)."""

    made_s: float
    at: tuple[int, ...]
    answer: OrderAnswer
    awaited: tuple[int, ...] = ()

    def left(self, at: tuple[int, ...]) -> list[tuple[int, int]]:
        """What is left of it: stock and place in its day, in order."""
        places, found = list(self.at), list[tuple[int, int]]()
        for index in self.answer.order:
            if places[index] >= at[index]:
                found.append((index, places[index]))
            places[index] += 1
        return found

    def ends_left(self, at: tuple[int, ...]) -> tuple[int, ...]:
        """The ends of what is left of it."""
        places, found = list(self.at), list[int]()
        for index, end in zip(self.answer.order, self.answer.ends, strict=False):
            if places[index] >= at[index]:
                found.append(end)
            places[index] += 1
        return tuple(found)

    def end_of(self, index: int, place: int) -> int | None:
        """The section, by number, where a move of a stock ends; None: the order does not say."""
        at = place - self.at[index]
        own = [end for each, end in zip(self.answer.order, self.answer.ends, strict=False) if each == index]
        return own[at] if 0 <= at < len(own) else None


def without_solver(_: OrderQuestion) -> OrderAnswer:
    """What is answered where nobody can solve it."""
    return OrderAnswer(lacking="there is no solver: the extra `plan` is not installed")
