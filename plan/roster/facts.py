"""What of each train counts for who may run it: where and when its set must be there, and where and when it is free."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from network.errors import InputError
from network.model import Direction, Line
from network.timetable import AtPortal
from plan.even_day import OUTSIDE_S
from simulation.setup import Setup
from study.feasibility.planned import planned_day
from study.feasibility.timing import throws_s


@dataclass(frozen=True, slots=True)
class RosterTerms:
    """Least times, s: `turn_s` on a track beyond what changing ends takes, as crews need it; `outside_s` off the line.

    `empty_mps`: sets may also run empty (回送) from anywhere to anywhere, as quickly and as often as nobody can: for a
    bound on what empty workings could save. None: they do not.
    """

    turn_s: int = 0
    outside_s: int = OUTSIDE_S
    empty_mps: float | None = None


@dataclass(frozen=True, slots=True)
class SetEvent:
    """A set comes to a place or leaves it: a track (section id), or outside the line beyond a station."""

    place: str
    outside: bool
    time_s: int
    position_m: float


@dataclass(frozen=True, slots=True)
class RosterTrain:
    """A train. `kind`: of its stock. `follows`: the train that its set runs before it today; None: it is the first.

    `turns_s`: the least time on a track between a train that ends there and this one.
    """

    number: str
    kind: str
    direction: Direction
    begins: SetEvent
    ends: SetEvent
    follows: str | None
    turns_s: int


def roster_trains(setup: Setup) -> tuple[RosterTrain, ...]:
    """The trains of a scenario's timetable. Raises InputError where the line has no way for one."""
    day = planned_day(setup)
    if day.missing:
        raise InputError(setup.name, "timetable", day.missing[0].number, f"a way: {day.missing[0].why}")
    found: list[RosterTrain] = []
    for stock_id, own in day.trains.items():
        follows: str | None = None
        for planned in own:
            train, spans = planned.duty.train, planned.duty.mission.spans
            turns_s = setup.operation.change_ends_s + throws_s(setup.line, planned.duty.mission)
            enters, leaves = isinstance(train.begins, AtPortal), isinstance(train.ends, AtPortal)
            begins = _event(setup.line, spans[0].section_id, enters, train.calls[0].first_s)
            ends = _event(setup.line, spans[-1].section_id, leaves, train.calls[-1].last_s)
            kind = setup.trains[stock_id].id
            found.append(
                RosterTrain(train.number, kind, train.direction, begins, ends, follows, math.ceil(turns_s))
            )
            follows = train.number
    return tuple(sorted(found, key=lambda train: (train.begins.time_s, train.number)))


def _event(line: Line, section_id: str, outside: bool, time_s: int) -> SetEvent:
    piece = line.pieces[line.sections[section_id].piece_ids[0]]
    middle_m = (piece.from_m + piece.to_m) / 2.0
    place = section_id
    if outside:  # sets that leave by one portal there may come back by another
        place = min(line.stations.values(), key=lambda s: (abs(s.position_m - middle_m), s.id)).id
    return SetEvent(place, outside, time_s, middle_m)


def possible_links(trains: Iterable[RosterTrain], terms: RosterTerms) -> Iterator[tuple[str, str]]:
    """Each two trains that one set may run one after the other, as times and places allow; those of today do anyway.

    On a track one set stands at a time: the next that leaves it is the one that came.
    """
    ordered = sorted(trains, key=lambda train: (train.begins.time_s, train.number))
    for before in ordered:
        same = (t for t in ordered if t.kind == before.kind and t.begins.time_s >= before.ends.time_s)
        for after in same:
            here = (after.begins.place, after.begins.outside) == (before.ends.place, before.ends.outside)
            if _in_time(before, after, terms, here=here) and (
                terms.empty_mps is not None or (here and _next_there(before, after, ordered))
            ):
                yield before.number, after.number


def _in_time(before: RosterTrain, after: RosterTrain, terms: RosterTerms, *, here: bool) -> bool:
    """Whether the set of one train is free in time for another, where that begins or from where it can run empty."""
    least_s: float = terms.outside_s if before.ends.outside else after.turns_s + terms.turn_s
    if not here and terms.empty_mps is not None:
        least_s = abs(after.begins.position_m - before.ends.position_m) / terms.empty_mps
    today = after.follows == before.number and not terms.turn_s
    return today or after.begins.time_s - before.ends.time_s >= least_s


def _next_there(before: RosterTrain, after: RosterTrain, ordered: Sequence[RosterTrain]) -> bool:
    """Whether a set that came to a track is the next that leaves it; outside the line any may be."""
    if before.ends.outside:
        return True
    from_s, to_s = before.ends.time_s, after.begins.time_s
    others = (event for t in ordered if t not in (before, after) for event in (t.begins, t.ends))
    return not any(event.place == before.ends.place and from_s <= event.time_s <= to_s for event in others)
