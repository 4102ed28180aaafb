"""The cheapest order of trains: solved, cut where no order of events is possible, and put into one row."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise
from typing import Final

from ortools.sat.python import cp_model
from ortools.sat.python.cp_model_helper import Literal

from network.errors import InputError
from plan.dispatching.checker import cost_of, objections
from plan.dispatching.instance import Instance, Solution, StartEvent
from plan.dispatching.model import DispatchModel

SEED: Final = 1
_Node = tuple[int, int]  # train, operation


@dataclass(frozen=True)
class Answer:
    """The best solution found (None: none was, or there is none) and the bound below which there is none.

    `work` is what the solver counts as work done, the same on every machine; `impossible`: proven.
    """

    solution: Solution | None
    bound: int
    impossible: bool
    work: float

    @property
    def proven(self) -> bool:
        """Whether no order costs less."""
        return self.solution is not None and self.solution.objective_value <= self.bound


def solve(instance: Instance, work_max: float, known: Solution | None = None) -> Answer:
    """The least cost that `work_max` of the solver's counted work leads to; 1 is about eight seconds of a processor.

    Two searches take half of it each: one that finds orders soon, and one from below, which proves. `known`: a solution
    to begin with.
    """
    dispatch = DispatchModel(instance)
    best = Answer(known, 0, impossible=False, work=0.0)
    if known is not None:
        dispatch.begin_with(known)
    for by_cores in (False, True):
        best = _search(instance, dispatch, best, work_max, by_cores=by_cores)
        if best.proven or best.impossible:
            break
        if best.solution is not None:
            dispatch.begin_with(best.solution)
    return best


def _search(
    instance: Instance, dispatch: DispatchModel, best: Answer, work_max: float, *, by_cores: bool
) -> Answer:
    """What one search adds to the best answer so far, within the rest of the work or half of the whole."""
    solver = cp_model.CpSolver()
    solver.parameters.random_seed = SEED
    solver.parameters.num_workers = 1  # the same answer on any machine
    # Orders decide and sums of delays relax badly: without linear programs the answer comes sooner by far.
    solver.parameters.linearization_level = 0
    solver.parameters.optimize_with_core = by_cores
    until, work = work_max if by_cores else work_max / 2.0, best.work
    while True:
        solver.parameters.max_deterministic_time = max(until - work, 0.0)
        status = solver.solve(dispatch.model)
        work += solver.response_proto.deterministic_time
        if status == cp_model.MODEL_INVALID:
            raise InputError("the instance", "times and costs", None, "numbers whose sums stay below 2**63")
        if status == cp_model.INFEASIBLE:
            return Answer(None, best.bound, impossible=True, work=work)
        bound = max(best.bound, round(solver.best_objective_bound))
        if status not in {cp_model.OPTIMAL, cp_model.FEASIBLE}:
            return Answer(best.solution, bound, impossible=False, work=work)
        if circle := _circle(dispatch, solver):
            dispatch.model.add_bool_or([~literal for literal in circle])
            continue
        found = _solution(instance, dispatch, solver)
        if best.solution is not None and best.solution.objective_value <= found.objective_value:
            found = best.solution
        return Answer(found, bound, impossible=False, work=work)


def _before(
    dispatch: DispatchModel, solver: cp_model.CpSolver
) -> Iterator[tuple[_Node, _Node, list[Literal]]]:
    """Which start comes before which, and what makes it so."""
    runs = [
        {i for i, runs in enumerate(train.runs) if solver.boolean_value(runs)} for train in dispatch.trains
    ]
    then = [
        {i: j for (i, j), goes in train.goes.items() if solver.boolean_value(goes)}
        for train in dispatch.trains
    ]
    for a, after in enumerate(then):
        for i, j in after.items():
            yield (a, i), (a, j), [dispatch.trains[a].goes[i, j]]
    for pair in dispatch.pairs:
        for earlier, later, first in ((pair.first, pair.second, True), (pair.second, pair.first, False)):
            conditions = dispatch.conditions(pair, first=first)
            if not all(solver.boolean_value(condition) for condition in conditions):
                continue
            last = max(runs[earlier.train].intersection(earlier.operations))
            first_run = min(runs[later.train].intersection(later.operations))
            left = then[earlier.train][last]
            # By another path another start may be the one that lets go of it, or takes it.
            path = (
                dispatch.trains[earlier.train].goes[last, left],
                dispatch.trains[later.train].runs[first_run],
            )
            yield (earlier.train, left), (later.train, first_run), [*conditions, *path]


def _circle(dispatch: DispatchModel, solver: cp_model.CpSolver) -> list[Literal]:
    """What cannot all be so, as starts at one time would each come before the next; nothing where all is well."""
    try:
        _order(dispatch, solver)
    except CycleError as error:
        nodes: list[_Node] = error.args[1]
        why = {(one, other): literals for one, other, literals in _before(dispatch, solver)}
        return [literal for step in pairwise(nodes) for literal in why[step]]
    return []


def _order(dispatch: DispatchModel, solver: cp_model.CpSolver) -> list[_Node]:
    """All starts in an order that keeps to times and to who is first. Raises CycleError where there is none."""
    earlier: dict[_Node, set[_Node]] = {(a, 0): set() for a in range(len(dispatch.trains))}
    for one, other, _ in _before(dispatch, solver):
        earlier.setdefault(other, set()).add(one)

    def time(node: _Node) -> int:
        return solver.value(dispatch.trains[node[0]].start[node[1]])

    rank = {node: i for i, node in enumerate(TopologicalSorter(earlier).static_order())}
    return sorted(rank, key=lambda node: (time(node), rank[node]))


def _solution(instance: Instance, dispatch: DispatchModel, solver: cp_model.CpSolver) -> Solution:
    events = tuple(
        StartEvent(solver.value(dispatch.trains[a].start[i]), a, i) for a, i in _order(dispatch, solver)
    )
    solution = Solution(cost_of(instance, events), events)
    wrong = objections(instance, solution)
    if wrong:
        raise AssertionError(f"the model lets pass what the checker refuses: {wrong[0]}")
    return solution
