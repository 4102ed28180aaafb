"""What a certificate costs: microseconds a grant, of a scenario's day and of a line with twenty trains.

The manager alone is asked, as its host does it: every stock asks for its next route when it is due, in blocks without
minutes, and gives back what lies behind. Late days have every stock delayed anew at each train, from a seed, so that
orders change and some are refused. What a grant costs without a certificate is reported beside it. The first decisions
of the twenty, late, are made by the order of all trains, too, with the solver that it asks.
"""

from __future__ import annotations

import math
import random
import statistics
import time
from collections.abc import Callable, Sequence
from typing import Any, Final

from msgspec.structs import replace as with_fields

from radio.messages import RouteRequest
from study.evaluate.afresh import budget_of
from study.evaluate.manager_day import AGAIN_S, ManagerDay, config_of
from wayside.config import (
    NO_DISPATCH,
    DispatchEntry,
    JourneyMove,
    ManagerConfig,
    OrderRule,
    RouteEntry,
    SectionEntry,
    StockMoves,
)

TRAINS: Final = 20
ROUNDS: Final = 2  # that each of the twenty makes
STATIONS: Final = 22
RUN_S: Final = 360.0
STAYS_S: Final = 60.0
LATE_S_MAX: Final = 1200.0
US_MAX: Final = 1000.0
DECISIONS: Final = 500  # by the order of all; most of them ask the solver nothing new
US_DECIDED_MAX: Final = 1e6  # for any of these
ASKED_MAX: Final = 200_000  # more, and the day is no bench any more


class DayOfManager:
    """A day of a manager, and what each grant and refusal took."""

    def __init__(
        self, config: ManagerConfig, journeys: tuple[StockMoves, ...], late_s: Callable[[], float]
    ) -> None:
        self.played = ManagerDay(config, journeys)
        self.grants_us: list[float] = []
        self.refused_us: list[float] = []
        self.decided_us: list[float] = []  # of both, those for which the order of all was asked for
        self._late_s = late_s

    @property
    def left(self) -> int:
        """How many moves were not made."""
        return sum(len(j.moves) - at for j, at in zip(self.played.journeys, self.played.at, strict=True))

    def play(self, asked_max: int = ASKED_MAX) -> None:
        """Whoever is due first asks; who is refused asks again a little later, until nobody has anything to do."""
        due_s = [self._due_s(k) for k in range(len(self.played.journeys))]
        for _ in range(asked_max):
            k = min(range(len(due_s)), key=due_s.__getitem__)
            if due_s[k] == math.inf:
                return
            granted = self._asks(k, due_s[k])
            due_s[k] = max(self._due_s(k), due_s[k] + STAYS_S) if granted else due_s[k] + AGAIN_S

    def _due_s(self, k: int) -> float:
        moves, at = self.played.journeys[k].moves, self.played.at[k]
        if at == len(moves):
            return math.inf
        begins = at == 0 or moves[at - 1].train != moves[at].train
        return moves[at].departs_s + (self._late_s() if begins else 0.0)

    def _asks(self, k: int, now_s: float) -> bool:
        message = self.played.request(k)
        solved, began = self.played.register.solved, time.perf_counter()
        granted = self.played.hear(k, message, now_s)
        spent_us = 1e6 * (time.perf_counter() - began)
        if self.played.register.solved is not solved:
            self.decided_us.append(spent_us)
        if not granted:
            self.refused_us.append(spent_us)
        else:
            if isinstance(message, RouteRequest):
                self.grants_us.append(spent_us)
            self.played.arrives(k, now_s)
        return granted


def of_twenty(order: OrderRule = OrderRule.FIRST_COME) -> ManagerConfig:
    """Two-track stations in a row with twenty sets on them, which go to the end, turn back, and so on, left-hand."""
    sections = [
        SectionEntry(f"{s}.{t}") if t else SectionEntry(f"{s}-{s + 1}", open_line=True)
        for s in range(STATIONS)
        for t in (1, 2, 0)
    ]
    routes = {
        name: RouteEntry(name, here, (f"{min(s, to)}-{max(s, to)}", there))
        for s in range(STATIONS)
        for to in (s - 1, s + 1)
        if 0 <= to < STATIONS
        for t in (1, 2)
        for u in (1, 2)
        for here, there in [(f"{s}.{t}", f"{to}.{u}")]
        for name in [f"{here}>{there}"]
    }
    journeys = tuple(StockMoves(f"u{k}", tuple(_shuttle(k))) for k in range(TRAINS))
    unit_ids = tuple(journey.unit_id for journey in journeys)
    entry = DispatchEntry(certificate=True, journeys=journeys, order=order)
    return ManagerConfig("line", "m", unit_ids, tuple(sections), tuple(routes.values()), dispatch=entry)


def _shuttle(number: int) -> list[JourneyMove]:
    """Sets stand in every station but the ends, down and up by turns; each goes round so often and is home again."""
    home, down = number + 1, number % 2 == 0
    at, track = home, 1 if down else 2
    goals = [STATIONS - 1, 0] if down else [0, STATIONS - 1]
    moves: list[JourneyMove] = []
    now_s = 0.0
    for turn, goal in enumerate([*goals * ROUNDS, home]):
        while at != goal:
            to, there = (1, at + 1) if goal > at else (2, at - 1)
            name = f"{at}.{track}>{there}.{to}"
            train = f"{number}/{turn}"
            moves.append(JourneyMove(train, name, f"{there}.{to}", False, now_s, now_s + RUN_S, STAYS_S))
            now_s += RUN_S + STAYS_S
            at, track = there, to
    return moves


def day_of(
    config: ManagerConfig, *, certificate: bool, late: bool, asked_max: int = ASKED_MAX
) -> DayOfManager:
    """A day of the manager, played through, or as far as so many requests."""
    chance = random.Random("late" if late else "planned")
    journeys = config.dispatch.journeys
    given = config if certificate else with_fields(config, dispatch=NO_DISPATCH)
    day = DayOfManager(given, journeys, lambda: chance.uniform(0.0, LATE_S_MAX) if late else 0.0)
    day.play(asked_max)
    return day


def row_of(name: str, config: ManagerConfig, *, late: bool) -> dict[str, Any]:
    """The figures of one day."""
    without, with_it = (day_of(config, certificate=c, late=late) for c in (False, True))
    grants = sorted(with_it.grants_us)
    return {
        "day": name,
        "grants": len(grants),
        "us_a_grant": round(statistics.fmean(grants), 1),
        "us_median": round(statistics.median(grants), 1),
        "us_of_100_the_slowest": round(grants[int(0.99 * (len(grants) - 1))], 1),
        "us_max": round(grants[-1], 1),
        "us_without": round(statistics.fmean(without.grants_us), 1),
        "us_refused_max": round(max(with_it.refused_us, default=0.0), 1),
        "moves_left": with_it.left,
        "moves_left_without": without.left,
    }


def decisions_us() -> list[float]:
    """Of the first of a late day of twenty trains, by the order of all, those for which the solver is asked anew."""
    return day_of(of_twenty(OrderRule.OPTIMAL), certificate=True, late=True, asked_max=DECISIONS).decided_us


def bench(scenario: str, rounds: int, tell: Callable[[str], None]) -> dict[str, Any]:
    """The days of a scenario and of twenty trains, as planned and late; the best of all rounds counts."""
    days = {scenario: config_of(scenario), f"{TRAINS} trains": of_twenty()}
    rows: list[dict[str, Any]] = []
    for name, config in days.items():
        for late in (False, True):
            shown = f"{name}, late" if late else name
            tell(f"certificate: {shown}")
            tried = [row_of(shown, config, late=late) for _ in range(rounds)]
            rows.append(min(tried, key=lambda row: float(row["us_a_grant"])))
    tell(f"certificate: {DECISIONS} decisions by the order of {TRAINS} trains")
    tried_us = [decisions_us() for _ in range(1 + rounds)]  # the first round starts the solver
    return report(scenario, rounds, rows, min(tried_us, key=max))


def report(
    scenario: str, rounds: int, rows: Sequence[dict[str, Any]], decided_us: Sequence[float]
) -> dict[str, Any]:
    """The rows, and whether a grant, and the decisions by the order of all, cost no more than they may."""
    return {
        "scenario": scenario,
        "rounds": rounds,
        "same_digest": True,  # no day runs here
        "rows": list(rows),
        "budgets": [
            *(budget_of(f"us a grant, {row['day']}", US_MAX, row["us_a_grant"]) for row in rows),
            *(
                budget_of(
                    f"us the {which} of {len(decided_us)} decisions by the order of {TRAINS} trains",
                    US_DECIDED_MAX,
                    round(took_us, 1),
                )
                for which, took_us in (
                    ("median", statistics.median(decided_us)),
                    ("slowest", max(decided_us)),
                )
            ),
        ],
    }
