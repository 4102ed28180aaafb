"""Level crossings drawn onto a drawn line: by radio and by contacts, with barriers and without, some with a road.

Contacts lie on the open section of their crossing, so that every train passes the first of them, unless departures
warn.
"""

from typing import Any, Final

from network.model import Line, Piece, SectionKind
from tests.system.chaos.draw import Draw

ONE_P, TWO_P, ON_TRACK_P = 0.6, 0.25, 0.15
CONTACTS_P, DEPARTURES_P, WARNING_ALONE_P, ROAD_P, DETECTOR_P = 0.2, 0.3, 0.25, 0.3, 0.4
FROM_END_M: Final = 40.0
HALF_ROAD_M: Final = 5.0
ALONG_S: Final = 45.0  # from the first contact to the road at the line's speed
VEHICLES_PER_H: Final = (60.0, 240.0, 600.0)
Row = dict[str, Any]


def crossings_on(line: Line, speed_kmh: int, draw: Draw) -> list[Row]:
    """Rows of `[[crossings]]`: at least one."""
    rows: list[Row] = []
    for piece in line.pieces.values():
        kind, mine = line.sections[piece.section_id].kind, draw.of(piece.id)
        if kind is SectionKind.TRACK:
            count = int(mine.chance(ON_TRACK_P))
        elif kind in (SectionKind.POINTS, SectionKind.PORTAL):
            continue
        else:
            count = 1 + int(mine.of("two").chance(TWO_P)) if mine.chance(ONE_P) or not rows else 0
        rows += [
            _crossing(line, piece, f"C{len(rows) + k + 1}", speed_kmh, mine.of(str(k))) for k in range(count)
        ]
    return rows


def beside_platforms(line: Line, at_m: float) -> float:
    """The place itself, or beside the platform that lies there: a road goes over all tracks, and through none."""
    platforms = (t.platform_m for station in line.stations.values() for t in station.tracks if t.platform_m)
    over = [low_m for low_m, high_m in platforms if low_m - HALF_ROAD_M < at_m < high_m + HALF_ROAD_M]
    return round(over[0]) - 2.0 * HALF_ROAD_M if over else at_m


def _crossing(line: Line, piece: Piece, crossing_id: str, speed_kmh: int, draw: Draw) -> Row:
    at_m = beside_platforms(line, draw.between(piece.from_m + FROM_END_M, piece.to_m - FROM_END_M, 0))
    row: Row = {"id": crossing_id, "section": piece.section_id, "km": at_m / 1000.0}
    if draw.of("kind").chance(WARNING_ALONE_P):
        row |= {"kind": "3", "closed_s": draw.of("times").between(20.0, 40.0, 0)}
    else:
        times = draw.of("times")
        lowering_s = times.between(4.0, 10.0, 0)
        closing_s = times.between(max(10.0, lowering_s), 20.0, 0)
        row |= {"lowering_s": lowering_s, "closing_s": closing_s, "closed_s": times.between(15.0, 30.0, 0)}
        row |= {"detector": draw.of("detector").chance(DETECTOR_P)}
    way_m = round(ALONG_S * speed_kmh / 3.6)
    room = at_m - way_m > piece.from_m and at_m + way_m < piece.to_m
    departures = draw.of("departures").chance(DEPARTURES_P)
    if (room or departures) and draw.of("control").chance(CONTACTS_P):
        contacts: Row = {"start_down_km": (at_m - way_m) / 1000.0, "start_up_km": (at_m + way_m) / 1000.0}
        row |= {"control": "contacts", "departures": departures} | contacts
    if draw.of("road").chance(ROAD_P):
        row |= {"road": {"vehicles_per_h": [draw.of("vehicles").one_of(VEHICLES_PER_H)]}}
    return row
