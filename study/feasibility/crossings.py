"""What a line's level crossings (踏切) need of it: contacts far enough out for the fastest train, radio where units ask
them, and for those without a device sight of what comes.

At the line's speed all the way a train is nowhere sooner; with the least times of `network.files.crossings` that is the
fastest that any timetable can bring.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Final

from network.files.crossings import LONG_S, least_warning_s
from network.model import CrossingControl, Direction, LevelCrossing, Line
from onboard.authority.coverage import covered_at
from onboard.crossings.ahead import no_contact_passed
from onboard.crossings.machine import EARLY_S
from simulation.setup import Setup
from study.feasibility.finding import Finding, FindingKind, Severity, length_of_time, severity_of
from study.feasibility.planned import PlannedDay, PlannedTrain, due_s

STEP_M: Final = 1.0
TOLERANCE_S: Final = 0.01
LOOK_EVERY_M: Final = 20.0
CROSSES_MPS: Final = 1.0  # assumed: somebody on foot, slowly
STOP_S: Final = 120.0  # assumed: to brake, to come over the road on sight, to gain speed again
LOOKS_ROUND_S: Final = 3.0  # assumed: before and after


def crossings_of(setup: Setup, day: PlannedDay) -> Iterator[Finding]:
    """What is wrong with the level crossings that trains of the day pass, crossing by crossing."""
    for crossing in day.line.crossings.values():
        trains = [train for train in day.all() if crossing.piece_id in train.duty.mission.path]
        if not trains:
            continue
        for direction in sorted({train.duty.mission.direction for train in trains}, reverse=True):
            own = [train for train in trains if train.duty.mission.direction is direction]
            yield from _of_direction(setup, day, crossing, direction, own)


def _of_direction(
    setup: Setup, day: PlannedDay, crossing: LevelCrossing, direction: Direction, trains: list[PlannedTrain]
) -> Iterator[Finding]:
    name, line = direction.name.lower(), day.line
    if not crossing.has_device:
        yield from _sight(line, crossing, direction, trains)
    elif crossing.control is CrossingControl.CONTACTS:
        way_m, _ = crossing.contacts_from_road_m(direction)
        warns_s, least_s = _least_s(line, crossing, direction, way_m), least_warning_s(crossing)
        said = f"level crossing {crossing.id} warns of {name} trains at line speed for {warns_s:.0f} s"
        if warns_s < least_s - TOLERANCE_S:
            remedy = f"{least_s:g} s are the least: its first contact further out"
            yield _finding(crossing, trains, Severity.IMPOSSIBLE, said, remedy, least_s - warns_s)
        elif warns_s > LONG_S:
            remedy = f"more than {LONG_S:g} s, and longer before slower trains: by radio it is constant"
            yield _finding(crossing, trains, Severity.TIGHT, said, remedy, None)
        yield from _unwarned(setup, crossing, direction, trains, day)
    elif setup.line_signals is not None:
        said = f"level crossing {crossing.id} is closed by units, and with [line_signals] there are none"
        yield _finding(crossing, trains, Severity.IMPOSSIBLE, said, 'control = "contacts"', None)
    else:
        if crossing.warning_s > LONG_S:
            said = f"level crossing {crossing.id} warns for {crossing.warning_s:g} s"
            yield _finding(crossing, trains, Severity.TIGHT, said, f"{LONG_S:g} s are long", None)
        yield from _radio(setup, line, crossing, direction, trains)


def _unwarned(
    setup: Setup, crossing: LevelCrossing, direction: Direction, trains: list[PlannedTrain], day: PlannedDay
) -> Iterator[Finding]:
    """Trains that begin beyond their first contact, having turned or come in there: none of them passes it."""
    name, least_s = direction.name.lower(), least_warning_s(crossing)
    before = {
        later.number: sooner.duty.mission for own in day.trains.values() for sooner, later in pairwise(own)
    }
    silent = [
        train for train in trains if no_contact_passed(crossing, train.duty.mission, before.get(train.number))
    ]
    if silent and crossing.warns_departures and setup.line_signals is None:
        yield from _radio(setup, day.line, crossing, direction, silent)
        return
    places = dict.fromkeys(train.duty.mission.targets[0].section_id for train in silent)
    for place in places:
        own = [train for train in silent if train.duty.mission.targets[0].section_id == place]
        said = f"level crossing {crossing.id} does not warn of {name} trains that begin in {place}, beyond its first"
        said += " contact"
        remedy = f"{least_s:g} s are the least: a first contact that they pass so long before, departures, or by radio"
        yield _finding(crossing, own, Severity.IMPOSSIBLE, said, remedy, least_s)


def _radio(
    setup: Setup, line: Line, crossing: LevelCrossing, direction: Direction, trains: list[PlannedTrain]
) -> Iterator[Finding]:
    """Where the unit asks, hears and says that it is over it, the radio must reach: until then no proof holds.

    Who stands before it waits for leave: what that takes the plan has to have over, or the train is late.
    """
    path = trains[0].duty.mission.path
    road_m = path.to_road_m(crossing)
    asks_m = road_m - _way_m(line, crossing, direction, crossing.warning_s + EARLY_S)
    count = max(math.ceil((road_m - asks_m) / LOOK_EVERY_M), 1)
    steps_m = (asks_m + (road_m - asks_m) * i / count for i in range(count + 1))
    looked_m = [at_m for at_m in steps_m if at_m >= 0.0]
    dead_m = [at_m for at_m in looked_m if not covered_at(line, path, at_m)]
    if not dead_m:
        return
    dead_km = path.kilometrage_m(dead_m[0]) / 1e3
    said = f"level crossing {crossing.id} is asked by radio, which does not reach at km {dead_km:.2f}"
    remedy = f"coverage over the {road_m - asks_m:.0f} m before it, or its trains stop there"
    # a proof that is heard on the way holds for some time
    short_s = {
        train.number: _short_s(setup, train, crossing) for train in trains if len(dead_m) == len(looked_m)
    }
    late = [train for train in trains if severity_of(short_s.get(train.number, 0.0)) is Severity.LATE]
    if late:
        worst_s = max(short_s.values())
        remedy += f", which makes them late by {length_of_time(worst_s)}"
        yield _finding(crossing, late, Severity.LATE, said, remedy, worst_s)
    else:
        yield _finding(crossing, trains, Severity.TIGHT, said, remedy, None)


def _short_s(setup: Setup, train: PlannedTrain, crossing: LevelCrossing) -> float:
    """What a stop before the road costs beyond what the plan has over the running time from stop to stop, s."""
    road_m = train.duty.mission.path.to_road_m(crossing)
    costs_s = setup.people.crossing_s + STOP_S
    for before, there in pairwise(train.stands):
        if before.target.mark_m < road_m <= there.target.mark_m:
            has_s = due_s(there.target, setup.unit.dwell_min_s) - before.departs_s
            return costs_s - max(has_s - there.run_s, 0.0)
    return costs_s


def _sight(
    line: Line, crossing: LevelCrossing, direction: Direction, trains: list[PlannedTrain]
) -> Iterator[Finding]:
    """Who crosses must see from where a train may come while he does."""
    needs_s = crossing.width_m / CROSSES_MPS + LOOKS_ROUND_S
    needs_m = _way_m(line, crossing, direction, needs_s)
    if crossing.sight_m is not None and crossing.sight_m < needs_m:
        name = direction.name.lower()
        said = f"level crossing {crossing.id} has no device, and {name} trains are seen from {crossing.sight_m:g} m"
        remedy = f"{needs_m:.0f} m are run in the {needs_s:.0f} s of crossing: a limit before it, or a device"
        yield _finding(crossing, trains, Severity.TIGHT, said, remedy, None)


def _limit_mps(line: Line, crossing: LevelCrossing, direction: Direction, at_m: float) -> float:
    limits = line.alignments[line.pieces[crossing.piece_id].alignment_id].limits
    own = [x.speed_mps for x in limits if x.from_m <= at_m <= x.to_m and direction in x.directions]
    return min((line.max_speed_mps, *own))


def _least_s(line: Line, crossing: LevelCrossing, direction: Direction, way_m: float) -> float:
    """The least time over the way before the road, s, at its limits."""
    steps = max(math.ceil(way_m / STEP_M), 1)
    edge_m, step_m = crossing.edge_m(direction), way_m / steps
    places_m = (edge_m - direction * (i + 0.5) * step_m for i in range(steps))
    return sum(step_m / _limit_mps(line, crossing, direction, at_m) for at_m in places_m)


def _way_m(line: Line, crossing: LevelCrossing, direction: Direction, time_s: float) -> float:
    """The way before the road that is run in a time at its limits, m."""
    edge_m, way_m, left_s = crossing.edge_m(direction), 0.0, time_s
    while left_s > 0.0:
        speed_mps = _limit_mps(line, crossing, direction, edge_m - direction * way_m)
        way_m += min(STEP_M, left_s * speed_mps)
        left_s -= STEP_M / speed_mps
    return way_m


def _finding(
    crossing: LevelCrossing,
    trains: list[PlannedTrain],
    severity: Severity,
    said: str,
    remedy: str,
    short_s: float | None,
) -> Finding:
    numbers = tuple(train.duty.mission.number for train in trains)
    times_s = (target.departure_s for train in trains for target in train.duty.mission.targets)
    first_s = min((at_s for at_s in times_s if at_s is not None), default=0.0)
    return Finding(
        FindingKind.LEVEL_CROSSING, severity, numbers, crossing.piece_id, first_s, said, remedy, short_s
    )
