"""Random lines of loops with points at both ends, on which trains need leave to come in, played by asking a manager.

Stations 0, 1, … have tracks `k.1` (and `k.2`) between points `kW` and `kE`; the line between two is `k-l`. An overrun
on any track but those of the ends fouls the points beyond it. `can_finish` tries everything, on its own account of the
rule.
"""

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from radio.messages import Claim, HoldingReport, RouteGranted, RouteRequest
from wayside.actions import Send
from wayside.block_manager import Heard, step
from wayside.config import DispatchEntry, JourneyMove, ManagerConfig, RouteEntry, SectionEntry, StockMoves
from wayside.register import Register, start

Ways = Sequence[Sequence[str]]
# what a train does on its way to a place: it is there, is on its way, has leave
STANDS, RUNS, COMES_IN = range(3)


def route_of(here: str, there: str, last: int) -> RouteEntry:
    """From a track to one of the next station; `last`: the station at the end of the line."""
    a, b = int(here[0]), int(there[0])
    out, comes, beyond = ("E", "W", "E") if b > a else ("W", "E", "W")
    sections = (f"{a}{out}", f"{min(a, b)}-{max(a, b)}", f"{b}{comes}", there)
    overlap = () if b in (0, last) else (f"{b}{beyond}",)
    fouled = 0 < b < last
    return RouteEntry(f"{here}>{there}", here, sections, (f"{b}{comes}",) if fouled else (), overlap)


def config_of(tracks: Sequence[int], ways: Ways) -> ManagerConfig:
    """The manager's fixed data, with a certificate before each grant."""
    sections = [SectionEntry(f"{k}.{t}") for k, count in enumerate(tracks) for t in range(1, count + 1)]
    sections += [
        SectionEntry(f"{k}{end}", terminal_ids=(f"{k}{end}",)) for k in range(len(tracks)) for end in "WE"
    ]
    sections += [SectionEntry(f"{k}-{k + 1}", open_line=True) for k in range(len(tracks) - 1)]
    last = len(tracks) - 1
    routes = {route_of(*pair, last).route_id: route_of(*pair, last) for way in ways for pair in pairwise(way)}
    journeys = tuple(
        StockMoves(
            f"u{n}",
            tuple(
                JourneyMove(
                    f"{n}",
                    route_of(*pair, last).route_id,
                    pair[1],
                    False,
                    100.0 * k + n,
                    100.0 * k + n + 60,
                    20,
                )
                for k, pair in enumerate(pairwise(way), start=1)
            ),
        )
        for n, way in enumerate(ways)
    )
    dispatch = DispatchEntry(certificate=True, journeys=journeys)
    unit_ids = tuple(f"u{n}" for n in range(len(ways)))
    return ManagerConfig("line", "m", unit_ids, tuple(sections), tuple(routes.values()), dispatch=dispatch)


def random_case(chance: random.Random) -> tuple[list[int], list[list[str]]]:
    """Three or four stations, two to four trains, each from end to end or part of it, some back again."""
    tracks = [chance.randint(1, 2) for _ in range(chance.randint(3, 4))]
    starts = [f"{k}.{t}" for k, count in enumerate(tracks) for t in range(1, count + 1)]
    chance.shuffle(starts)
    ways: list[list[str]] = []
    for _ in range(min(chance.randint(2, 4), len(starts))):
        way = [starts.pop()]
        for down in chance.sample((True, False), chance.randint(1, 2)):
            at = int(way[-1][0])
            ahead = list(range(at + 1, len(tracks)) if down else range(at - 1, -1, -1))
            way += [f"{k}.{chance.randint(1, tracks[k])}" for k in ahead[: chance.randint(0, len(ahead))]]
        ways.append(way)
    return tracks, ways


State = tuple[tuple[int, int], ...]  # of each train: the place it is at, or on its way to, and what it does


def _held(ways: Ways, n: int, place: int, does: int, last: int) -> set[str]:
    if does == STANDS:
        return {ways[n][place]}
    return {ways[n][place - 1], *route_of(ways[n][place - 1], ways[n][place], last).section_ids}


def _follows(ways: Ways, state: State, n: int, last: int) -> tuple[int, int] | None:
    """What a train can do next in a state; None: nothing, or it is at its end."""
    place, does = state[n]
    if does == COMES_IN:
        return place, STANDS
    to = place + 1 if does == STANDS else place
    if to == len(ways[n]):
        return None
    route = route_of(ways[n][to - 1], ways[n][to], last)
    for other, (its_place, it_does) in enumerate(state):
        if other == n:
            continue
        if does == STANDS and not set(route.section_ids).isdisjoint(
            _held(ways, other, its_place, it_does, last)
        ):
            return None
        if it_does == STANDS:
            continue
        its = route_of(ways[other][its_place - 1], ways[other][its_place], last)
        comes = it_does == COMES_IN or not its.entry
        over = {s for s in route.section_ids if does == RUNS or s not in route.entry}
        if comes and not over.isdisjoint(its.overlap):
            return None
        goes = {s for s in its.section_ids if comes or s not in its.entry}
        if (does == RUNS or not route.entry) and not goes.isdisjoint(route.overlap):
            return None
    if does == STANDS:
        return to, RUNS if route.entry else COMES_IN
    return place, COMES_IN


def following(ways: Ways, state: State, last: int) -> Iterator[State]:
    """The states that one train's next step leads to."""
    for n in range(len(ways)):
        step_ = _follows(ways, state, n, last)
        if step_ is not None:
            yield (*state[:n], step_, *state[n + 1 :])


def can_finish(ways: Ways, state: State, last: int, known: dict[State, bool]) -> bool:
    """Whether any order of steps brings all to the end of their ways."""
    if state in known:
        return known[state]
    known[state] = all(
        does == STANDS and place == len(w) - 1 for w, (place, does) in zip(ways, state, strict=True)
    )
    known[state] = known[state] or any(can_finish(ways, s, last, known) for s in following(ways, state, last))
    return known[state]


@dataclass
class Play:
    """A manager and its trains; a train asks for its route, then for leave, then stands and gives the rest back."""

    config: ManagerConfig
    ways: Ways
    leave: set[int] = field(default_factory=set[int])  # trains that come in

    def __post_init__(self) -> None:
        self.register: Register = start(
            self.config, 1, {f"{s.section_id}": b"k" * 32 for s in self.config.sections}
        )
        self.at = [0] * len(self.ways)
        self.runs = [False] * len(self.ways)
        for n, way in enumerate(self.ways):
            self._hear(n, Claim((way[0],), 0))

    def route(self, n: int) -> RouteEntry:
        """The route of a train's next move."""
        way = self.ways[n]
        return self.register.plan.routes[f"{way[self.at[n]]}>{way[self.at[n] + 1]}"]

    def done(self, n: int) -> bool:
        """Whether it is where its way ends."""
        return self.at[n] == len(self.ways[n]) - 1

    def acts(self, n: int) -> bool:
        """One step of a train; whether it could."""
        unit_id, route = f"u{n}", self.route(n)
        if n in self.leave:
            self.leave.discard(n)
            self.runs[n] = False
            self.at[n] += 1
            self._hear(n, HoldingReport((self.ways[n][self.at[n]],), self.register.unit(unit_id).token))
            return True
        sections = route.section_ids[-len(route.entry) - 1 :] if self.runs[n] else route.section_ids
        granted = self._hear(n, RouteRequest(unit_id, route.route_id, sections))
        if not isinstance(granted, RouteGranted):
            return False
        if self.runs[n] or not route.entry:
            self.leave.add(n)
        self.runs[n] = True
        return True

    def _hear(self, n: int, message: object) -> object:
        self.register, actions = step(self.register, Heard(f"u{n}", 1, True, 0, message), 0.0)  # type: ignore[arg-type]
        return next(a.message for a in reversed(actions) if isinstance(a, Send) and a.destination == f"u{n}")
