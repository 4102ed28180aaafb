"""Level crossings: what the road truly shows when a front comes onto them, as SUMO has it, and for how long it has.

A road whose lamps fail when a train can no longer stop before it, by its guaranteed emergency brake, is outside the
design: told, and no breach of a rule. So is one that opens then because persons alone say of that train that it does
not come; one that its device opens otherwise is not. One that opens under a train is, but for a train that crept onto
it and that its device has not heard.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from simulation import events
from simulation.judge.body import RESOLUTION_M, Body
from simulation.judge.locking import GuaranteedBrake
from simulation.judge.log import Checker, Log
from sumo_cfg.truth_map import NetMap

ANNOUNCES, IS_OVER = "CrossingRequest", "CrossingOver"  # kinds of telegrams
TIME_TOLERANCE_S: Final = 0.11  # a front is seen at the end of a step
CREEP_MARGIN_MPS: Final = 0.6
TOLD_WITHIN_S: Final = 2.0  # the device, the air and the unit: until a train knows that a proof is taken back


@dataclass(frozen=True, slots=True)
class CrossingFacts:
    """A crossing with a device: where its road begins along SUMO's edges (m), and its least times (s)."""

    begins_m: Mapping[str, float]
    has_barriers: bool
    least_warning_s: float
    least_closed_s: float


@dataclass(slots=True)
class _WatchedRoad:
    """Since when (s) lamps shine and barriers are down; infinite: they do not, are not. `freed_of`: who was struck
    off by persons' word when its device opened it; None: it has not.
    """

    lit_s: float = math.inf
    lowered_s: float = math.inf
    freed_of: tuple[str, ...] | None = None


class CrossingWatch:
    """Checks `crossing-open` and `crossing-warning`: no front comes onto a road that is not closed, or not for its
    least times, unless its driver has leave to creep over it and does; and none opens under a train.
    """

    def __init__(
        self,
        net: NetMap,
        crossings: Mapping[str, CrossingFacts],
        creep_mps: float,
        brakes: Mapping[str, GuaranteedBrake],
        log: Log,
    ) -> None:
        self._facts, self._creep_mps, self._brakes, self._log = crossings, creep_mps, brakes, log
        self._edges = net.edges
        self._roads = {crossing_id: _WatchedRoad() for crossing_id in crossings}
        self._width_m = {
            crossing_id: self._width_of(facts.begins_m) for crossing_id, facts in crossings.items()
        }
        self._on_edge: dict[str, list[tuple[float, str]]] = {}
        for crossing_id, facts in crossings.items():
            for edge_id, begins_m in facts.begins_m.items():
                self._on_edge.setdefault(edge_id, []).append((begins_m, crossing_id))
        self._seen: dict[str, tuple[str, float]] = {}
        self._leave: set[tuple[str, str]] = set()
        self._stopped: set[tuple[str, str]] = set()  # for whom which road has been stopped by hand
        self._too_late: set[tuple[str, str]] = set()  # who could not stop when which road ceased to be closed
        self._on_road: dict[tuple[str, str], float] = {}  # run of a front when it came onto which road, m
        self._crept: set[tuple[str, str]] = set()  # who came onto which by leave to creep
        self._heard: set[tuple[str, str]] = set()  # who has announced itself to which

    def see(self, entry: events.JournalEntry, bodies: Iterable[Body]) -> None:
        """Lamps and barriers change; a driver has leave to creep over a crossing, once, that of somebody who guards it
        only if the road was stopped by hand for him before.
        """
        match entry.event:
            case events.CrossingLamps(crossing_id=crossing_id, lit=lit):
                road, was_s = self._roads[crossing_id], self._closed_s(crossing_id)
                road.freed_of = None if lit else road.freed_of
                if lit or road.lowered_s == math.inf:  # barriers that are down hold who has been warned
                    road.lit_s = entry.t_s if lit else math.inf
                self._ceases(crossing_id, was_s, bodies)
            case events.CrossingBarriers(crossing_id=crossing_id, state=state):
                road, was_s = self._roads[crossing_id], self._closed_s(crossing_id)
                road.lowered_s = entry.t_s if state is events.BarrierState.LOWERED else math.inf
                self._ceases(crossing_id, was_s, bodies)
            case events.CrossingOpens(struck_off=struck_off):
                self._roads[entry.who].freed_of = struck_off
                self._opens(entry.t_s, entry.who, bodies)
            case events.TookEffect(source=unit_id, kind=kind) if kind in (ANNOUNCES, IS_OVER):
                (self._heard.add if kind == ANNOUNCES else self._heard.discard)((unit_id, entry.who))
            case events.RoadStopped(crossing_id=crossing_id, unit_id=unit_id):
                self._stopped.add((unit_id, crossing_id))
            case events.CrossingCreep(crossing_id=crossing_id, guarded=guarded):
                pair = (entry.who, crossing_id)
                if not guarded or pair in self._stopped:
                    self._leave.add(pair)
            case _:
                pass

    def _opens(self, t_s: float, crossing_id: str, bodies: Iterable[Body]) -> None:
        """Its device opens it: no train is on the road, by whatever right it came there."""
        for body in bodies:
            pair = (body.unit_id, crossing_id)
            if body.run_m - self._on_road.get(pair, -math.inf) < body.length_m + self._width_m[crossing_id]:
                text = f"level crossing {crossing_id} opens under {body.unit_id}"
                unheard = pair in self._crept - self._heard
                self._log.note(t_s, Checker.CROSSING_OPEN, " ".join(reversed(pair)), text, outside=unheard)

    def _closed_s(self, crossing_id: str) -> float:
        """Since when (s) the road is closed; infinite: it is not."""
        road = self._roads[crossing_id]
        return road.lowered_s if self._facts[crossing_id].has_barriers else road.lit_s

    def _ceases(self, crossing_id: str, was_s: float, bodies: Iterable[Body]) -> None:
        """Who cannot stop any more before a road that was closed since `was_s` and is not any more, unless its device
        has opened it for others: without that no barriers rise.
        """
        if was_s == math.inf or self._closed_s(crossing_id) < math.inf:
            return
        freed_of = self._roads[crossing_id].freed_of
        fails = freed_of is None and not self._facts[crossing_id].has_barriers
        for body in bodies:
            brake = self._brakes.get(body.unit_id)
            if brake is not None and (fails or not {body.unit_id, ""}.isdisjoint(freed_of or ())):
                late_m = body.speed_mps * (brake.reaction_s + TOLD_WITHIN_S)
                stops_m = late_m + body.speed_mps**2 / (2.0 * brake.deceleration_mps2)
                if self._comes_within(body, crossing_id, stops_m):
                    self._too_late.add((body.unit_id, crossing_id))

    def _comes_within(self, body: Body, crossing_id: str, stops_m: float) -> bool:
        """Whether the road begins so near before a front, whichever way that goes."""
        begins_m = self._facts[crossing_id].begins_m
        ways = [(self._edges[body.path[-1]], -body.front_m)]
        for edge, at_m in ways:  # grows as it goes
            if 0.0 < at_m + begins_m.get(edge.id, -math.inf) <= stops_m:
                return True
            if at_m + edge.length_m <= stops_m:
                ways += [(self._edges[onto], at_m + edge.length_m) for onto in edge.next_edge_ids]
        return False

    def forget(self, unit_id: str) -> None:
        """The train has turned, or is off the line: where its front was says nothing any more."""
        self._seen.pop(unit_id, None)
        self._could_stop(unit_id)
        self._on_road = {pair: came_m for pair, came_m in self._on_road.items() if pair[0] != unit_id}

    def turned(self, body: Body, was_run_m: float) -> None:
        """The train has turned in place: it is off a road that it was on when it has run back as far as it had come."""
        mine = {pair: was_run_m - at for pair, at in self._on_road.items() if pair[0] == body.unit_id}
        self.forget(body.unit_id)
        for pair, run_m in mine.items():
            lies_m = body.length_m + self._width_m[pair[1]]
            if run_m < lies_m:
                self._on_road[pair] = body.run_m - lies_m + run_m
        self._seen[body.unit_id] = (body.path[-1], body.front_m)

    def _width_of(self, begins_m: Mapping[str, float]) -> float:
        """How wide a road is, as its two sides lie on the edges of either direction, m."""
        edge_id, from_m = next(iter(begins_m.items()))
        edge = self._edges[edge_id]
        return edge.length_m - from_m - begins_m[edge.bidi_edge_id]

    def _could_stop(self, unit_id: str) -> None:
        self._too_late = {pair for pair in self._too_late if pair[0] != unit_id}

    def observe(self, t_s: float, body: Body) -> None:
        """Where SUMO has a train's front now."""
        if not self._on_edge:
            return
        edge_id, front_m = body.path[-1], body.front_m
        if body.speed_mps == 0.0 and self._too_late:
            self._could_stop(body.unit_id)
        before = self._seen.get(body.unit_id)
        self._seen[body.unit_id] = (edge_id, front_m)
        if before is None:
            return
        was_edge, was_m = before
        for begins_m, crossing_id in self._on_edge.get(edge_id, ()):
            from_m = was_m if was_edge == edge_id else -math.inf
            if from_m < begins_m - RESOLUTION_M <= front_m:
                self._entered(t_s, body, crossing_id, body.behind_m + begins_m)
        if was_edge != edge_id:
            begun_m = body.behind_m - self._edges[was_edge].length_m
            for begins_m, crossing_id in self._on_edge.get(was_edge, ()):
                if was_m < begins_m - RESOLUTION_M:
                    self._entered(t_s, body, crossing_id, begun_m + begins_m)

    def _entered(self, t_s: float, body: Body, crossing_id: str, came_m: float) -> None:
        """Its front came onto a road that begins `came_m` along its run."""
        facts, road = self._facts[crossing_id], self._roads[crossing_id]
        pair = (body.unit_id, crossing_id)
        creeps = pair in self._leave and body.speed_mps <= self._creep_mps + CREEP_MARGIN_MPS
        self._leave.discard(pair)
        self._stopped.discard(pair)
        outside = pair in self._too_late
        self._too_late.discard(pair)
        self._on_road[pair] = came_m
        (self._crept.add if creeps else self._crept.discard)(pair)
        if creeps:
            return
        closed_s = self._closed_s(crossing_id)
        who = f"{body.unit_id} came onto level crossing {crossing_id} at {body.speed_mps:.1f} m/s"
        subject = f"{crossing_id} {body.unit_id}"
        if closed_s > t_s:
            text = f"{who}, which was not closed"
            self._log.note(t_s, Checker.CROSSING_OPEN, subject, text, outside=outside)
            return
        warned_s, shut_s = t_s - road.lit_s, t_s - closed_s
        short = warned_s < facts.least_warning_s - TIME_TOLERANCE_S
        if short or shut_s < facts.least_closed_s - TIME_TOLERANCE_S:
            text = f"{who}, which had warned for {warned_s:.1f} s and been closed for {shut_s:.1f} s"
            self._log.note(t_s, Checker.CROSSING_WARNING, subject, text)
