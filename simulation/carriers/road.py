"""The road at level crossings in SUMO: vehicles stop at barriers and at nothing else, and a train may strike one.

Every `LOOK_STEPS` steps of the day, whatever the trains do, each signal at a stop line is set by what the crossing
shows, queues are counted, drivers at half barriers decide, and the detector looks at a closed crossing; seldom where it
is open and nobody stands. While lamps flash or barriers move down, who can stop with his service brake does; before
lowered or rising barriers everybody stops as hard as it takes. Trains see nothing of it: whether one touches a vehicle
is judged from SUMO's positions of both, in every step in which it is near.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final, NamedTuple

from network.model import Direction, Line
from simulation.carriers.carrier import Carrier, Truth
from simulation.carriers.road_demand import road_vehicles
from simulation.carriers.road_shown import OPEN, CrossingShown, ObstacleDetectors
from simulation.carriers.road_totals import RoadTotals
from simulation.carriers.sumo_api import SumoApi
from simulation.carriers.trail import Trail
from simulation.events import BarrierState, VehicleStruck
from sumo_cfg.options import STEP_S, clock_ahead_s
from sumo_cfg.road_net import RoadAt, RoadPart, RoadWay
from sumo_cfg.road_traffic import CAR, ROUND, WIDTH_M, RoadVehicle, road_routes_xml, stall_at_m

LOOK_STEPS: Final = 5
LOOK_ROUND_STEPS: Final = 50  # at crossings that are open and without a queue
TRAIN_HALF_WIDTH_M: Final = 1.4  # half of a narrow-gauge car's 2.8 m
SEEN_M: Final = 100.0  # ahead of a train that drivers see come: it has stood less far from the crossing
NEAR_M: Final = 15.0  # beyond the middle of a crossing: its lanes, and what a train runs in a step
STANDS_MPS: Final = 0.1  # SUMO's own bound of a halt
GO_AHEAD_MPS: Final = -1.0  # setSpeed: the vehicle drives by itself again


class Noticed(NamedTuple):
    """A vehicle stands on a closed crossing, or no longer does."""

    crossing_id: str
    present: bool


class _Near(NamedTuple):
    trail: Trail
    unit_id: str
    at: RoadAt
    middle_m: float  # of the crossing, on the train's way


class Road:
    """The roads of a run, which its carrier drives; all crossings are open until they show something else.

    `folder` is for SUMO's files.
    """

    def __init__(
        self,
        line: Line,
        roads: Sequence[RoadAt],
        folder: Path,
        *,
        seed: int,
        end_s: float,
        today: Sequence[str] = (),
    ) -> None:
        self._line, self._folder = line, folder
        self.roads: Final = tuple(roads)
        self._seed, self._end_s, self._today = seed, end_s, tuple(today)
        self._over: dict[str, list[RoadAt]] = {}  # by piece of track
        for at in self.roads:
            self._over.setdefault(at.piece_id, []).append(at)
        self._lanes: Final = {
            (at.crossing_id, way, part): at.lanes(way, part)
            for at in self.roads
            for way in RoadWay
            for part in RoadPart
        }
        self._known: dict[str, RoadVehicle] = {}
        self._trails: dict[str, Trail] = {}
        self._signals: dict[str, str] = {}
        self._watched = {at.crossing_id for at in roads}
        self._on_it = {at.crossing_id: False for at in roads}
        self._shows: dict[str, CrossingShown] = dict.fromkeys(self._on_it, OPEN)
        self._stalled: dict[str, str] = {}  # the vehicle by crossing
        # By crossing: the train that drivers see come, until it is over it.
        self._creeping: dict[str, str] = {}
        self._near: list[_Near] = []
        self._noticed: list[Noticed] = []
        self._step = 0
        self.totals: Final = RoadTotals()
        self.struck: Final[list[VehicleStruck]] = []

    # SUMO's start -------------------------------------------------------------------------------------------------

    def routes(self, begin_s: float) -> Path:
        """Draw the vehicles of the run and write SUMO's file of them."""
        vehicles = self._comers(begin_s)
        self._known = {vehicle.id: vehicle for vehicle in vehicles}
        path = self._folder / "road.rou.xml"
        ahead_s = clock_ahead_s(begin_s)
        by_sumo = [replace(vehicle, depart_s=vehicle.depart_s + ahead_s) for vehicle in vehicles]
        path.write_bytes(road_routes_xml(self.roads, by_sumo))
        return path

    def _comers(self, begin_s: float) -> tuple[RoadVehicle, ...]:
        drawn = road_vehicles(self.roads, self._seed, self._today, begin_s, self._end_s)
        return tuple(vehicle for vehicle in drawn if vehicle.depart_s >= begin_s)

    def begin(self, api: SumoApi, begin_s: float) -> None:
        """SUMO has started, at that time."""
        self._sumo = api
        self._step = round(begin_s / STEP_S)
        self._look()

    def finish(self) -> None:
        """The run is over: those count who have not come through too, with what they have waited until now."""
        now_s, there = self._step * STEP_S, set(self._sumo.vehicle.getIDList())
        for vehicle in self._known.values():
            if vehicle.depart_s <= now_s:
                run_m = self._sumo.vehicle.getDistance(vehicle.id) if vehicle.id in there else 0.0
                self.totals.waited(vehicle, now_s - vehicle.depart_s - run_m / vehicle.free_mps)

    def blocked(self, crossing_id: str) -> bool:
        """Whether a vehicle stands where a train comes, for who looks before he drives on."""
        here = (at for at in self.roads if at.crossing_id == crossing_id)
        speed_mps = self._sumo.vehicle.getSpeed
        return any(
            speed_mps(vehicle_id) < STANDS_MPS for at in here for vehicle_id, _ in self._on_the_way(at)
        )

    # trains -------------------------------------------------------------------------------------------------------

    def put(
        self, unit_id: str, pieces: Sequence[str], direction: Direction, offset_m: float, length_m: float
    ) -> None:
        """A train is put on the line."""
        self._trails[unit_id] = Trail(self._line, pieces, direction, offset_m, length_m)

    def lead(self, unit_id: str, pieces: Sequence[str]) -> None:
        """Another way lies ahead of it."""
        self._trails[unit_id].lead(pieces)

    def turn(self, unit_id: str, pieces: Sequence[str]) -> None:
        """It changes ends."""
        self._trails[unit_id].turn(pieces)

    def remove(self, unit_id: str) -> None:
        """It is taken off the line."""
        del self._trails[unit_id]

    def expect(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> None:
        """Trains are about to run so many steps with these speeds, m/s: who comes near a crossing?"""
        runs_m = {unit_id: steps * STEP_S * max(speeds, default=0.0) for unit_id, speeds in columns}
        self._near.clear()
        for unit_id, trail in self._trails.items():
            run_m = runs_m.get(unit_id, 0.0) + NEAR_M
            self._near += [_Near(trail, unit_id, at, middle_m) for at, middle_m in self._met(trail, run_m)]

    def _met(self, trail: Trail, run_m: float) -> Iterator[tuple[RoadAt, float]]:
        """Crossings that a train is on or comes to within `run_m`, and where on its way they are, m."""
        for entered in trail.within(run_m):
            for at in self._over.get(entered.piece_id, ()):
                middle_m = trail.place_m(entered, at.position_m)
                if trail.front_m + run_m > middle_m > trail.front_m - trail.length_m - NEAR_M:
                    yield at, middle_m

    def follow(self, unit_id: str, truth: Truth) -> None:
        """Where the front of a train that ran now is."""
        self._trails[unit_id].follow(truth.piece_id, truth.offset_m)

    # each step ----------------------------------------------------------------------------------------------------

    def stepped(self) -> bool:
        """SUMO has made a step. Whether somebody must hear of it: a train struck a vehicle, or a detector changed."""
        self._step += 1
        for vehicle_id in self._sumo.arrived():
            if (vehicle := self._known.pop(vehicle_id, None)) is not None:
                self.totals.passed(vehicle, self._step * STEP_S)
        hit = False
        for near in self._near:
            hit |= self._meets(near)
        if self._step % LOOK_STEPS == 0:
            self._look()
        return hit or bool(self._noticed)

    def tell(self, detectors: ObstacleDetectors | None) -> None:
        """Tell the detectors what was noticed in the present step."""
        for crossing_id, present in self._noticed:
            if detectors is not None:
                detectors.obstacle(crossing_id, self._step, present=present)
        self._noticed.clear()

    def show(self, crossing_id: str, shown: CrossingShown) -> None:
        """From now on drivers see this of a crossing; of one without a road nobody sees it."""
        if crossing_id in self._shows:
            self._shows[crossing_id] = shown
            self._watched.add(crossing_id)

    def creeps_over(self, crossing_id: str, unit_id: str) -> None:
        """A train that stood before a crossing creeps over it: drivers see it, and stop until it is gone."""
        if crossing_id in self._shows:
            self._creeping[crossing_id] = unit_id
            self._watched.add(crossing_id)

    def stall(self, crossing_id: str, *, stands: bool) -> None:
        """A vehicle stalls with its middle on the track, in the first lane towards the right of DOWN: one that is there
        or another. Or the one that did goes on. Nothing happens where a crossing has no road here.
        """
        at = next((at for at in self.roads if at.crossing_id == crossing_id), None)
        if at is None or stands is (crossing_id in self._stalled):
            return
        vehicle, way = self._sumo.vehicle, RoadWay.RIGHT
        if not stands:
            vehicle.setSpeed(self._stalled.pop(crossing_id), GO_AHEAD_MPS)
            return
        lane_id = self._lanes[crossing_id, way, RoadPart.OVER][0]
        there = self._sumo.lane.getLastStepVehicleIDs(lane_id)
        vehicle_id = there[-1] if there else f"{at.edge(way, RoadPart.OVER)}.{self._step}"
        if not there:
            self._sumo.route.add(vehicle_id, at.edges(way)[1:])
            vehicle.add(vehicle_id, vehicle_id, typeID=CAR, departPos="0", departSpeed="0")
        vehicle.moveTo(vehicle_id, lane_id, stall_at_m(at, vehicle.getLength(vehicle_id)))
        vehicle.setPreviousSpeed(vehicle_id, 0.0)
        vehicle.setSpeed(vehicle_id, 0.0)
        self._stalled[crossing_id] = vehicle_id

    def _look(self) -> None:
        everywhere = self._step % LOOK_ROUND_STEPS == 0
        for at in self.roads:
            if everywhere or at.crossing_id in self._watched:
                self._look_at(at)

    def _look_at(self, at: RoadAt) -> None:
        """What it shows reaches the drivers; it is watched on unless it is open and nobody stands there."""
        shown = self._shows[at.crossing_id]
        self._signal(at, "r" if self._sees_train(at) else _state_for(shown))
        self._count(at)
        closed = shown.barriers is BarrierState.LOWERED
        if closed and at.road.half_barriers:
            self._drive_round(at)
        self._detect(at, closed=closed)
        if self._signals[at.crossing_id] == "G" and not self.totals.queues(at):
            self._watched.discard(at.crossing_id)
        else:
            self._watched.add(at.crossing_id)

    def _sees_train(self, at: RoadAt) -> bool:
        """Whether the train that creeps over it is not yet beyond: as it was at the end of its last stretch."""
        trail = self._trails.get(self._creeping.get(at.crossing_id, ""))
        comes = trail is not None and any(each is at for each, _ in self._met(trail, SEEN_M))
        if not comes:
            self._creeping.pop(at.crossing_id, None)
        return comes

    def _signal(self, at: RoadAt, state: str) -> None:
        if state != self._signals.get(at.crossing_id):
            self._signals[at.crossing_id] = state
            for way in RoadWay:
                self._sumo.trafficlight.setRedYellowGreenState(at.stop_line(way), state * at.road.lanes)

    def _count(self, at: RoadAt) -> None:
        halting = self._sumo.lane.getLastStepHaltingNumber
        lanes = (lane for way in RoadWay for lane in self._lanes[at.crossing_id, way, RoadPart.APPROACH])
        self.totals.queue(at, [halting(lane) for lane in lanes], self._step * STEP_S)

    def _drive_round(self, at: RoadAt) -> None:
        """Those first at a barrier go round it whose patience is over."""
        vehicle = self._sumo.vehicle
        for way in RoadWay:
            for lane in self._lanes[at.crossing_id, way, RoadPart.APPROACH]:
                waiting = self._sumo.lane.getLastStepVehicleIDs(lane)
                first = self._known.get(waiting[-1]) if waiting else None
                if first is None or first.patience_s == 0.0:
                    continue
                if vehicle.getWaitingTime(first.id) >= first.patience_s:
                    vehicle.setType(first.id, first.type_id + ROUND)

    def _detect(self, at: RoadAt, *, closed: bool) -> None:
        if not at.has_detector:
            return
        present = closed and any(True for _ in self._on_the_way(at))
        if present is not self._on_it[at.crossing_id]:
            self._on_it[at.crossing_id] = present
            self._noticed.append(Noticed(at.crossing_id, present))

    def _on_the_way(self, at: RoadAt) -> Iterator[tuple[str, float]]:
        """Vehicles that reach between the rails and 1.4 m beside them, and the kilometrage of their middle from the
        crossing's, m.
        """
        near_m, far_m = at.road.stop_line_m - TRAIN_HALF_WIDTH_M, at.road.stop_line_m + TRAIN_HALF_WIDTH_M
        vehicle, over_m = self._sumo.vehicle, at.over_m
        for way in RoadWay:
            for part, begins_m in ((RoadPart.OVER, 0.0), (RoadPart.AWAY, over_m)):
                for index, lane in enumerate(self._lanes[at.crossing_id, way, part]):
                    for vehicle_id in self._sumo.lane.getLastStepVehicleIDs(lane):
                        front_m = begins_m + vehicle.getLanePosition(vehicle_id)
                        if front_m > near_m and front_m - vehicle.getLength(vehicle_id) < far_m:
                            yield vehicle_id, at.lane_at_m(way, index)

    def _meets(self, near: _Near) -> bool:
        """Whether a train now touches a vehicle that it did not touch before."""
        trail, vehicle = near.trail, self._sumo.vehicle
        before_m, edge = trail.front_m, vehicle.getRoadID(near.unit_id)
        trail.follow(edge[:-1], vehicle.getLanePosition(near.unit_id))
        found = False
        for vehicle_id, lane_m in self._on_the_way(near.at):
            begins_m = near.middle_m + trail.direction * lane_m - WIDTH_M / 2.0
            touches = trail.front_m > begins_m and trail.front_m - trail.length_m < begins_m + WIDTH_M
            if touches and all((s.unit_id, s.vehicle_id) != (near.unit_id, vehicle_id) for s in self.struck):
                speed_mps = self._speed_at(near.unit_id, before_m, begins_m, trail.front_m)
                struck = VehicleStruck(
                    unit_id=near.unit_id,
                    crossing_id=near.at.crossing_id,
                    vehicle_id=vehicle_id,
                    speed_mps=speed_mps,
                )
                self.struck.append(struck)
                found = True
        return found

    def _speed_at(self, unit_id: str, before_m: float, at_m: float, now_m: float) -> float:
        """A train's speed, m/s, where its front was in the last step: even acceleration, v^2 grows with the way."""
        now_mps = self._sumo.vehicle.getSpeed(unit_id)
        run_m = now_m - before_m
        if not before_m <= at_m < now_m:
            return now_mps  # the vehicle came to the train
        was_mps = 2.0 * run_m / STEP_S - now_mps
        return math.sqrt(max(0.0, was_mps**2 + (now_mps**2 - was_mps**2) * (at_m - before_m) / run_m))


# How a carrier is made, given the time at which the run begins, s, and the road, if that is carried too.
CarrierOf = Callable[[float, Road | None], Carrier]


def _state_for(shown: CrossingShown) -> str:
    """What SUMO's signal at the stop lines is then."""
    if shown.barriers in (BarrierState.LOWERED, BarrierState.RISING):
        return "r"
    return "y" if shown.lamps or shown.barriers is BarrierState.LOWERING else "G"
