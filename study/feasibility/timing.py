"""Times of one set's trains that are too short: legs, stops, turning back, staying outside, coming in.

A leg is measured against what units make of it (`RunTimes`), a stop against the shortest that they keep, a turn-back
against the driver's walk to the other end and the points to be thrown, a layover outside a portal and the lead with
which trains come in against the run between portal and first call.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from network.clock import clock
from network.model import Line
from onboard.mission import Mission
from simulation.setup import Setup
from study.feasibility.finding import Finding, FindingKind, length_of_time, minute, severity_of
from study.feasibility.planned import SIGNS_S, PlannedDay, PlannedStop, PlannedTrain, due_s
from study.feasibility.run_times import RunTimes

NEGLIGIBLE_S = 1.0  # shorter than this, a time is not worth a word


def timing_of(setup: Setup, day: PlannedDay) -> Iterator[Finding]:
    """Every time of the day that is too short."""
    times = RunTimes(setup)
    for trains in day.trains.values():
        for train in trains:
            yield from _legs(setup, day.line, train, times)
            yield from _dwells(setup, day.line, train)
            if train.duty.enters:
                yield from _comes_in(setup, train)
        for before, after in pairwise(trains):
            yield from _between(setup, day.line, before, after)


def _name(line: Line, stand: PlannedStop) -> str:
    station_id = stand.target.station_id
    return f"portal {stand.target.section_id}" if station_id is None else line.stations[station_id].name


def _legs(setup: Setup, line: Line, train: PlannedTrain, times: RunTimes) -> Iterator[Finding]:
    """Runs from stop to stop that take longer than the plan gives them."""
    for before, there in pairwise(train.stands):
        if before.target.station_id is None or there.target.station_id is None:
            continue
        least_s = due_s(there.target, setup.unit.dwell_min_s)
        short_s = before.departs_s + there.run_s - least_s
        # a train that cannot climb is a finding of the gradient
        if short_s < NEGLIGIBLE_S or math.isinf(short_s):
            continue
        names = _name(line, before), _name(line, there)
        planned_s = least_s - before.departs_s
        ends_m = before.target.mark_m, there.target.mark_m
        limits_s = times.run_s(train.stock_id, train.duty.mission.path, *ends_m, at_limits=True)
        km = (ends_m[1] - ends_m[0]) / 1000.0
        text = (
            f"{train.number} leaves {names[0]} at {minute(before.departs_s)} and has {planned_s:.0f} s for"
            f" {km:.1f} km to {names[1]}; {setup.trains[train.stock_id].name} needs {there.run_s:.0f} s"
            f" as trains are driven, {limits_s:.0f} s at the limits"
        )
        remedy = f"it is at {names[1]} at {clock(math.ceil(before.departs_s + there.run_s))} at the earliest"
        times_s = (
            before.target.departure_s,
            there.target.departure_s if there.target.arrival_s is None else there.target.arrival_s,
        )
        place = f"{before.target.station_id}-{there.target.station_id}"
        severity = severity_of(short_s, *times_s)
        yield Finding(
            FindingKind.LEG, severity, (train.number,), place, before.departs_s, text, remedy, short_s
        )


def _dwells(setup: Setup, line: Line, train: PlannedTrain) -> Iterator[Finding]:
    """Stops for passengers that are shorter than units keep; the first and the last of a train are none.

    Whole minutes hide a stop that arrives and leaves in the same one: it is named where the train cannot leave in time.
    """
    for before, stand in pairwise(train.stands):
        target = stand.target
        if target.arrival_s is None or target.departure_s is None or not target.passengers:
            continue
        short_s = setup.unit.dwell_min_s - (target.departure_s - target.arrival_s)
        if short_s < NEGLIGIBLE_S or target.station_id is None:
            continue
        late_s = before.departs_s + stand.run_s + setup.unit.dwell_min_s - target.departure_s
        if target.arrival_s % 60 == target.departure_s % 60 == 0 and late_s < NEGLIGIBLE_S:
            continue
        stays_s = target.departure_s - target.arrival_s
        text = (
            f"{train.number} stops at {_name(line, stand)} at {minute(target.arrival_s)} for {stays_s:.0f} s; units"
            f" stay {setup.unit.dwell_min_s:.0f} s at least"
        )
        remedy = f"it leaves at {clock(math.ceil(target.arrival_s + setup.unit.dwell_min_s))} at the earliest"
        severity = severity_of(short_s, target.arrival_s, target.departure_s)
        trains, place = (train.number,), target.station_id
        yield Finding(FindingKind.DWELL, severity, trains, place, target.arrival_s, text, remedy, short_s)


def _comes_in(setup: Setup, train: PlannedTrain) -> Iterator[Finding]:
    """A train from a portal that the lead lets come too late for its first call."""
    if len(train.stands) < 2:
        return
    portal, first = train.stands[:2]
    come_s = train.duty.enter_s + SIGNS_S + first.run_s
    short_s = come_s - due_s(first.target, setup.unit.dwell_min_s)
    if short_s < NEGLIGIBLE_S:
        return
    lead_s, needs_s = setup.operation.portal_lead_s, setup.operation.portal_lead_s + short_s
    text = (
        f"{train.number} stands in portal {portal.target.section_id} {lead_s:.0f} s before its first call at"
        f" {minute(first.arrives_s)}, and needs {needs_s:.0f} s to be there in time"
    )
    remedy = f"operation.portal_lead_s is {math.ceil(needs_s)} at least"
    severity = severity_of(short_s, first.target.arrival_s, first.target.departure_s)
    place = portal.target.section_id
    yield Finding(
        FindingKind.PORTAL, severity, (train.number,), place, first.arrives_s, text, remedy, short_s
    )


def throws_s(line: Line, mission: Mission) -> float:
    """How long the points between a train's first track and the open line take at most, s: they may lie right."""
    first = mission.routes[0] if mission.routes else None
    if first is None:
        return 0.0
    sections = {line.points[points_id].section_id: points_id for points_id, _ in first.points}
    ahead = next((section_id for section_id in first.section_ids if section_id in sections), None)
    if ahead is None or ahead != first.section_ids[0]:
        return 0.0
    return max(line.points[p].throw_time_s for p, _ in first.points if line.points[p].section_id == ahead)


def _between(setup: Setup, line: Line, before: PlannedTrain, after: PlannedTrain) -> Iterator[Finding]:
    """From the end of a train to the beginning of the next one of its set."""
    if before.duty.leaves:
        yield from _layover(setup, before, after)
        return
    arrival, start = before.stands[-1], after.stands[0]
    needs_s = setup.turn_s + throws_s(line, after.duty.mission)
    planned_s = start.departs_s - arrival.arrives_s
    short_s = needs_s - planned_s
    if short_s < NEGLIGIBLE_S or arrival.target.station_id is None:
        return
    text = (
        f"{before.number} becomes {after.number} at {_name(line, arrival)} at {minute(arrival.arrives_s)} within"
        f" {planned_s:.0f} s; changing ends and setting the way take {needs_s:.0f} s"
    )
    remedy = f"{after.number} leaves at {clock(math.ceil(arrival.arrives_s + needs_s))} at the earliest"
    severity = severity_of(short_s, arrival.target.arrival_s, start.target.departure_s)
    trains, place = (before.number, after.number), arrival.target.station_id
    kind = FindingKind.TURN_BACK
    yield Finding(kind, severity, trains, place, arrival.arrives_s, text, remedy, short_s)


def _layover(setup: Setup, before: PlannedTrain, after: PlannedTrain) -> Iterator[Finding]:
    """A set that leaves by a portal and comes back too soon."""
    if len(after.stands) < 2:
        return
    left_s = before.stands[-1].arrives_s + SIGNS_S
    first = after.stands[1]
    short_s = left_s + SIGNS_S + first.run_s - due_s(first.target, setup.unit.dwell_min_s)
    if short_s < NEGLIGIBLE_S:
        return
    text = (
        f"the set of {before.number} has left by {before.nodes[-1].section_id} at {clock(round(left_s))} at the"
        f" earliest, and cannot come back as {after.number} for {minute(first.arrives_s)}"
    )
    remedy = f"{after.number} comes {length_of_time(short_s)} later"
    severity = severity_of(short_s, first.target.arrival_s, first.target.departure_s)
    trains, place = (before.number, after.number), before.nodes[-1].section_id
    yield Finding(FindingKind.LAYOVER, severity, trains, place, first.arrives_s, text, remedy, short_s)
