"""A dispatching problem and its solution, as DISPLIB publishes them (description of 2025-09-17, section 1.2).

A train is a graph of operations without circles; it runs along one path from the first to the last. An operation
needs all its resources for itself from its start until the next one starts, and some for a while longer.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import msgspec

from network.errors import InputError
from network.files.json_input import read_json

Count = Annotated[int, msgspec.Meta(ge=0)]
Train = tuple["TrainOperation", ...]


class ResourceUsage(msgspec.Struct, frozen=True):
    """A resource that nobody else may have during an operation, nor for `release_time` after its end."""

    resource: str
    release_time: Count = 0


class TrainOperation(msgspec.Struct, frozen=True):
    """What a train does from its start until that of one of `successors` (indices; none: the exit); times in units."""

    min_duration: Count
    successors: tuple[Count, ...]
    resources: tuple[ResourceUsage, ...] = ()
    start_lb: Count = 0
    start_ub: Count | None = None


class OperationDelay(msgspec.Struct, frozen=True):
    """What a start at `threshold` or later costs: `increment` at once, and `coeff` a unit of time."""

    type: Literal["op_delay"]
    train: Count
    operation: Count
    threshold: Count = 0
    increment: Count = 0
    coeff: Count = 0

    def cost(self, start: int) -> int:
        """What a start at that time costs."""
        late = start - self.threshold
        return self.coeff * max(0, late) + (self.increment if late >= 0 else 0)


class Instance(msgspec.Struct, frozen=True):
    """Trains, and what is to be least: the sum of the delays' costs."""

    trains: tuple[Train, ...]
    objective: tuple[OperationDelay, ...]


class StartEvent(msgspec.Struct, frozen=True):
    """An operation starts, and the one before it of its train ends."""

    time: Count
    train: Count
    operation: Count


class Solution(msgspec.Struct, frozen=True):
    """All starts in their order, which counts at equal times, too."""

    objective_value: int
    events: tuple[StartEvent, ...]


def predecessors(train: Train) -> list[list[int]]:
    """For each operation those that it can follow."""
    before: list[list[int]] = [[] for _ in train]
    for i, operation in enumerate(train):
        for successor in operation.successors:
            before[successor].append(i)
    return before


def read_instance(file: Path) -> Instance:
    """Read and check an instance. Raises InputError naming the first place that contradicts the description."""
    instance = read_json(file, Instance)
    for a, train in enumerate(instance.trains):
        _check_train(str(file), f"trains[{a}]", train)
    for i, delay in enumerate(instance.objective):
        key = f"objective[{i}]"
        if delay.train >= len(instance.trains):
            raise InputError(
                str(file), f"{key}.train", delay.train, f"below {len(instance.trains)}, the number of trains"
            )
        count = len(instance.trains[delay.train])
        if delay.operation >= count:
            raise InputError(
                str(file), f"{key}.operation", delay.operation, f"below {count}, its train's operations"
            )
    return instance


def read_solution(file: Path) -> Solution:
    """Read a solution; what is wrong with it `objections` says. Raises InputError where it is none by its form."""
    return read_json(file, Solution)


def solution_text(solution: Solution) -> str:
    """The solution as a file has it."""
    return msgspec.json.encode(solution).decode()


def _check_train(file: str, key: str, train: Train) -> None:
    if not train:
        raise InputError(file, key, None, "at least one operation")
    entered = {0}
    for i, operation in enumerate(train):
        place = f"{key}[{i}]"
        for successor in operation.successors:
            if not i < successor < len(train):
                expected = f"an operation after {i} and below {len(train)}: they are in topological order"
                raise InputError(file, f"{place}.successors", successor, expected)
        entered.update(operation.successors)
        if not operation.successors and i + 1 < len(train):
            raise InputError(
                file, f"{place}.successors", [], "at least one: only the last operation is the exit"
            )
        if i not in entered:
            raise InputError(
                file, place, None, "the successor of an earlier operation: only the first is the entry"
            )
        if operation.start_ub is not None and operation.start_ub < operation.start_lb:
            raise InputError(
                file, f"{place}.start_ub", operation.start_ub, f"no less than start_lb, {operation.start_lb}"
            )
        names = [use.resource for use in operation.resources]
        if len(set(names)) < len(names):
            raise InputError(file, f"{place}.resources", None, "each resource once")
