"""A day's trains as SUMO's own vehicles, without any unit of ours on board: types, routes and stops.

A vehicle is a set from where it comes onto the line to where it leaves it or is stabled. It stops at the marks, leaves
no earlier than planned, and runs slower when it is before its time (`speedFactorPremature`), so that the timetable
alone keeps trains apart. It changes ends in place, as its route goes on over the edge's way back.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from sumo_cfg.writer import document_of

ROUTES_XSD: Final = "http://sumo.dlr.de/xsd/routes_file.xsd"
CONFIG_XSD: Final = "http://sumo.dlr.de/xsd/sumoConfiguration.xsd"
STEP_S: Final = 0.5
SLOWEST_SHARE: Final = 0.05  # of its speed: a train before its time runs no slower
PASSING_SPEED_MPS: Final = 100.0  # above any train's
# Of eight sets in turn: told apart on paper and by eyes that do not see red and green alike (Okabe and Ito).
COLOURS: Final = (
    *("0,114,178", "213,94,0", "0,158,115", "204,121,167"),
    *("230,159,0", "86,180,233", "240,228,66", "90,90,90"),
)


@dataclass(frozen=True, slots=True)
class VehicleType:
    """A kind of train. `acceleration_mps2` is that of its start, `deceleration_mps2` of its full service brake."""

    id: str
    length_m: float
    speed_mps: float
    acceleration_mps2: float
    deceleration_mps2: float
    emergency_mps2: float


@dataclass(frozen=True, slots=True)
class VehicleStop:
    """A stop: `until_s` None where nothing is planned; `passes` where the train does not stand.

    `number` is the train that the set is from here on.
    """

    stop_id: str
    number: str
    arrival_s: float | None
    until_s: float | None
    duration_s: float
    passes: bool = False


@dataclass(frozen=True, slots=True)
class SumoVehicle:
    """A set from where it appears, `depart_m` into the first edge, to `arrive_m` on the last; None: to its end."""

    id: str
    type_id: str
    number: str
    depart_s: float
    depart_m: float
    edges: tuple[str, ...]
    stops: tuple[VehicleStop, ...]
    arrive_m: float | None


def routes_xml(types: Sequence[VehicleType], vehicles: Sequence[SumoVehicle]) -> bytes:
    """The route file: vehicles in order of their departure."""
    root = _root("routes", ROUTES_XSD)
    for kind in types:
        ET.SubElement(
            root,
            "vType",
            {
                "id": kind.id,
                "vClass": "rail",
                "length": f"{kind.length_m:g}",
                "maxSpeed": f"{kind.speed_mps:.3f}",
                "accel": f"{kind.acceleration_mps2:.3f}",
                "decel": f"{kind.deceleration_mps2:.3f}",
                "emergencyDecel": f"{kind.emergency_mps2:.3f}",
                "sigma": "0",
                "speedFactor": "1",
                "speedFactorPremature": f"{SLOWEST_SHARE:g}",
                "minGap": "1",
                "guiShape": "rail/railcar",
            },
        )
    colours = {vehicle.id.partition("#")[0]: "" for vehicle in vehicles}
    for index, name in enumerate(sorted(colours)):
        colours[name] = COLOURS[index % len(COLOURS)]
    for vehicle in sorted(vehicles, key=lambda vehicle: (vehicle.depart_s, vehicle.id)):
        element = ET.SubElement(
            root,
            "vehicle",
            {
                "id": vehicle.id,
                "type": vehicle.type_id,
                "line": vehicle.number,
                "depart": f"{vehicle.depart_s:.1f}",
                "departPos": f"{vehicle.depart_m:.3f}",
                "departSpeed": "0",
                # SUMO would keep a train out until all the way to the next rail signal is free, and there is none.
                "insertionChecks": "none",
                "arrivalPos": "max" if vehicle.arrive_m is None else f"{vehicle.arrive_m:.3f}",
                "color": colours[vehicle.id.partition("#")[0]],
            },
        )
        ET.SubElement(element, "route", edges=" ".join(vehicle.edges))
        for stop in vehicle.stops:
            ET.SubElement(element, "stop", _stop(stop))
    return document_of(root)


def config_xml(name: str, begin_s: float, end_s: float, routes: Sequence[str]) -> bytes:
    """The configuration that names net, route files and scenery, all called `name`. Signals, which crossings alone
    have, are off: nobody closes one here.
    """
    root = _root("sumoConfiguration", CONFIG_XSD)
    sections = {
        "input": {
            "net-file": f"{name}.net.xml",
            "route-files": ",".join(routes),
            "additional-files": f"{name}.add.xml",
        },
        "time": {"begin": f"{begin_s:.0f}", "end": f"{end_s:.0f}", "step-length": f"{STEP_S:g}"},
        "processing": {
            "step-method.ballistic": "true",
            "time-to-teleport": "-1",
            "collision.action": "warn",
            "default.speeddev": "0",
            "tls.all-off": "true",
        },
        # Without its own schemas at hand SUMO would warn that it checks nothing.
        "report": {
            "xml-validation": "never",
            "xml-validation.net": "never",
            "xml-validation.routes": "never",
            "no-step-log": "true",
            "duration-log.statistics": "true",
        },
    }
    for section, options in sections.items():
        element = ET.SubElement(root, section)
        for option, value in options.items():
            ET.SubElement(element, option, value=value)
    return document_of(root)


def _stop(stop: VehicleStop) -> dict[str, str]:
    attributes = {"trainStop": stop.stop_id, "tripId": stop.number, "line": stop.number}
    if stop.arrival_s is not None:
        attributes["arrival"] = f"{stop.arrival_s:.1f}"
    if stop.passes:
        # A way point: it is passed at any speed, and trains before their time come to it as slowly as to a stop.
        return attributes | {"speed": f"{PASSING_SPEED_MPS:g}", "duration": "0"}
    attributes["duration"] = f"{stop.duration_s:.1f}"
    if stop.until_s is not None:
        attributes["until"] = f"{stop.until_s:.1f}"
    return attributes


def _root(name: str, schema: str) -> ET.Element:
    return ET.Element(
        name,
        {
            "xmlns:xsi": "http://www.w3.org/2001/XMLSchema-instance",
            "xsi:noNamespaceSchemaLocation": schema,
        },
    )
