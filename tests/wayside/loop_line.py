"""Random lines of loops with random trains, as the block manager's fixed data, played through by asking for routes.

A train runs its route as soon as it has it, and holds its track alone then: blocks without minutes. `can_finish` is the
search without any cleverness, in which nothing is left out.
"""

import itertools
import random
from collections.abc import Sequence
from dataclasses import dataclass, field

from radio.messages import Claim, HoldingReport, RouteGranted, RouteRefused, RouteRequest, SignOff, SignOn
from wayside.actions import Send, Show
from wayside.block_manager import Heard, step
from wayside.config import (
    DispatchEntry,
    JourneyMove,
    ManagerConfig,
    OrderRule,
    RouteEntry,
    SectionEntry,
    StockMoves,
)
from wayside.register import Register, start
from wayside.said import BoundaryPassed, Note


def line_of(tracks: Sequence[int]) -> tuple[SectionEntry, ...]:
    """Stations in a row with so many tracks each, a portal at either end: P, 0.1, 0.2, 0-1, 1.1, ..., Q."""
    sections = [SectionEntry("P", portal=True)]
    for station, count in enumerate(tracks):
        if station:
            sections.append(SectionEntry(f"{station - 1}-{station}", open_line=True))
        sections += [SectionEntry(f"{station}.{track}") for track in range(1, count + 1)]
    return (*sections, SectionEntry("Q", portal=True))


def route_of(here: str, there: str) -> RouteEntry:
    """From a track or portal to one of the next station, or to the portal behind it."""
    name = f"{here}>{there}"
    if "." not in here or "." not in there:
        return RouteEntry(name, here, (there,))
    low, high = sorted((int(here.split(".", maxsplit=1)[0]), int(there.split(".", maxsplit=1)[0])))
    return RouteEntry(name, here, (f"{low}-{high}", there))


def config_of(tracks: Sequence[int], ways: Sequence[Sequence[str]], **dispatch: object) -> ManagerConfig:
    """A line, and for each stock the places that it comes to; `P` or `Q` is off the line. One train a direction.

    Planned by turns: the k-th move of every stock is due at 100 k and its number, s.
    """
    routes: dict[str, RouteEntry] = {}
    journeys: list[StockMoves] = []
    for number, way in enumerate(ways):
        moves: list[JourneyMove] = []
        if way and way[0] in "PQ":
            moves.append(JourneyMove(f"{number}", "", way[0], False, float(number), float(number), 0.0))
        for k, (here, there) in enumerate(itertools.pairwise(way), start=1):
            route = route_of(here, there)
            routes[route.route_id] = route
            due_s = 100.0 * k + number
            moves.append(
                JourneyMove(f"{number}", route.route_id, there, there in "PQ", due_s, due_s + 60.0, 20.0)
            )
        journeys.append(StockMoves(f"u{number}", tuple(moves)))
    entry = DispatchEntry(journeys=tuple(journeys), **dispatch)  # type: ignore[arg-type]
    unit_ids = tuple(journey.unit_id for journey in journeys)
    return ManagerConfig("line", "m", unit_ids, line_of(tracks), tuple(routes.values()), dispatch=entry)


def random_case(chance: random.Random) -> tuple[list[int], list[list[str]]]:
    """Two to four stations, one to four stocks; each goes one way, and some come back. One waits outside a portal at
    most: of two, the second could not come in before the first.
    """
    tracks = [chance.randint(1, 2) for _ in range(chance.randint(2, 4))]
    starts = [f"{s}.{t}" for s, count in enumerate(tracks) for t in range(1, count + 1)]
    chance.shuffle(starts)
    ways: list[list[str]] = []
    for _ in range(min(chance.randint(1, 4), len(starts))):
        down = chance.random() < 0.5
        portal = "P" if down else "Q"
        outside = chance.random() < 0.3 and not any(other[0] == portal for other in ways)
        way = [portal if outside else starts.pop()]
        for turn in range(chance.randint(1, 2)):
            way = _on(chance, tracks, way, down if turn == 0 else not down)
            if way[-1] in "PQ":
                break
        ways.append(way)
    return tracks, ways


def _on(chance: random.Random, tracks: Sequence[int], way: list[str], down: bool) -> list[str]:
    at = (-1 if way[-1] == "P" else len(tracks)) if way[-1] in "PQ" else int(way[-1].split(".")[0])
    ahead = list(range(at + 1, len(tracks)) if down else range(at - 1, -1, -1))
    gone = ahead[: chance.randint(0, len(ahead))]
    more = [f"{station}.{chance.randint(1, tracks[station])}" for station in gone]
    if gone == ahead and (ahead or way[-1] not in "PQ") and chance.random() < 0.6:
        more.append("Q" if down else "P")
    return [*way, *more]


def can_finish(ways: Sequence[Sequence[str]], at: Sequence[int], outside: Sequence[bool]) -> bool:
    """Whether any order of moves brings every stock to the end of its way; `at` is where each is on it."""
    dead: set[tuple[tuple[int, bool], ...]] = set()

    def held(k: int, place: int, out: bool) -> str:
        return "" if out or (place and ways[k][place] in "PQ") else ways[k][place]

    def search(state: tuple[tuple[int, bool], ...]) -> bool:
        if state in dead:
            return False
        if all(place == len(ways[k]) - 1 and not out for k, (place, out) in enumerate(state)):
            return True
        for k, (place, out) in enumerate(state):
            others = {held(j, *other) for j, other in enumerate(state) if j != k}
            if out:
                following = place, False
            elif place < len(ways[k]) - 1:
                following = place + 1, False
            else:
                continue
            if ways[k][following[0]] not in others and search((*state[:k], following, *state[k + 1 :])):
                return True
        dead.add(state)
        return False

    return search(tuple(zip(at, outside, strict=True)))


@dataclass
class Play:
    """A manager and its stocks, played by asking for moves one at a time."""

    config: ManagerConfig
    ways: Sequence[Sequence[str]]
    now_s: float = 0.0
    notes: list[Note] = field(default_factory=list[Note])

    def __post_init__(self) -> None:
        self.register: Register = start(self.config, 1, {})
        self.at = [0] * len(self.ways)
        self.outside = [way[0] in "PQ" for way in self.ways]
        for k, way in enumerate(self.ways):
            self.hear(k, Claim(() if self.outside[k] else (way[0],), 0))
        self.notes.clear()

    def hear(self, k: int, message: object) -> object:
        """The answer to what a stock says."""
        heard = Heard(f"u{k}", 1, True, 0, message)
        self.register, actions = step(self.register, heard, self.now_s)  # type: ignore[arg-type]
        self.notes += [action.note for action in actions if isinstance(action, Show)]
        return next(a.message for a in reversed(actions) if isinstance(a, Send) and a.destination == f"u{k}")

    def done(self, k: int) -> bool:
        """Whether a stock is where its way ends."""
        return self.at[k] == len(self.ways[k]) - 1 and not self.outside[k]

    def asks(self, k: int) -> object:
        """A stock asks for its next move, and makes it if it may."""
        unit_id, way = f"u{k}", self.ways[k]
        if self.outside[k]:
            answer = self.hear(k, SignOn(unit_id, (way[0],)))
            self.outside[k] = not self.register.held_by(unit_id)
            return answer
        route = route_of(way[self.at[k]], way[self.at[k] + 1])
        answer = self.hear(k, RouteRequest(unit_id, route.route_id, route.section_ids))
        if isinstance(answer, RouteGranted):
            self.runs(k)
        elif not isinstance(answer, RouteRefused):
            raise AssertionError(answer)
        return answer

    def runs(self, k: int) -> None:
        """A stock runs the route that it was granted, and gives back what lies behind."""
        self.at[k] += 1
        unit_id, there = f"u{k}", self.ways[k][self.at[k]]
        self.hear(k, HoldingReport((there,), self.register.unit(unit_id).token))
        if there in "PQ":
            self.hear(k, SignOff(unit_id, self.register.unit(unit_id).token))
            self.register, _ = step(self.register, BoundaryPassed(there), self.now_s)

    def finishes(self) -> bool:
        """Whether all can still finish, by the search that leaves nothing out."""
        return can_finish(self.ways, self.at, self.outside)


def planned(**dispatch: object) -> dict[str, object]:
    """Settings of the planned order."""
    return {"order": OrderRule.PLANNED, **dispatch}
