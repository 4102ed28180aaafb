"""A good order of trains, soon: many orders begun side by side, a move longer at each step, the best of them kept.

An order begun counts by what it costs already and what it costs at least from there on: each train as soon as it can
leave, were it alone. Of two with all trains at the same places the cheaper is kept. No move is made after which two
trains could not both finish (`wayside.pairs`), or some stand in a circle. A solver that begins from any order finds
its way out of one late train's wake too slowly: whoever is to go first changes at all meets at once.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled
from wayside.moves import Train
from wayside.order_question import OrderTrain, OrderWay
from wayside.pairs import Pairs

WIDTH_MAX: Final = 400  # assumed: orders side by side
WORK: Final = 40_000_000  # assumed: moves looked at, some 0.2 s of a processor
WINDOWS_S: Final = (600, 900)  # assumed: moves that begin by so much later than the first possible one wait
NOBODY: Final = -1

Ints = NDArray[np.int64]


class BeamLine(NamedTuple):
    """What is to be done: moves in rows, those of stock i from `first[i]` on; sections by number, -1: none. s from now.

    `dead[i, j, a, b]`: with a and b moves made stocks i and j cannot both finish; `marks`: by stock and moves made.
    """

    first: Ints
    needs: Ints
    keeps: Ints
    departs: Ints
    runs: Ints
    stays: Ints
    due: Ints
    counts: Ints
    dead: NDArray[np.bool_]
    marks: Ints


class BeamStates(NamedTuple):
    """Orders begun, in rows: the next move of each stock, when it is ready for it and where it stands; for each section
    when it is free and who stands there; what it costs.
    """

    at: Ints
    ready: Ints
    place: Ints
    free: Ints
    holder: Ints
    cost: Ints


@compiled
def _leaves_s(line: BeamLine, states: BeamStates, b: int, i: int) -> int:
    """When a stock can make its next move; -1: another stands there, or not all could finish afterwards."""
    m, place = states.at[b, i], states.place[b, i]
    time_s = max(states.ready[b, i], line.departs[m])
    for section in line.needs[m]:
        if section < 0:
            break
        holder = states.holder[b, section]
        if holder >= 0 and holder != i:
            return -1
        if section != place:
            time_s = max(time_s, states.free[b, section])
    made = m + 1 - line.first[i]
    for other in range(len(line.first) - 1):
        if other != i and line.dead[i, other, made, states.at[b, other] - line.first[other]]:
            return -1
    return int(time_s)


@compiled
def _makes(line: BeamLine, states: BeamStates, b: int, i: int, leaves_s: int) -> None:
    """The next move of a stock."""
    m, place = states.at[b, i], states.place[b, i]
    comes_s = leaves_s + line.runs[m]
    if place >= 0:
        states.holder[b, place] = -1
        states.free[b, place] = comes_s
    for section in line.needs[m]:
        if section < 0:
            break
        states.free[b, section] = comes_s
    kept = line.keeps[m]
    states.place[b, i] = kept
    if kept >= 0:
        states.holder[b, kept] = i
    states.ready[b, i] = comes_s + line.stays[m]
    states.at[b, i] = m + 1
    if line.counts[m]:
        states.cost[b] += max(0, comes_s - line.due[m])


@compiled
def _in_a_circle(line: BeamLine, states: BeamStates, b: int, mover: int, seen: Ints, stack: Ints) -> bool:
    """Whether from a stock to those that stand where it is to go, and on, it comes again."""
    seen[:] = 0
    stack[0], size = mover, 1
    while size:
        size -= 1
        i = stack[size]
        m = states.at[b, i]
        if m >= line.first[i + 1]:
            continue
        for section in line.needs[m]:
            if section < 0:
                break
            holder = states.holder[b, section]
            if holder == mover and i != mover:
                return True
            if holder >= 0 and holder != i and not seen[holder]:
                seen[holder] = 1
                stack[size] = holder
                size += 1
    return False


@compiled
def _rest_s(line: BeamLine, states: BeamStates, b: int) -> int:
    """How late all that is still to come will be at least."""
    late_s = 0
    for i in range(len(line.first) - 1):
        m, end = states.at[b, i], line.first[i + 1]
        if m >= end:
            continue
        time_s = max(states.ready[b, i], line.departs[m])
        for section in line.needs[m]:
            if section < 0:
                break
            if section == states.place[b, i]:
                continue
            time_s = max(time_s, states.free[b, section])
            holder = states.holder[b, section]
            if holder >= 0 and holder != i and states.at[b, holder] < line.first[holder + 1]:
                its = states.at[b, holder]
                goes_s = max(states.ready[b, holder], line.departs[its]) + line.runs[its]
                time_s = max(time_s, goes_s)
        while m < end:
            time_s = max(time_s, line.departs[m]) + line.runs[m]
            if line.counts[m]:
                late_s += max(0, time_s - line.due[m])
            time_s += line.stays[m]
            m += 1
    return late_s


@compiled
def _copied(states: BeamStates, b: int, to: BeamStates, k: int) -> None:
    to.at[k] = states.at[b]
    to.ready[k] = states.ready[b]
    to.place[k] = states.place[b]
    to.free[k] = states.free[b]
    to.holder[k] = states.holder[b]
    to.cost[k] = states.cost[b]


@compiled
def _tried(line: BeamLine, states: BeamStates, count: int, window_s: int, found: Ints) -> int:
    """All orders that are a move longer than one of the states, into `found`; how many. The last state is spare.

    In each row: what it costs at least, its state, who moves, when it leaves, and the mark of its places.
    """
    stocks, spare, tried = len(line.first) - 1, len(states.cost) - 1, 0
    leave_s = np.zeros(stocks, np.int64)
    seen, stack = np.zeros(stocks, np.int64), np.zeros(stocks + 1, np.int64)
    for b in range(count):
        first_s, mark = -1, 0
        for i in range(stocks):
            leave_s[i] = -1
            mark ^= line.marks[i, states.at[b, i] - line.first[i]]
            if states.at[b, i] < line.first[i + 1]:
                leave_s[i] = _leaves_s(line, states, b, i)
            if leave_s[i] >= 0 and (first_s < 0 or leave_s[i] < first_s):
                first_s = leave_s[i]
        for i in range(stocks):
            if leave_s[i] < 0 or leave_s[i] > first_s + window_s:
                continue
            _copied(states, b, states, spare)
            _makes(line, states, spare, i, leave_s[i])
            if _in_a_circle(line, states, spare, i, seen, stack):
                continue
            made = states.at[b, i] - line.first[i]
            found[tried, 0] = states.cost[spare] + _rest_s(line, states, spare)
            found[tried, 1], found[tried, 2], found[tried, 3] = b, i, leave_s[i]
            found[tried, 4] = mark ^ line.marks[i, made] ^ line.marks[i, made + 1]
            tried += 1
    return tried


@compiled
def _kept(line: BeamLine, states: BeamStates, then: BeamStates, found: Ints, steps: Ints) -> int:
    """The cheapest of those found as states, one for the same places of all; into `steps` from which, and who moved."""
    count, width = 0, len(steps)
    marks = np.zeros(width, np.int64)
    for k in np.argsort(found[:, 0], kind="mergesort"):
        if count == width:
            break
        again = False
        for other in range(count):
            again = again or marks[other] == found[k, 4]
        if again:
            continue
        _copied(states, found[k, 1], then, count)
        _makes(line, then, count, found[k, 2], found[k, 3])
        steps[count, 0], steps[count, 1], marks[count] = found[k, 1], found[k, 2], found[k, 4]
        count += 1
    return count


@compiled
def _searched(line: BeamLine, states: BeamStates, then: BeamStates, window_s: int, order: Ints) -> int:
    """The best order found, into `order`, and its cost; -1: none. The states begin with one."""
    moves, width = len(order), len(states.cost) - 1
    steps = np.zeros((moves, width, 2), np.int64)
    found = np.zeros((width * (len(line.first) - 1), 5), np.int64)
    count = 1
    for layer in range(moves):
        tried = _tried(line, states, count, window_s, found)
        count = _kept(line, states, then, found[:tried], steps[layer])
        if count == 0:
            return -1
        states, then = then, states
    best = 0
    for b in range(count):
        best = b if states.cost[b] < states.cost[best] else best
    cost = states.cost[best]
    for layer in range(moves - 1, -1, -1):
        order[layer] = steps[layer, best, 1]
        best = steps[layer, best, 0]
    return int(cost)


def beam_orders(
    trains: Sequence[OrderTrain], ways: Sequence[Sequence[OrderWay]], searched: Sequence[Train]
) -> list[tuple[int, ...]]:
    """Orders in which all trains can finish that go these ways, one for each window at most; none may be found."""
    kept = [*(train.keeps for train in trains), *(way.keeps for own in ways for way in own)]
    if any(len(sections) > 1 for sections in kept):
        return []  # one that has a part of its next move stands in several places
    line, begin = _line(trains, ways, searched)
    stocks, moves = len(trains), len(line.runs)
    width = max(1, min(WIDTH_MAX, WORK // max(1, moves * moves * stocks)))
    found: list[tuple[int, ...]] = []
    for window_s in WINDOWS_S if moves else ():
        order = np.zeros(moves, np.int64)
        rows = [np.repeat(values[None], width + 1, axis=0) for values in begin]
        states, then = BeamStates(*rows), BeamStates(*(row.copy() for row in rows))
        if _searched(line, states, then, window_s, order) >= 0:
            found.append(tuple(map(int, order)))
    return list(dict.fromkeys(found))


def _line(
    trains: Sequence[OrderTrain], ways: Sequence[Sequence[OrderWay]], searched: Sequence[Train]
) -> tuple[BeamLine, BeamStates]:
    """As arrays; of the states one row."""
    own = [way for each in ways for way in each]
    moves = [move for train in trains for move in train.moves]
    used = [s for train in trains for s in (*train.holds, *train.keeps)]
    sections = 1 + max([*used, *(s for way in own for s in (*way.needs, *way.keeps))], default=0)
    needs = np.full((len(own), 1 + max((len(way.needs) for way in own), default=0)), NOBODY, np.int64)
    for row, way in zip(needs, own, strict=True):
        row[: len(way.needs)] = way.needs
    first = np.cumsum([0, *(len(train.moves) for train in trains)]).astype(np.int64)
    longest = 1 + max((len(train.moves) for train in trains), default=0)
    chance = random.Random(1)
    marks = [[chance.getrandbits(62) for _ in range(longest)] for _ in trains]
    line = BeamLine(
        first,
        needs,
        np.array([way.keeps[0] if way.keeps else NOBODY for way in own], np.int64),
        np.array([move.departs_s for move in moves], np.int64),
        np.array([move.runs_s for move in moves], np.int64),
        np.array([move.stays_s for move in moves], np.int64),
        np.array([max(0, move.due_s) for move in moves], np.int64),
        np.array([move.counts for move in moves], np.int64),
        _dead(searched, longest),
        np.array(marks, np.int64).reshape(len(trains), longest),
    )
    free, holder = np.zeros(sections, np.int64), np.full(sections, NOBODY, np.int64)
    for index, train in enumerate(trains):
        free[list(train.holds)] = train.comes_s
        holder[list(train.keeps)] = index
    ready = np.array([train.comes_s + train.ready_s for train in trains], np.int64)
    place = np.array([train.keeps[0] if train.keeps else NOBODY for train in trains], np.int64)
    return line, BeamStates(first[:-1].copy(), ready, place, free, holder, np.array(0, np.int64))


def _dead(searched: Sequence[Train], longest: int) -> NDArray[np.bool_]:
    """For each two trains the places from which they cannot both finish."""
    pairs, stocks = Pairs(searched), len(searched)
    dead = np.zeros((stocks, stocks, longest, longest), np.bool_)
    for one, two in ((later, earlier) for later in range(stocks) for earlier in range(later)):
        moves = len(searched[two].ahead)
        for at, good in enumerate(pairs.rows(one, two)):
            bad = [not good >> (moves - b) & 1 for b in range(moves + 1)]
            dead[one, two, at, : moves + 1] = dead[two, one, : moves + 1, at] = bad
    return dead
