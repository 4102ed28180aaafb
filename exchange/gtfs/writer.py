"""A timetable of a line as a GTFS feed: a zip archive of the tables that GTFS asks for, the same bytes each time.

Each station is a stop with its tracks as platforms; each train a trip, each set a block. Where a train stands without
passengers, passes, or runs empty, nobody may get on or off (pickup_type and drop_off_type 1), and columns of our own
say which it is. What GTFS asks for and no timetable has (agency, dates, a place on the earth) is given, with stated
defaults.
"""

from __future__ import annotations

import csv
import io
import math
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from exchange.gtfs import columns
from exchange.gtfs.days import WEEKDAYS
from exchange.gtfs.exact import head_written
from exchange.timetable_writer import file_of_timetable
from network.alignment import positions
from network.clock import clock
from network.files.json_input import write_bytes_aside
from network.model import Direction, Line, Station
from network.timetable import Call, CallKind, Timetable, TimetableTrain, begins_text, ends_text, platform_of

AGENCY_URL: Final = "https://example.com/"  # no operator's: a reserved name
TIMEZONE: Final = "Asia/Tokyo"
FIRST_DATE: Final = 20260101
LAST_DATE: Final = 20261231
EVERY_DAY: Final = "1111111"
CENTRE: Final = (35.0, 135.0)  # the middle of Japan: where the plane of a line is put that nobody has placed
_SERVICE: Final = "DAY"
_RAIL: Final = "2"
# GRS80
_A_M: Final = 6_378_137.0
_E2: Final = 0.006_694_380_022_90
_EPOCH: Final = (1980, 1, 1, 0, 0, 0)  # of every file in the archive: the same timetable gives the same bytes


@dataclass(frozen=True, slots=True)
class FeedFacts:
    """What a feed needs beside line and timetable; `weekdays` are seven of 0 and 1 from Monday, dates YYYYMMDD.

    `centre` is latitude and longitude (degrees) of the point that the line's plane is laid out about.
    """

    agency: str = ""  # empty: the line's name
    url: str = AGENCY_URL
    timezone: str = TIMEZONE
    first_date: int = FIRST_DATE
    last_date: int = LAST_DATE
    weekdays: str = EVERY_DAY
    centre: tuple[float, float] = CENTRE


def write_gtfs(out: Path, line: Line, timetable: Timetable, facts: FeedFacts | None = None) -> dict[str, int]:
    """Write the feed whole or not at all; rows of each table by its name. Raises InputError where it cannot."""
    tables = tables_of(line, timetable, facts or FeedFacts())
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, rows in tables.items():
            text = io.StringIO()
            csv.writer(text, lineterminator="\r\n").writerows(rows)
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, text.getvalue().encode())
    write_bytes_aside(out, data.getvalue(), b"PK")
    return {name: len(rows) - 1 for name, rows in tables.items()}


def tables_of(line: Line, timetable: Timetable, facts: FeedFacts) -> dict[str, list[Sequence[str]]]:
    """The tables by name, each with its header first."""
    agency = facts.agency or line.name or line.id
    japanese = [(s.id, s.name_ja) for s in line.stations.values() if s.name_ja]
    head = head_written(file_of_timetable(timetable))
    tables: dict[str, list[Sequence[str]]] = {
        "agency.txt": [
            ("agency_id", "agency_name", "agency_url", "agency_timezone"),
            ("1", agency, facts.url, facts.timezone),
        ],
        "stops.txt": list(_stops(line, facts.centre)),
        "routes.txt": [
            ("route_id", "agency_id", "route_short_name", "route_long_name", "route_type"),
            (line.id, "1", "", line.name or line.id, _RAIL),
        ],
        "trips.txt": list(_trips(line, timetable)),
        "stop_times.txt": list(_stop_times(line, timetable)),
        "calendar.txt": [
            ("service_id", *WEEKDAYS, "start_date", "end_date"),
            (_SERVICE, *facts.weekdays, str(facts.first_date), str(facts.last_date)),
        ],
        "feed_info.txt": [
            ("feed_publisher_name", "feed_publisher_url", "feed_lang", "feed_version", columns.TIMETABLE),
            (agency, facts.url, "en", timetable.head.id, head),
        ],
    }
    if japanese:
        tables["translations.txt"] = [
            ("table_name", "field_name", "language", "translation", "record_id"),
            *(("stops", "stop_name", "ja", name, stop_id) for stop_id, name in japanese),
        ]
    return tables


def stop_of(station_id: str, track: str) -> str:
    """Id of the stop that a track is; a station has no space in its id, so no two are the same."""
    return f"{station_id} {track}"


def _stops(line: Line, centre: tuple[float, float]) -> Iterator[Sequence[str]]:
    yield ("stop_id", "stop_name", "stop_lat", "stop_lon", "location_type", "parent_station", "platform_code")
    for station in sorted(line.stations.values(), key=lambda station: station.position_m):
        place = _place(line, station, centre)
        name = station.name or station.name_ja or station.id
        yield (station.id, name, *place, "1", "", "")
        for track in station.tracks:
            yield (stop_of(station.id, track.name), name, *place, "0", station.id, track.name)


def _place(line: Line, station: Station, centre: tuple[float, float]) -> tuple[str, str]:
    """Latitude and longitude of a station on the axis of its first track, degrees."""
    alignment = line.alignments[line.pieces[station.tracks[0].piece_id].alignment_id]
    at_m = min(max(station.position_m, alignment.from_m), alignment.to_m)
    east_m, north_m, _ = positions(alignment, np.array([at_m]))[0].tolist()
    latitude, longitude = degrees_of(east_m, north_m, centre)
    return f"{latitude:.6f}", f"{longitude:.6f}"


def degrees_of(east_m: float, north_m: float, centre: tuple[float, float]) -> tuple[float, float]:
    """Latitude and longitude (degrees) of a point on the transverse Mercator plane about `centre` (GRS80).

    Terms to the second order in the distance east: within 1 m to 30 km (Snyder, Map Projections, 1987, eq. 8-17 f.).
    """
    latitude0 = math.radians(centre[0])
    latitude1 = latitude0 + north_m / _meridian_radius_m(latitude0)
    for _ in range(3):  # the radius changes along the way
        latitude1 = latitude0 + north_m / _meridian_radius_m((latitude0 + latitude1) / 2)
    across_m = _A_M / math.sqrt(1 - _E2 * math.sin(latitude1) ** 2)
    distance = east_m / across_m
    slope = math.tan(latitude1)
    latitude = latitude1 - across_m * slope / _meridian_radius_m(latitude1) * distance**2 / 2
    longitude = math.radians(centre[1]) + (distance - distance**3 / 6 * (1 + 2 * slope**2)) / math.cos(
        latitude1
    )
    return math.degrees(latitude), math.degrees(longitude)


def _meridian_radius_m(latitude: float) -> float:
    return _A_M * (1 - _E2) / math.pow(1 - _E2 * math.sin(latitude) ** 2, 1.5)


def _trips(line: Line, timetable: Timetable) -> Iterator[Sequence[str]]:
    blocks = {number: item.stock_id for item in timetable.diagrams for number in item.train_numbers}
    names = {station.id: station.name or station.name_ja or station.id for station in line.stations.values()}
    yield (
        *(
            "route_id",
            "service_id",
            "trip_id",
            "trip_short_name",
            "trip_headsign",
            "direction_id",
            "block_id",
        ),
        *(columns.REVENUE, columns.BEGINS, columns.ENDS),
    )
    for train in timetable.trains.values():
        yield (
            *(line.id, _SERVICE, train.number, train.number, names[train.calls[-1].station_id]),
            "0" if train.direction is Direction.DOWN else "1",
            blocks.get(train.number, ""),
            *("1" if train.revenue else "0", begins_text(train.begins), ends_text(train.ends)),
        )


def _stop_times(line: Line, timetable: Timetable) -> Iterator[Sequence[str]]:
    yield (
        *("trip_id", "arrival_time", "departure_time", "stop_id", "stop_sequence"),
        *("pickup_type", "drop_off_type", "timepoint", columns.CALL, columns.TIMES, columns.TRACK),
    )
    for train in timetable.trains.values():
        for i, call in enumerate(train.calls, start=1):
            yield _stop_time(line, train, call, i)


def _stop_time(line: Line, train: TimetableTrain, call: Call, sequence: int) -> Sequence[str]:
    """A row; GTFS wants both times, so one that was not planned is the other."""
    times = [clock(call.first_s), clock(call.last_s)]
    given = "departure" if call.arrival_s is None else "arrival" if call.departure_s is None else "both"
    platform = platform_of(line, call, train.direction)
    boards = train.revenue and call.kind is CallKind.STOP
    door = "0" if boards else columns.NO_PASSENGERS
    stop = stop_of(call.station_id, platform.name)
    return (
        train.number,
        *times,
        stop,
        str(sequence),
        door,
        door,
        columns.INFERRED if call.inferred else "1",
        call.kind.value,
        given,
        call.track or "",
    )
