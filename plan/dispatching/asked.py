"""The manager's question of order as a dispatching problem, and the answer; as a process that its host asks.

A train is a row of operations: it comes, it stands, it runs, it stands. While it runs it has all sections of its move
and the place that it leaves; where it stands, the place. So what the certificate calls a move is an operation here.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import Final

import msgspec
from msgspec.structs import replace

from plan.dispatching.checker import cost_of
from plan.dispatching.instance import (
    Instance,
    OperationDelay,
    ResourceUsage,
    Solution,
    StartEvent,
    Train,
    TrainOperation,
)
from plan.dispatching.solver import Answer, solve
from wayside.certificate import CertificateProof, finishing_order, follows
from wayside.moves import Move
from wayside.moves import Train as WaysideTrain
from wayside.order_question import OrderAnswer, OrderQuestion, OrderTrain

MOVES_MAX: Final = (
    180  # assumed: making the model of more takes longer than solving it may; then a search extends it
)
STAGES: Final = 3  # assumed: forty minutes of two hours are mostly proven in a tenth of a second


def answer_to(question: OrderQuestion) -> OrderAnswer:
    """The best order found by the work allowed.

    A third of the time ahead is solved first, then two thirds, then all: what is near is certain and decides, and each
    begins with what the one before has found, or with the order found last. All moves planned before a time can be made
    before all others.
    """
    asked = [
        index for index, train in enumerate(question.trains) if train.moves or train.holds or train.keeps
    ]
    trains = [question.trains[index] for index in asked]
    last = tuple(asked.index(index) for index in question.order if index in asked)
    order: tuple[int, ...] = ()
    found = Answer(None, 0, impossible=False, work=0.0)
    for stage in range(1, STAGES + 1):
        part = [_before(train, question.ahead_s * stage // STAGES) for train in trains]
        known = _known(part, (order, _of_these(part, last)))
        if known is None:
            return OrderAnswer(lacking="no order was found in which all trains can run")
        found = Answer(known, 0, impossible=False, work=0.0)
        if sum(len(train.moves) for train in part) <= MOVES_MAX:
            found = solve(_instance(part, known.objective_value), question.work_max / STAGES, known)
        order = _order(part, found.solution or known)
    lost_s = sum(max(0, -move.due_s) for train in trains for move in train.moves if move.counts)
    delay_s = 0 if found.solution is None else found.solution.objective_value
    return OrderAnswer(tuple(asked[index] for index in order), delay_s + lost_s, found.bound + lost_s)


def _before(train: OrderTrain, until_s: int) -> OrderTrain:
    """With the moves that are planned to begin before that; where it is then counts."""
    moves = [move for move in train.moves if move.departs_s < until_s]
    if moves:
        moves[-1] = replace(moves[-1], counts=True)
    return replace(train, moves=tuple(moves))


def _order(trains: Sequence[OrderTrain], solution: Solution) -> tuple[int, ...]:
    """Trains in the order in which their moves begin."""
    return tuple(e.train for e in solution.events if e.operation in _runs(trains[e.train]))


def _of_these(trains: Sequence[OrderTrain], order: Sequence[int]) -> tuple[int, ...]:
    """As much of an order as is of the moves of these trains."""
    left = [len(train.moves) for train in trains]
    found: list[int] = []
    for index in order:
        if left[index]:
            left[index] -= 1
            found.append(index)
    return tuple(found)


def _known(trains: Sequence[OrderTrain], begins: Iterable[tuple[int, ...]]) -> Solution | None:
    """An order in which all can run, which begins in one of these ways; then by the times of the plan, or by when
    trains can be ready, whichever delays least.
    """
    instance = _instance(trains, None)
    solutions: list[Solution] = []
    for late in (False, True):
        searched = [_searched(train, late=late) for train in trains]
        for begun in dict.fromkeys(begins):
            if not follows(searched, begun):
                continue
            counts = (begun.count(index) for index in range(len(trains)))
            rest = [
                WaysideTrain(train.ahead[done - 1].keeps if done else train.holds, train.ahead[done:])
                for train, done in zip(searched, counts, strict=True)
            ]
            found = finishing_order(rest)
            if found.proof is CertificateProof.ORDER:
                solutions.append(_played(instance, (*begun, *found.order)))
    return min(solutions, key=lambda solution: solution.objective_value, default=None)


def _searched(train: OrderTrain, *, late: bool) -> WaysideTrain:
    """The train as the search for any order takes it."""
    moves: list[Move] = []
    ready_s = train.comes_s + train.ready_s if late else 0
    for move in train.moves:
        ready_s = max(ready_s, move.departs_s)
        moves.append(Move(_bits(move.needs), _bits(move.keeps), ready_s))
        ready_s = ready_s + move.runs_s + move.stays_s if late else 0
    return WaysideTrain(_bits(train.keeps), tuple(moves))


def _bits(sections: Sequence[int]) -> int:
    return sum(1 << section for section in sections)


def _played(instance: Instance, order: Sequence[int]) -> Solution:
    """The moves in an order, each as soon as it can be."""
    free_s: dict[str, int] = defaultdict(int)
    at = [0] * len(instance.trains)
    ready_s = [0] * len(instance.trains)
    events: list[tuple[int, int, int, int]] = []

    def starts(index: int) -> None:
        operation = instance.trains[index][at[index]]
        had = instance.trains[index][at[index] - 1].resources if at[index] else ()
        own = {use.resource for use in had}
        waits_s = (free_s[use.resource] for use in operation.resources if use.resource not in own)
        start_s = max(ready_s[index], operation.start_lb, *waits_s, 0)
        kept = {use.resource for use in operation.resources}
        free_s.update(dict.fromkeys(own - kept, start_s))
        events.append((start_s, len(events), index, at[index]))
        ready_s[index] = start_s + operation.min_duration
        at[index] += 1

    for index in range(len(instance.trains)):
        starts(index)
        starts(index)
    for index in order:
        starts(index)
        starts(index)
    found = tuple(StartEvent(time, train, operation) for time, _, train, operation in sorted(events))
    return Solution(cost_of(instance, found), found)


def _instance(trains: Sequence[OrderTrain], cost_max: int | None) -> Instance:
    """The problem of these trains. `cost_max`: what a known order costs, so that no train need be so late alone."""
    delays = tuple(delay for index, train in enumerate(trains) for delay in _delays(index, train))
    latest: list[dict[int, int]] = [{} for _ in trains]
    for delay in delays if cost_max is not None else ():
        latest[delay.train][delay.operation] = delay.threshold + (cost_max or 0)
    return Instance(tuple(map(_operations, trains, latest)), delays)


def _runs(train: OrderTrain) -> range:
    """The operations that are moves."""
    return range(2, 2 + 2 * len(train.moves), 2)


def _operations(train: OrderTrain, latest_s: dict[int, int]) -> Train:
    held = tuple(dict.fromkeys((*train.holds, *train.keeps)))
    done = [(train.comes_s, 0, held), (train.ready_s, 0, train.keeps)]
    keeps = train.keeps
    for move in train.moves:
        done += [
            (move.runs_s, move.departs_s, tuple(dict.fromkeys((*keeps, *move.needs)))),
            (move.stays_s, 0, move.keeps),
        ]
        keeps = move.keeps
    until_s: int | None = None
    operations: list[TrainOperation] = []
    for place in range(len(done) - 1, -1, -1):
        lasts_s, earliest_s, sections = done[place]
        ends = [
            s for s in (None if until_s is None else until_s - lasts_s, latest_s.get(place)) if s is not None
        ]
        until_s = min(ends, default=None)
        operations.append(
            TrainOperation(
                lasts_s,
                (place + 1,) if place + 1 < len(done) else (),
                tuple(ResourceUsage(str(section)) for section in sections),
                start_lb=earliest_s,
                start_ub=until_s if place else 0,
            )
        )
    return tuple(reversed(operations))


def _delays(index: int, train: OrderTrain) -> list[OperationDelay]:
    return [
        OperationDelay("op_delay", index, place + 1, threshold=max(0, move.due_s), coeff=1)
        for place, move in zip(_runs(train), train.moves, strict=True)
        if move.counts
    ]


def serve() -> None:
    """Answer each line of the standard input, until it ends."""
    for line in sys.stdin.buffer:
        answer = answer_to(msgspec.json.decode(line, type=OrderQuestion))
        sys.stdout.buffer.write(msgspec.json.encode(answer) + b"\n")
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    serve()
