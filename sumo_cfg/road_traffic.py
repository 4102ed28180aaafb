"""A day's road vehicles as SUMO's own: types, routes, departures, and stops of those that stall on the crossing.

Nothing is left to SUMO's chance (`sigma` 0, each vehicle has its own share of the limit), so what a vehicle does
follows from what was drawn for it, from the signals and from those ahead of it.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from sumo_cfg.road_net import RoadAt, RoadPart, RoadWay

CAR: Final = "road-car"
HEAVY: Final = "road-heavy"
ROUND: Final = "-round"  # ending of the type of those that drive round a half barrier
LENGTH_M: Final[Mapping[str, float]] = {CAR: 4.5, HEAVY: 12.0}
WIDTH_M: Final = (
    1.8  # that is hit by a train: a car's; those of others are wider, and hit some 0.01 s earlier
)
DECIDE_S: Final = (
    "0.5"  # how often drivers change their pedals: a reaction time; it takes a quarter of SUMO's work away
)
ROUND_MPS: Final = 10.0 / 3.6
# SUMO's own passenger car and truck, but for `sigma` and the lorry's length.
_MOTION: Final[Mapping[str, dict[str, str]]] = {
    CAR: {"vClass": "passenger", "accel": "2.6", "decel": "4.5", "emergencyDecel": "9", "minGap": "2.5"},
    HEAVY: {"vClass": "truck", "accel": "1.3", "decel": "4", "emergencyDecel": "7", "minGap": "2.5"},
}
_NEVER: Final = "1000000"  # s


@dataclass(frozen=True, slots=True)
class RoadVehicle:
    """One passage. `stall_s`: how long it stands on the crossing; `patience_s`: until it drives round; 0: never."""

    id: str
    at: RoadAt
    way: RoadWay
    type_id: str
    depart_s: float
    speed_share: float  # of the limit
    stall_s: float = 0.0
    patience_s: float = 0.0

    @property
    def length_m(self) -> float:
        """From bumper to bumper."""
        return LENGTH_M[self.type_id]

    @property
    def free_s(self) -> float:
        """From where its front appears, its own length into the approach, to the end of the road, unhindered."""
        return (self.at.way_m - self.length_m) / self.free_mps

    @property
    def free_mps(self) -> float:
        """Its speed if nothing hinders it."""
        return self.speed_share * self.at.road.speed_mps


def stall_at_m(at: RoadAt, length_m: float) -> float:
    """How far over the stop line the front of a vehicle is that stands with its middle on the track, m."""
    return min(at.road.stop_line_m + length_m / 2.0, at.over_m)


def road_routes_xml(roads: Sequence[RoadAt], vehicles: Sequence[RoadVehicle]) -> bytes:
    """The route file: vehicles in order of their departure."""
    root = ET.Element("routes")
    for kind, motion in _MOTION.items():
        common = {
            **motion,
            "length": f"{LENGTH_M[kind]:g}",
            "sigma": "0",
            "speedDev": "0",
            "actionStepLength": DECIDE_S,
        }
        ET.SubElement(root, "vType", {"id": kind, **common})
        round_it = {"jmDriveAfterRedTime": _NEVER, "jmDriveRedSpeed": f"{ROUND_MPS:.3f}"}
        ET.SubElement(
            root, "vType", {"id": kind + ROUND, **common, **round_it, "maxSpeed": f"{ROUND_MPS:.3f}"}
        )
    for road in roads:
        for way in RoadWay:
            ET.SubElement(root, "route", id=_route(road, way), edges=" ".join(road.edges(way)))
    for vehicle in sorted(vehicles, key=lambda vehicle: (vehicle.depart_s, vehicle.id)):
        attributes = {
            "id": vehicle.id,
            "type": vehicle.type_id,
            "route": _route(vehicle.at, vehicle.way),
            "depart": f"{vehicle.depart_s:.1f}",
            "departLane": "best",
            "departSpeed": "max",
            "speedFactor": f"{vehicle.speed_share:.4f}",
            # The trains' option is none; a road vehicle waits until there is room for it.
            "insertionChecks": "all",
        }
        element = ET.SubElement(root, "vehicle", attributes)
        if vehicle.stall_s > 0.0:
            stop = {
                "lane": vehicle.at.lanes(vehicle.way, RoadPart.OVER)[0],
                "endPos": f"{stall_at_m(vehicle.at, vehicle.length_m):.2f}",
                "duration": f"{vehicle.stall_s:.1f}",
            }
            ET.SubElement(element, "stop", stop)
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def _route(road: RoadAt, way: RoadWay) -> str:
    return f"road.{road.crossing_id}.{way.value}"
