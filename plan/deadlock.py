"""Whether all trains of a published situation can still leave (the form of Dal Sasso et al., J. Rail Transport Planning
& Management 17, 2021, 100239, and of their larger instances of 2023), asked of the manager's own search.

A train stands on a row of routes, as many as it is long, and goes on to one of those that can follow. While it is on a
route, others are kept out of those that are not compatible with it; one that is longer than the route without its
points also keeps others from entering those that lead over the points, until it has drawn clear of them. A route from
which none follows is where a train is gone.

As in the published verdicts, safe places and priorities are not looked at, several trains are on one route only where
they stand so at first (then the first of them leaves first), and a situation is lost in which two trains stand on
different routes that exclude each other, whichever way they face.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from itertools import combinations, pairwise
from pathlib import Path
from typing import Annotated, Final

import msgspec

from network.errors import InputError
from network.files.json_input import read_json
from wayside.certificate import CertificateProof, finishing_order
from wayside.moves import Move, Train

STEPS_MAX: Final = (
    1_000_000  # assumed: moves tried until nothing is known; the published instances need 6,000
)
POINTS_COUNT: Final = True  # a train that stands over points bars them; for tests alone

Length = Annotated[int, msgspec.Meta(ge=0)]
Row = tuple[str, ...]  # the routes that a train stands on, its front on the last


class StandingTrain(msgspec.Struct, frozen=True):
    """A train with the routes on which it stands, and those on which it may end, if any; `is_dummy`: no train.

    `initial_multitrain_prev_trainid`: trains before it on the same route.
    """

    id: str
    initial_routes: tuple[str, ...]
    final_routes: tuple[str, ...] = ()
    is_dummy: bool = False
    initial_multitrain_prev_trainid: tuple[str, ...] = ()


class TrackRoute(msgspec.Struct, frozen=True):
    """A route of the situation."""

    id: str
    is_unusable: bool = False


class TrainRoute(msgspec.Struct, frozen=True):
    """A route that a train can take, its length there, and the routes that can follow."""

    train: str
    route: str
    length: Length
    next_routes: tuple[str, ...] = ()


class RouteConflicts(msgspec.Struct, frozen=True):
    """Routes that a train keeps others from while no more than `length` of the route is under it; the longer row of a
    route adds what a train bars that is longer than the shorter one.
    """

    route: str
    length: Length
    conflicts: tuple[str, ...]


class Situation(msgspec.Struct, frozen=True):
    """Trains where they stand, their routes, and which of them exclude each other."""

    trains: tuple[StandingTrain, ...]
    routes: tuple[TrackRoute, ...]
    train_routes: tuple[TrainRoute, ...]
    conflicts: tuple[RouteConflicts, ...]


def read_situation(file: Path) -> Situation:
    """Read and check a situation. Raises InputError naming the first place that contradicts itself."""
    situation = read_json(file, Situation)
    known = {route.id for route in situation.routes}
    trains = {train.id for train in situation.trains}
    ways = {(way.train, way.route) for way in situation.train_routes}
    for i, train in enumerate(situation.trains):
        key = f"trains[{i}]"
        if not train.initial_routes:
            raise InputError(str(file), f"{key}.initial_routes", [], "at least one: where the train stands")
        for ahead in train.initial_multitrain_prev_trainid:
            if ahead not in trains:
                raise InputError(str(file), f"{key}.initial_multitrain_prev_trainid", ahead, "a train")
        fronts = _fronts(situation, train)
        if len(fronts) != 1:
            expected = "routes that follow each other, with one at the front from which the train can go on"
            raise InputError(str(file), f"{key}.initial_routes", list(train.initial_routes), expected)
    for i, way in enumerate(situation.train_routes):
        for route in (way.route, *way.next_routes):
            if route not in known:
                raise InputError(str(file), f"train_routes[{i}]", route, "one of the routes")
        for route in way.next_routes:
            if (way.train, route) not in ways:
                raise InputError(
                    str(file), f"train_routes[{i}].next_routes", route, f"a route of train {way.train}"
                )
    return situation


@dataclass(frozen=True, slots=True)
class LeavingVerdict:
    """What the search has shown; trains and the routes that they enter in an order in which all leave, or trains that
    are in each other's way.
    """

    proof: CertificateProof
    entered: tuple[tuple[str, str], ...]
    circle: tuple[str, ...]
    steps: int


def can_all_leave(situation: Situation, steps_max: int = STEPS_MAX) -> LeavingVerdict:
    """Whether all trains can leave, by the search of the manager's certificate.

    Raises ValueError where the routes of a train run in a circle.
    """
    rows = _Rows(situation)
    trains = [train for train in situation.trains if not train.is_dummy]
    for one, other in combinations(trains, 2):
        if rows.exclude(rows.first(one), rows.first(other)):
            return LeavingVerdict(CertificateProof.NONE, (), (one.id, other.id), 0)
    ways = [_ways(rows, train) for train in trains]
    found = finishing_order(_searched(ways), steps_max)
    moves = zip(found.order, found.moves, strict=True)
    entered = tuple((trains[index].id, ways[index].rows[move + 1][-1]) for index, move in moves)
    return LeavingVerdict(
        found.proof, entered, tuple(trains[index].id for index in found.circle), found.steps
    )


@dataclass(frozen=True, slots=True, order=True)
class _Bar:
    """What a train on a route keeps others from; where several stand on one route at first, of each train its own."""

    by: str
    keeps_from: str
    train: str = ""


@dataclass(frozen=True, slots=True)
class _Ways:
    """All rows of routes that a train may come to stand on, as `wayside.moves.Train` has its places, what is barred
    there, and what bars its first move.
    """

    rows: tuple[Row, ...]
    choices: tuple[tuple[int, ...], ...]
    bars: tuple[frozenset[_Bar], ...]
    behind: tuple[_Bar, ...]


class _Rows:
    """The situation, looked up."""

    def __init__(self, situation: Situation) -> None:
        self.ways: dict[str, dict[str, TrainRoute]] = defaultdict(dict)
        for way in situation.train_routes:
            self.ways[way.train][way.route] = way
        self.fronts = {train.id: _fronts(situation, train)[0] for train in situation.trains}
        self._unusable = {route.id for route in situation.routes if route.is_unusable}
        self._conflicts: dict[str, list[RouteConflicts]] = defaultdict(list)
        for conflicts in sorted(situation.conflicts, key=lambda conflicts: conflicts.length):
            self._conflicts[conflicts.route].append(conflicts)
        self._excluded: dict[str, set[str]] = defaultdict(set)
        for route, of_route in self._conflicts.items():
            for other in of_route[0].conflicts:
                self._excluded[route].add(other)
                self._excluded[other].add(route)
        stand = [route for train in situation.trains if not train.is_dummy for route in train.initial_routes]
        self.shared = {route for route in stand if stand.count(route) > 1}

    def exclude(self, one: Row, other: Row) -> bool:
        """Whether two trains cannot stand so, unless they stand on one route together."""
        return not set(one).intersection(other) and any(
            self._excluded[route].intersection(other) for route in one
        )

    def first(self, train: StandingTrain) -> Row:
        """Where it stands; a route of which its ways say nothing lies behind the others."""
        ways = self.ways[train.id]
        row = [self.fronts[train.id]]
        left = [route for route in train.initial_routes if route != row[0]]
        while left:
            before = next((r for r in left if r in ways and row[0] in ways[r].next_routes), left[-1])
            left.remove(before)
            row.insert(0, before)
        return self._cleared(train.id, tuple(row))

    def following(self, train: StandingTrain, row: Row) -> Iterator[Row]:
        """Where it can stand next."""
        if row[-1] in train.final_routes:
            return
        for route in self.ways[train.id][row[-1]].next_routes:
            if route not in self._unusable:
                yield self._cleared(train.id, (*row, route))

    def bars(self, train: str, row: Row) -> Iterator[_Bar]:
        """What it keeps others from while it stands so; nothing where it is gone."""
        if self._gone(train, row):
            return
        for route, clear in self._drawn_on(row):
            owner = train if route in self.shared and route in row else ""
            for other in self._excluded[route]:
                yield _Bar(route, other, owner)
            of_route = self._conflicts[route]
            for shorter, longer in pairwise(of_route):
                over = self._length(train, row, route) - shorter.length
                if POINTS_COUNT and clear < over and not owner:
                    for other in longer.conflicts:
                        yield _Bar(f"{route} over points", other)

    def _cleared(self, train: str, row: Row) -> Row:
        """Without the routes behind it; off the area only the last one is left, as its name."""
        if self._gone(train, row):
            return (row[-1],)
        stands = (
            r for r, clear in self._drawn_on(row) if r == row[-1] or clear < self._length(train, row, r)
        )
        return tuple(stands)[::-1]

    def _drawn_on(self, row: Row) -> Iterator[tuple[str, int]]:
        """Each route from the front, and how far the front has drawn on beyond it."""
        clear = 0
        for route in reversed(row):
            yield route, clear
            clear += self._conflicts[route][-1].length if self._conflicts[route] else 0

    def _length(self, train: str, row: Row, route: str) -> int:
        ways = self.ways[train]
        return ways[route if route in ways else row[-1]].length

    def _gone(self, train: str, row: Row) -> bool:
        return not self.ways[train][row[-1]].next_routes


def _fronts(situation: Situation, train: StandingTrain) -> list[str]:
    stands = set(train.initial_routes)
    own = {way.route: way for way in situation.train_routes if way.train == train.id}
    return [r for r in train.initial_routes if r in own and not stands.intersection(own[r].next_routes)]


def _ways(rows: _Rows, train: StandingTrain) -> _Ways:
    first = rows.first(train)
    before: dict[Row, set[Row]] = {first: set()}
    left = [first]
    while left:
        row = left.pop()
        for following in rows.following(train, row):
            if following not in before:
                before[following] = set()
                left.append(following)
            before[following].add(row)
    try:
        order = tuple(
            TopologicalSorter({row: sorted(earlier) for row, earlier in before.items()}).static_order()
        )
    except CycleError:
        raise ValueError(f"the routes of train {train.id} run in a circle") from None
    place = {row: i for i, row in enumerate(order)}
    choices = tuple(tuple(sorted(place[r] - 1 for r in rows.following(train, row))) for row in order)
    bars = [frozenset(rows.bars(train.id, row)) for row in order]
    if rows.shared.intersection(train.initial_routes):
        bars[0] |= {_Bar("stands", "", train.id)}
    behind = tuple(_Bar("stands", "", ahead) for ahead in train.initial_multitrain_prev_trainid)
    return _Ways(order, choices, tuple(bars), behind)


def _searched(ways: Sequence[_Ways]) -> list[Train]:
    """The trains as the search takes them: a section for each route and what it keeps others from."""
    bits: dict[_Bar, int] = {}
    barred_on: dict[str, int] = defaultdict(int)
    for way in ways:
        for bar in sorted({bar for bars in way.bars for bar in bars}):
            if bar not in bits:
                bits[bar] = 1 << len(bits)
                barred_on[bar.keeps_from] |= bits[bar]
    trains: list[Train] = []
    for way in ways:
        behind = sum(bits[bar] for bar in way.behind)
        held = [sum(bits[bar] for bar in bars) for bars in way.bars]
        moves = (
            Move(barred_on[row[-1]] | (behind if move in way.choices[0] else 0), held[move + 1])
            for move, row in enumerate(way.rows[1:])
        )
        trains.append(Train(held[0], tuple(moves), way.choices))
    return trains
