"""Whether a train goes now or waits for another, where nobody knows when trains that are overdue will be ready.

Either is played on, in blocks and seconds, through the same few ways in which it may turn out. From then on trains are
let on by one of some simple rules, none of which knows more than the manager would by then, and of them the one that
loses least in the mean counts. What loses less is done, and `least_delay` decides where there is little between them.
The choice is made again as time goes on; under the law assumed it loses no more in the mean than each of these rules: a
rollout of several rules (Bertsekas and Castanon, Rollout algorithms for stochastic scheduling problems, 1999).
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plan.dispatching.rows import NOBODY, Ints, LineRows, StateRows, circles, go_s, leaves_s, line_rows, makes
from vehicle.compiled import compiled
from wayside.moves import Train
from wayside.order_question import OrderAnswer, OrderQuestion, OrderTrain, OrderWay

SAMPLES: Final = 8  # assumed: ways in which it may turn out, the same for every choice
WORK_MAX: Final = 20_000_000  # assumed: stocks looked at in a second; then no further way is played
SPREAD_S: Final = 120.0  # assumed: who is just overdue is as likely as not there after so long
LONGEST_S: Final = 1800  # assumed: by then it is there
GAIN_S: Final = 60  # assumed: what it must save to go or to wait otherwise than by `least_delay`
WAITS_S: Final = 60  # who is held is thought of again
HEARS_S: Final = 5  # assumed: who is held asks again so soon after another has come
HELD_S: Final = 900  # assumed: for as long a train is held in a play at most
FIRST_WAYS: Final = (3, 4, 1, 6, 0, 7, 2, 5)  # the middle first, as not all may be played
CHOICES: Final = (0, WAITS_S)  # until when it is held
NEVER: Final = 1 << 40
STUCK_S: Final = 3600  # assumed: for each stock, where all stand in each other's way
FIRST_COME: Final = -1
ANYBODY: Final = -2
# By `least_delay`, with who is overdue ready now, after as long again, or after as long as may be; by who asks first.
RULES: Final = (0, 1, LONGEST_S, FIRST_COME)


class ChancePlan(NamedTuple):
    """By move when it was to leave (s from now, below 0: it should have left), and whether two want the same open line;
    from how late on the planned order is left, and the rule by which trains are let on.
    """

    departs: Ints
    shares: NDArray[np.bool_]
    late_s: int
    rule: int


class ChanceStocks(NamedTuple):
    """By stock when it is ready for its first move in truth and as the manager thinks; for how long it is overdue, how
    late it was when it left last; for whom it waits, and since when. `seen`, `stack`: to work with; `work`: stocks
    looked at.
    """

    ready: Ints
    thought: Ints
    stood: Ints
    late: Ints
    waits: Ints
    held: Ints
    seen: Ints
    stack: Ints
    work: Ints


@compiled
def _leads_on(line: LineRows, states: StateRows, b: int, i: int, stocks: ChanceStocks) -> bool:
    """Whether stocks do not stand in a circle after its next move."""
    m, place = states.at[b, i], states.place[b, i]
    kept = line.keeps[m]
    if place >= 0:
        states.holder[b, place] = NOBODY
    if kept >= 0:
        states.holder[b, kept] = i
    states.at[b, i] = m + 1
    circle = circles(line, states, b, i, stocks.seen, stocks.stack)
    states.at[b, i] = m
    if kept >= 0:
        states.holder[b, kept] = NOBODY
    if place >= 0:
        states.holder[b, place] = i
    return not circle


@compiled
def _by_plan(line: LineRows, plan: ChancePlan, states: StateRows, stocks: ChanceStocks) -> int:
    """What it costs if all go on, who is planned first first where that can go; -1: nobody can. In the second row."""
    tried = np.zeros(len(stocks.ready), np.int64)
    while True:
        stocks.work[0] += len(tried)
        i, left = -1, False
        for k in range(len(tried)):
            m = states.at[1, k]
            if m < line.first[k + 1]:
                left = True
                if not tried[k] and (i < 0 or plan.departs[m] < plan.departs[states.at[1, i]]):
                    i = k
        if i < 0:
            return -1 if left else int(states.cost[1])
        time_s = leaves_s(line, states, 1, i)
        if time_s >= 0 and _leads_on(line, states, 1, i, stocks):
            makes(line, states, 1, i, time_s)
            tried[:] = 0
        else:
            tried[i] = 1


@compiled
def _comes_first(line: LineRows, states: StateRows, i: int, first: int, move: int) -> bool:
    """Another makes its moves up to one, who is in its way moving on; whether that goes without this one."""
    wanted, size = np.zeros(len(line.first), np.int64), 1
    wanted[0] = first
    while states.at[1, first] <= move:
        mover = wanted[size - 1]
        if states.at[1, mover] >= line.first[mover + 1]:
            return False
        time_s = go_s(line, states, 1, mover)
        if time_s >= 0:
            makes(line, states, 1, mover, time_s)
            size = max(1, size - 1)
            continue
        in_the_way = -1 - time_s
        for k in range(size):
            if in_the_way == i or in_the_way == wanted[k]:
                return False
        wanted[size] = in_the_way
        size += 1
    return True


@compiled
def _as_seen(line: LineRows, plan: ChancePlan, states: StateRows, stocks: ChanceStocks, now_s: int) -> None:
    """All as the manager sees it, into the second row."""
    states.at[1] = states.at[0]
    states.ready[1] = states.ready[0]
    states.place[1] = states.place[0]
    states.free[1] = states.free[0]
    states.holder[1] = states.holder[0]
    states.cost[1] = states.cost[0]
    for k in range(len(stocks.ready)):
        if states.at[0, k] == line.first[k]:
            states.ready[1, k] = stocks.thought[k]
            if stocks.stood[k] and now_s < stocks.ready[k]:
                again_s = min(plan.rule * (now_s + stocks.stood[k]), LONGEST_S)
                states.ready[1, k] = now_s + again_s
        states.ready[1, k] = max(states.ready[1, k], now_s)


@compiled
def _waits_for(
    line: LineRows, plan: ChancePlan, states: StateRows, stocks: ChanceStocks, i: int, now_s: int
) -> int:
    """For whom a train waits that could go, by the rule."""
    mine, going = states.at[0, i], -2
    for first in range(len(stocks.ready)):
        if first == i or plan.rule == FIRST_COME:
            continue
        for m in range(states.at[0, first], line.first[first + 1]):
            if plan.departs[m] >= plan.departs[mine]:
                break
            if not plan.shares[m, mine]:
                continue
            _as_seen(line, plan, states, stocks, now_s)
            if not _comes_first(line, states, i, first, m):
                break
            if max(stocks.late[first], now_s - plan.departs[states.at[0, first]]) < plan.late_s:
                return first
            holding = _by_plan(line, plan, states, stocks)
            if going == -2:
                _as_seen(line, plan, states, stocks, now_s)
                makes(line, states, 1, i, now_s)
                going = _by_plan(line, plan, states, stocks)
            if going < 0 or (holding >= 0 and going > holding - GAIN_S):
                return first
            break
    return NOBODY


@compiled
def _next_of(again: Ints, asked: Ints) -> int:
    """Who asks next; of several the one that asked first."""
    i = 0
    for k in range(1, len(again)):
        if again[k] < again[i] or (again[k] == again[i] and asked[k] < asked[i]):
            i = k
    return i


@compiled
def _asks_again_s(
    line: LineRows,
    plan: ChancePlan,
    states: StateRows,
    stocks: ChanceStocks,
    i: int,
    now_s: int,
    ruled: bool,
) -> int:
    """When one that asks now asks again; -1: it is let on. `ruled`: not before others if the rule says so."""
    stocks.waits[i] = NOBODY
    time_s = leaves_s(line, states, 0, i)
    if time_s < 0 or not _leads_on(line, states, 0, i, stocks):
        stocks.waits[i] = ANYBODY
        return NEVER
    if time_s > now_s or not ruled:
        return time_s if time_s > now_s else -1
    stocks.waits[i] = _waits_for(line, plan, states, stocks, i, now_s)
    if stocks.waits[i] < 0 or now_s >= stocks.held[i] + HELD_S:
        return -1
    stocks.held[i] = min(stocks.held[i], now_s)
    return now_s + WAITS_S


@compiled
def _played(
    line: LineRows,
    plan: ChancePlan,
    states: StateRows,
    stocks: ChanceStocks,
    asks: int,
    until_s: int,
    order: Ints,
) -> int:
    """What it costs if a train goes at once, or is held until then (s) or until one comes that is overdue; -1: nobody
    can go on. `order`: who moved, one after the other.
    """
    asked = np.full(len(stocks.ready), NEVER, np.int64)
    for k in range(len(asked)):
        if line.first[k] < line.first[k + 1]:
            asked[k] = max(stocks.ready[k], line.departs[line.first[k]])
    count, chosen = 0, until_s == 0
    if asks >= 0:
        asked[asks] = 0
    again = asked.copy()
    while True:
        i = _next_of(again, asked)
        if again[i] == NEVER:
            return int(states.cost[0]) if count == len(order) else -1
        now_s, m = again[i], states.at[0, i]
        if m == line.first[i] and stocks.stood[i] and now_s == asked[i] and now_s + HEARS_S < until_s:
            until_s = now_s + HEARS_S
            again[asks] = min(again[asks], until_s)
        states.ready[0, i] = now_s
        own = i == asks and m == line.first[i]
        again[i] = until_s
        if not own or now_s >= until_s:
            again[i] = _asks_again_s(line, plan, states, stocks, i, now_s, not own or not chosen)
        if again[i] >= 0:
            continue
        makes(line, states, 0, i, now_s)
        order[count], count = i, count + 1
        stocks.late[i], stocks.held[i], stocks.waits[i] = max(0, now_s - plan.departs[m]), NEVER, NOBODY
        again[i] = max(states.ready[0, i], line.departs[m + 1]) if m + 1 < line.first[i + 1] else NEVER
        asked[i] = again[i]
        for k in range(len(again)):
            if stocks.waits[k] == i or stocks.waits[k] == ANYBODY:
                again[k] = now_s


def residue_s(stood_s: int, level: float) -> int:
    """After how long one comes that has stood for so long; by chance, from 0 to 1. As likely as not after as long again
    and a little: the longer it has stood, the longer it still may.
    """
    return round(min((stood_s + SPREAD_S) * level / (1.0 - level), LONGEST_S))


class _Plays:
    """All that is the same in all plays of a question. `asks`: who does, if anybody. `order`: of the last play;
    `late_s`: what is lost already, s.
    """

    def __init__(
        self,
        trains: Sequence[OrderTrain],
        ways: Sequence[Sequence[OrderWay]],
        searched: Sequence[Train],
        late_s: int,
        asks: int = NOBODY,
    ) -> None:
        self.line, self._begin = line_rows(trains, ways, searched)
        self._late_s, self._asks = late_s, asks
        moves = [move for train in trains for move in train.moves]
        kept = [*(train.keeps for train in trains), *(way.keeps for own in ways for way in own)]
        tracks = {section for sections in kept for section in sections}
        wants = np.zeros((len(moves), len(self._begin.free)), np.int64)
        for row, way in zip(wants, (way for own in ways for way in own), strict=True):
            row[[section for section in way.needs if section not in tracks]] = 1
        self.shares = wants @ wants.T > 0
        self._departs = np.array([move.due_s - move.runs_s for move in moves], np.int64)
        stood = [train.stood_s if asks not in {NOBODY, k} else 0 for k, train in enumerate(trains)]
        self.stood = np.array(stood, np.int64)
        self.thought = np.where(self.stood > 0, 0, self._begin.ready)
        self._late = np.zeros(len(trains), np.int64)
        for k, m in enumerate(self.line.first[:-1]):
            self._late[k] = max(0, self.thought[k] - self._departs[m]) if trains[k].moves else 0
        self.order, self.work = np.zeros(len(moves), np.int64), np.zeros(1, np.int64)
        self.late_s = sum(max(0, -move.due_s) for move in moves if move.counts)

    def _begun(self, ready: Ints, rule: int) -> tuple[ChancePlan, StateRows, ChanceStocks]:
        states = StateRows(*(np.repeat(np.asarray(values)[None], 2, axis=0) for values in self._begin))
        states.ready[0] = ready
        waits, seen = np.full(len(ready), NOBODY, np.int64), np.zeros(len(ready), np.int64)
        held, stack = np.full(len(ready), NEVER, np.int64), np.zeros(len(ready) + 1, np.int64)
        late, work = self._late.copy(), self.work
        stocks = ChanceStocks(ready, self.thought, self.stood, late, waits, held, seen, stack, work)
        return ChancePlan(self._departs, self.shares, self._late_s, rule), states, stocks

    def lost_s(self, ready: Ints, rule: int, until_s: int = 0) -> int:
        """What is lost by a rule if that is when stocks are ready, and who asks goes at once or is held."""
        self.order[:] = self._asks
        cost = _played(self.line, *self._begun(ready, rule), self._asks, until_s, self.order)
        return cost if cost >= 0 else STUCK_S * len(ready)

    def waits_for(self) -> int:
        """For whom the one that asks waits by `least_delay`."""
        return _waits_for(self.line, *self._begun(self.thought, 0), self._asks, 0)


def rule_orders(
    trains: Sequence[OrderTrain], ways: Sequence[Sequence[OrderWay]], searched: Sequence[Train]
) -> list[tuple[int, ...]]:
    """The orders in which all go by `least_delay` and by who asks first, ready when they are expected."""
    plays = _Plays(trains, ways, searched, 0)
    lost = ((plays.lost_s(plays.thought, rule), tuple(plays.order.tolist())) for rule in (0, FIRST_COME))
    return [order for _, order in lost if NOBODY not in order]


def chance_order(
    question: OrderQuestion, ways: Sequence[Sequence[OrderWay]], searched: Sequence[Train]
) -> OrderAnswer:
    """Whether the train that asks goes now: the order has it first, or up to the first move of another for which it
    waits.
    """
    asks = question.asks
    plays = _Plays(question.trains, ways, searched, question.late_s, asks)
    line, shares, samples = plays.line, plays.shares, _samples(plays.thought, plays.stood)
    rules = RULES if plays.stood.any() else (RULES[0], FIRST_COME)
    lost_s = [[list[int]() for _ in rules] for _ in CHOICES]
    for ready in samples:
        for until_s, by_rule in zip(CHOICES, lost_s, strict=True):
            for rule, lost in zip(rules, by_rule, strict=True):
                lost.append(plays.lost_s(ready, rule, until_s))
        if plays.work[0] > WORK_MAX:
            break
    goes_s, waits_s = best = [min(by_rule, key=sum) for by_rule in lost_s]
    other = plays.waits_for()
    usual = int(other >= 0)
    goes = is_better(best[1 - usual], best[usual], lost_s[usual][0]) == bool(usual)
    found: list[int] = []
    if not goes and other >= 0:
        moves_of = range(int(line.first[other]), int(line.first[other + 1]))
        found = [other] * next(n for n, m in enumerate(moves_of, 1) if shares[m, line.first[asks]])
    for ready in () if goes or found else samples:
        plays.lost_s(ready, 0, WAITS_S)
        found = found or _first_over(plays.order.tolist(), line, shares, asks)
    chosen, otherwise = (waits_s, goes_s) if found else (goes_s, waits_s)
    means_s = (plays.late_s + sum(each) // len(each) for each in (chosen, otherwise))
    return OrderAnswer((*found, asks), next(means_s), otherwise_s=next(means_s))


def is_better(lost_s: Sequence[int], other_s: Sequence[int], usual_s: Sequence[int]) -> bool:
    """Whether a choice loses less than the other, and than `least_delay` by more than the standard error of that."""
    saved_s = [usual - lost for usual, lost in zip(usual_s, lost_s, strict=True)]
    less = sum(lost_s) + GAIN_S * len(lost_s) <= sum(other_s)
    return less and sum(saved_s) ** 2 >= sum(saved**2 for saved in saved_s)


def _first_over(order: Sequence[int], line: LineRows, shares: NDArray[np.bool_], asks: int) -> list[int]:
    """The moves until another has gone over the line that a train wants; none where it goes first itself."""
    at = [int(first) for first in line.first]
    for count, i in enumerate(order, 1):
        if i == asks:
            break
        if shares[at[i], line.first[asks]]:
            return list(order[:count])
        at[i] += 1
    return []


def _samples(thought: Ints, stood: Ints) -> list[Ints]:
    """When all are ready, one way after the other; one way where nobody is overdue. The same for the same question."""
    unknown, chance = np.flatnonzero(stood), random.Random(1)
    samples = [thought.copy() for _ in range(SAMPLES if len(unknown) else 1)]
    for k in unknown:
        levels = list(range(SAMPLES))
        if k != unknown[0]:
            chance.shuffle(levels)
        for ready, level in zip(samples, levels, strict=True):
            ready[k] = residue_s(int(stood[k]), (level + 0.5) / SAMPLES)
    return [samples[k] for k in FIRST_WAYS] if len(unknown) else samples
