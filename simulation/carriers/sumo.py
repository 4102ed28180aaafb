"""SUMO as the carrier: it integrates the speeds we set and tells where the trains are; its position is the truth."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from network.model import Direction
from simulation.carriers.carrier import Truth
from simulation.carriers.sumo_api import SumoApi, in_process
from simulation.carriers.touching import text_of
from sumo_cfg.options import LANE_CHANGE_MODE, SPEED_MODE, add_train_type, clock_ahead_s, sumo_command

SIGN: Final = {Direction.DOWN: "+", Direction.UP: "-"}
DIRECTION: Final = {"+": Direction.DOWN, "-": Direction.UP}


def edge_id(piece_id: str, direction: Direction) -> str:
    """Name of the SUMO edge of a piece in one direction."""
    return piece_id + SIGN[direction]


class SumoCarrier:
    """One SUMO simulation; libsumo allows one a process. `api` may be another way to it than libsumo, `routes` a file
    of road vehicles.
    """

    def __init__(
        self, net: Path, begin_s: float, api: SumoApi | None = None, routes: Path | None = None
    ) -> None:
        self._sumo = in_process() if api is None else api
        self._open = True
        begin = f"{begin_s + clock_ahead_s(begin_s):.1f}"
        self._sumo.start([*sumo_command(net, routes=routes), "--begin", begin])
        self._collisions: dict[tuple[str, str], str] = {}
        self._lengths_m: dict[str, float] = {}
        self._routes = 0
        self._step_s = float(self._sumo.simulation.getDeltaT())
        self._reversing: list[tuple[str, str, float]] = []
        self._judged = True  # whether SUMO has looked at the trains as they now lie

    def insert(
        self, unit_id: str, pieces: Sequence[str], direction: Direction, offset_m: float, length_m: float
    ) -> None:
        """Put a standing train on the net. SUMO inserts it at once: no step is taken for it."""
        kind = f"train-{length_m:g}"
        if kind not in self._sumo.vehicletype.getIDList():
            add_train_type(kind, length_m, self._sumo.vehicletype)
        self._lengths_m[unit_id] = length_m
        self._routes += 1
        route = f"route-{self._routes}"
        self._sumo.route.add(route, [edge_id(piece, direction) for piece in pieces])
        self._sumo.vehicle.add(unit_id, route, typeID=kind, departPos="0", departSpeed="0")
        self._sumo.vehicle.moveTo(unit_id, edge_id(pieces[0], direction) + "_0", offset_m)
        self._sumo.vehicle.setSpeedMode(unit_id, SPEED_MODE)
        self._sumo.vehicle.setLaneChangeMode(unit_id, LANE_CHANGE_MODE)
        self._sumo.vehicle.setSpeed(unit_id, 0.0)
        self._judged = False

    def run(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> int:
        """Execute the speeds step by step, watching for collisions."""
        hit = self._run(columns, steps)
        if hit:
            self._tell()
        return hit

    def _run(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> int:
        if self._reversing and steps > 0:
            hit = self._run_steps(columns, 0, 1)
            first_mps = {unit_id: speeds[0] for unit_id, speeds in columns}
            for unit_id, lane, offset_m in self._reversing:
                speed_mps = first_mps.get(unit_id, 0.0)  # it stood when it turned, and SUMO lets it stand
                self._sumo.vehicle.moveTo(unit_id, lane, offset_m + 0.5 * speed_mps * self._step_s)
                if speed_mps > 0.0:
                    self._sumo.vehicle.setPreviousSpeed(unit_id, speed_mps)
            self._reversing.clear()
            return hit or self._run_steps(columns, 1, steps)
        return self._run_steps(columns, 0, steps)

    def _run_steps(self, columns: Sequence[tuple[str, Sequence[float]]], first: int, last: int) -> int:
        """Execute rows `first` to `last` - 1; returns the number of steps after which a collision was seen, or 0."""
        set_speed, step, colliding = self._sumo.set_speed, self._sumo.step, self._sumo.colliding
        if not columns:
            if last > first and not self._judged:
                step()
                first += 1
                self._judged = True
                if self._note_collisions():
                    return first
            if last > first:
                step(self._sumo.simulation.getTime() + (last - first) * self._step_s)
            return last if self._note_collisions() else 0
        self._judged = True
        if len(columns) == 1:
            unit_id, speeds = columns[0]
            for k in range(first, last):
                set_speed(unit_id, speeds[k])
                step()
                if colliding() and self._note_collisions():
                    return k + 1
            return 0
        for k in range(first, last):
            for unit_id, speeds in columns:
                set_speed(unit_id, speeds[k])
            step()
            if colliding() and self._note_collisions():
                return k + 1
        return 0

    def _note_collisions(self) -> int:
        """Write down trains that collide and did not before; returns the number of pairs."""
        pairs = (sorted((c.collider, c.victim)) for c in self._sumo.simulation.getCollisions())
        found = (pair for pair in pairs if self._lengths_m.keys() >= set(pair))
        new = {(one_id, other_id) for one_id, other_id in found} - self._collisions.keys()
        self._collisions |= dict.fromkeys(sorted(new), "")
        return len(new)

    def _tell(self) -> None:
        """Say where those are that have just collided."""
        for (one_id, other_id), text in self._collisions.items():
            if not text:
                told = text_of(one_id, self.truth(one_id), other_id, self.truth(other_id))
                self._collisions[one_id, other_id] = told

    def truth(self, unit_id: str) -> Truth:
        """Where the front is, as SUMO has it."""
        edge = self._sumo.vehicle.getRoadID(unit_id)
        return Truth(
            edge[:-1],
            DIRECTION[edge[-1]],
            self._sumo.vehicle.getLanePosition(unit_id),
            self._sumo.vehicle.getSpeed(unit_id),
        )

    def reroute(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Change what lies ahead."""
        self._sumo.vehicle.setRoute(unit_id, [edge_id(piece, direction) for piece in pieces])

    def reverse(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Change ends: SUMO turns the train in its next step; its own millimetre of overrun is then put back."""
        here = self._sumo.vehicle.getRoadID(unit_id)
        from_end_m = self._sumo.vehicle.getLanePosition(unit_id) - self._lengths_m[unit_id]
        edges = [edge_id(piece, direction) for piece in pieces]
        self._sumo.vehicle.setRoute(unit_id, [here, *edges])
        self._sumo.vehicle.setSpeed(unit_id, 0.0)
        lanes = [edge + "_0" for edge in edges]
        offset_m = self._sumo.lane.getLength(lanes[0]) - from_end_m
        while len(lanes) > 1 and offset_m > self._sumo.lane.getLength(lanes[0]):
            offset_m -= self._sumo.lane.getLength(lanes.pop(0))
        self._reversing.append((unit_id, lanes[0], offset_m))

    def remove(self, unit_id: str) -> None:
        """Take a train off the line."""
        self._sumo.vehicle.remove(unit_id)

    def collisions(self) -> tuple[str, ...]:
        """What SUMO's own check found."""
        return tuple(self._collisions.values())

    def close(self) -> None:
        """End the simulation. May be called more than once."""
        if self._open:
            self._open = False
            self._sumo.close()
