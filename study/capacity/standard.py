"""Standard paths (標準列車) of a timetable: trains that could run between the others, made of what its own trains do.

One calls where that train of its direction does which has most stops, on the same tracks, and comes from a portal and
goes to one as they do. Where only one end of the line has portals it is a set there and back. It runs as units drive
and stands no longer than they must, in whole seconds.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from network.errors import InputError
from network.model import Direction, PlatformTrack, Station
from network.timetable import (
    AtPortal,
    BecomesTrain,
    Call,
    CallKind,
    Diagram,
    FromTrain,
    Stabled,
    Timetable,
    TimetableTrain,
)
from simulation.setup import Setup
from study.feasibility.planned import PlannedTrain, planned_day

ALONE: Final = "+"  # the set of a standard path alone on its line
ORIGIN_S: Final = 43_200  # where standard paths are laid out before they are moved: noon


@dataclass(frozen=True, slots=True)
class StandardPath:
    """A set's trains in order; `name` says what they are: down, up, or there and back.

    `comes_by`: of each call of each train, by which leg of the set, from place to place, it comes there.
    """

    name: str
    trains: tuple[TimetableTrain, ...]
    kind_of_stock: str  # a stock id of the setup, of whose kind it is
    comes_by: tuple[tuple[int, ...], ...] = ()


@dataclass(frozen=True, slots=True)
class _Ends:
    """Trains of one direction: the one with the most calls, one that comes from a portal, one that goes to one."""

    most: TimetableTrain
    begins: TimetableTrain | None
    ends: TimetableTrain | None


def standard_paths(setup: Setup) -> tuple[StandardPath, ...]:
    """The standard paths of a setup: down and up from portal to portal, else there and back; none without portals."""
    ends = {direction: _ends_of(setup, direction) for direction in Direction}
    stock = _usual_stock(setup)
    found: list[StandardPath] = []
    for direction in Direction:
        own, back = ends[direction], ends[direction.opposite]
        if own is None or own.begins is None:
            continue
        if own.ends is not None:
            found.append(StandardPath(direction.name.lower(), (_one_way(own),), stock))
        elif back is not None and back.ends is not None:
            found.append(
                StandardPath(f"{direction.name.lower()} and back", _there_and_back(own, back), stock)
            )
    return tuple(_timed(setup, path) for path in found)


def round_path(setup: Setup, rounds: int = 1) -> StandardPath | None:
    """A set that goes there and back so often, and there again; None where trains do not run from end to end.

    Of several rounds each turns on the next track of those that an end of the line has.
    """
    there, back = (_ends_of(setup, direction) for direction in (Direction.DOWN, Direction.UP))
    if there is None or back is None:
        return None
    down, up = (_calls(own, begins=False, ends=False) for own in (there, back))
    if [call.station_id for call in (down[0], down[-1])] != [call.station_id for call in (up[-1], up[0])]:
        return None
    ends = down[-1].track, up[-1].track  # where it came in it goes out again
    down, up = (replace(down[0], track=ends[1]), *down[1:]), (replace(up[0], track=ends[0]), *up[1:])
    stations = (setup.line.stations[down[at].station_id] for at in (0, -1))
    turns = [turning_tracks(station) if rounds > 1 else () for station in stations]
    ways: list[TimetableTrain] = []
    for at in range(2 * rounds + 1):
        direction = Direction.UP if at % 2 else Direction.DOWN
        calls = list(up if at % 2 else down)
        for end, turn in (
            (0, at),
            (-1, at + 1),
        ):  # the turns are counted along the way, near and far by turns
            tracks = turns[turn % 2]
            if tracks:
                calls[end] = replace(calls[end], track=tracks[turn // 2 % rounds % len(tracks)].name)
        ways.append(
            TimetableTrain(
                f"{'-' if at % 2 else '+'}{at}",
                direction,
                True,
                tuple(calls),
                FromTrain(ways[-1].number) if ways else Stabled(),
                BecomesTrain(f"{'+' if at % 2 else '-'}{at + 1}") if at < 2 * rounds else Stabled(),
            )
        )
    return _timed(setup, StandardPath("round", tuple(ways), _usual_stock(setup)))


def turning_tracks(station: Station) -> tuple[PlatformTrack, ...]:
    """Those with a platform on which a train can come in and go out again the other way."""
    return tuple(t for t in station.tracks if len(t.marks_m) == len(Direction) and t.platform_m is not None)


def _usual_stock(setup: Setup) -> str:
    kinds = [setup.trains[diagram.stock_id].id for diagram in setup.timetable.diagrams]
    usual = max(sorted(set(kinds)), key=kinds.count)
    return next(d.stock_id for d in setup.timetable.diagrams if setup.trains[d.stock_id].id == usual)


def _ends_of(setup: Setup, direction: Direction) -> _Ends | None:
    trains = [t for t in setup.timetable.trains.values() if t.direction is direction]
    if not trains:
        return None
    most = max(trains, key=lambda t: (t.revenue, sum(call.stops for call in t.calls)))
    whole = (most.calls[0].station_id, most.calls[-1].station_id)
    begins = (t for t in trains if isinstance(t.begins, AtPortal) and t.calls[0].station_id == whole[0])
    ends = (t for t in trains if isinstance(t.ends, AtPortal) and t.calls[-1].station_id == whole[1])
    return _Ends(most, next(begins, None), next(ends, None))


def _calls(own: _Ends, *, begins: bool, ends: bool) -> tuple[Call, ...]:
    """All stops, on the tracks on which trains stand that come in or go out there."""
    calls = [replace(call, kind=CallKind.STOP if call.stops else call.kind) for call in own.most.calls]
    if begins and own.begins is not None:
        calls[0] = replace(calls[0], track=own.begins.calls[0].track)
    if ends and own.ends is not None:
        calls[-1] = replace(calls[-1], track=own.ends.calls[-1].track)
    return tuple(calls)


def _one_way(own: _Ends) -> TimetableTrain:
    if own.begins is None or own.ends is None:
        raise ValueError("a path from portal to portal without portals")
    calls = _calls(own, begins=True, ends=True)
    return TimetableTrain("+", own.most.direction, True, calls, own.begins.begins, own.ends.ends)


def _there_and_back(own: _Ends, back: _Ends) -> tuple[TimetableTrain, ...]:
    if own.begins is None or back.ends is None:
        raise ValueError("there and back without portals")
    there = _calls(own, begins=True, ends=False)
    home = _calls(back, begins=False, ends=True)
    home = (replace(home[0], track=there[-1].track), *home[1:])
    return (
        TimetableTrain("+", own.most.direction, True, there, own.begins.begins, BecomesTrain("-")),
        TimetableTrain("-", back.most.direction, True, home, FromTrain("+"), back.ends.ends),
    )


def _timed(setup: Setup, path: StandardPath) -> StandardPath:
    """With the least times: running as units drive, shortest stops, changing ends with the points of the way out."""
    spread = _spread(path.trains)
    day = planned_day(path_alone(setup, replace(path, trains=spread)))
    for lacking in day.missing:
        raise InputError(setup.name, "timetable", None, f"trains that turn where they end ({lacking.why})")
    planned = day.trains[ALONE]
    at_s, trains, comes_by, legs = ORIGIN_S, list[TimetableTrain](), list[tuple[int, ...]](), 0
    for index, (train, own) in enumerate(zip(spread, planned, strict=True)):
        if index:
            at_s += math.ceil(setup.turn_s + setup.unit.request_lead_s)
        calls = _least_times(setup, train.calls, own, at_s)
        trains.append(replace(train, calls=calls))
        places_m = [node.position_m for node in own.nodes]
        at_m = _places_m(own)
        comes_by.append(tuple(legs + bisect_left(places_m, at_m[call.station_id]) - 1 for call in calls))
        legs += len(own.routes)
        at_s = calls[-1].first_s
    return replace(path, trains=tuple(trains), comes_by=tuple(comes_by))


def _places_m(own: PlannedTrain) -> dict[str | None, float]:
    """Where along its path a train is at each station at which it calls or that it is said to run through, m."""
    targets = own.duty.mission.targets
    passed_m = {at.station_id: at.position_m for target in targets for at in target.passings}
    return passed_m | {target.station_id: target.mark_m for target in targets}


def _spread(trains: Iterable[TimetableTrain]) -> tuple[TimetableTrain, ...]:
    """With times that only keep the order, so that running times can be asked for."""
    at_s, found = ORIGIN_S, list[TimetableTrain]()
    for train in trains:
        calls: list[Call] = []
        for call in train.calls:
            at_s += 1800
            calls.append(
                replace(call, arrival_s=at_s if call.stops else None, departure_s=at_s + 600 * call.stops)
            )
        last = replace(calls[-1], departure_s=None)
        found.append(replace(train, calls=(*calls[:-1], last)))
    return tuple(found)


def _least_times(setup: Setup, calls: Sequence[Call], own: PlannedTrain, departs_s: int) -> tuple[Call, ...]:
    runs_s: dict[str | None, float] = {}
    for stand in own.stands:
        runs_s |= zip((p.station_id for p in stand.target.passings), stand.passes_s, strict=True)
        runs_s[stand.target.station_id] = stand.run_s
    found = [replace(calls[0], arrival_s=None, departure_s=departs_s)]
    left_s = departs_s
    for call in calls[1:]:
        at_s = left_s + math.ceil(runs_s[call.station_id])
        if not call.stops:
            found.append(replace(call, arrival_s=None, departure_s=at_s))
            continue
        left_s = at_s + math.ceil(setup.unit.dwell_min_s)
        found.append(replace(call, arrival_s=at_s, departure_s=None if call is calls[-1] else left_s))
    return tuple(found)


def path_alone(setup: Setup, path: StandardPath, stock_id: str = ALONE) -> Setup:
    """A day with nothing but one standard path."""
    return _with(setup, {}, (), [(stock_id, path.trains)], path.kind_of_stock)


@dataclass(frozen=True, slots=True)
class Added:
    """A standard path put into the day: its set, and its trains as they would stand in the timetable."""

    stock_id: str
    trains: tuple[TimetableTrain, ...]


def added_path(setup: Setup, path: StandardPath, number: int, moves_s: Sequence[float]) -> Added:
    """A path with each leg moved, s: from place to place, beginning with that from the portal; the n-th of the day."""
    names = {train.number: f"X{number}-{at}" for at, train in enumerate(path.trains, start=1)}
    trains: list[TimetableTrain] = []
    for index, train in enumerate(path.trains):
        calls: list[Call] = []
        for call, leg in zip(train.calls, path.comes_by[index], strict=True):
            comes_s = moves_s[max(leg, 0)]
            goes = leg if setup.line.stations[call.station_id].is_halt else leg + 1
            goes_s = moves_s[goes] if goes < len(moves_s) else comes_s
            calls.append(
                replace(
                    call,
                    arrival_s=None if call.arrival_s is None else round(call.arrival_s + comes_s),
                    departure_s=None if call.departure_s is None else round(call.departure_s + goes_s),
                )
            )
        trains.append(
            replace(
                train,
                number=names[train.number],
                calls=tuple(calls),
                begins=FromTrain(names[train.begins.number])
                if isinstance(train.begins, FromTrain)
                else train.begins,
                ends=BecomesTrain(names[train.ends.number])
                if isinstance(train.ends, BecomesTrain)
                else train.ends,
            )
        )
    return Added(f"X{number}", tuple(trains))


def extended_day(setup: Setup, more: Iterable[tuple[Added, StandardPath]]) -> Setup:
    """The day with the paths put in, each run by a set of its own."""
    for one, path in more:
        sets = [(one.stock_id, one.trains)]
        setup = _with(setup, setup.timetable.trains, setup.timetable.diagrams, sets, path.kind_of_stock)
    return setup


def _with(
    setup: Setup,
    trains: Mapping[str, TimetableTrain],
    diagrams: Sequence[Diagram],
    sets: Sequence[tuple[str, tuple[TimetableTrain, ...]]],
    kind_of_stock: str,
) -> Setup:
    more = {train.number: train for _, own in sets for train in own}
    new = tuple(Diagram(stock_id, tuple(train.number for train in own)) for stock_id, own in sets)
    timetable: Timetable = replace(setup.timetable, trains={**trains, **more}, diagrams=(*diagrams, *new))
    kinds = {stock_id: setup.trains[kind_of_stock] for stock_id, _ in sets}
    return replace(setup, timetable=timetable, trains={**setup.trains, **kinds})
