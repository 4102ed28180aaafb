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
from dataclasses import replace
from typing import Final

from network.graph import all_routes
from radio.messages import Claim, HoldingReport, RouteRequest, SignOff, SignOn
from study.run.journeys import dispatch_of
from study.scenario.scenario import load_scenario
from study.sweep.statistics import difference_of, mean_of
from wayside.block_manager import Heard, step
from wayside.config import ManagerConfig, Order, manager_config
from wayside.register import start
from wayside.said import BoundaryPassed

SHARE: Final = 0.01  # assumed: of departures at which doors stay open
MEAN_S: Final = 480.0  # assumed: exponential
LID_S: Final = 1800.0
AGAIN_S: Final = 5.0  # a refused train asks again
LAST_S: Final = 2.0 * 86_400.0  # who has not come by then never does
SAID: Final = 0.95


def config_of(scenario: str, order: Order) -> ManagerConfig:
    """The manager of a scenario, with the certificate and this order of trains."""
    setup = load_scenario(scenario).setup
    given = replace(setup, dispatch=setup.dispatch.model_copy(update={"certificate": True, "order": order}))
    unit_ids = tuple(diagram.stock_id for diagram in setup.timetable.diagrams)
    return manager_config(setup.line, all_routes(setup.line), unit_ids, dispatch=dispatch_of(given))


def lost_min(config: ManagerConfig, seed: int) -> float:
    """By how much trains come late to their ends on a day, together, min; who never comes, as late as `LAST_S`."""
    journeys = config.dispatch.journeys
    routes = {route.route_id: route for route in config.routes}
    keys = {terminal: bytes(32) for section in config.sections for terminal in section.terminal_ids}
    register = start(config, 1, keys)
    at, lost_s = [0] * len(journeys), 0.0

    def hear(k: int, message: object, now_s: float) -> bool:
        nonlocal register
        before = register.counter
        heard = Heard(journeys[k].unit_id, 1, True, 0, message)
        register, _ = step(register, heard, now_s)  # type: ignore[arg-type]
        return register.counter != before

    def leaves_s(k: int, ready_s: float) -> float:
        move = journeys[k].moves[at[k]]
        chance = random.Random(f"{seed} {move.train} {at[k]}")
        held_s = min(chance.expovariate(1.0 / MEAN_S), LID_S) if chance.random() < SHARE else 0.0
        return max(move.departs_s, ready_s) + held_s

    asks = [(leaves_s(k, 0.0), k, False) for k in range(len(journeys)) if journeys[k].moves]
    for _, k, _ in asks:
        first = routes.get(journeys[k].moves[0].route_id)
        hear(k, Claim((first.from_section,) if first else (), 0), 0.0)
    heapq.heapify(asks)
    while asks:
        now_s, k, runs = heapq.heappop(asks)
        move = journeys[k].moves[at[k]]
        if now_s > LAST_S:
            break
        if not runs:
            route = routes.get(move.route_id)
            unit_id = journeys[k].unit_id
            message = (
                SignOn(unit_id, (move.section_id,))
                if route is None
                else RouteRequest(unit_id, route.route_id, route.section_ids)
            )
            granted = hear(k, message, now_s)
            takes_s = move.arrives_s - move.departs_s if granted else AGAIN_S
            heapq.heappush(asks, (now_s + takes_s, k, granted))
            continue
        token = register.unit(journeys[k].unit_id).token
        if move.route_id:
            hear(k, HoldingReport((move.section_id,), token), now_s)
            if move.leaves:
                hear(k, SignOff(journeys[k].unit_id, token), now_s)
                register, _ = step(register, BoundaryPassed(move.section_id), now_s)
        at[k] += 1
        moves = journeys[k].moves
        if at[k] == len(moves) or moves[at[k]].train != move.train:
            lost_s += max(0.0, now_s - move.arrives_s)
        if at[k] < len(moves):
            heapq.heappush(asks, (leaves_s(k, now_s + move.stays_s), k, False))
    never = (moves[place:] for moves, place in zip((j.moves for j in journeys), at, strict=True))
    lost_s += sum(LAST_S - last.arrives_s for rest in never for last in {m.train: m for m in rest}.values())
    return lost_s / 60.0


def rows(scenario: str, days: int) -> list[str]:
    """For each rule the train-minutes lost a day, and how much more than with who asks first, paired by day."""
    by_rule = {
        order: [lost_min(config, seed) for seed in range(1, days + 1)]
        for order in Order
        for config in [config_of(scenario, order)]
    }
    first = by_rule[Order.FIRST_COME]
    return [f"{order.value}: {_text(first, lost)}" for order, lost in by_rule.items()]


def _text(first: Sequence[float], lost: Sequence[float]) -> str:
    differs = sum(abs(a - b) > 1e-6 for a, b in zip(first, lost, strict=True))
    more = difference_of(list(zip(first, lost, strict=True)), SAID)
    return f"{mean_of(lost, SAID).text} min; more than first come: {more.text}; {differs} days differ"


if __name__ == "__main__":
    sys.stdout.write("\n".join(rows(sys.argv[1], int(sys.argv[2]))) + "\n")
