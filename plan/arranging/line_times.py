"""What runs and legs of a line take and hold, from a few trains alone on it: the program's own blocking times.

Each direction is run four times: standing at every station, at none but the ends, and at every second one, so that
each run between two neighbours is known for all four ways of being at its ends.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Final

from network.model import Direction, Line, PlatformTrack, SectionKind, Station
from network.timetable import Call, CallKind, Diagram, Stabled, TimetableTrain, no_trains, platform_of
from onboard.authority.tables import REFUSED_REPEAT_S
from plan.arranging.problem import ByStanding, Leg, RunSeconds, SlowerTrack
from simulation.setup import Setup
from study.capacity.journey import TrainJourney
from study.capacity.legs import SetLeg, legs_of, places_of
from study.capacity.occupation import TOUCH_S
from study.capacity.rules import Rules
from study.capacity.theory import Theory
from study.feasibility.planned import PlannedTrain, planned_day
from study.measures.standard_times import stations_along
from vehicle.train_file import TrainType

ALONE: Final = Rules(late=True, throws=True, unslowed=True)
STARTS_S: Final = 1.0  # assumed: until a train that may leave moves
SPARE_S: Final = (
    600  # between two calls of a train that is run to be measured, so that it never waits for its time
)
Standings = tuple[bool, bool]  # at the beginning and at the end


@dataclass(slots=True)
class LineTimes:
    """What a kind of train takes and holds on a line.

    `runs`: s, by direction, both stations and how the train is there. `leads`, `lags`, s, by direction, the leg's
    places (station ids) and whether the train stands where it leaves (comes). `ways`: sections between the places.
    `overlaps`: what it has alone as it comes in; from `enters` before it comes until `stood` after. `longer`: how much
    longer a run takes that ends on a track (section id), or leaves it, than on the usual one, s, by direction, station,
    track, whether it leaves it and whether the train stands there.
    """

    setup: Setup
    runs: dict[tuple[Direction, str, str, Standings], float] = field(
        default_factory=dict[tuple[Direction, str, str, Standings], float]
    )
    leads: dict[tuple[Direction, str, str, bool], float] = field(
        default_factory=dict[tuple[Direction, str, str, bool], float]
    )
    lags: dict[tuple[Direction, str, str, bool], float] = field(
        default_factory=dict[tuple[Direction, str, str, bool], float]
    )
    ways: dict[tuple[Direction, str, str], tuple[str, ...]] = field(
        default_factory=dict[tuple[Direction, str, str], tuple[str, ...]]
    )
    overlaps: dict[tuple[Direction, str, str], tuple[str, ...]] = field(
        default_factory=dict[tuple[Direction, str, str], tuple[str, ...]]
    )
    enters: dict[tuple[Direction, str, str, bool], float] = field(
        default_factory=dict[tuple[Direction, str, str, bool], float]
    )
    stood: dict[tuple[Direction, str, str, bool], float] = field(
        default_factory=dict[tuple[Direction, str, str, bool], float]
    )

    longer: dict[tuple[Direction, str, str, bool, bool], int] = field(
        default_factory=dict[tuple[Direction, str, str, bool, bool], int]
    )

    def slower(self, direction: Direction, station_id: str) -> tuple[SlowerTrack, ...]:
        """The tracks of a station to or from which a train takes longer than to or from the usual one."""
        tracks = dict.fromkeys(
            track for way, name, track, *_ in self.longer if (way, name) == (direction, station_id)
        )

        def by(track: str, *, leaves: bool) -> ByStanding:
            key = direction, station_id, track, leaves
            return ByStanding(self.longer.get((*key, True), 0), self.longer.get((*key, False), 0))

        return tuple(SlowerTrack(track, by(track, leaves=False), by(track, leaves=True)) for track in tracks)

    def run(self, direction: Direction, from_id: str, to_id: str) -> RunSeconds:
        """From one station to the next, whole seconds up. KeyError where the line has no such way."""
        known = self.runs
        whole = known[direction, from_id, to_id, (True, True)]

        def seconds(*standings: bool) -> int:
            at_s = known.get((direction, from_id, to_id, (standings[0], standings[1])), whole)
            return math.ceil(at_s)

        return RunSeconds(
            seconds(True, True), seconds(True, False), seconds(False, True), seconds(False, False)
        )

    def leg(self, direction: Direction, from_id: str, to_id: str) -> Leg:
        """From one station with tracks to the next. Who is refused asks again: that is in the lead."""
        key = (direction, from_id, to_id)
        lead = _by_standing(self.leads, key, REFUSED_REPEAT_S)
        lag = _by_standing(self.lags, key, 0.0)
        # a plan is judged by times at stations too: nobody leaves for a section before its train has come
        lag = ByStanding(max(lag.stands, -lead.stands), max(lag.passes, -lead.stands))
        overlaps = self.overlaps.get(key, ())
        if not overlaps:
            return Leg(self.ways[key], lead, lag)
        enters = _by_standing(self.enters, key, REFUSED_REPEAT_S)
        return Leg(self.ways[key], lead, lag, overlaps, enters, _by_standing(self.stood, key, 0.0))


def _by_standing(
    known: dict[tuple[Direction, str, str, bool], float], key: tuple[Direction, str, str], more_s: float
) -> ByStanding:
    stands = known[*key, True] if (*key, True) in known else known[*key, False]
    passes = known.get((*key, False), stands)
    return ByStanding(math.ceil(stands + more_s), math.ceil(passes + more_s))


def line_times(line: Line, train: TrainType, dwell_min_s: float) -> LineTimes:
    """Run the trains that measure a line."""
    setup = Setup("measured", line, no_trains(line, dwell_min_s), {"": train})
    found = LineTimes(setup)
    for direction in Direction:
        stations = stations_along(line, direction)
        for stops in _patterns(len(stations)):
            _measure(found, direction, stations, stops)
        _measure_other_tracks(found, direction, stations)
    return found


def _patterns(count: int) -> Iterator[tuple[bool, ...]]:
    every = range(count)
    for standing in (frozenset(every), frozenset[int](), frozenset(every[::2]), frozenset(every[1::2])):
        if count > 1:
            yield tuple(i in (0, count - 1) or i in standing for i in every)


def _measure(
    found: LineTimes, direction: Direction, stations: Sequence[Station], stops: Sequence[bool]
) -> None:
    setup = _alone(found, direction, _calls(stations, stops))
    theory = Theory(setup, ALONE)
    journeys = theory.journeys()
    if not journeys["1"]:
        return  # no way: what comes of that is said where a train needs it
    times = list(_times(journeys["1"][0], stations))
    for before, after, standings, run_s in _runs(planned_day(setup).trains["1"][0]):
        found.runs.setdefault((direction, before, after, standings), run_s)
    at = {name: (come_s, left_s, stands) for name, (come_s, left_s), stands in times}
    for leg in legs_of(theory.of_day(journeys), places_of(setup.line)):
        _note(found, direction, leg, at)


def _alone(found: LineTimes, direction: Direction, calls: Sequence[Call]) -> Setup:
    """One train on the line."""
    train = TimetableTrain("1", direction, False, tuple(calls), Stabled(), Stabled())
    timetable = no_trains(found.setup.line, found.setup.timetable.head.dwell_min_s)
    timetable = type(timetable)(timetable.head, {"1": train}, (Diagram("1", ("1",)),))
    return Setup("measured", found.setup.line, timetable, {"1": found.setup.trains[""]})


def _measure_other_tracks(found: LineTimes, direction: Direction, stations: Sequence[Station]) -> None:
    """At every second station on another track, so that each run has it at one of its ends."""
    others = [_other_tracks(found.setup.line, station, direction) for station in stations]
    stops_at = [(True,) * len(stations), tuple(i in (0, len(stations) - 1) for i in range(len(stations)))]
    for rank in range(max(map(len, others), default=0)):
        for parity in (0, 1):
            tracks = [
                own[rank] if i % 2 == parity and rank < len(own) else None for i, own in enumerate(others)
            ]
            for stops in stops_at if any(tracks) else ():
                calls = [
                    replace(call, track=None if track is None else track.name)
                    for call, track in zip(_calls(stations, stops), tracks, strict=True)
                ]
                _compare(
                    found,
                    direction,
                    calls,
                    {s.id: t.section_id for s, t in zip(stations, tracks, strict=True) if t},
                )


def _other_tracks(line: Line, station: Station, direction: Direction) -> list[PlatformTrack]:
    """Those beside the usual one that a train may have."""
    usual = platform_of(line, Call(station.id, None, None, 0), direction)
    return [
        track
        for track in station.tracks
        if direction in track.marks_m
        and track.section_id != usual.section_id
        and line.sections[track.section_id].kind is SectionKind.TRACK
    ]


def _compare(
    found: LineTimes, direction: Direction, calls: Sequence[Call], tracks: Mapping[str, str]
) -> None:
    """How much longer each run takes by these tracks than by the usual ones."""
    day = planned_day(_alone(found, direction, calls))
    for before, after, standings, run_s in _runs(day.trains["1"][0]) if day.trains["1"] else ():
        usual_s = found.runs.get((direction, before, after, standings))
        longer_s = 0 if usual_s is None else math.ceil(run_s) - math.ceil(usual_s)
        for station_id, leaves in ((before, True), (after, False)):
            if station_id in tracks and longer_s > 0:
                key = direction, station_id, tracks[station_id], leaves, standings[not leaves]
                found.longer[key] = max(found.longer.get(key, 0), longer_s)


def _note(
    found: LineTimes, direction: Direction, leg: SetLeg, at: dict[str, tuple[float, float, bool]]
) -> None:
    sections = found.setup.line.sections
    if leg.start is None or leg.end is None:
        return
    from_id, to_id = (sections[one.section_id].station_id or "" for one in (leg.start, leg.end))
    (_, left_s, stood), (come_s, _, stands) = at[from_id], at[to_id]
    way = [
        one
        for one in leg.occupations
        if not one.is_overlap and sections[one.section_id].kind is not SectionKind.TRACK
    ]
    begin_s = min(one.begin_s for one in leg.occupations)
    end_s = max([one.end_s for one in way], default=come_s)
    found.ways[direction, from_id, to_id] = tuple(one.section_id for one in way)
    found.leads[direction, from_id, to_id, stood] = left_s - begin_s
    found.lags[direction, from_id, to_id, stands] = end_s - come_s
    for one in (one for one in leg.occupations if one.is_overlap):
        if one.begin_s <= begin_s + TOUCH_S:  # as it goes out: with its way
            found.ways[direction, from_id, to_id] += (one.section_id,)
            continue
        known = found.overlaps.get((direction, from_id, to_id), ())
        found.overlaps[direction, from_id, to_id] = tuple(dict.fromkeys((*known, one.section_id)))
        found.enters[direction, from_id, to_id, stands] = come_s - one.begin_s
        found.stood[direction, from_id, to_id, stands] = one.end_s - come_s


def _calls(stations: Sequence[Station], stops: Sequence[bool]) -> tuple[Call, ...]:
    found: list[Call] = []
    at_s = 0
    for index, (station, stands) in enumerate(zip(stations, stops, strict=True)):
        at_s += SPARE_S
        kind = CallKind.OPERATIONAL if stands else CallKind.PASS
        arrival_s = at_s if stands and index else None
        found.append(Call(station.id, None, arrival_s, at_s if index + 1 < len(stations) else None, kind))
    return tuple(found)


def _times(
    journey: TrainJourney, stations: Sequence[Station]
) -> Iterator[tuple[str, tuple[float, float], bool]]:
    """Each station with when the train comes and leaves, s, and whether it stands there."""
    mission = journey.mission
    stays = {mission.targets[stay.target].station_id: stay for stay in journey.stays}
    passed = {p.station_id: journey.at_s(p.position_m) for target in mission.targets for p in target.passings}
    for station in stations:
        stay = stays.get(station.id)
        if stay is not None:
            yield station.id, (stay.arrives_s, stay.departs_s), True
        elif station.id in passed:
            yield station.id, (passed[station.id], passed[station.id]), False


def _runs(train: PlannedTrain) -> Iterator[tuple[str, str, Standings, float]]:
    """Running times from each station to the next, s, as a plan is judged: as trains are driven."""
    for before, there in pairwise(train.stands):
        names = [
            before.target.station_id,
            *(p.station_id for p in there.target.passings),
            there.target.station_id,
        ]
        at_s = [0.0, *there.passes_s, there.run_s]
        last = len(names) - 2
        for leg, ((here, next_id), (begin_s, end_s)) in enumerate(
            zip(pairwise(names), pairwise(at_s), strict=True)
        ):
            starts_s = STARTS_S if leg == 0 else 0.0
            yield here or "", next_id or "", (leg == 0, leg == last), end_s - begin_s + starts_s
