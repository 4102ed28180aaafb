"""A line and its stock in rows of numbers, for compiled code: what keeps a stock from its next move, what that does.

No move is made after which two trains could not both finish (`wayside.pairs`), or some stand in a circle.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled
from wayside.moves import Train
from wayside.order_question import OrderTrain, OrderWay
from wayside.pairs import Pairs

NOBODY: Final = -1

Ints = NDArray[np.int64]


class LineRows(NamedTuple):
    """What is to be done: moves in rows, those of stock i from `first[i]` on; sections by number, -1: none. s from now.

    `dead[i, j, a, b]`: with a and b moves made stocks i and j cannot both finish.
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


class StateRows(NamedTuple):
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
def go_s(line: LineRows, states: StateRows, b: int, i: int) -> int:
    """When the way of a stock's next move is free and it is ready; -1 - k: stock k stands there."""
    m = states.at[b, i]
    time_s = max(states.ready[b, i], line.departs[m])
    for section in line.needs[m]:
        if section < 0:
            break
        holder = states.holder[b, section]
        if holder >= 0 and holder != i:
            return int(-1 - holder)
        time_s = max(time_s, states.free[b, section])  # its own place was free when it came
    return int(time_s)


@compiled
def leaves_s(line: LineRows, states: StateRows, b: int, i: int) -> int:
    """When a stock can make its next move; -1: another stands there, or not all could finish afterwards."""
    time_s = go_s(line, states, b, i)
    if time_s < 0:
        return -1
    made = states.at[b, i] + 1 - line.first[i]
    for other in range(len(line.first) - 1):
        if other != i and line.dead[i, other, made, states.at[b, other] - line.first[other]]:
            return -1
    return time_s


@compiled
def makes(line: LineRows, states: StateRows, b: int, i: int, leaves_s: int) -> None:
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
def circles(line: LineRows, states: StateRows, b: int, mover: int, seen: Ints, stack: Ints) -> bool:
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


def line_rows(
    trains: Sequence[OrderTrain], ways: Sequence[Sequence[OrderWay]], searched: Sequence[Train]
) -> tuple[LineRows, StateRows]:
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
    line = LineRows(
        first,
        needs,
        np.array([way.keeps[0] if way.keeps else NOBODY for way in own], np.int64),
        np.array([move.departs_s for move in moves], np.int64),
        np.array([move.runs_s for move in moves], np.int64),
        np.array([move.stays_s for move in moves], np.int64),
        np.array([max(0, move.due_s) for move in moves], np.int64),
        np.array([move.counts for move in moves], np.int64),
        _dead(searched, longest),
    )
    free, holder = np.zeros(sections, np.int64), np.full(sections, NOBODY, np.int64)
    for index, train in enumerate(trains):
        free[list(train.holds)] = train.comes_s
        holder[list(train.keeps)] = index
    ready = np.array([train.comes_s + train.ready_s for train in trains], np.int64)
    place = np.array([train.keeps[0] if train.keeps else NOBODY for train in trains], np.int64)
    return line, StateRows(first[:-1].copy(), ready, place, free, holder, np.array(0, np.int64))


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
