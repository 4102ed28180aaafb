"""The day of every stock as the block manager knows it: its moves from track to track with their planned times.

Fixed data of the manager (`wayside.config.DispatchEntry`), made of the missions that the run draws up, so that the
tracks are those that the units will ask for.
"""

from __future__ import annotations

from collections.abc import Iterator

from simulation.setup import Setup
from study.feasibility.planned import PlannedDay, PlannedTrain, planned_day
from wayside.config import NO_DISPATCH, DispatchEntry, JourneyMove, OrderRule, StockMoves

S_PER_MIN = 60.0


def dispatch_of(setup: Setup) -> DispatchEntry:
    """How the manager gives routes, by `[dispatch]`; with the journeys of the day where it needs them."""
    given = setup.dispatch
    if not given.certificate and given.order is OrderRule.FIRST_COME and not given.given:
        return NO_DISPATCH
    return DispatchEntry(
        given.certificate,
        given.order,
        S_PER_MIN * given.keep_order_below_min,
        S_PER_MIN * given.hold_min_max,
        given.overtaken_max,
        journeys_of(setup, planned_day(setup)),
        given.given,
        parts=setup.grants_parts,
    )


def journeys_of(setup: Setup, day: PlannedDay) -> tuple[StockMoves, ...]:
    """The moves of every stock in order, from where it stands at first, or from outside."""
    return tuple(
        StockMoves(stock_id, tuple(move for train in trains for move in _moves(setup, train)))
        for stock_id, trains in day.trains.items()
    )


def _moves(setup: Setup, train: PlannedTrain) -> Iterator[JourneyMove]:
    """Onto the line, where it comes from outside, then route by route; the last one leaves the line, where it does."""
    duty, nodes = train.duty, train.nodes
    if duty.enters:
        section_id, enter_s = nodes[0].section_id, duty.enter_s
        yield JourneyMove(train.number, "", section_id, False, enter_s, enter_s, 0.0)
    for place, route in enumerate(train.routes):
        here, there = nodes[place], nodes[place + 1]
        last = place == len(train.routes) - 1
        stops = there.target is not None and there.target.passengers
        stays_s = setup.turn_s if last else setup.unit.dwell_min_s if stops else 0.0
        leaves = last and duty.leaves
        yield JourneyMove(
            train.number, route.id, there.section_id, leaves, here.departs_s, there.arrives_s, stays_s
        )
