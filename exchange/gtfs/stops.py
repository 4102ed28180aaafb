"""The stops of a GTFS feed: stations, and platforms of them as their tracks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from exchange.gtfs.tables import Feed
from exchange.published import PublishedStation
from network.errors import InputError
from network.files.names import title_of
from network.making.station_names import is_japanese


@dataclass(frozen=True, slots=True)
class GtfsStop:
    """A place where a trip calls: its station (itself, where it has no parent), and its track, if that is named."""

    id: str
    name: str
    station: str
    track: str


@dataclass(frozen=True)
class GtfsStops(Mapping[str, GtfsStop]):
    """Stops by id, with the names that `translations.txt` has for them."""

    by_id: Mapping[str, GtfsStop]
    names: Mapping[str, Mapping[str, str]] = field(default_factory=dict[str, Mapping[str, str]])

    def __getitem__(self, key: str) -> GtfsStop:
        return self.by_id[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.by_id)

    def __len__(self) -> int:
        return len(self.by_id)

    def published(self, key: str) -> PublishedStation:
        """A station with its names in either writing, and the tracks that its stops name."""
        name = self.by_id[key].name
        others = self.names.get(key, {})
        japanese = name if is_japanese(name) else next((others[k] for k in others if k.startswith("ja")), "")
        latin = next((others[k] for k in others if k.startswith("en")), "") if is_japanese(name) else name
        tracks = sorted({stop.track for stop in self.by_id.values() if stop.station == key and stop.track})
        return PublishedStation(key, title_of(latin), title_of(japanese), tracks=tuple(tracks))


def read_stops(feed: Feed) -> GtfsStops:
    """Read stops and their translations. Raises InputError."""
    file = f"{feed.path}: stops.txt"
    rows: dict[str, tuple[int, str, str, str]] = {}
    for row in feed.rows("stops.txt", ("stop_id",), ("stop_name", "parent_station", "platform_code")):
        stop_id, name, parent, code = row.texts
        if not stop_id or stop_id in rows:
            raise InputError(file, f"line {row.line}.stop_id", stop_id, "an id of its own")
        rows[stop_id] = (row.line, name, parent, code)
    stops: dict[str, GtfsStop] = {}
    for stop_id, (line, name, parent, code) in rows.items():
        if parent and parent not in rows:
            raise InputError(file, f"line {line}.parent_station", parent, "a stop of the table")
        station = stop_id
        for _ in range(3):  # a boarding area lies on a platform, that in a station
            station = rows[station][2] or station
        stops[stop_id] = GtfsStop(stop_id, name or rows[station][1] or stop_id, station, code)
    return GtfsStops(stops, _translations(feed, stops))


def _translations(feed: Feed, stops: Mapping[str, GtfsStop]) -> dict[str, dict[str, str]]:
    """Names by stop id and language; a table names stops by id or by the name that is translated."""
    if not feed.has_table("translations.txt"):
        return {}
    wanted = ("table_name", "field_name", "language", "translation", "record_id", "field_value")
    found: dict[str, dict[str, str]] = {}
    for row in feed.rows("translations.txt", (), wanted):
        table, column, language, text, stop_id, name = row.texts
        if (table, column) != ("stops", "stop_name"):
            continue
        for key in [stop_id] if stop_id else [stop.id for stop in stops.values() if stop.name == name]:
            found.setdefault(key, {})[language.lower()] = text
    return found
