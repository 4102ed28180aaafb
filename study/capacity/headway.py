"""Headway (運転時隔): how soon a train can come behind another one, from occupations moved against each other.

Two trains, an event of each at one station: the second's event can be no sooner after the first's than that every
section which both need is free again. Where the second starts from a place that the first has held, it has yet to come
there: its way in counts too, with the shortest stand. The kinds have the names that Japanese timetables use
(docs/capacity.md):

- following (続行): same direction from the same track, departure to departure;
- the way open (開通): same direction from another track, departure (or passing) to departure;
- closing up (追い込み): same direction onto another track, arrival to arrival (or passing);
- arrival to departure (着発): the one comes, the other leaves into where it came from;
- departure to arrival (発着): the one leaves, the other comes, onto its track or over the way that it took;
- coming in against each other (不同時進入): onto two tracks, arrival to arrival, where one must
  stand before the other comes in.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final

from network.model import Direction, Line
from study.capacity.claims import Claims, Event, claims_of
from study.capacity.legs import SetLeg, joined_legs, legs_of, places_of, stand_of
from study.capacity.occupation import TOUCH_S, Occupation, OccupationCost
from study.capacity.orders import DayOfLegs


class HeadwayKind(StrEnum):
    """What the two trains do at the station; the value is the name in Japanese."""

    FOLLOWING = "続行"
    OPEN = "開通"
    CLOSING_UP = "追い込み"
    ARRIVAL_DEPARTURE = "着発"
    DEPARTURE_ARRIVAL = "発着"
    COMING_IN = "不同時進入"

    @property
    def english(self) -> str:
        """The name in English."""
        return _ENGLISH[self]

    @property
    def between(self) -> str:
        """The events that it lies between."""
        return _BETWEEN[self]


_ENGLISH: Final[Mapping[HeadwayKind, str]] = {
    HeadwayKind.FOLLOWING: "following",
    HeadwayKind.OPEN: "way open",
    HeadwayKind.CLOSING_UP: "closing up",
    HeadwayKind.ARRIVAL_DEPARTURE: "arrival to departure",
    HeadwayKind.DEPARTURE_ARRIVAL: "departure to arrival",
    HeadwayKind.COMING_IN: "coming in against each other",
}
NEAR: Final = 8  # trains: who is further from another is not held up by it
_BETWEEN: Mapping[HeadwayKind, str] = {
    HeadwayKind.FOLLOWING: "departure to departure",
    HeadwayKind.OPEN: "departure to departure",
    HeadwayKind.CLOSING_UP: "arrival to arrival",
    HeadwayKind.ARRIVAL_DEPARTURE: "arrival to departure",
    HeadwayKind.DEPARTURE_ARRIVAL: "departure to arrival",
    HeadwayKind.COMING_IN: "arrival to arrival",
}


@dataclass(frozen=True, slots=True)
class Headway:
    """The least time from an event of the first train to one of the second, s, and the section that makes it so.

    `costs_s` make up `least_s`.
    """

    kind: HeadwayKind
    first: Event
    second: Event
    claims: Claims
    least_s: float
    costs_s: Mapping[OccupationCost, float]

    @property
    def section_id(self) -> str:
        """The section by which the first is last in the second's way."""
        return self.claims.section_id

    @property
    def first_s(self) -> float:
        """What of it is the first train's: it has a section that the second needs."""
        return math.fsum(self.claims.first_s.values())

    @property
    def second_s(self) -> float:
        """What of it is the second's: from its need of a section on."""
        return math.fsum(self.claims.second_s.values())

    @property
    def planned_s(self) -> float:
        """The time between the two events as they are."""
        return self.second.time_s - self.first.time_s

    @property
    def buffer_s(self) -> float:
        """What the plan leaves over the least; negative where it cannot be kept."""
        return self.planned_s - self.least_s


def least_between(
    kind: HeadwayKind,
    first: Event,
    second: Event,
    known: DayOfLegs,
    room: Collection[str] | None = None,
) -> Headway | None:
    """The headway of two events; None where the two share nothing.

    Of sections that free at once the first on the second's way counts. `room`: see `claims_of`.
    """
    claims = claims_of(first, second, known, room)
    if claims is None:
        return None
    costs_s = {cost: claims.first_s[cost] + claims.second_s[cost] for cost in OccupationCost}
    return Headway(kind, first, second, claims, math.fsum(costs_s.values()), costs_s)


@dataclass(frozen=True, slots=True)
class StationVisit:
    """A train at one station: how it comes, if it does, and how it leaves.

    `before` and `after` are the legs of its set before and after these, the nearest first.
    """

    number: str
    stock_id: str
    comes: SetLeg | None
    leaves: SetLeg | None
    before: tuple[SetLeg, ...] = ()
    after: tuple[SetLeg, ...] = ()

    @property
    def arrival(self) -> Event | None:
        """Its arrival."""
        if self.comes is None:
            return None
        after = self.after if self.leaves is None else (self.leaves, *self.after)
        return Event(self.comes, arrival=True, before=self.before, after=after)

    @property
    def departure(self) -> Event | None:
        """Its departure."""
        if self.leaves is None:
            return None
        before = self.before if self.comes is None else (self.comes, *self.before)
        return Event(self.leaves, arrival=False, before=before, after=self.after)

    @property
    def direction(self) -> Direction:
        """Its direction of travel."""
        leg = self.comes or self.leaves
        if leg is None:
            raise ValueError(f"{self.number}: a visit without a leg")
        return leg.direction

    @property
    def time_s(self) -> float:
        """When it is there first."""
        first = self.arrival or self.departure
        return math.inf if first is None else first.time_s

    @property
    def passes(self) -> bool:
        """Whether it runs through."""
        place = self.comes.end if self.comes is not None else None
        return place is not None and self.leaves is not None and stand_of(place).passes


def headways_of(
    first: StationVisit, second: StationVisit, dwell_min_s: float = math.inf, known: DayOfLegs | None = None
) -> Iterator[Headway]:
    """Every headway between two trains at a station, the first before the second; none between trains of one set.

    `known`: of the legs of the same day, with the same shortest dwell.
    """
    if first.stock_id == second.stock_id:
        return
    known = known or DayOfLegs(dwell_min_s)
    for kind, one, other in _events(first, second):
        found = least_between(kind, one, other, known)
        if found is not None:
            yield found


def _events(first: StationVisit, second: StationVisit) -> Iterator[tuple[HeadwayKind, Event, Event]]:
    """The pairs of events for which there is a name."""
    one, other = (first.arrival, first.departure), (second.arrival, second.departure)
    same_way = first.direction is second.direction
    if same_way and one[1] is not None and other[1] is not None:
        same_track = one[1].track_id == other[1].track_id
        yield (HeadwayKind.FOLLOWING if same_track else HeadwayKind.OPEN), one[1], other[1]
    if same_way and one[0] is not None and other[0] is not None and one[0].track_id != other[0].track_id:
        yield HeadwayKind.CLOSING_UP, one[0], other[0]
    if not same_way and one[0] is not None and other[0] is not None and one[0].track_id != other[0].track_id:
        overlaps = [
            {o.section_id for o in event.leg.occupations if o.is_overlap} for event in (one[0], other[0])
        ]
        if overlaps[0] & overlaps[1]:
            yield HeadwayKind.COMING_IN, one[0], other[0]
    # Who leaves stood there when the other came: on another track.
    if not same_way and one[0] is not None and other[1] is not None and one[0].track_id != other[1].track_id:
        yield HeadwayKind.ARRIVAL_DEPARTURE, one[0], other[1]
    if one[1] is not None and other[0] is not None and (not same_way or one[1].track_id == other[0].track_id):
        yield HeadwayKind.DEPARTURE_ARRIVAL, one[1], other[0]


def visits_at(legs: Sequence[SetLeg], track_ids: frozenset[str]) -> tuple[StationVisit, ...]:
    """Every train at a station of these tracks, in order of time; a set that turns back is two trains."""
    comes = {leg.number: leg for leg in legs if leg.end is not None and leg.end.section_id in track_ids}
    leaves = {leg.number: leg for leg in legs if leg.start is not None and leg.start.section_id in track_ids}
    joined = joined_legs(legs)
    before = {id(later): leg for leg, later in joined}
    after = {id(leg): later for leg, later in joined}
    found: list[StationVisit] = []
    for number in dict.fromkeys((*comes, *leaves)):
        first, last = comes.get(number) or leaves[number], leaves.get(number) or comes[number]
        ways = tuple(_chain(first, before)), tuple(_chain(last, after))
        found.append(StationVisit(number, first.stock_id, comes.get(number), leaves.get(number), *ways))
    return tuple(sorted(found, key=lambda visit: (visit.time_s, visit.number)))


def _chain(leg: SetLeg, following: Mapping[int, SetLeg]) -> Iterator[SetLeg]:
    """The legs that follow one, each as long as there is another."""
    while (found := following.get(id(leg))) is not None:
        yield found
        leg = found


@dataclass(frozen=True, slots=True)
class HeadwayCase:
    """A row of the table of headways: two kinds of trains at a station, and what of the day is nearest to the least.

    A kind of train is its direction, its track and whether it passes; `headway` is the greatest least
    time that two trains of these kinds have, `closest` the pair of them that the plan brings nearest to it.
    """

    station_id: str
    first: str
    second: str
    headway: Headway
    closest: Headway | None
    pairs: int

    def as_dict(self) -> dict[str, Any]:
        """For JSON and CSV: times to 0.1 s."""
        one, near = self.headway, self.closest
        return {
            "station": self.station_id,
            "kind": one.kind.name.lower(),
            "kind_ja": one.kind.value,
            "between": one.kind.between,
            "first": self.first,
            "second": self.second,
            "least_s": round(one.least_s, 1),
            "section": one.section_id,
            "first_train_s": round(one.first_s, 1),
            "second_train_s": round(one.second_s, 1),
            **{cost.column: round(one.costs_s[cost], 1) for cost in OccupationCost},
            "of": f"{one.first.leg.number}, {one.second.leg.number}",
            "pairs": self.pairs,
            "closest": "" if near is None else f"{near.first.leg.number}, {near.second.leg.number}",
            "closest_s": None if near is None else round(near.planned_s, 1),
            "buffer_s": None if near is None else round(near.buffer_s, 1),
        }


def kind_of_visit(visit: StationVisit) -> str:
    """What a train is at a station, in few words: direction, track, and whether it passes."""
    event = visit.arrival or visit.departure
    track_id = "" if event is None else event.track_id
    return f"{visit.direction.name.lower()}, {track_id}{' passes' if visit.passes else ''}"


@dataclass(slots=True)
class _Found:
    """What is known of two kinds of trains and a headway so far."""

    greatest: Headway
    closest: Headway | None = None
    pairs: int = 0

    def take(self, one: Headway) -> None:
        """One more pair; where the events are in that order it is one of the plan."""
        if one.least_s > self.greatest.least_s + TOUCH_S:
            self.greatest = one
        if one.planned_s > 0.0:
            self.pairs += 1
            if self.closest is None or one.buffer_s < self.closest.buffer_s - TOUCH_S:
                self.closest = one


def cases_at(station_id: str, visits: Sequence[StationVisit], known: DayOfLegs) -> tuple[HeadwayCase, ...]:
    """The headways at a station by kinds of trains, in the order in which they first come.

    A train is held against the NEAR trains after it, and against those before it as if they came after, where they can.
    """
    found: dict[tuple[str, str, HeadwayKind], _Found] = {}
    for index, visit in enumerate(visits):
        for other in visits[index + 1 : index + 1 + NEAR]:
            for first, second in ((visit, other), (other, visit)):
                for one in headways_of(first, second, known.dwell_min_s, known):
                    if not one.claims.possible:
                        continue
                    key = kind_of_visit(first), kind_of_visit(second), one.kind
                    found.setdefault(key, _Found(one)).take(one)
    return tuple(
        HeadwayCase(station_id, first, second, one.greatest, one.closest, one.pairs)
        for (first, second, _), one in found.items()
    )


def line_cases(
    line: Line, occupations: Iterable[Occupation], dwell_min_s: float = math.inf
) -> tuple[HeadwayCase, ...]:
    """The headways at every station of a line, along the line."""
    legs = legs_of(occupations, places_of(line))
    known = DayOfLegs(dwell_min_s)
    stations = sorted((s for s in line.stations.values() if not s.is_halt), key=lambda s: s.position_m)
    return tuple(
        case
        for station in stations
        for case in cases_at(
            station.id, visits_at(legs, frozenset(t.section_id for t in station.tracks)), known
        )
    )
