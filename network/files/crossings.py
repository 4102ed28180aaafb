"""`[[crossings]]` of a line file, checked against its tracks; the figures are those of the ministry's interpretation of
article 62 of the technical standards (鉄道に関する技術上の基準を定める省令の解釈基準, 踏切保安設備).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from network.errors import InputError
from network.files.line_schema import CrossingTable, LineFile
from network.model import (
    CrossingClass,
    CrossingControl,
    Direction,
    LevelCrossing,
    Piece,
)
from network.units import metres

CLOSING_S: Final = 15.0  # from the start of the warning to closed
CLOSED_S: Final = 20.0  # from closed to the train
WARNING_ALONE_S: Final = 30.0  # without barriers, from the start of the warning to the train
LEAST_CLOSING_S: Final = 10.0
LEAST_CLOSED_S: Final = 15.0
LEAST_WARNING_ALONE_S: Final = 20.0
LONG_S: Final = 60.0  # a longer warning is reported


def least_closed_s(crossing: LevelCrossing) -> float:
    """From closed to the train at least, s; without barriers it is closed from the start of the warning."""
    return LEAST_CLOSED_S if crossing.kind is CrossingClass.BARRIERS else LEAST_WARNING_ALONE_S


def least_warning_s(crossing: LevelCrossing) -> float:
    """From the start of the warning to the train at least, s."""
    alone = crossing.kind is CrossingClass.WARNING
    return LEAST_WARNING_ALONE_S if alone else LEAST_CLOSING_S + LEAST_CLOSED_S


def crossings_of(
    file: str, laid: Sequence[tuple[CrossingTable, Piece]], entry: LineFile
) -> dict[str, LevelCrossing]:
    """Crossings by id, each with the piece that its row names. InputError for one in a portal, in points or beside
    them, in a platform, for times under the least, a crossing that overlaps the end of its track, and contacts that are
    missing or not before it.
    """
    kinds = {section.id: section.kind for section in entry.sections}
    found: dict[str, LevelCrossing] = {}
    for i, (table, piece) in enumerate(laid):
        here = _crossing(file, f"crossings[{i}]", table, piece, kinds[piece.section_id], entry)
        for other in found.values():
            apart_m = (here.width_m + other.width_m) / 2.0
            if other.piece_id == piece.id and abs(here.position_m - other.position_m) < apart_m:
                raise InputError(file, f"crossings[{i}].km", table.km, f"a road clear of crossing {other.id}")
        found[here.id] = here
    return found


def _crossing(
    file: str, key: str, table: CrossingTable, piece: Piece, section_kind: str, entry: LineFile
) -> LevelCrossing:
    if table.id in {points.terminal for points in entry.points}:
        raise InputError(file, f"{key}.id", table.id, "an id that no terminal has")
    if section_kind in ("points", "portal"):
        where = "piece" if table.section is None else "section"
        expected = "a platform track or a section between stations: no crossing in points or a portal"
        raise InputError(file, f"{key}.{where}", table.piece or table.section, expected)
    middle_m, half_m = metres(table.km), table.width_m / 2.0
    if middle_m - half_m < piece.from_m or middle_m + half_m > piece.to_m:
        room_m = 2.0 * min(middle_m - piece.from_m, piece.to_m - middle_m)
        raise InputError(file, f"{key}.width_m", table.width_m, f"at most {room_m:g}, inside {piece.id}")
    for points in entry.points:  # of the track beside it: the road goes over both
        beside = (points.alignment or entry.alignments[0].id) == piece.alignment_id
        from_m, to_m = metres(points.from_km), metres(points.to_km)
        if beside and from_m < middle_m + half_m and middle_m - half_m < to_m:
            expected = f"a place clear of points {points.id}, {points.from_km:g} to {points.to_km:g}"
            raise InputError(file, f"{key}.km", table.km, expected)
    _check_platforms(file, f"{key}.km", table, piece, entry)
    kind, control = CrossingClass(table.kind), CrossingControl(table.control)
    closing_s, closed_s = _times(file, key, table, kind)
    crossing = LevelCrossing(
        table.id,
        table.name or table.id,
        kind,
        control,
        piece.id,
        middle_m,
        table.width_m,
        table.lowering_s,
        closing_s,
        closed_s,
        _contacts(table.start_down_km, table.start_up_km),
        _contacts(table.end_down_km, table.end_up_km),
        table.sight_m,
        table.detector,
        table.protection,
        table.departures,
    )
    _check_contacts(file, key, crossing)
    _check_road(file, key, table)
    if table.protection and not (crossing.has_device and control is CrossingControl.CONTACTS):
        expected = 'false, or control = "contacts" and a device: by radio a crossing proves itself closed'
        raise InputError(file, f"{key}.protection", True, expected)
    if table.departures and (
        table.protection or not (crossing.has_device and control is CrossingControl.CONTACTS)
    ):
        expected = 'false, or control = "contacts", a device, and no protection: whoever asks hears that it is closed'
        raise InputError(file, f"{key}.departures", True, expected)
    return crossing


def _check_platforms(file: str, key: str, table: CrossingTable, piece: Piece, entry: LineFile) -> None:
    """No road through a platform, on whichever track beside: a train that stands there would keep it closed."""
    axes = {section.id: section.alignment or entry.alignments[0].id for section in entry.sections}
    half_km = table.width_m / 2000.0
    for station in entry.stations:
        for track in station.tracks:
            from_km, to_km = track.platform_from_km, track.platform_to_km
            if from_km is None or to_km is None or axes.get(track.section) != piece.alignment_id:
                continue
            if from_km < table.km + half_km and table.km - half_km < to_km:
                expected = f"a place clear of the platform of {station.id}, {from_km:g} to {to_km:g}"
                raise InputError(file, key, table.km, f"{expected}: its trains would keep the road closed")


def _times(file: str, key: str, table: CrossingTable, kind: CrossingClass) -> tuple[float, float]:
    """From the start of the warning to closed, and from there to the train, s."""
    barriers = kind is CrossingClass.BARRIERS
    if not barriers and table.closing_s is not None:
        raise InputError(
            file, f"{key}.closing_s", table.closing_s, 'only where kind = "1": nothing else closes'
        )
    closing_s = (CLOSING_S if table.closing_s is None else table.closing_s) if barriers else 0.0
    usual_s, least_s = (CLOSED_S, LEAST_CLOSED_S) if barriers else (WARNING_ALONE_S, LEAST_WARNING_ALONE_S)
    closed_s = usual_s if table.closed_s is None else table.closed_s
    if barriers and closing_s < max(LEAST_CLOSING_S, table.lowering_s):
        expected = f"at least {LEAST_CLOSING_S:g} s, and lowering_s = {table.lowering_s:g}"
        raise InputError(file, f"{key}.closing_s", closing_s, expected)
    if closed_s < least_s:
        raise InputError(file, f"{key}.closed_s", closed_s, f"at least {least_s:g} s")
    return closing_s, closed_s


def _check_road(file: str, key: str, table: CrossingTable) -> None:
    """What looks at the road, and the road itself, belong to the crossing's class and lie within it."""
    barriers, road = CrossingClass(table.kind) is CrossingClass.BARRIERS, table.road
    if table.detector and not barriers:
        raise InputError(
            file, f"{key}.detector", True, 'false, or kind = "1": it looks while barriers are down'
        )
    if road is None:
        return
    if CrossingClass(table.kind) is CrossingClass.NO_DEVICE:
        expected = 'kind = "1" or "3": drivers stop for lamps and barriers, and there are none'
        raise InputError(file, f"{key}.road", None, expected)
    if road.half_barriers and not barriers:
        raise InputError(file, f"{key}.road.half_barriers", True, 'false, or kind = "1"')
    if road.width_m > table.width_m:
        expected = f"at least {road.width_m:g}: lanes = {road.lanes} each way"
        raise InputError(file, f"{key}.width_m", table.width_m, expected)


def _contacts(down_km: float | None, up_km: float | None) -> dict[Direction, float]:
    both = {Direction.DOWN: down_km, Direction.UP: up_km}
    return {direction: metres(km) for direction, km in both.items() if km is not None}


def _check_contacts(file: str, key: str, crossing: LevelCrossing) -> None:
    by_contacts = crossing.has_device and crossing.control is CrossingControl.CONTACTS
    for direction in Direction:
        name, start_m = direction.name.lower(), crossing.starts_m.get(direction)
        if by_contacts and start_m is None:
            raise InputError(
                file, f"{key}.start_{name}_km", None, f"a place: {name} trains start the warning by a contact"
            )
        edge_m, end_m = crossing.edge_m(direction), crossing.ends_m.get(direction)
        if start_m is not None and direction * (edge_m - start_m) <= 0.0:
            expected = f"a place before {edge_m / 1000.0:g}, as {name} trains run"
            raise InputError(file, f"{key}.start_{name}_km", start_m / 1000.0, expected)
        leaves_m = crossing.edge_m(direction.opposite)
        if end_m is not None and direction * (end_m - leaves_m) < 0.0:
            expected = f"a place from {leaves_m / 1000.0:g} on, as {name} trains run"
            raise InputError(file, f"{key}.end_{name}_km", end_m / 1000.0, expected)
