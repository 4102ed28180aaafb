"""The dispatching problem for OR-Tools' CP-SAT: when each operation starts, on which path, and who is first."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Final

from ortools.sat.python import cp_model
from ortools.sat.python.cp_model_helper import Literal

from plan.dispatching.instance import Instance, OperationDelay, Solution, Train, TrainOperation, predecessors
from plan.dispatching.occupations import (
    Pair,
    ResourceOccupation,
    certain_operations,
    occupations_of,
    questions_of,
)

ALIKE_COUNTS: Final = True  # questions of order that have one answer are one; for experiments alone


class TrainModel:
    """A train's times and path: `start[i]`, whether it runs operation i, and whether it goes from i on to j.

    Operations between which it chooses at one place have one start.
    """

    def __init__(self, model: cp_model.CpModel, train: Train, horizon: int) -> None:
        self.train, self._model, self._horizon = train, model, horizon
        self._yes = model.new_constant(1)
        self._before = predecessors(train)
        certain = certain_operations(train)
        self.runs = [self._yes if i in certain else model.new_bool_var("") for i in range(len(train))]
        self.start = self._starts()
        self.goes = self._arcs()

    def _starts(self) -> list[cp_model.IntVar]:
        earliest: list[int] = []
        for i, operation in enumerate(self.train):
            reached = min((earliest[k] + self.train[k].min_duration for k in self._before[i]), default=0)
            earliest.append(max(reached, operation.start_lb))
        together: dict[tuple[int, ...], list[int]] = defaultdict(list)
        for i in range(len(self.train)):
            together[tuple(self._before[i])].append(i)
        starts: dict[int, cp_model.IntVar] = {}
        for group in together.values():
            least, most = min(earliest[i] for i in group), max(self._latest(self.train[i]) for i in group)
            start = self._model.new_int_var(least, max(least, most), "")
            for i in group:
                starts[i] = start
                self._model.add(start >= earliest[i]).only_enforce_if(self.runs[i])
                self._model.add(start <= self._latest(self.train[i])).only_enforce_if(self.runs[i])
        return [starts[i] for i in range(len(self.train))]

    def _latest(self, operation: TrainOperation) -> int:
        return self._horizon if operation.start_ub is None else min(operation.start_ub, self._horizon)

    def _arcs(self) -> dict[tuple[int, int], cp_model.IntVar]:
        model, arcs = self._model, dict[tuple[int, int], cp_model.IntVar]()
        for i, operation in enumerate(self.train):
            for successor in operation.successors:
                if len(operation.successors) == 1:
                    goes = self.runs[i]
                elif len(self._before[successor]) == 1:
                    goes = self.runs[successor]
                else:
                    goes = model.new_bool_var("")
                arcs[i, successor] = goes
                model.add(self.start[successor] >= self.start[i] + operation.min_duration).only_enforce_if(
                    goes
                )
            if operation.successors:
                model.add(sum(arcs[i, successor] for successor in operation.successors) == self.runs[i])
        for i, earlier in enumerate(self._before[1:], 1):
            model.add(sum(arcs[k, i] for k in earlier) == self.runs[i])
        return arcs

    def has(self, occupation: ResourceOccupation) -> cp_model.IntVar:
        """Whether the train has it."""
        if occupation.certain or len(occupation.operations) == 1:
            return self._yes if occupation.certain else self.runs[occupation.operations[0]]
        has = self._model.new_bool_var("")
        self._model.add_max_equality(has, [self.runs[i] for i in occupation.operations])
        return has

    def begins(self, occupation: ResourceOccupation) -> cp_model.IntVar:
        """When it begins, no later than any of its operations."""
        inside = set(occupation.operations)
        entries = [i for i in inside if i == 0 or not inside.issuperset(self._before[i])]
        starts = {self.start[i].index: self.start[i] for i in entries}
        if len(starts) == 1:
            return next(iter(starts.values()))
        begins = self._model.new_int_var(0, self._horizon, "")
        for i in sorted(entries):
            self._model.add(begins <= self.start[i]).only_enforce_if(self.runs[i])
        return begins

    def ends(self, occupation: ResourceOccupation) -> cp_model.IntVar | None:
        """When others may have the resource again, no earlier than it is let go of; None: never."""
        if len(self.train) - 1 in occupation.operations:
            return None
        arcs = [(i, j) for i in occupation.operations for j in self.train[i].successors]
        release = {i: self._release(i, occupation.resource) for i in occupation.operations}
        telling = [(i, j) for i, j in arcs if j not in occupation.operations or release[i] > 0]
        then = {self.start[j].index: self.start[j] for _, j in telling}
        if len(then) == 1 and not any(release.values()):
            return next(iter(then.values()))
        ends = self._model.new_int_var(0, 2 * self._horizon, "")
        for i, j in telling:
            self._model.add(ends >= self.start[j] + release[i]).only_enforce_if(self.goes[i, j])
        return ends

    def _release(self, i: int, resource: str) -> int:
        return next(use.release_time for use in self.train[i].resources if use.resource == resource)


class DispatchModel:
    """The whole: trains, whom each question of order lets go first, and what the delays cost, which is least."""

    def __init__(self, instance: Instance) -> None:
        self.model, self.horizon = cp_model.CpModel(), horizon_of(instance)
        self.trains = [TrainModel(self.model, train, self.horizon) for train in instance.trains]
        self.occupations = [list(occupations_of(a, train)) for a, train in enumerate(instance.trains)]
        self.pairs, alike = questions_of(instance.trains, self.occupations)
        self._first: dict[int, cp_model.IntVar] = {}
        self._hinted: set[int] = set()
        self._has = {o: self.trains[o.train].has(o) for own in self.occupations for o in own}
        self._begins = {o: self.trains[o.train].begins(o) for own in self.occupations for o in own}
        self._ends = {o: self.trains[o.train].ends(o) for own in self.occupations for o in own}
        for pair in self.pairs:
            self._exclude(pair)
        for both in alike if ALIKE_COUNTS else ():
            one, other = self.first(both.one), self.first(both.other)
            unless = [
                ~self._has[o] for p in (both.one, both.other) for o in (p.first, p.second) if not o.certain
            ]
            self.model.add_bool_or([*unless, ~one, other])
            self.model.add_bool_or([*unless, one, ~other])
        self._alone_on_resources()
        costs = [part for delay in instance.objective for part in self._delay(delay)]
        self.model.minimize(cp_model.LinearExpr.sum(costs))

    def begin_with(self, solution: Solution) -> None:
        """Have the next search begin with the paths and times of a solution."""
        started = {(event.train, event.operation): event.time for event in solution.events}
        for a, train in enumerate(self.trains):
            for i, (start, runs) in enumerate(zip(train.start, train.runs, strict=True)):
                if (a, i) in started:
                    self._hint(start, started[a, i])
                self._hint(runs, int((a, i) in started))

    def _hint(self, variable: cp_model.IntVar, value: int) -> None:
        if variable.index not in self._hinted:
            self._hinted.add(variable.index)
            self.model.add_hint(variable, value)

    def first(self, pair: Pair) -> cp_model.IntVar:
        """Whether the first of the two is first."""
        question = pair.question if ALIKE_COUNTS else id(pair)
        if question not in self._first:
            self._first[question] = self.model.new_bool_var("")
        return self._first[question]

    def conditions(self, pair: Pair, *, first: bool) -> list[Literal]:
        """What holds where both are had and the first, or the second, is first."""
        literals: list[Literal] = [self.first(pair)] if first else [~self.first(pair)]
        literals += [self._has[o] for o in (pair.first, pair.second) if not o.certain]
        return literals

    def _exclude(self, pair: Pair) -> None:
        for earlier, later, first in ((pair.first, pair.second, True), (pair.second, pair.first, False)):
            conditions, ends = self.conditions(pair, first=first), self._ends[earlier]
            if ends is None:
                self.model.add_bool_or([~condition for condition in conditions])
            else:
                self.model.add(self._begins[later] >= ends).only_enforce_if(conditions)

    def _alone_on_resources(self) -> None:
        """The same once more for each resource as a whole, by which the solver sees further."""
        using: dict[str, list[ResourceOccupation]] = defaultdict(list)
        for own in self.occupations:
            for occupation in own:
                using[occupation.resource].append(occupation)
        for had in using.values():
            if len({occupation.train for occupation in had}) < len(had):
                continue  # a train's own occupations may follow closer than another's
            intervals = [
                self.model.new_optional_interval_var(
                    self._begins[o], self.model.new_int_var(0, 2 * self.horizon, ""), ends, self._has[o], ""
                )
                for o in had
                if (ends := self._ends[o]) is not None
            ]
            self.model.add_no_overlap(intervals)

    def _delay(self, delay: OperationDelay) -> Iterator[cp_model.LinearExprT]:
        """What a delay costs, in parts."""
        train = self.trains[delay.train]
        runs, start = train.runs[delay.operation], train.start[delay.operation]
        if delay.coeff:
            late = self.model.new_int_var(0, self.horizon, "")
            self.model.add(late >= start - delay.threshold).only_enforce_if(runs)
            yield delay.coeff * late
        if delay.increment:
            is_late = self.model.new_bool_var("")
            self.model.add(start < delay.threshold).only_enforce_if([runs, ~is_late])
            yield delay.increment * is_late


def horizon_of(instance: Instance) -> int:
    """A time by which all trains can be through, one after the other, whatever their order."""
    operations = [operation for train in instance.trains for operation in train]
    lasting = sum(
        o.min_duration + max((use.release_time for use in o.resources), default=0) for o in operations
    )
    latest = max((max(o.start_lb, o.start_ub or 0) for o in operations), default=0)
    late = max((delay.threshold for delay in instance.objective), default=0)
    return lasting + latest + late
