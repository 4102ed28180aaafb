"""Moves of legs for OR-Tools' CP-SAT, in one day or with a period: who is first is its choice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from ortools.sat.python import cp_model

from plan.moving.bounds import EitherFirst, LegBounds, MoveBound

SEED: Final = 1


@dataclass(frozen=True, slots=True)
class FoundMoves:
    """The moves of all legs, ticks (None: none were found), and below what the cost cannot be.

    `impossible`: proven that there are none. `work`: what the solver counts as work done, the same on every machine.
    """

    moves: tuple[int, ...] | None
    cost: int
    cost_min: int
    impossible: bool
    work: float

    @property
    def proven(self) -> bool:
        """Whether no moves cost less."""
        return self.moves is not None and self.cost <= self.cost_min


class MovingModel:
    """A CP-SAT model of legs that are moved. `model` and `moves` are open: what else is asked or minimised is added.

    `between`: the least and the greatest move of each leg, ticks. `period`: of all trains, ticks; None where each runs
    once. With a period `bounds.in_a_period` is as much as need be looked through.
    """

    def __init__(
        self, bounds: LegBounds, between: Sequence[tuple[int, int]], period: int | None = None
    ) -> None:
        self.bounds: Final = bounds
        self.period: Final = period
        self.model: Final = cp_model.CpModel()
        self.moves: Final = [self.model.new_int_var(least, most, "") for least, most in between]
        self.first: Final[
            list[cp_model.IntVar]
        ] = []  # of `bounds.either`: whether the one is, or by how many periods
        self._between = between
        for bound in bounds.always:
            self._later(bound)
        for either in bounds.either:
            self.first.append(self._who_is_first(either) if period is None else self._turn(either, period))

    def _later(self, bound: MoveBound) -> cp_model.Constraint:
        least = bound.least if self.period is None else bound.at_period(self.period)
        return self.model.add(self.moves[bound.after] - self.moves[bound.before] >= least)

    def _who_is_first(self, either: EitherFirst) -> cp_model.IntVar:
        first = self.model.new_bool_var("")
        self._later(either.one_first).only_enforce_if(first)
        self._later(either.other_first).only_enforce_if(~first)
        return first

    def _turn(self, either: EitherFirst, period: int) -> cp_model.IntVar:
        """How many periods later the other is when it is first after the one: one period sooner it is before it."""
        one, other, moves = either.one_first, either.other_first, self.moves
        least = -(-(one.least - self._most(one)) // period)
        most = (self._most(other) - other.least) // period + 1
        turn = self.model.new_int_var(min(least, most), max(least, most), "")
        self.model.add(moves[one.after] - moves[one.before] + period * turn >= one.least)
        self.model.add(moves[other.after] - moves[other.before] - period * turn >= other.least - period)
        return turn

    def _most(self, bound: MoveBound) -> int:
        """By how much `after` can be moved more than `before`."""
        return self._between[bound.after][1] - self._between[bound.before][0]

    def solve(self, work_max: float) -> FoundMoves:
        """The cheapest moves that counted work leads to; 1 is about eight seconds of a processor."""
        solver = cp_model.CpSolver()
        solver.parameters.random_seed = SEED
        solver.parameters.num_workers = 1  # the same answer on any machine
        solver.parameters.max_deterministic_time = work_max
        status = solver.solve(self.model)
        work = solver.response_proto.deterministic_time
        if status == cp_model.INFEASIBLE:
            return FoundMoves(None, 0, 0, impossible=True, work=work)
        cost_min = round(solver.best_objective_bound)
        if status not in {cp_model.OPTIMAL, cp_model.FEASIBLE}:
            return FoundMoves(None, 0, cost_min, impossible=False, work=work)
        moves = tuple(solver.value(move) for move in self.moves)
        return FoundMoves(moves, round(solver.objective_value), cost_min, impossible=False, work=work)
