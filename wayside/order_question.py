"""The question of order as it is put to a solver, and its answer: what each train has and has still to do.

In blocks and seconds: times are whole seconds from now, sections numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import msgspec


class OrderMove(msgspec.Struct, frozen=True, array_like=True):
    """A move: not before `departs_s`, `runs_s` long; then it stays at least `stays_s`. It is to end at `due_s`.

    Where it `counts`, as a train ends there, each second later costs one.
    """

    needs: tuple[int, ...]
    keeps: tuple[int, ...]
    departs_s: int
    runs_s: int
    stays_s: int
    due_s: int
    counts: bool


class OrderTrain(msgspec.Struct, frozen=True, array_like=True):
    """A stock: it has `holds` until it has come, in `comes_s`, to where it `keeps` a section, ready `ready_s` later."""

    holds: tuple[int, ...]
    comes_s: int
    keeps: tuple[int, ...]
    ready_s: int
    moves: tuple[OrderMove, ...]


class OrderQuestion(msgspec.Struct, frozen=True, array_like=True):
    """All stock, what is left of the order found last, how far is looked ahead, and how much the solver may work."""

    trains: tuple[OrderTrain, ...]
    order: tuple[int, ...]
    ahead_s: int
    work_max: float


class OrderAnswer(msgspec.Struct, frozen=True, array_like=True):
    """Trains by index in the order in which their moves begin, all delay in it, and below which there is none, s.

    `lacking`: why there is no order; empty where there is one.
    """

    order: tuple[int, ...] = ()
    delay_s: int = 0
    bound_s: int = 0
    lacking: str = ""


OrderSolver = Callable[[OrderQuestion], OrderAnswer]


@dataclass(frozen=True, slots=True)
class LastOrder:
    """The answer given last: when, and how many moves each stock had made then."""

    made_s: float
    at: tuple[int, ...]
    answer: OrderAnswer

    def left(self, at: tuple[int, ...]) -> list[tuple[int, int]]:
        """What is left of it: stock and place in its day, in order."""
        places, found = list(self.at), list[tuple[int, int]]()
        for index in self.answer.order:
            if places[index] >= at[index]:
                found.append((index, places[index]))
            places[index] += 1
        return found


def without_solver(_: OrderQuestion) -> OrderAnswer:
    """What is answered where nobody can solve it."""
    return OrderAnswer(lacking="there is no solver: the extra `plan` is not installed")
