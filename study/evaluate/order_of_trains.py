"""Whether an order of trains helps: a scenario's late days played through by the manager, in blocks and minutes.

The manager alone is asked, as its host does it, by trains that run each move in the time planned for it: no driving, no
radio, no failures. At some departures doors stay open for minutes, drawn by seed, train and place, so that every rule
has the same days. `python -m study.evaluate.order_of_trains SCENARIO FIRST DAYS [change_track] [take_back] [cuts]` says
what each rule loses, with and without that allowed, and by how much more than with who asks first; `share=0.02`: at so
many departures doors stay open.
"""

from __future__ import annotations

import heapq
import random
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from study.evaluate.manager_day import AGAIN_S, ManagerDay, config_of
from study.sweep.statistics import difference_of, mean_of
from wayside.config import DispatcherMeans, JourneyMove, ManagerConfig, OrderRule

SHARE: Final = 0.01  # assumed: of departures at which doors stay open
MEAN_S: Final = 480.0  # assumed: exponential
LID_S: Final = 1800.0
LAST_S: Final = 2.0 * 86_400.0  # who has not come by then never does
SAID: Final = 0.95


@dataclass(frozen=True, slots=True)
class LostDay:
    """What a day lost: by how much trains came late to their ends, together, and how long they waited at stops for each
    other; the longest of these waits. Min. `cut`: trains left out whole or in part; each is in both sums, as late
    as the scenario states.
    """

    lost_min: float
    waited_min: float
    longest_min: float
    cut: int = 0


class _Played:
    """A day of a manager, played through; doors stay open before a train asks."""

    def __init__(self, config: ManagerConfig, seed: int, share: float | None) -> None:
        self._share = share
        self._day, self._seed = ManagerDay(config, config.dispatch.journeys), seed
        self._events: list[tuple[float, int, bool]] = []  # asks, or (True) has come to the end of its move
        self._asked_s: dict[int, float] = {}
        self._doors_s: dict[int, float] = {}  # until when they are open
        self.lost_s = self.waited_s = self.longest_s = 0.0
        self.cut, self.cut_s = 0, 0.0
        self._due_s: dict[int, float] = {}
        self._cut_s = config.dispatch.cuts.late_s

    def run(self) -> None:
        """To the end of the day."""
        for k in range(len(self._day.moves)):
            self._ready(k, 0.0)
        while self._events:
            now_s, k, comes = heapq.heappop(self._events)
            if now_s > LAST_S:
                break
            if comes:
                self._comes(k, now_s)
            else:
                self._asks(k, now_s)
            for other, until_s in self._day.given_back.items():
                self._events = sorted(event for event in self._events if event[1] != other)
                self._put(until_s, other)
            self._day.given_back.clear()
        for k, moves in enumerate(self._day.moves):
            last = {move.train: move for move in moves[self._day.at[k] :]}
            self.lost_s += sum(LAST_S - move.arrives_s for move in last.values())
        self.lost_s += self.cut_s
        self.waited_s += self.cut_s

    def _put(self, at_s: float, k: int, *, comes: bool = False) -> None:
        """To the millisecond, so that rounding does not decide who asks first."""
        heapq.heappush(self._events, (round(at_s, 3), k, comes))

    def _ready(self, k: int, ready_s: float) -> None:
        """A stock asks when its next move is due and it is ready, or its doors are shut."""
        move = self._day.move(k)
        if move is not None:
            self._due_s[k] = move.departs_s
            due_s, open_s = max(move.departs_s, ready_s), self._open_s(k, move)
            self._doors_s[k] = due_s + open_s
            self._put(due_s + open_s, k)

    def _open_s(self, k: int, move: JourneyMove) -> float:
        return doors_s(self._seed, move, self._day.planned_at[k][self._day.at[k]], self._share)

    def _asks(self, k: int, now_s: float) -> None:
        self._asked_s.setdefault(k, now_s)
        granted = self._day.hear(k, self._day.request(k), now_s)
        if k in self._day.cut:
            trains, ready_s = self._day.cut.pop(k)
            self.cut += trains
            self.cut_s += max(self._cut_s, now_s - self._due_s[k]) + (trains - 1) * self._cut_s
            self.waited_s += now_s - self._asked_s.pop(k)
            self._ready(k, ready_s)
            return
        if not granted:
            self._put(now_s + AGAIN_S, k)
            return
        waited_s = now_s - self._asked_s.pop(k)
        self.waited_s, self.longest_s = self.waited_s + waited_s, max(self.longest_s, waited_s)
        move, leaves_s = self._day.moves[k][self._day.at[k]], max(now_s, self._doors_s[k])
        self._day.leaves_s[k] = leaves_s
        self._put(leaves_s + move.arrives_s - move.departs_s, k, comes=True)

    def _comes(self, k: int, now_s: float) -> None:
        move = self._day.arrives(k, now_s)
        following = self._day.move(k)
        if following is None or following.train != move.train:
            self.lost_s += max(0.0, now_s - move.arrives_s)
        self._ready(k, now_s + move.stays_s)


def played_day(config: ManagerConfig, seed: int, *, share: float | None = None) -> LostDay:
    """A day by its seed; who never comes is as late as if it came at `LAST_S`."""
    played = _Played(config, seed, share)
    played.run()
    return LostDay(played.lost_s / 60.0, played.waited_s / 60.0, played.longest_s / 60.0, played.cut)


def lost_min(config: ManagerConfig, seed: int) -> float:
    """By how much trains come late to their ends on a day, together, min."""
    return played_day(config, seed).lost_min


def doors_s(seed: int, move: JourneyMove, place: int, share: float | None = None) -> float:
    """For how long doors stay open before a move of a day, by its place there, s."""
    chance = random.Random(f"{seed} {move.train} {place}")
    return (
        min(chance.expovariate(1.0 / MEAN_S), LID_S)
        if chance.random() < (SHARE if share is None else share)
        else 0.0
    )


def days_lost_min(scenario: str, order: OrderRule, seeds: Sequence[int]) -> list[float]:
    """What a rule loses on each of some days, min."""
    config = config_of(scenario, order)
    return [lost_min(config, seed) for seed in seeds]


def rows(
    scenario: str,
    seeds: Sequence[int],
    may: tuple[DispatcherMeans, ...] = (),
    *,
    cuts: bool = False,
    share: float | None = None,
) -> list[str]:
    """For each rule, and with what the dispatcher may do besides, the train-minutes lost a day and waited at stops, and
    how much more than with who asks first, paired by day.
    """
    first: list[LostDay] = []
    found: list[str] = []
    for means, cut in dict.fromkeys((((), False), (may, cuts))):
        for order in OrderRule:
            config = config_of(scenario, order, means, cuts=cut)
            days = [played_day(config, seed, share=share) for seed in seeds]
            first = first or days
            name = " and ".join([order.value, *(each.value for each in means), *(["cuts"] if cut else [])])
            lost = _text([day.lost_min for day in first], [day.lost_min for day in days])
            waited = _text([day.waited_min for day in first], [day.waited_min for day in days])
            longest = max(day.longest_min for day in days)
            number = sum(day.cut for day in days)
            found.append(
                f"{name}: lost {lost}; waited {waited}; at most {longest:.0f} min; {number} trains cut"
            )
    return found


def _text(first: Sequence[float], lost: Sequence[float]) -> str:
    differs = sum(abs(a - b) > 1e-6 for a, b in zip(first, lost, strict=True))
    more = difference_of(list(zip(first, lost, strict=True)), SAID)
    return f"{mean_of(lost, SAID).text} min, {more.text} more than first come, {differs} days differ"


if __name__ == "__main__":
    scenario, first_seed, days, *named = sys.argv[1:]
    seeds = range(int(first_seed), int(first_seed) + int(days))
    shares = [float(word.removeprefix("share=")) for word in named if word.startswith("share=")]
    allowed = tuple(DispatcherMeans(word) for word in named if word != "cuts" and "=" not in word)
    said = rows(scenario, seeds, allowed, cuts="cuts" in named, share=(*shares, None)[0])
    sys.stdout.write("\n".join(said) + "\n")
