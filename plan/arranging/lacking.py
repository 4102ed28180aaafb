"""What a line lacks for a day: the fewest tracks more with which no printed time is moved beyond the limit.

Of stations that have tracks, one more beside them; of halts, the second track by which trains can meet there; where
opposing trains meet between two neighbours by print, a signal station there (信号場). A way that goes by these is taken
apart at them as if they were stations, with the blocking times of the whole; what is chosen so is looked at again on
the line with just these tracks, and only what holds there is told.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Final

from plan.arranging.model import ANOTHER, REACH_S, Aim, ArrangeModel, NoRoomError
from plan.arranging.problem import Arranged, ArrangedVisit, Leg, Standing, TrainToArrange, Visit
from plan.arranging.search import improved, with_fewer_tracks
from plan.arranging.telling import Tell, tell_nobody

LACKING_WORK: Final = 0.4  # of the solver's counted work, for all days and choices
CHOICE_WORK: Final = 0.1  # for one choice of tracks
STEPS_WORK: Final = 0.1  # for a better plan with the tracks chosen
MORE_TRACKS_MAX: Final = 6  # that a station is thought to be given
MOST: Final = 1000  # more tracks than any day lacks
MEETS_STAY_S: Final = 10  # assumed: a train that only waits for another

Day = Sequence[TrainToArrange]


@dataclass(frozen=True, slots=True)
class MoreTracks:
    """What a day lacks: tracks by station, the trains that they are for, and the furthest move with them, s."""

    by_station: dict[str, int]
    worst_s: int
    trains: dict[str, tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class Halts:
    """Where a second track could be laid: halts, and signal stations between two neighbours.

    `along_m`: places of all stations along the line; `room`: whether there is room for tracks at some halts; `laid`:
    the days on the line with them; `between`: what the signal station between two stations would be called.
    """

    names: frozenset[str]
    along_m: Mapping[str, float]
    room: Callable[[Sequence[str]], bool]
    laid: Callable[[Sequence[str]], Sequence[Day]]
    between: Mapping[frozenset[str], str] = field(default_factory=dict[frozenset[str], str])

    def without_room(self, chosen: Sequence[str]) -> frozenset[str]:
        """Of halts chosen the first for which there is no room beside those before it."""
        for count in range(1, len(chosen) + 1):
            if not self.room(chosen[:count]):
                return frozenset(chosen[count - 1 : count])
        return frozenset()


NO_HALTS: Final = Halts(frozenset(), {}, lambda _: True, lambda _: ())


def more_tracks(
    days: Sequence[Day], halts: Halts, limit_s: int, tell: Tell = tell_nobody
) -> MoreTracks | None:
    """The fewest for the limit, or else for the least reach beyond it; None where none were found."""
    left = LACKING_WORK
    tell("looking for tracks that lack")
    room = frozenset(name for name in halts.names if halts.room((name,)))
    beside = {name for ends, name in halts.between.items() if not room.isdisjoint(ends)}  # the halt would do
    halts = replace(halts, names=room - beside)
    new = frozenset(halts.between.values())
    for reach_s in dict.fromkeys((limit_s, max(limit_s, REACH_S // 6))):
        found: list[MoreTracks] = []
        for some in dict.fromkeys((halts.names.difference(new), frozenset[str](), halts.names)):
            if found and not some.isdisjoint(new):
                break  # rather a track where there is a station or a halt
            for trains in days:
                below = min((sum(one.by_station.values()) for one in found), default=MOST)
                told, spent = _told(trains, replace(halts, names=some), days, limit_s, reach_s, left, below)
                left -= spent
                found += [told] if told is not None else []
        if found:
            return min(found, key=lambda one: (sum(one.by_station.values()), one.worst_s))
    return None


def _told(
    trains: Day, halts: Halts, days: Sequence[Day], limit_s: int, reach_s: int, left: float, below: int
) -> tuple[MoreTracks | None, float]:
    """The fewest tracks of a day, and fewer than `below`, as they hold on the line with them; and the work for it."""
    spent = 0.0
    while spent < left and below > 1:
        try:
            chosen, work = fewest_tracks(trains, halts, limit_s, reach_s, min(left - spent, CHOICE_WORK))
        except NoRoomError as none:
            return None, spent + none.work
        spent += work
        if not 0 < sum(chosen.more_tracks.values()) < below:
            break
        laid = tuple(name for name in chosen.more_tracks if name in halts.names)
        tracks = {name: count for name, count in chosen.more_tracks.items() if name not in laid}
        if no_room := halts.without_room(laid):
            halts = replace(halts, names=halts.names - no_room)
            continue
        if not halts.names:  # a plan of the line as it is, but for these tracks
            best, work = improved(trains, chosen, limit_s, tracks, min(max(left - spent, 0.0), STEPS_WORK))
            return _as_told(best, chosen.more_tracks), spent + work
        held: list[tuple[int, Day, Arranged]] = []
        for other in halts.laid(laid) if laid else days:
            try:
                plan, work = fewest_tracks(
                    other, NO_HALTS, limit_s, reach_s, min(max(left - spent, 0.0), CHOICE_WORK)
                )
            except NoRoomError as none:
                spent += none.work
                continue
            spent += work
            held.append((sum(plan.more_tracks.values()), other, plan))
            if not plan.more_tracks:
                break
        if held:
            _, other, plan = min(held, key=lambda one: one[0])
            best, work = improved(
                other, plan, limit_s, plan.more_tracks, min(max(left - spent, 0.0), STEPS_WORK)
            )
            return _as_told(best, Counter(laid) + Counter(plan.more_tracks)), spent + work
        break
    return None, spent


def fewest_tracks(
    trains: Day, halts: Halts, limit_s: int, reach_s: int, work: float
) -> tuple[Arranged, float]:
    """A plan with as few tracks more as may be, and the work for it. Raises NoRoomError."""
    stations = {visit.station_id for train in trains for visit in train.visits if visit.tracks}
    more = dict.fromkeys(sorted(stations), MORE_TRACKS_MAX)
    apart = [meeting_at(train, halts) for train in trains] if halts.names else trains
    plan = ArrangeModel(apart, limit_s, reach_s, more, laid=halts.names).solve(work, Aim.FEWEST)
    if plan.proven or not halts.names.isdisjoint(plan.more_tracks):
        return plan, plan.work
    fewer, spent = with_fewer_tracks(trains, plan, limit_s, work)
    return fewer, plan.work + spent


def meeting_at(train: TrainToArrange, halts: Halts) -> TrainToArrange:
    """The same with a place at each halt on its way, on the track of its direction."""
    ends_m = [halts.along_m[train.visits[at].station_id] for at in (0, -1)]
    track = int(ends_m[0] > ends_m[1])
    visits: list[Visit] = []
    parts: list[str] = []
    way = list(_with_between(train.visits, halts))
    for at, visit in enumerate(way):
        if at:
            parts.append("|".join(sorted((way[at - 1].station_id, visit.station_id))))
        leg = next((after.leg for after in way[at:] if after.tracks), None)
        if leg is None or not (visit.tracks or visit.station_id in halts.names):
            visits.append(visit)
            continue
        own = replace(leg, section_ids=tuple(parts))
        parts = []
        visits.append(
            replace(visit, leg=own) if visit.tracks else _meeting(visit, own, f"{visit.station_id}.{track}")
        )
    return replace(train, visits=tuple(visits))


def _with_between(visits: Sequence[Visit], halts: Halts) -> Iterator[Visit]:
    """The visits of a train with those of signal stations that could lie between them, each half way."""
    yield visits[0]
    for before, visit in pairwise(visits):
        name = halts.between.get(frozenset((before.station_id, visit.station_id)))
        if name not in halts.names or visit.run is None:
            yield visit
            continue
        half = visit.run.half()
        yield Visit(name, Standing.NEVER, run=half)
        yield replace(visit, run=half)


def _meeting(visit: Visit, leg: Leg, track: str) -> Visit:
    through = visit.standing is Standing.NEVER
    return replace(
        visit,
        standing=Standing.MAY if through else visit.standing,
        stay_s=MEETS_STAY_S if through else visit.stay_s,
        leg=replace(leg, overlaps=()),
        tracks=(track,),
    )


def _as_told(plan: Arranged, tracks: Mapping[str, int]) -> MoreTracks:
    worst_s = max((abs(move.by_s) for move in plan.moves), default=0)
    return MoreTracks(dict(tracks), worst_s, {name: _needing(plan, name) for name in tracks})


def _needing(plan: Arranged, station_id: str) -> tuple[str, ...]:
    """The trains on a track that lacks; at what is a halt now, those that are there together."""
    there = [
        (here, number)
        for number, visits in plan.visits.items()
        for here in visits
        if here.station_id == station_id
    ]
    another = [number for here, number in there if here.track == ANOTHER]
    together = [
        number for here, number in there for other, name in there if name != number and _meet(here, other)
    ]
    return tuple(dict.fromkeys(another or together))


def _meet(one: ArrangedVisit, other: ArrangedVisit) -> bool:
    return one.arrival_s <= other.departure_s and other.arrival_s <= one.departure_s
