"""The day of every stock as the block manager knows it: its moves from track to track with their planned times.

Fixed data of the manager (`wayside.config.DispatchEntry`), made of the missions that the run draws up, so that the
tracks are those that the units will ask for.
"""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from network.model import SectionKind
from network.train_fit import usable_length_m
from onboard.mission import Target
from simulation.setup import Setup
from study.feasibility.planned import PlannedDay, PlannedTrain, planned_day
from wayside.config import (
    NO_CUTS,
    NO_DISPATCH,
    CutRules,
    DispatchEntry,
    DispatcherMeans,
    JourneyMove,
    OrderRule,
    StockMoves,
)

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
        may=given.may,
        cuts=CutRules(
            given.turn_back_at, given.cancel_trains, given.stated_late_s, S_PER_MIN * given.cut_gain_min
        )
        if given.cuts
        else NO_CUTS,
    )


def journeys_of(setup: Setup, day: PlannedDay) -> tuple[StockMoves, ...]:
    """The moves of every stock in order, from where it stands at first, or from outside."""
    found: list[StockMoves] = []
    for stock_id, trains in day.trains.items():
        moves = [move for train in trains for move in _moves(setup, train)]
        if moves:  # where it is stabled the next day begins
            moves[-1] = msgspec.structs.replace(moves[-1], others=())
        found.append(StockMoves(stock_id, tuple(moves)))
    return tuple(found)


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
        others = () if there.target is None else _other_tracks(setup, train, there.target)
        station = None if here.target is None else here.target.station_id
        yield JourneyMove(
            train.number,
            route.id,
            there.section_id,
            leaves,
            here.departs_s,
            there.arrives_s,
            stays_s,
            others,
            station or "",
        )


def _other_tracks(setup: Setup, train: PlannedTrain, target: Target) -> tuple[str, ...]:
    """Other tracks of the station where a train stops that can take it."""
    line, direction = setup.believed_line, train.direction
    if DispatcherMeans.CHANGE_TRACK not in setup.dispatch.may or target.station_id is None:
        return ()
    length_m = setup.lengths_m[train.duty.stock_id]
    return tuple(
        track.section_id
        for track in line.stations[target.station_id].tracks
        if track.section_id != target.section_id
        and line.sections[track.section_id].kind is SectionKind.TRACK
        and direction in track.marks_m
        and usable_length_m(line, track, direction) >= length_m
    )
