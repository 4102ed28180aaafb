"""The manager's question of order as a dispatching problem, and the answer; as a process that its host asks.

A train is a row of operations: it comes, it stands, it runs, it stands. While it runs it has all sections of its move
and the place that it leaves; where it stands, the place. So what the certificate calls a move is an operation here.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import msgspec
from msgspec.structs import replace

from plan.dispatching.chances import chance_order, rule_orders
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
from wayside.order_question import ALL, OrderAnswer, OrderMove, OrderQuestion, OrderTrain, OrderWay

MOVES_MAX: Final = (
    180  # assumed: making the model of more takes longer than solving it may; then a search extends it
)
CHOICES_MAX: Final = 24  # assumed: ways besides the planned ones, of moves that come first
NEAR: Final = 3  # assumed: forty minutes of two hours are mostly proven in a tenth of a second

CHANCES = True  # off: what is overdue is ready when it is expected, and the solver's order is kept
RULES = True  # off: the solver begins with the order of the plan, or the last one
ANYWHERE: Final = -1  # a move of which is not said from where: it has one way
OFF_LINE: Final = -1
PLANNED: Final = -2
Order = tuple[tuple[int, int], ...]  # trains, and where the move of each ends


def answer_to(question: OrderQuestion) -> OrderAnswer:
    """What is best for one that asks; else the best order found by the work allowed, no worse than the last one.

    Where there are tracks to choose, a third of the time ahead is solved first, with them alone, and then all with what
    was chosen; where that costs anything or leads nowhere, all of it is looked at once more with all tracks, by the
    work that is left: a bound is of all that could be done.
    """
    if CHANCES and question.asks != ALL and _in_single_places(question.trains):
        return chance_order(question, *_as_planned(question.trains))
    asked = [
        index for index, train in enumerate(question.trains) if train.moves or train.holds or train.keeps
    ]
    all_tracks = [_ends_as_planned(question.trains[index]) for index in asked]
    trains = all_tracks
    ends = question.ends or (PLANNED,) * len(question.order)
    told = zip(question.order, ends, strict=True)
    last = tuple((asked.index(index), end) for index, end in told if index in asked)
    chosen, spent, begins = any(move.others for train in trains for move in train.moves), 0.0, [last]
    if chosen:
        part = _near_choices([_before(train, question.ahead_s // NEAR) for train in trains])
        known = _known(part, (_of_these(part, last),))
        near = Answer(None, 0, impossible=False, work=0.0)
        if known is not None:
            near = _solved(part, known, question.work_max / NEAR)
            begins.insert(0, _order(part, near.solution or known))
        spent = near.work
        own = [[end for each, end in begins[0] if each == index] for index in range(len(trains))]
        trains = [_fixed(train, ends) for train, ends in zip(trains, own, strict=True)]
    known = _known(trains, [(), *(_of_these(trains, begun) for begun in begins)])
    found = Answer(None, 0, impossible=False, work=spent)
    if known is not None:
        found = _solved(trains, known, max(question.work_max - spent, 0.0) / (2 if chosen else 1))
        spent += found.work
    if chosen and (found.solution is None or found.solution.objective_value):
        order = () if found.solution is None else _order(trains, found.solution)
        found = _solved(all_tracks, _known(all_tracks, (order,)), max(question.work_max - spent, 0.0))
        trains = all_tracks
    if found.solution is None:
        return OrderAnswer(lacking="no order was found in which all trains can run")
    order = _order(trains, found.solution)
    lost_s = sum(max(0, -move.due_s) for train in trains for move in train.moves if move.counts)
    return OrderAnswer(
        tuple(asked[index] for index, _ in order),
        found.solution.objective_value + lost_s,
        found.bound + lost_s,
        ends=tuple(end for _, end in order),
    )


def _solved(trains: Sequence[OrderTrain], known: Solution | None, work: float) -> Answer:
    """An order that is no worse than one that is known; that one where making the model would take too long."""
    if sum(len(move_ways(move)) for train in trains for move in train.moves) > MOVES_MAX:
        return Answer(known, 0, impossible=False, work=0.0)
    return solve(_instance(trains, None if known is None else known.objective_value), work, known)


def move_ways(move: OrderMove) -> tuple[OrderWay, ...]:
    """All ways to make a move, the planned one first."""
    return (OrderWay(move.here, move.needs, move.keeps), *move.others)


def _end(way: OrderWay) -> int:
    return way.keeps[0] if way.keeps else OFF_LINE


def _before(train: OrderTrain, until_s: int) -> OrderTrain:
    """With the moves that are planned to begin before that."""
    moves = tuple(move for move in train.moves if move.departs_s < until_s)
    return _ends_as_planned(replace(train, moves=moves))


def _ends_as_planned(train: OrderTrain) -> OrderTrain:
    """The train; where it is after its last move counts, and is as planned."""
    last = (replace(_leads_on_only(move), counts=True) for move in train.moves[-1:])
    return replace(train, moves=(*train.moves[:-1], *last))


def _near_choices(trains: Sequence[OrderTrain]) -> list[OrderTrain]:
    """The trains with the choices that come first, as many as a model may have."""
    ways = sorted(
        (move.departs_s, index, place, len(move.others))
        for index, train in enumerate(trains)
        for place, move in enumerate(train.moves)
    )
    count, kept = 0, set[tuple[int, int]]()
    for _, index, place, others in ways:
        count += others
        if count <= CHOICES_MAX:
            kept.add((index, place))
    return [
        replace(
            train,
            moves=tuple(
                move if (index, place) in kept else _leads_on_only(move)
                for place, move in enumerate(train.moves)
            ),
        )
        for index, train in enumerate(trains)
    ]


def _leads_on_only(move: OrderMove) -> OrderMove:
    """The move to its planned track alone, from wherever the one before may end."""
    return replace(move, others=tuple(way for way in move.others if way.keeps == move.keeps))


def _fixed(train: OrderTrain, ends: Sequence[int]) -> OrderTrain:
    """The train with one way for each move, to these ends, then to those planned."""
    ways = zip(train.moves, _ways(train, ends), strict=True)
    moves = (replace(m, needs=w.needs, keeps=w.keeps, here=w.here, others=()) for m, w in ways)
    return replace(train, moves=tuple(moves))


def _order(trains: Sequence[OrderTrain], solution: Solution) -> Order:
    """Trains in the order in which their moves begin, each with where it ends."""
    runs = [course.runs for course in map(_course, trains)]
    return tuple(
        (e.train, _end(runs[e.train][e.operation])) for e in solution.events if e.operation in runs[e.train]
    )


def _of_these(trains: Sequence[OrderTrain], order: Order) -> Order:
    """As much of an order as is of the moves of these trains."""
    left = [len(train.moves) for train in trains]
    found: list[tuple[int, int]] = []
    for index, end in order:
        if left[index]:
            left[index] -= 1
            found.append((index, end))
    return tuple(found)


def _known(trains: Sequence[OrderTrain], begins: Iterable[Order]) -> Solution | None:
    """An order in which all can run: the one that delays least of those that begin in one of these ways, and then go by
    the times of the plan or by when trains can be ready, and of those that a beam finds. Tracks are as in what it
    begins with, then as planned.
    """
    instance = _instance(trains, None)
    solutions: list[Solution] = []
    for late in (False, True):
        for begun in dict.fromkeys(begins):
            ends = [[end for each, end in begun if each == index] for index in range(len(trains))]
            ways = [_ways(train, own) for train, own in zip(trains, ends, strict=True)]
            searched = [_searched(train, own, late=late) for train, own in zip(trains, ways, strict=True)]
            first = [index for index, _ in begun]
            if not follows(searched, first):
                continue
            rest = [
                WaysideTrain(train.ahead[done - 1].keeps if done else train.holds, train.ahead[done:])
                for train, done in zip(searched, map(len, ends), strict=True)
            ]
            found = finishing_order(rest)
            if found.proof is CertificateProof.ORDER:
                solutions.append(_played(instance, trains, ways, (*first, *found.order)))
    if RULES and _in_single_places(trains):
        ways, searched = _as_planned(trains)
        orders = rule_orders(trains, ways, searched)
        solutions += [_played(instance, trains, ways, order) for order in orders]
    return min(solutions, key=lambda solution: solution.objective_value, default=None)


def _in_single_places(trains: Sequence[OrderTrain]) -> bool:
    """Whether nobody stands in several places, as one does that has a part of its next move."""
    kept = [*(train.keeps for train in trains), *(move.keeps for train in trains for move in train.moves)]
    return all(len(sections) <= 1 for sections in kept)


def _as_planned(trains: Sequence[OrderTrain]) -> tuple[list[list[OrderWay]], list[WaysideTrain]]:
    """The ways of all as they are planned, and the trains as the search for any order takes them."""
    ways = [_ways(train, ()) for train in trains]
    return ways, [_searched(train, own, late=False) for train, own in zip(trains, ways, strict=True)]


def _ways(train: OrderTrain, ends: Sequence[int]) -> list[OrderWay]:
    """A way for each move: to these ends, then to those planned, as far as a way leads there."""
    chosen: list[OrderWay] = []
    for place, move in enumerate(train.moves):
        here = _end(chosen[-1]) if chosen else move.here
        ways = [way for way in move_ways(move) if way.here in {here, ANYWHERE}]
        end = ends[place] if place < len(ends) and ends[place] != PLANNED else _end(move_ways(move)[0])
        chosen.append(
            next((way for way in ways if _end(way) == end), ways[0] if ways else move_ways(move)[0])
        )
    return chosen


def _searched(train: OrderTrain, ways: Sequence[OrderWay], *, late: bool) -> WaysideTrain:
    """The train as the search for any order takes it."""
    moves: list[Move] = []
    ready_s = train.comes_s + train.ready_s if late else 0
    for move, way in zip(train.moves, ways, strict=True):
        ready_s = max(ready_s, move.departs_s)
        moves.append(Move(_bits(way.needs), _bits(way.keeps), ready_s))
        ready_s = ready_s + move.runs_s + move.stays_s if late else 0
    return WaysideTrain(_bits(train.keeps), tuple(moves))


def _bits(sections: Sequence[int]) -> int:
    return sum(1 << section for section in sections)


def _played(
    instance: Instance, trains: Sequence[OrderTrain], ways: Sequence[Sequence[OrderWay]], order: Sequence[int]
) -> Solution:
    """The moves in an order, each as soon as it can be."""
    free_s: dict[str, int] = defaultdict(int)
    paths = [_course(train).path(own) for train, own in zip(trains, ways, strict=True)]
    at = [0] * len(instance.trains)
    ready_s = [0] * len(instance.trains)
    events: list[tuple[int, int, int, int]] = []

    def starts(index: int) -> None:
        train, path = instance.trains[index], paths[index]
        operation = train[path[at[index]]]
        had = train[path[at[index] - 1]].resources if at[index] else ()
        own = {use.resource for use in had}
        waits_s = (free_s[use.resource] for use in operation.resources if use.resource not in own)
        start_s = max(ready_s[index], operation.start_lb, *waits_s, 0)
        kept = {use.resource for use in operation.resources}
        free_s.update(dict.fromkeys(own - kept, start_s))
        events.append((start_s, len(events), index, path[at[index]]))
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
    courses = [_course(train) for train in trains]
    delays = tuple(
        OperationDelay("op_delay", index, stand, threshold=max(0, move.due_s), coeff=1)
        for index, (train, course) in enumerate(zip(trains, courses, strict=True))
        for move, stands in zip(train.moves, course.stands, strict=True)
        for stand in (stands if move.counts else ())
    )
    latest: list[dict[int, int]] = [{} for _ in trains]
    for delay in delays if cost_max is not None else ():
        latest[delay.train][delay.operation] = delay.threshold + (cost_max or 0)
    return Instance(tuple(c.operations(late) for c, late in zip(courses, latest, strict=True)), delays)


@dataclass(frozen=True, slots=True)
class _Operation:
    """What a train does at a place of its way, of all that it can do there (`place`)."""

    place: int
    lasts_s: int
    earliest_s: int
    sections: tuple[int, ...]


@dataclass(slots=True)
class _Course:
    """A train as operations: it comes, it stands, it runs, it stands. `runs`: those that are moves, each with its way;
    `stands`: for each move those where it ends; `then`: what can follow each.
    """

    did: list[_Operation]
    then: list[list[int]]
    runs: dict[int, OrderWay]
    stands: list[list[int]]

    def path(self, ways: Sequence[OrderWay]) -> list[int]:
        """The operations of a train that goes these ways."""
        path = [0, 1]
        for way in ways:
            run = next(i for i in self.then[path[-1]] if self.runs[i] is way or self.runs[i] == way)
            path += [run, self.then[run][0]]
        return path

    def operations(self, latest_s: dict[int, int]) -> Train:
        """As an instance has them, each no later than it may be for those after it."""
        until_s: list[int | None] = [None] * len(self.did)
        for i in range(len(self.did) - 1, -1, -1):
            after = [until_s[j] for j in self.then[i]]
            ends = (
                [max(s for s in after if s is not None) - self.did[i].lasts_s]
                if after and None not in after
                else []
            )
            until_s[i] = min([*ends, *([latest_s[i]] if i in latest_s else [])], default=None)
        return tuple(
            TrainOperation(
                each.lasts_s,
                tuple(self.then[i]),
                tuple(ResourceUsage(str(section)) for section in each.sections),
                start_lb=each.earliest_s,
                start_ub=until_s[i] if i else 0,
            )
            for i, each in enumerate(self.did)
        )


def _course(train: OrderTrain) -> _Course:
    """The operations of a train: while it runs it has what it needs and the place that it leaves."""
    held = tuple(dict.fromkeys((*train.holds, *train.keeps)))
    did = [_Operation(0, train.comes_s, 0, held), _Operation(1, train.ready_s, 0, train.keeps)]
    course = _Course(did, [[1], []], {}, [])
    at = {ANYWHERE: 1}
    for move in train.moves:
        place, comes_to, stands = did[-1].place, dict[int, int](), list[int]()
        leads_on = [
            way for way in move_ways(move) if way.here in at or ANYWHERE in at or way.here == ANYWHERE
        ]
        first = len(did)
        for way in leads_on:
            stood = [i for here, i in at.items() if ANYWHERE in {here, way.here} or here == way.here]
            for i in stood:
                course.runs[len(did)] = way
                course.then[i].append(len(did))
                sections = tuple(dict.fromkeys((*did[i].sections, *way.needs)))
                did.append(_Operation(place + 1, move.runs_s, move.departs_s, sections))
                course.then.append([])
        for i in range(first, len(did)):
            way = course.runs[i]
            if _end(way) not in comes_to:
                comes_to[_end(way)] = len(did)
                stands.append(len(did))
                did.append(_Operation(place + 2, move.stays_s, 0, way.keeps))
                course.then.append([])
            course.then[i].append(comes_to[_end(way)])
        course.stands.append(stands)
        at = comes_to
    return course


def serve() -> None:
    """Answer each line of the standard input, until it ends."""
    for line in sys.stdin.buffer:
        answer = answer_to(msgspec.json.decode(line, type=OrderQuestion))
        sys.stdout.buffer.write(msgspec.json.encode(answer) + b"\n")
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    serve()
