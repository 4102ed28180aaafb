"""Whether an order of trains helps: a scenario's late days played through by the manager, in blocks and minutes.

The manager alone is asked, as its host does it, by trains that run each move in the time planned for it: no driving, no
radio, no failures. At some departures doors stay open for minutes, drawn by seed, train and place, so that every rule
has the same days. `python -m study.evaluate.order_of_trains SCENARIO DAYS` says what each rule loses, and by how much
more than with who asks first.
"""

from __future__ import annotations

import heapq
import random
import sys
from collections.abc import Sequence
from typing import Final

from study.evaluate.manager_day import AGAIN_S, ManagerDay, config_of
from study.sweep.statistics import difference_of, mean_of
from wayside.config import JourneyMove, ManagerConfig, OrderRule

SHARE: Final = 0.01  # assumed: of departures at which doors stay open
MEAN_S: Final = 480.0  # assumed: exponential
LID_S: Final = 1800.0
LAST_S: Final = 2.0 * 86_400.0  # who has not come by then never does
SAID: Final = 0.95


def lost_min(config: ManagerConfig, seed: int) -> float:
    """By how much trains come late to their ends on a day, together, min; who never comes, as late as `LAST_S`."""
    journeys = config.dispatch.journeys
    day, lost_s = ManagerDay(config, journeys), 0.0

    def leaves_s(k: int, ready_s: float) -> float:
        move = journeys[k].moves[day.at[k]]
        return max(move.departs_s, ready_s) + doors_s(seed, move, day.at[k])

    asks = [(leaves_s(k, 0.0), k, False) for k in range(len(journeys)) if journeys[k].moves]
    heapq.heapify(asks)
    while asks:
        now_s, k, runs = heapq.heappop(asks)
        if now_s > LAST_S:
            break
        if not runs:
            move = journeys[k].moves[day.at[k]]
            granted = day.hear(k, day.request(k), now_s)
            takes_s = move.arrives_s - move.departs_s if granted else AGAIN_S
            heapq.heappush(asks, (now_s + takes_s, k, granted))
            continue
        move = day.arrives(k, now_s)
        following = day.move(k)
        if following is None or following.train != move.train:
            lost_s += max(0.0, now_s - move.arrives_s)
        if following is not None:
            heapq.heappush(asks, (leaves_s(k, now_s + move.stays_s), k, False))
    never = (moves[place:] for moves, place in zip((j.moves for j in journeys), day.at, strict=True))
    lost_s += sum(LAST_S - last.arrives_s for rest in never for last in {m.train: m for m in rest}.values())
    return lost_s / 60.0


def doors_s(seed: int, move: JourneyMove, place: int) -> float:
    """For how long doors stay open before a move of a day, by its place there, s."""
    chance = random.Random(f"{seed} {move.train} {place}")
    return min(chance.expovariate(1.0 / MEAN_S), LID_S) if chance.random() < SHARE else 0.0


def days_lost_min(scenario: str, order: OrderRule, seeds: Sequence[int]) -> list[float]:
    """What a rule loses on each of some days, min."""
    config = config_of(scenario, order)
    return [lost_min(config, seed) for seed in seeds]


def rows(scenario: str, days: int) -> list[str]:
    """For each rule the train-minutes lost a day, and how much more than with who asks first, paired by day."""
    seeds = range(1, days + 1)
    by_rule = {order: days_lost_min(scenario, order, seeds) for order in OrderRule}
    first = by_rule[OrderRule.FIRST_COME]
    return [f"{order.value}: {_text(first, lost)}" for order, lost in by_rule.items()]


def _text(first: Sequence[float], lost: Sequence[float]) -> str:
    differs = sum(abs(a - b) > 1e-6 for a, b in zip(first, lost, strict=True))
    more = difference_of(list(zip(first, lost, strict=True)), SAID)
    return f"{mean_of(lost, SAID).text} min; more than first come: {more.text}; {differs} days differ"


if __name__ == "__main__":
    sys.stdout.write("\n".join(rows(sys.argv[1], int(sys.argv[2]))) + "\n")
