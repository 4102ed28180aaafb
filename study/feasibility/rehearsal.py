"""The day played through in blocks and minutes: who waits for whom, how late that makes trains, and who never gets on.

The rules of the run without its metres: a route is asked for `request_lead_s` before the train may leave and granted
whole, refused ones are asked for again every 5 s, a train leaves when its points are thrown, runs its time, and gives
back what lies behind as it arrives; section by section, the track that it left some time after that. Trains come in by
their portals as early as the operation sends them. So it also finds what the plan's own times do not show: trains that
take each other's way because one of them comes early or late.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise, takewhile
from typing import Final

import numpy as np

from network.graph import overlaps_coming_in, overlaps_going_out
from network.model import Line, SectionKind
from onboard.authority.tables import REFUSED_REPEAT_S
from onboard.duty.timekeeping import CRUISE_MIN_KMH
from onboard.duty_parameters import ReleaseRule
from onboard.mission import Target
from simulation.setup import Setup
from simulation.world.roster import OPENING_S
from study.feasibility.entries import Entries
from study.feasibility.planned import SIGNS_S, PlannedDay, PlannedNode, PlannedTrain
from study.feasibility.timing import throws_s

CLEARS_S: Final = (
    30.0  # assumed: from leaving a track until a tag proves it, and points beyond it, to be behind
)
COMES_S: Final = 40.0  # assumed: from the approach tag to the track
SLOWEST_MPS: Final = CRUISE_MIN_KMH / 3.6
SLOWED_S: Final = 40.0  # assumed: what a stop before points costs that are thrown only then
RESTARTS_S: Final = 30.0  # assumed: what a train loses that must stop where it was to run through


@dataclass(frozen=True, slots=True)
class BlockedTrain:
    """A train that never gets on: at a node it wants sections, which others hold."""

    train: PlannedTrain
    node: int
    wants: tuple[str, ...]
    held_by: tuple[str, ...]  # stock ids
    section_id: str


@dataclass(frozen=True, slots=True)
class RehearsedLateness:
    """How late a train comes to a stop, or leaves it, s, and behind whom it had to wait on its way there, or there."""

    train: PlannedTrain
    station_id: str
    due_s: float
    late_s: float
    behind: tuple[str, ...]
    leaves: bool


@dataclass(slots=True)
class _RehearsedSet:
    """One set of the day. `asks` is the route of its train that it asks for, `granted` the last one granted."""

    line: Line
    stock_id: str
    trains: Sequence[PlannedTrain]
    at: int = 0  # index of its train
    node: int = 0  # where its train is, or was last
    moving: bool = False
    holds: set[str] = field(default_factory=set[str])
    ready_s: float = -math.inf  # when it may leave the node
    asks: int = 0
    granted: int = -1
    waits_since_s: float | None = None
    blocked_by: str = ""  # a section
    behind: list[str] = field(default_factory=list[str])
    done: bool = False

    @property
    def train(self) -> PlannedTrain:
        return self.trains[self.at]

    @property
    def wants(self) -> tuple[str, ...]:
        """The sections that it needs next."""
        if not self.holds:
            return (self.train.nodes[0].section_id,)
        return self.needs(self.asks)

    def needs(self, route: int) -> tuple[str, ...]:
        """What it needs to be granted a route of its train."""
        if route >= len(self.train.routes):
            return ()
        wanted = self.train.routes[route]
        return (*wanted.section_ids, *overlaps_going_out(self.line, wanted))


class Rehearsal:
    """The day played through; `waits` and `late` say what came of it.

    `slowed`: trains that must stop before the points of a station, by number and the station's id.
    """

    def __init__(
        self, setup: Setup, day: PlannedDay, slowed: frozenset[tuple[str, str]] = frozenset()
    ) -> None:
        self._setup = setup
        self._slowed = slowed
        self._day = day
        self._holder: dict[str, _RehearsedSet] = {}
        self._sets = [
            _RehearsedSet(day.line, stock_id, trains) for stock_id, trains in day.trains.items() if trains
        ]
        self._entries = Entries(setup)
        self._before_points: list[
            tuple[float, Callable[[float], None]]
        ] = []  # asked in vain since, and again
        self._heap: list[tuple[float, int, Callable[[float], None]]] = []
        self._count = 0
        self.late: list[RehearsedLateness] = []
        self._play()

    @property
    def waits(self) -> list[BlockedTrain]:
        """Trains that never get on."""
        found: list[BlockedTrain] = []
        for one in self._sets:
            if one.done:
                continue
            others = [self._holder[s] for s in one.wants if self._holder.get(s, one) is not one]
            held_by = tuple(dict.fromkeys(other.stock_id for other in others))
            found.append(BlockedTrain(one.train, one.node, one.wants, held_by, one.blocked_by))
        return found

    # the course of the day --------------------------------------------------------------------------------------------

    def _at(self, time_s: float, what: Callable[[float], None]) -> None:
        self._count += 1
        heapq.heappush(self._heap, (time_s, self._count, what))

    def _play(self) -> None:
        opens_s = min((one.train.nodes[0].arrives_s for one in self._sets), default=0.0) - OPENING_S
        for one in self._sets:
            if one.train.duty.enters:
                self._at(one.train.duty.enter_s, partial(self._wait, one))
                continue
            section_id = one.train.nodes[0].section_id
            if section_id in self._holder:  # two sets on one track: the second is never let on
                one.blocked_by = section_id
                continue
            self._take(one, (section_id,))
            self._at(opens_s, partial(self._begin, one))
        while self._heap:
            now_s, _, what = heapq.heappop(self._heap)
            what(now_s)

    def _take(self, one: _RehearsedSet, sections: Sequence[str]) -> None:
        self._holder.update(dict.fromkeys(sections, one))
        one.holds.update(sections)

    def _give_back(self, one: _RehearsedSet, keep: set[str], now_s: float) -> None:
        """All but what is kept; those that wait for something ask again when it is their turn."""
        for section_id in one.holds - keep:
            del self._holder[section_id]
        one.holds &= keep
        for other in self._sets:
            if other.waits_since_s is not None:
                turns = math.ceil(max(now_s - other.waits_since_s, 0.0) / REFUSED_REPEAT_S)
                self._at(other.waits_since_s + turns * REFUSED_REPEAT_S, partial(self._try, other))
        heard_s = now_s + self._entries.report_s
        for since_s, again in self._before_points:
            turns = math.ceil(max(heard_s - since_s, 0.0) / REFUSED_REPEAT_S)
            self._at(since_s + turns * REFUSED_REPEAT_S, again)
        self._before_points.clear()

    def _begin(self, one: _RehearsedSet, now_s: float) -> None:
        """Takes up its train where it stands."""
        train = one.train
        one.node, one.asks, one.granted, one.moving, one.behind = 0, 0, -1, False, []
        one.ready_s = now_s if train.duty.enters else max(now_s, train.nodes[0].departs_s)
        if not train.routes:  # all its stops are on one track
            self._at(max(now_s, train.stands[-1].arrives_s), partial(self._end, one))
            return
        self._at(max(now_s, one.ready_s - self._setup.unit.request_lead_s), partial(self._wait, one))

    def _wait(self, one: _RehearsedSet, now_s: float) -> None:
        """Asks for the first time; what is refused is asked for again when something becomes free."""
        one.waits_since_s = now_s
        self._try(one, now_s)

    def _try(self, one: _RehearsedSet, now_s: float) -> None:
        if one.waits_since_s is None:
            return
        held_by_other = next((s for s in one.wants if self._holder.get(s, one) is not one), None)
        if held_by_other is not None:
            one.blocked_by = held_by_other
            ahead = self._holder[held_by_other].train.number
            if ahead not in one.behind:
                one.behind.append(ahead)
            return
        one.waits_since_s = None
        signs_on = not one.holds
        self._take(one, one.wants)
        if signs_on:
            self._at(now_s + SIGNS_S, partial(self._begin, one))
            return
        one.granted = one.asks
        if not one.moving:
            self._leave(one, now_s)

    def _leave(self, one: _RehearsedSet, granted_s: float) -> None:
        """The way from its node is granted: it leaves when its points are thrown and its time has come."""
        train, here, there = one.train, one.train.nodes[one.node], one.train.nodes[one.node + 1]
        leaves_s = max(one.ready_s, granted_s)
        if here.target is not None:
            thrown_s = throws_s(self._day.line, train.duty.mission) if one.node == 0 else 0.0
            leaves_s = max(leaves_s, granted_s + SIGNS_S / 2.0 + thrown_s)
            self._note(one, here.target, here.departs_s, leaves_s, leaves=True)
        elif granted_s > one.ready_s:  # it had to stop where it was to run through
            leaves_s += RESTARTS_S
        comes_s = self._driven_s(one, here, there, leaves_s)
        if (train.number, self._day.line.sections[there.section_id].station_id) in self._slowed:
            comes_s += SLOWED_S
        # As late as the plan says, but no train goes slower than its unit lets it.
        given = there.target is None or there.target.arrival_s is not None
        not_before_s = there.arrives_s - self._setup.unit.time_margin_s if given else -math.inf
        slowest_s = (there.position_m - here.position_m) / SLOWEST_MPS + RESTARTS_S
        arrives_s = max(comes_s, min(not_before_s, leaves_s + slowest_s))
        one.moving = True
        if there.target is None:
            one.asks = one.node + 1
            self._at(max(arrives_s - COMES_S, leaves_s), partial(self._wait, one))
        if self._setup.operation.release is ReleaseRule.SECTION:
            left = partial(self._clear, one, self._left_behind(one))
            self._at(min(leaves_s + CLEARS_S, arrives_s), left)
        if not train.routes[one.node].entry:
            self._at(arrives_s, partial(self._arrive, one))
            return
        asks_s, lead_s = self._entries.leads_s(train, one.node + 1)
        asks_s = max(arrives_s - asks_s, leaves_s)
        self._at(asks_s, partial(self._come_in, one, asks_s, arrives_s, lead_s))

    def _come_in(
        self, one: _RehearsedSet, since_s: float, arrives_s: float, lead_s: float, now_s: float
    ) -> None:
        """Asks for leave to come in; who has none asks again when somebody stands."""
        overlaps = overlaps_coming_in(self._day.line, one.train.routes[one.node])
        held_by_other = next((s for s in overlaps if self._holder.get(s, one) is not one), None)
        if held_by_other is None:
            self._take(one, overlaps)
            late_s = now_s + lead_s - arrives_s if now_s > since_s else 0.0
            self._at(arrives_s + max(late_s, 0.0), partial(self._arrive, one))
            return
        ahead = self._holder[held_by_other].train.number
        if ahead not in one.behind:
            one.behind.append(ahead)
        self._before_points.append((since_s, partial(self._come_in, one, since_s, arrives_s, lead_s)))

    def _left_behind(self, one: _RehearsedSet) -> set[str]:
        """The track that it leaves, and the points between that and the open line."""
        sections = self._day.line.sections
        ahead = one.train.routes[one.node].section_ids
        points = takewhile(lambda section_id: sections[section_id].kind is SectionKind.POINTS, ahead)
        return {one.train.nodes[one.node].section_id, *points}

    def _clear(self, one: _RehearsedSet, behind: set[str], now_s: float) -> None:
        self._give_back(one, one.holds - behind, now_s)

    def _driven_s(self, one: _RehearsedSet, here: PlannedNode, there: PlannedNode, leaves_s: float) -> float:
        """When a train is at a node as it is driven from another, s after midnight, with its stops at halts between."""
        now_s = leaves_s
        for before, stand in pairwise(one.train.stands):
            at_m = (before.target.mark_m, *(p.position_m for p in stand.target.passings), stand.target.mark_m)
            low_m, high_m = max(here.position_m, at_m[0]), min(there.position_m, at_m[-1])
            if low_m >= high_m or stand.target.section_id == here.section_id:
                continue
            if math.isinf(stand.run_s):
                return math.inf
            begin_s, end_s = np.interp((low_m, high_m), at_m, (0.0, *stand.passes_s, stand.run_s)).tolist()
            now_s += end_s - begin_s
            if high_m < there.position_m:
                self._note(one, stand.target, stand.arrives_s, now_s, leaves=False)
                dwell_s = self._setup.unit.dwell_min_s if stand.target.passengers else 0.0
                now_s = max(now_s + dwell_s, stand.departs_s)
                self._note(one, stand.target, stand.departs_s, now_s, leaves=True)
        return now_s

    def _arrive(self, one: _RehearsedSet, now_s: float) -> None:
        """At the next track: what lies behind is given back, the next route asked for."""
        train = one.train
        one.node += 1
        one.moving = False
        node = train.nodes[one.node]
        ahead = one.needs(one.node) if one.granted >= one.node else ()
        if node.target is not None:
            self._note(one, node.target, node.arrives_s, now_s, leaves=False)
        self._give_back(one, {node.section_id, *ahead}, now_s)
        if one.node == len(train.nodes) - 1:
            self._end(one, now_s)
        elif node.target is None:
            one.ready_s = now_s
            if one.granted >= one.node:
                self._leave(one, now_s)
        else:
            one.behind = []
            dwell_s = self._setup.unit.dwell_min_s if node.target.passengers else 0.0
            one.ready_s = max(now_s + dwell_s, node.departs_s)
            one.asks = one.node
            self._at(max(now_s, one.ready_s - self._setup.unit.request_lead_s), partial(self._wait, one))

    def _note(self, one: _RehearsedSet, target: Target, due_s: float, real_s: float, *, leaves: bool) -> None:
        if target.station_id is not None:
            late = RehearsedLateness(
                one.train, target.station_id, due_s, real_s - due_s, tuple(one.behind), leaves
            )
            self.late.append(late)

    def _end(self, one: _RehearsedSet, now_s: float) -> None:
        """The train's journey is over: it leaves the line, becomes the next one, or stays."""
        follows = one.at + 1 < len(one.trains)
        if one.train.duty.leaves:
            self._at(now_s + SIGNS_S, partial(self._left, one))
        elif follows:
            one.at += 1
            one.node = 0
            self._at(now_s + self._setup.turn_s, partial(self._begin, one))
        else:
            one.done = True

    def _left(self, one: _RehearsedSet, now_s: float) -> None:
        self._give_back(one, set(), now_s)
        one.done = one.at + 1 >= len(one.trains)
        if not one.done:
            one.at += 1
            one.node = one.asks = 0
            self._at(max(one.train.duty.enter_s, now_s), partial(self._wait, one))
