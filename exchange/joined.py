"""What is joined to a list of stations from files: the axis with its curves, gradients, limits."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Final

from pydantic import Field

from exchange.geometry import SOURCE, ImportedGeometry, SourceStation, read_geometry, read_stations
from network.errors import InputError
from network.files.kinds import ROWS_MAX
from network.files.line_schema import DIRECTIONS, GradientTable, LimitTable
from network.files.text_input import read_text
from network.files.toml_input import Record, validate
from network.making.crossing_list import CrossingListFile, CrossingRow, ListedCrossings
from network.making.kana import romanised
from network.making.station_list import ONE_WAY, ListedStation, StationList, csv_tables, number_of
from network.making.station_names import spellings
from network.model import Alignment, Direction, Gradient, SpeedLimit

REMARKABLE_FIT_M: Final = 20.0  # several times what the polylines of branch lines leave elsewhere
REMARKABLE_KM_M: Final = (
    250.0  # a chain of measuring and of moved zeros; the Karasuyama line differs by as much
)
_BOTH: Final = (Direction.DOWN, Direction.UP)


@dataclass(frozen=True, slots=True)
class StationsOnAxis:
    """Places of the stations (m) and the axis they lie on, with what is to be said of both."""

    places_m: tuple[float, ...]
    alignment: Alignment
    rows: tuple[str, ...]  # one for each station: what gave its place
    remarks: tuple[str, ...]
    sources: tuple[str, ...]
    assumed: tuple[str, ...]
    comment: tuple[str, ...]


class _Gradients(Record):
    gradients: Annotated[list[GradientTable], Field(min_length=1, max_length=ROWS_MAX)]


class _Limits(Record):
    limits: Annotated[list[LimitTable], Field(min_length=1, max_length=ROWS_MAX)]


def without_geometry(stations: StationList) -> StationsOnAxis:
    """Places as listed on a straight axis. Raises InputError for a station without kilometrage."""
    for station in stations.stations:
        if station.km is None and not _in_the_middle(stations, station):
            expected = "a kilometrage: there is no geometry to take it from"
            raise InputError(stations.file, f"{station.key}.km", None, expected)
    listed_m = {s.id: 1000.0 * s.km for s in stations.stations if s.km is not None}
    places_m = tuple(_place_m(stations, station, listed_m) for station in stations.stations)
    alignment = Alignment("main", places_m[0], places_m[-1], 0.0, 0.0, 90.0, 0.0, (), (), (), ())
    return StationsOnAxis(
        places_m,
        alignment,
        rows=tuple(
            f"{s.name} ({s.id}): km {at_m / 1000:.3f}, {'as listed' if s.id in listed_m else _how(stations, s)}"
            for s, at_m in zip(stations.stations, places_m, strict=True)
        ),
        remarks=(),
        sources=(),
        assumed=(
            "plan: one straight, because no geometry was joined; so there are no curves and no limits of curves",
            *_between(stations, listed_m),
        ),
        comment=(),
    )


def with_geometry(
    stations: StationList, polyline_file: Path, stations_file: Path, max_speed_kmh: float
) -> StationsOnAxis:
    """Stations on the axis that is fitted to a polyline. Raises InputError for one that has no place on it."""
    table = read_stations(stations_file)
    found = [_match(stations_file, station, table.station_list) for station in stations.stations]
    matched = [(station, at) for station, at in zip(stations.stations, found, strict=True) if at is not None]
    if len(matched) < 2:
        names = ", ".join(row.original_name for row in table.station_list)
        raise InputError(
            stations.file, "stations", len(matched), f"two or more stations of {stations_file}: {names}"
        )
    imported = read_geometry(
        polyline_file, stations_file, max_speed_kmh=max_speed_kmh, only=[at for _, at in matched]
    )
    first_m = imported.stations[0].position_m
    known = ((s, place) for (s, _), place in zip(matched, imported.stations, strict=True) if s.km is not None)
    zero_m = next((1000.0 * (s.km or 0.0) - place.position_m + first_m for s, place in known), 0.0)
    on_axis = {
        s.id: place.position_m + zero_m for (s, _), place in zip(matched, imported.stations, strict=True)
    }
    places_m = tuple(_place_m(stations, station, on_axis) for station in stations.stations)
    _check_order(stations, places_m)
    return _joined(stations, imported, on_axis, places_m, zero_m)


def read_gradients(file: Path, from_m: float, to_m: float) -> tuple[tuple[Gradient, ...], tuple[str, ...]]:
    """Gradients of a CSV (from_km, to_km, permille) from end to end of an axis, level in gaps; and remarks."""
    name = str(file)
    tables = csv_tables(
        read_text(file), name, ("from_km", "to_km", "permille"), ("from_km", "to_km", "permille")
    )
    rows = [
        {key: number_of(name, f"gradients[{i}].{key}", cell) for key, cell in table.items()}
        for i, table in enumerate(tables)
    ]
    entries = validate({"gradients": rows}, name, _Gradients).gradients
    found: list[Gradient] = []
    at_m = from_m
    cut = False
    for i, entry in enumerate(entries):
        key = f"gradients[{i}]"
        low_m, high_m = entry.from_km * 1000.0, entry.to_km * 1000.0
        if high_m <= low_m:
            raise InputError(name, f"{key}.to_km", entry.to_km, f"more than from_km = {entry.from_km}")
        if i and low_m < entries[i - 1].to_km * 1000.0 - 1e-3:
            expected = (
                f"at least {entries[i - 1].to_km}, where gradients[{i - 1}] ends (sorted, without overlap)"
            )
            raise InputError(name, f"{key}.from_km", entry.from_km, expected)
        if high_m <= from_m or low_m >= to_m:
            raise InputError(name, f"{key}.from_km", entry.from_km, _on_axis(from_m, to_m))
        cut = cut or low_m < from_m or high_m > to_m
        low_m, high_m = max(low_m, from_m), min(high_m, to_m)
        if low_m > at_m + 1e-3:
            found.append(Gradient(at_m, low_m, 0.0))
        found.append(Gradient(max(low_m, at_m), high_m, entry.permille))
        at_m = high_m
    if at_m < to_m - 1e-3:
        found.append(Gradient(at_m, to_m, 0.0))
    remarks = (f"{name}: what lies beyond the ends of the line is left out",) if cut else ()
    return tuple(found), remarks


def read_crossings(file: Path) -> ListedCrossings:
    """Level crossings of a CSV with the columns of `CrossingRow`, of which km alone is needed. Raises InputError."""
    name = str(file)
    tables = csv_tables(read_text(file), name, tuple(CrossingRow.model_fields), ("km",))
    rows = [
        {
            key: number_of(name, f"crossings[{i}].{key}", cell) if key in ("km", "width_m") else cell
            for key, cell in table.items()
        }
        for i, table in enumerate(tables)
    ]
    return ListedCrossings(name, tuple(validate({"crossings": rows}, name, CrossingListFile).crossings))


def read_limits(file: Path, from_m: float, to_m: float) -> tuple[tuple[SpeedLimit, ...], tuple[str, ...]]:
    """Limits of a CSV (from_km, to_km, speed_kmh and, where not both, directions) cut to an axis; and remarks."""
    name = str(file)
    columns = ("from_km", "to_km", "speed_kmh", "directions")
    rows: list[dict[str, object]] = []
    for i, table in enumerate(csv_tables(read_text(file), name, columns, columns[:3])):
        row: dict[str, object] = {
            key: number_of(name, f"limits[{i}].{key}", cell)
            for key, cell in table.items()
            if key != "directions"
        }
        if "directions" in table:
            words = table["directions"].replace(";", " ").split()
            row["directions"] = ["down", "up"] if words == ["both"] else words
        rows.append(row)
    found: list[SpeedLimit] = []
    cut = False
    for i, entry in enumerate(validate({"limits": rows}, name, _Limits).limits):
        key = f"limits[{i}]"
        low_m, high_m = entry.from_km * 1000.0, entry.to_km * 1000.0
        if high_m <= low_m:
            raise InputError(name, f"{key}.to_km", entry.to_km, f"more than from_km = {entry.from_km}")
        if high_m <= from_m or low_m >= to_m:
            raise InputError(name, f"{key}.from_km", entry.from_km, _on_axis(from_m, to_m))
        cut = cut or low_m < from_m or high_m > to_m
        directions = tuple(d for d in _BOTH if d in {DIRECTIONS[word] for word in entry.directions})
        found.append(SpeedLimit(max(low_m, from_m), min(high_m, to_m), entry.speed_kmh / 3.6, directions))
    remarks = (f"{name}: what lies beyond the ends of the line is left out",) if cut else ()
    return tuple(found), remarks


def joined_limits(derived: Iterable[SpeedLimit], given: Sequence[SpeedLimit]) -> tuple[SpeedLimit, ...]:
    """Limits given, and of the derived ones what these leave free: what is known counts before what is assumed."""
    free = list(derived)
    for limit in given:
        free = [part for rest in free for part in _without(rest, limit)]
    return tuple(sorted((*free, *given), key=lambda limit: (limit.from_m, limit.to_m)))


def prolonged_axis(alignment: Alignment, from_m: float, to_m: float) -> Alignment:
    """An axis that reaches at least so far, straight on at both ends."""
    ahead_m = max(0.0, alignment.from_m - from_m)
    bearing_rad = math.radians(alignment.bearing_deg)
    return replace(
        alignment,
        from_m=alignment.from_m - ahead_m,
        to_m=max(alignment.to_m, to_m),
        x_m=round(alignment.x_m - ahead_m * math.sin(bearing_rad), 3) + 0.0,
        y_m=round(alignment.y_m - ahead_m * math.cos(bearing_rad), 3) + 0.0,
    )


def _without(rest: SpeedLimit, limit: SpeedLimit) -> Iterable[SpeedLimit]:
    low_m, high_m = max(rest.from_m, limit.from_m), min(rest.to_m, limit.to_m)
    if low_m >= high_m:
        yield rest
        return
    if rest.from_m < low_m:
        yield replace(rest, to_m=low_m)
    unbound = tuple(direction for direction in rest.directions if direction not in limit.directions)
    if unbound:
        yield replace(rest, from_m=low_m, to_m=high_m, directions=unbound)
    if high_m < rest.to_m:
        yield replace(rest, from_m=high_m)


def _on_axis(from_m: float, to_m: float) -> str:
    return f"{from_m / 1000:.3f} to {to_m / 1000:.3f}, the range of the line"


def _match(file: Path, station: ListedStation, rows: Sequence[SourceStation]) -> int | None:
    """Which of the source's stations a listed one is: by Japanese name, else by the letters of its kana."""
    ours = {*spellings(station.name_ja), *spellings(station.name)}
    japanese, letters = (
        [set(spellings(name)) for name in names]
        for names in ([row.original_name for row in rows], [romanised(row.name_kana) for row in rows])
    )
    for theirs in (japanese, letters):
        fits = [i for i, theirs_here in enumerate(theirs) if ours & theirs_here]
        if len(fits) > 1:
            several = " and ".join(rows[i].original_name for i in fits)
            raise InputError(
                str(file), f"station_list[{fits[1]}]", several, f"one station that is {station.name}"
            )
        if fits:
            return fits[0]
    if station.km is None and station.has_platforms:
        name = station.name_ja or station.name
        names = [row.original_name for row in rows]
        near = difflib.get_close_matches(name, names, n=3, cutoff=0.3) or names
        raise InputError(
            str(file),
            "station_list",
            None,
            f"a station named {name} ({station.id}); it has {', '.join(near)}",
        )
    return None


def _place_m(stations: StationList, station: ListedStation, on_axis: dict[str, float]) -> float:
    """Place of a station; of one that the source lacks, between its neighbours as the listed kilometrages say."""
    if station.id in on_axis:
        return float(round(on_axis[station.id]))
    listed = stations.stations
    index = listed.index(station)
    if _in_the_middle(stations, station):
        beside_m = [_place_m(stations, listed[at], on_axis) for at in (index - 1, index + 1)]
        return float(round(sum(beside_m) / 2.0))
    known = [s for s in listed if s.id in on_axis and s.km is not None]
    below = next((s for s in reversed(known) if listed.index(s) < index), None)
    above = next((s for s in known if listed.index(s) > index), None)
    if station.km is None or (below is None and above is None):
        expected = "kilometrages of this station and of one that the geometry has"
        raise InputError(stations.file, f"{station.key}.km", station.km, expected)
    if below is None or above is None:
        near = below or above
        assert near is not None
        return float(round(on_axis[near.id] + 1000.0 * (station.km - (near.km or 0.0))))
    share = (station.km - (below.km or 0.0)) / ((above.km or 0.0) - (below.km or 0.0))
    return float(round(on_axis[below.id] + share * (on_axis[above.id] - on_axis[below.id])))


def _in_the_middle(stations: StationList, station: ListedStation) -> bool:
    """Of a signal station (信号場) it may be known only between which stations it is: in their middle, assumed."""
    index = stations.stations.index(station)
    beside = stations.stations[index - 1 : index + 2 : 2] if index else ()
    unplaced = [s for s in (station, *beside) if s.km is None and not s.has_platforms]
    return unplaced == [station] and len(beside) > 1


def _check_order(stations: StationList, places_m: Sequence[float]) -> None:
    for i in range(1, len(places_m)):
        if places_m[i] <= places_m[i - 1]:
            station, before = stations.stations[i], stations.stations[i - 1]
            expected = f"a place beyond {before.name} along the track; {ONE_WAY}"
            raise InputError(stations.file, f"{station.key}.km", station.km, expected)


def _how(stations: StationList, station: ListedStation) -> str:
    if _in_the_middle(stations, station):
        return "in the middle between its neighbours"
    return "from the list, between stations of the polyline"


def _between(stations: StationList, on_axis: dict[str, float]) -> Iterator[str]:
    lacking = [s for s in stations.stations if s.id not in on_axis]
    for how, is_middle in (
        ("not in the geometry, so by the list's kilometrages between neighbours", False),
        ("in the middle between the stations beside them, as nothing says where", True),
    ):
        if names := [s.name for s in lacking if _in_the_middle(stations, s) is is_middle]:
            yield f"places of {', '.join(names)}: {how}"


def _joined(
    stations: StationList,
    imported: ImportedGeometry,
    on_axis: dict[str, float],
    places_m: tuple[float, ...],
    zero_m: float,
) -> StationsOnAxis:
    fit = f"rms {imported.rms_m:.1f} m, worst {imported.max_m:.1f} m at km {(imported.max_at_m + zero_m) / 1000:.1f}"
    worst_remark = (
        (
            f"geometry: the fitted axis lies up to {imported.max_m:.0f} m from the polyline ({fit}): look at it there",
        )
        if imported.max_m > REMARKABLE_FIT_M
        else ()
    )
    listed = [s for s in stations.stations if s.km is not None and s.id in on_axis]
    apart = [(s, on_axis[s.id] - 1000.0 * (s.km or 0.0)) for s in listed]
    worst = max(apart, key=lambda item: abs(item[1]), default=None)
    km_remark = (
        (
            f"kilometrage: {worst[0].name} lies at km {on_axis[worst[0].id] / 1000:.3f} of the polyline, "
            f"{worst[1]:+.0f} m from the list; the polyline counts",
        )
        if worst is not None and abs(worst[1]) > REMARKABLE_KM_M
        else ()
    )
    rows = tuple(
        f"{s.name} ({s.id}): km {at_m / 1000:.3f}, "
        + ("as the polyline" if s.id in on_axis else _how(stations, s))
        for s, at_m in zip(stations.stations, places_m, strict=True)
    )
    assumed = (
        "kilometrage: along the axis fitted to the polyline, from the first station; official kilometrages differ",
        f"plan: straights and curves fitted to the polyline, {fit}; transitions of 42 m or a third of the curve, radii "
        "in round figures and 200 m at least, because a polyline does not resolve them",
        "cant: equilibrium at the curve's limit for 1067 mm gauge, at most 105 mm and 1/400 of the transition",
        *_between(stations, on_axis),
        *worst_remark,
        *km_remark,
    )
    alignment = imported.alignment
    moved = replace(
        alignment,
        from_m=alignment.from_m + zero_m,
        to_m=alignment.to_m + zero_m,
        curves=tuple(replace(c, from_m=c.from_m + zero_m, to_m=c.to_m + zero_m) for c in alignment.curves),
        limits=tuple(replace(x, from_m=x.from_m + zero_m, to_m=x.to_m + zero_m) for x in alignment.limits),
    )
    plane = (
        f"plane: transverse Mercator about {imported.origin_lat_deg} N {imported.origin_lon_deg} E (GRS80)"
    )
    return StationsOnAxis(
        places_m,
        moved,
        rows,
        (*worst_remark, *km_remark),
        (f"geometry and stations: {SOURCE}",),
        assumed,
        (plane,),
    )
