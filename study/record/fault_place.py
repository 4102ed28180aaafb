"""Where on the line a fault is: stretches of kilometrage, or trains, whose place is wherever they run meanwhile."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from network.model import Line, Piece
from simulation.faults.cable import BETWEEN, WHOLE, CableFault
from simulation.faults.chargers import ChargerFault
from simulation.faults.crossing_road import CrossingRoadFault
from simulation.faults.crossings import CrossingFault
from simulation.faults.fault import Fault
from simulation.faults.lidar import MarkerMissing
from simulation.faults.links import DeadZone, LinkFault
from simulation.faults.points import PointsFault
from simulation.faults.tag_reader import TagFault
from study.record.marks import MarkPlace

TO_SEE_M = 60.0  # what is at one place is shown as so long a stretch


def place_of_fault(fault: Fault[Any], line: Line, unit_ids: Iterable[str]) -> MarkPlace:
    """Where a fault is. What is nowhere in particular, as the block manager is, is on the whole line."""
    if isinstance(fault, LinkFault):
        return _of_parties((fault.target.source, fault.target.destination), line, unit_ids)
    target = str(fault.target)
    match fault:
        case DeadZone():
            low_m, high_m = _around(_in_section(line, target))
            from_m = low_m + fault.from_share * (high_m - low_m)
            found = MarkPlace(stretches_m=((from_m, from_m + fault.length_m),))
        case CableFault():
            ends = target.split(BETWEEN)
            found = MarkPlace() if target == WHOLE else _over_m(line.stations[end].position_m for end in ends)
        case CrossingFault() | CrossingRoadFault():
            found = _at(line.crossings[target].position_m)
        case PointsFault():
            found = _over(piece for piece in line.pieces.values() if piece.points_id == target)
        case TagFault():
            found = _at(line.tags[int(target)].position_m)
        case MarkerMissing():
            found = _at(line.markers[int(target)].position_m)
        case ChargerFault():
            found = _over(line.pieces[track.piece_id] for track in line.stations[target].tracks)
        case _:
            found = _of_parties((target,), line, unit_ids)
    return found


def _of_parties(ids: Iterable[str], line: Line, unit_ids: Iterable[str]) -> MarkPlace:
    """The units among some parties; where there is none, the points of the terminals among them."""
    named = tuple(ids)
    units = tuple(unit_id for unit_id in unit_ids if unit_id in named)
    points = {points.id for points in line.points.values() if points.terminal_id in named}
    return MarkPlace(units=units) or _over(
        piece for piece in line.pieces.values() if piece.points_id in points
    )


def _in_section(line: Line, section_id: str) -> tuple[Piece, ...]:
    return tuple(line.pieces[piece_id] for piece_id in line.sections[section_id].piece_ids)


def _over(pieces: Iterable[Piece]) -> MarkPlace:
    """The stretch that some pieces cover, all branches of kilometrage taken as one; nowhere for none."""
    found = tuple(pieces)
    return MarkPlace(stretches_m=(_around(found),)) if found else MarkPlace()


def _over_m(places_m: Iterable[float]) -> MarkPlace:
    places = tuple(places_m)
    return MarkPlace(stretches_m=((min(places), max(places)),))


def _around(pieces: tuple[Piece, ...]) -> tuple[float, float]:
    return min(piece.from_m for piece in pieces), max(piece.to_m for piece in pieces)


def _at(place_m: float) -> MarkPlace:
    return MarkPlace(stretches_m=((place_m - TO_SEE_M / 2, place_m + TO_SEE_M / 2),))
