"""What may be moved in a timetable without changing who goes first anywhere, and what holds between its times.

Trains keep their stops, tracks, sets and orders. Their times may move as far as running times, shortest stands and the
blocking times between two trains allow; these are the program's own (`study.capacity.theory`), taken relative to the
nearest time of the train that holds the section. Trains of one shape keep one shape: an even timetable stays even.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from network.errors import InputError
from network.model import Line
from onboard.authority.tables import REFUSED_REPEAT_S
from simulation.people import Pause
from simulation.setup import Setup
from study.capacity.compression import HeldSection, held_sections
from study.capacity.journey import TrainJourney
from study.capacity.legs import SetLeg, joined_legs, legs_of, places_of, stand_of
from study.capacity.rules import Rules
from study.capacity.theory import Theory
from study.feasibility.planned import PlannedTrain, planned_day

LATE_TRAINS: Final = Rules(late=True, throws=True)  # a train that waits has its way set as soon as it can be
STARTS_S: Final = 1.0  # assumed, as in `plan.arranging`: until a train that may leave moves
ORDERED = True  # off: trains do not wait for one another


@dataclass(frozen=True, slots=True)
class ReserveStop:
    """A stop of a train. `run_s`: the least from the stop before; `stay_s`: the least stand; both 0 at the first.

    `counted`: whether its arrival is a time of the timetable, of a train with passengers. `departure_s` None: the last.
    """

    station_id: str
    arrival_s: int
    departure_s: int | None
    counted: bool
    run_s: float
    stay_s: float


@dataclass(frozen=True, slots=True)
class ReserveTrain:
    """A train. `follows`: what its set ran before without leaving the line, and `turn_s` the least time between.

    `entry_slack_s`: by how much it may come late to its portal without leaving its first station late; None: it does
    not come by one.
    """

    number: str
    stops: tuple[ReserveStop, ...]
    follows: str | None
    turn_s: float
    entry_slack_s: float | None

    @property
    def journey_s(self) -> int:
        """From its first departure to its last arrival, s."""
        return self.stops[-1].arrival_s - (self.stops[0].departure_s or 0)

    @property
    def shape(self) -> tuple[tuple[str, int, int | None], ...]:
        """Its times after its first departure, relative to that; trains with one shape keep one."""
        first_s = self.stops[0].departure_s or 0
        return tuple(
            (s.station_id, s.arrival_s - first_s, None if s.departure_s is None else s.departure_s - first_s)
            for s in self.stops[1:]
        )


@dataclass(frozen=True, slots=True)
class PlanEvent:
    """A time of a train: its arrival at a stop, or its departure."""

    number: str
    stop: int
    departs: bool


@dataclass(frozen=True, slots=True)
class SectionWait:
    """One train's time comes at least so long after another's, s, because both want one section."""

    before: PlanEvent
    after: PlanEvent
    least_s: float
    section_id: str


@dataclass(frozen=True, slots=True)
class ReserveProblem:
    """The trains of a day by number, and who waits for whom. `early_s`: trains aim to arrive so long before plan."""

    trains: Mapping[str, ReserveTrain]
    waits: tuple[SectionWait, ...]
    early_s: float = 0.0

    def planned_s(self, event: PlanEvent) -> int:
        """When the timetable has it, s."""
        stop = self.trains[event.number].stops[event.stop]
        if not event.departs:
            return stop.arrival_s
        assert stop.departure_s is not None
        return stop.departure_s


def reserve_problem(setup: Setup) -> ReserveProblem:
    """The problem of a scenario's timetable. Raises InputError where the line has no way for one of its trains."""
    day = planned_day(setup)
    if day.missing:
        raise InputError(setup.name, "timetable", day.missing[0].number, f"a way: {day.missing[0].why}")
    theory = Theory(setup, LATE_TRAINS)
    journeys = theory.journeys()
    legs = legs_of(theory.of_day(journeys), places_of(setup.line))
    turns_s = dict(_turns_s(legs))
    trains: dict[str, ReserveTrain] = {}
    for own in day.trains.values():
        for before, train in pairwise((None, *own)):
            if train is not None:
                trains[train.number] = _train(setup, train, before, turns_s)
    times = {journey.number: _times_of(journey) for run in journeys.values() for journey in run}
    waits = tuple(_waits(setup.line, legs, times)) if ORDERED else ()
    return ReserveProblem(trains, waits, setup.unit.time_margin_s)


def _train(
    setup: Setup, train: PlannedTrain, before: PlannedTrain | None, turns_s: Mapping[str, float]
) -> ReserveTrain:
    calls = {call.station_id: call for call in train.duty.train.calls}
    stops: list[ReserveStop] = []
    counted = train.duty.train.revenue
    for stand in (s for s in train.stands if s.target.station_id is not None):
        call = calls[stand.target.station_id or ""]
        first = not stops
        stay_s = setup.unit.dwell_min_s if stand.target.passengers and not first else 0.0
        arrival_s = call.arrival_s
        if arrival_s is None:
            arrival_s = math.floor(stand.arrives_s)
        run_s = 0.0 if first else stand.run_s + STARTS_S
        stops.append(
            ReserveStop(
                call.station_id,
                arrival_s,
                call.departure_s,
                counted and call.arrival_s is not None,
                run_s,
                stay_s,
            )
        )
    slack_s = None
    if train.duty.enters:
        signs_s = setup.people.mean_s(Pause.ENTRY)
        comes_in_s = train.stands[1].run_s + STARTS_S + setup.unit.dwell_min_s
        slack_s = setup.operation.portal_lead_s - signs_s - comes_in_s
    follows = before.number if before is not None and not train.duty.enters else None
    return ReserveTrain(train.number, _ended(stops), follows, turns_s.get(train.number, 0.0), slack_s)


def _ended(stops: Sequence[ReserveStop]) -> tuple[ReserveStop, ...]:
    """Stops of which the last has no departure."""
    end = stops[-1]
    return (
        *stops[:-1],
        ReserveStop(end.station_id, end.arrival_s, None, end.counted, end.run_s, end.stay_s),
    )


def _turns_s(legs: Sequence[SetLeg]) -> Iterator[tuple[str, float]]:
    """Of each train whose set stood there as another: the least time from that one's arrival."""
    for before, after in joined_legs(legs):
        if before.number != after.number and before.end is not None:
            yield after.number, stand_of(before.end).least_s


TimesOfTrain = Sequence[tuple[PlanEvent, str, float]]  # with the station, and when theory has it, s


def _times_of(journey: TrainJourney) -> TimesOfTrain:
    """The times of a train in order: its first departure, arrivals and departures, its last arrival."""
    places = [(journey.mission.targets[stay.target].station_id, stay) for stay in journey.stays]
    stays = [(station_id, stay) for station_id, stay in places if station_id is not None]
    found: list[tuple[PlanEvent, str, float]] = []
    for index, (station_id, stay) in enumerate(stays):
        if index:
            found.append((PlanEvent(journey.number, index, departs=False), station_id, stay.arrives_s))
        if index + 1 < len(stays):
            found.append((PlanEvent(journey.number, index, departs=True), station_id, stay.departs_s))
    return found


def _waits(line: Line, legs: Sequence[SetLeg], times: Mapping[str, TimesOfTrain]) -> Iterator[SectionWait]:
    """One after the other on each section, as planned. Who is refused asks again: that is in the time between."""
    by_section: dict[str, list[HeldSection]] = defaultdict(list)
    for one in held_sections(legs):
        by_section[one.occupation.section_id].append(one)
    for section_id, ordered in by_section.items():
        for one, other in pairwise(ordered):
            if one.occupation.stock_id == other.occupation.stock_id:
                continue
            end_s, begin_s = one.occupation.end_s, other.occupation.begin_s
            ending, begun = (
                _along(line, legs[at], times[legs[at].number]) for at in (one.ends, other.begins)
            )
            before, _, before_s = min(ending, key=lambda item: abs(item[2] - end_s))
            after, _, after_s = begun[0]
            # who does not depart goes out by a portal: what it waits for there delays no time of the plan
            if after.departs:
                least_s = (end_s - before_s) + (after_s - begin_s) + REFUSED_REPEAT_S
                yield SectionWait(before, after, least_s, section_id)


def _along(line: Line, leg: SetLeg, times: TimesOfTrain) -> TimesOfTrain:
    """The times of its train from a leg's start to its end; of one from a portal the first, into one the last."""
    start, end = (
        None if one is None else line.sections[one.section_id].station_id for one in (leg.start, leg.end)
    )
    if start is None or end is None:
        return times[:1] if start is None else times[-1:]
    begins = next(at for at, (event, place, _) in enumerate(times) if event.departs and place == start)
    ends = next(at for at, (event, place, _) in enumerate(times) if not event.departs and place == end)
    return times[begins : ends + 1]
