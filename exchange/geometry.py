"""Import of surveyed geometry: polyline and stations in degrees to a TOML fragment of a line file.

Reads the two JSON files of Seo-4d696b75/station_database (CC BY-SA 4.0): the track as GeoJSON line strings
and the list of stations. The polyline is projected to the plane (transverse Mercator about the line's middle,
GRS80), fitted by `exchange.curve_fit`, and the stations are projected on the fitted axis: kilometrage 0 is the
first one.

What the data does not hold is derived by rule and marked as assumed: speed limits of curves from the
customary basic speeds of 1067 mm gauge lines (50, 60, 65, 70, 75 km/h at radius 200, 250, 300, 350, 400 m;
3.7 sqrt(R) to the nearest 5 km/h gives them), and cant at equilibrium with that speed, at most 105 mm and at
most what the transition can bring up at 1 in 400.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from exchange.curve_fit import AxisFit, SampledAxis, chainage, fit_curves, points_at, sample_axis
from network.alignment import bearing_rad, curvature_table, positions
from network.errors import InputError
from network.files.json_input import read_json, write_aside
from network.files.names import TITLE_HELP, title_of
from network.files.toml_text import text_toml
from network.making.station_list import ONE_WAY
from network.model import Alignment, Curve, Direction, SpeedLimit

Floats = NDArray[np.float64]

SOURCE: Final = "Seo-4d696b75/station_database, CC BY-SA 4.0"
CANT_MAX_MM: Final = 105.0
CANT_STEP_MM: Final = 5.0
_RAIL_CENTRES_MM: Final = 1067.0  # the rule of 1067 mm gauge takes the gauge itself: C = 8.4 V^2 / R
_STATION_FAR_M: Final = 300.0
_BEYOND_M: Final = 300.0  # of track kept beyond the stations that are wanted
_STATION_FAR_DEG: Final = 10.0  # of the middle of the track: the plane is none so far out
_RELIEF_MIN_M: Final = 60.0  # a shorter gap between equal limits frees no train
CANT_RAMP_MAX: Final = 1.0 / 400.0
_DEVIATION_STEP_M: Final = 10.0
_TURN_M: Final = (
    240.0  # of track with its ends not a third of it apart turn back; a curve of 60 m radius does not
)
VERTICES_MAX: Final = 20_000  # assumed: one every 10 m
TWICE_MIN: Final = 2  # vertices that a track comes to twice when it goes back on itself; a loop has one
VERTEX_GAP_M_MAX: Final = 10_000.0  # assumed: on a straight; further apart a coordinate is wrong
TRACK_M_MAX: Final = 200_000.0  # assumed: what the fit is made for are branch lines
_BOTH: Final = (Direction.DOWN, Direction.UP)


_Part = tuple[str, list[tuple[float, float]]]  # key and coordinates of a feature


class _Geometry(msgspec.Struct):
    type: str
    coordinates: list[Annotated[list[float], msgspec.Meta(min_length=2)]]  # GeoJSON lets heights follow


class _Feature(msgspec.Struct):
    geometry: _Geometry


class _PolylineFile(msgspec.Struct):
    features: list[_Feature]


class SourceStation(msgspec.Struct):
    """A station of the source, in degrees; its name also in hiragana, where the source has that."""

    original_name: str
    lat: float
    lng: float
    name_kana: str = ""


class StationsFile(msgspec.Struct):
    """The source's stations of a line, in their order."""

    name: str
    station_list: list[SourceStation]


@dataclass(frozen=True, slots=True)
class StationPlace:
    """A station's foot on the axis: kilometrage and distance from the axis (positive right), m."""

    name_ja: str
    position_m: float
    offset_m: float


@dataclass(frozen=True, slots=True)
class ImportedGeometry:
    """What the two files say, as an alignment without gradients and coverage.

    `origin_lat_deg`, `origin_lon_deg` is the point (0, 0) of the plane; `rms_m` and `max_m` are the lateral
    distances between the alignment as written (rounded) and the polyline, sampled every 10 m; the largest is at
    `max_at_m` of the alignment.
    """

    name_ja: str
    alignment: Alignment
    stations: tuple[StationPlace, ...]
    origin_lat_deg: float
    origin_lon_deg: float
    rms_m: float
    max_m: float
    max_at_m: float


def curve_speed_kmh(radius_m: float) -> float:
    """Customary basic speed of a curve of 1067 mm gauge: 3.7 sqrt(R) to the nearest 5 km/h."""
    return 5.0 * round(3.7 * math.sqrt(abs(radius_m)) / 5.0)


def equilibrium_cant_mm(speed_kmh: float, radius_m: float) -> float:
    """Cant at which weight and centrifugal force balance, C = G V^2 / (127 R) with G = 1067 mm."""
    return _RAIL_CENTRES_MM * speed_kmh**2 / (127.0 * abs(radius_m))


def assumed_cant_mm(radius_m: float, transition_m: float, speed_max_kmh: float) -> float:
    """Equilibrium cant at the curve's limit in steps of 5 mm; at most 105 mm, and 1/400 of the transition."""
    speed_kmh = min(curve_speed_kmh(radius_m), speed_max_kmh)
    cant_mm = CANT_STEP_MM * round(equilibrium_cant_mm(speed_kmh, radius_m) / CANT_STEP_MM)
    ramp_mm = CANT_STEP_MM * math.floor(transition_m * 1000.0 * CANT_RAMP_MAX / CANT_STEP_MM)
    return min(CANT_MAX_MM, cant_mm, ramp_mm)


def curve_limits(curves: Sequence[Curve], speed_max_kmh: float) -> tuple[SpeedLimit, ...]:
    """Limits of the curves slower than the line, in whole metres; equal ones closer than a train are one."""
    limits: list[SpeedLimit] = []
    for curve in curves:
        speed_kmh = curve_speed_kmh(curve.radius_m)
        if speed_kmh >= speed_max_kmh:
            continue
        low_m, high_m = float(math.floor(curve.from_m)), float(math.ceil(curve.to_m))
        last = limits[-1] if limits else None
        if last and last.speed_mps == speed_kmh / 3.6 and low_m - last.to_m < _RELIEF_MIN_M:
            limits[-1] = replace(last, to_m=high_m)
            continue
        if last:
            low_m = max(low_m, last.to_m)
        limits.append(SpeedLimit(low_m, high_m, speed_kmh / 3.6, _BOTH))
    return tuple(limits)


def read_polyline(file: Path) -> Floats:
    """Vertices of the track, (n, 2) longitude and latitude in degrees. Raises InputError."""
    parts: list[_Part] = []
    for index, feature in enumerate(read_json(file, _PolylineFile).features):
        key = f"features[{index}].geometry"
        if feature.geometry.type != "LineString":
            raise InputError(str(file), f"{key}.type", feature.geometry.type, "LineString")
        if feature.geometry.coordinates:
            parts.append((key, [(east, north) for east, north, *_ in feature.geometry.coordinates]))
    points = _chained(str(file), parts)
    if len(points) > VERTICES_MAX:
        raise InputError(str(file), "features", len(points), f"at most {VERTICES_MAX} vertices")
    vertices = np.array(points, dtype=np.float64).reshape(-1, 2)
    if np.any(np.abs(vertices) > (180.0, 90.0)):
        raise InputError(str(file), "features", None, "longitude and latitude in degrees")
    moved = np.append(np.True_, np.any(np.diff(vertices, axis=0) != 0.0, axis=1))
    distinct: Floats = vertices[moved[: len(vertices)]]
    if len(distinct) < 3:
        raise InputError(str(file), "features", len(distinct), "a track of at least three vertices")
    _, first, count = np.unique(distinct, axis=0, return_index=True, return_counts=True)
    if np.count_nonzero(count > 1) >= TWICE_MIN:
        again = tuple(map(float, distinct[first[count > 1].min()]))
        raise InputError(str(file), "features", again, f"a track that goes each way once; {ONE_WAY}")
    return distinct


def _chained(file: str, parts: list[_Part]) -> list[tuple[float, float]]:
    """One line of parts that touch, in whatever order and direction they are given."""
    points = list(parts[0][1]) if parts else []
    waiting = parts[1:]
    while waiting:
        for part in waiting:
            if _attached(points, part[1]):
                waiting.remove(part)
                break
        else:
            key, coordinates = waiting[0]
            expected = f"a line that goes on at {points[-1]} or {points[0]}"
            leaves = [end for end in (coordinates[0], coordinates[-1]) if end in points]
            raise InputError(
                file, key, (leaves or coordinates)[:1], f"{expected}; {ONE_WAY}" if leaves else expected
            )
    return points


def _attached(points: list[tuple[float, float]], part: list[tuple[float, float]]) -> bool:
    """Put a part behind or before the points, where one of its ends touches theirs."""
    for way in (part, part[::-1]):
        if way[0] == points[-1]:
            points += way[1:]
            return True
        if way[-1] == points[0]:
            points[:0] = way[:-1]
            return True
    return False


def _names(table: StationsFile) -> Iterator[tuple[str, str]]:
    """What is written into the fragment, by key."""
    yield "name", table.name
    yield from (
        (f"station_list[{i}].original_name", row.original_name) for i, row in enumerate(table.station_list)
    )


def plane_projection(file: Path, lat_deg: float, lon_deg: float) -> Callable[[Floats], Floats]:
    """Transverse Mercator about a point: (n, 2) longitude, latitude to east, north in m.

    Raises InputError when pyproj is not installed.
    """
    try:
        from pyproj import Transformer
    except ImportError as error:
        raise InputError(str(file), "", None, "the extra branchline[net] (pyproj) to be installed") from error
    plane = f"+proj=tmerc +lat_0={lat_deg} +lon_0={lon_deg} +k=1 +x_0=0 +y_0=0 +ellps=GRS80 +units=m"
    transformer = Transformer.from_crs("EPSG:4326", plane, always_xy=True)

    def project(points: Floats) -> Floats:
        plane_m: Floats = np.column_stack(transformer.transform(points[:, 0], points[:, 1]))
        return plane_m

    return project


def read_stations(file: Path) -> StationsFile:
    """The stations of the source. Raises InputError."""
    table = read_json(file, StationsFile)
    for key, name in _names(table):
        if title_of(name) != name:
            raise InputError(str(file), key, name, TITLE_HELP)
    return table


def read_geometry(
    polyline_file: Path,
    stations_file: Path,
    *,
    begin_km: float | None = None,
    max_speed_kmh: float = 85.0,
    only: Sequence[int] | None = None,
) -> ImportedGeometry:
    """Read, project and fit. The alignment is prolonged straight to `begin_km` where that is given.

    `only` are indices of the stations that are wanted, in order along the line: the track is cut to what they need.
    Raises InputError for input that is not a track with stations along it.
    """
    vertices = read_polyline(polyline_file)
    table = read_stations(stations_file)
    rows = table.station_list if only is None else [table.station_list[i] for i in only]
    if len(rows) < 2:
        raise InputError(str(stations_file), "station_list", len(rows), "two or more stations")
    lows, highs = np.min(vertices, axis=0), np.max(vertices, axis=0)
    lon_deg, lat_deg = (float(np.round((float(lows[i]) + float(highs[i])) / 2.0, 4)) for i in (0, 1))
    project = plane_projection(polyline_file, lat_deg, lon_deg)
    track = project(vertices)
    _check_track(polyline_file, track)
    for row in rows:
        if max(abs(row.lat - lat_deg), abs(row.lng - lon_deg)) > _STATION_FAR_DEG:
            key = f"station_list[{table.station_list.index(row)}]"
            raise InputError(str(stations_file), key, row.original_name, "a station near the track")
    stops = project(np.array([(row.lng, row.lat) for row in rows]))
    if only is None:
        turned = math.dist(track[-1], stops[0]) < math.dist(track[0], stops[0])
    else:
        dense = points_at(np.arange(0.0, chainage(track)[-1], _DEVIATION_STEP_M), chainage(track), track)
        turned = _foot_m(dense, stops[0]) > _foot_m(dense, stops[-1])
    track = track[::-1] if turned else track
    if only is not None:
        track = _cut(track, stops)
    _check_turns(polyline_file, track, project(vertices), vertices)
    fit = fit_curves(track)
    if fit.max_m > _STATION_FAR_M:
        expected = (
            f"a track that an axis can be fitted to; the best one found lies up to {fit.max_m:.0f} m off"
        )
        raise InputError(str(polyline_file), "features", None, expected)
    at_m, offset_m = _fitted_axis(fit).nearest(stops)
    _check_stations(stations_file, table.station_list, rows, at_m, offset_m)
    zero_m = float(at_m[0])
    begin_m = -zero_m if begin_km is None else begin_km * 1000.0
    if begin_m > -zero_m:
        raise InputError(str(polyline_file), "begin_km", begin_km, f"at most {-zero_m / 1000.0:.3f}")
    alignment = _alignment(fit, zero_m, begin_m, max_speed_kmh)
    at, lateral = _laterals(alignment, track)
    worst = int(np.argmax(lateral))
    places = tuple(
        StationPlace(row.original_name, round(float(at) - zero_m), round(float(off), 1))
        for row, at, off in zip(rows, at_m, offset_m, strict=True)
    )
    rms_m, max_m = float(np.sqrt(np.mean(lateral**2))), float(lateral[worst])
    return ImportedGeometry(table.name, alignment, places, lat_deg, lon_deg, rms_m, max_m, float(at[worst]))


def import_geometry(polyline_file: Path, stations_file: Path, out_file: Path) -> ImportedGeometry:
    """`branchline import geometry`: write the TOML fragment that a line file is completed from.

    Raises InputError, for an output that cannot be written before the seconds that the fit takes.
    """
    if not out_file.parent.is_dir():
        raise InputError(str(out_file), "", None, "a writable path in an existing folder")
    imported = read_geometry(polyline_file, stations_file)
    write_aside(out_file, fragment(imported))
    return imported


def deviation(alignment: Alignment, track: Floats) -> tuple[float, float]:
    """Rms and largest lateral distance, m, of a polyline (n, 2) from an alignment, every 10 m."""
    _, lateral = _laterals(alignment, track)
    return float(np.sqrt(np.mean(lateral**2))), float(lateral.max())


def _laterals(alignment: Alignment, track: Floats) -> tuple[Floats, Floats]:
    """Kilometrages (m) of points every 10 m of a polyline (n, 2) on an alignment, and their distances from it."""
    along = chainage(track)
    points = points_at(np.arange(0.0, along[-1], _DEVIATION_STEP_M), along, track)
    at_m = np.arange(alignment.from_m, alignment.to_m, 4.0)
    places = positions(alignment, at_m)
    axis = SampledAxis(at_m, places[:, 0], places[:, 1], bearing_rad(alignment, at_m))
    feet_m, lateral = axis.nearest(points)
    return feet_m, np.abs(lateral)


def fragment(imported: ImportedGeometry) -> str:
    """The TOML fragment: alignment with curves and their limits, and the stations' kilometrages."""
    line = imported.alignment
    rows = [
        f"# {imported.name_ja}; geometry: {SOURCE}",
        f"# plane: transverse Mercator about {imported.origin_lat_deg} N {imported.origin_lon_deg} E, GRS80",
        f"# fit to the polyline: rms {imported.rms_m:.1f} m, largest {imported.max_m:.1f} m",
        "# assumed: transitions, cant (equilibrium, at most 105 mm), limits (3.7 sqrt(R) to 5 km/h)",
        "[[alignments]]",
        f'id = "{line.id}"',
        f"from_km = {_km(line.from_m)}",
        f"to_km = {_km(line.to_m)}",
        f"x_m = {line.x_m}",
        f"y_m = {line.y_m}",
        f"bearing_deg = {line.bearing_deg}",
        "curves = [",
        *(_curve_row(curve) for curve in line.curves),
        "]",
        "limits = [",
        *(_limit_row(limit) for limit in line.limits),
        "]",
    ]
    for station in imported.stations:
        rows += [
            "",
            "[[stations]]",
            f"name_ja = {text_toml(station.name_ja)}",
            f"km = {_km(station.position_m)}",
        ]
    return "\n".join(rows) + "\n"


def _curve_row(curve: Curve) -> str:
    return (
        f"  {{ from_km = {_km(curve.from_m)}, to_km = {_km(curve.to_m)}, radius_m = {curve.radius_m:.0f},"
        f" transition_m = {curve.transition_m:.3f}, cant_mm = {curve.cant_mm:.0f} }},"
    )


def _limit_row(limit: SpeedLimit) -> str:
    speed_kmh = limit.speed_mps * 3.6
    return f"  {{ from_km = {_km(limit.from_m)}, to_km = {_km(limit.to_m)}, speed_kmh = {speed_kmh:.0f} }},"


def _km(position_m: float) -> str:
    text = f"{position_m / 1000.0:.6f}".rstrip("0")
    return text + "0" if text.endswith(".") else text


def _fitted_axis(fit: AxisFit) -> SampledAxis:
    table = curvature_table(0.0, fit.length_m, fit.bearing_rad, fit.curves)
    return sample_axis(fit.east_m, fit.north_m, table, fit.length_m)


def _alignment(fit: AxisFit, zero_m: float, begin_m: float, speed_max_kmh: float) -> Alignment:
    """The fit as an alignment, rounded as it is written: a millimetre of curve turns it by microradians."""
    curves = tuple(
        replace(
            curve,
            from_m=round(curve.from_m - zero_m, 3),
            to_m=round(curve.to_m - zero_m, 3),
            transition_m=round(curve.transition_m, 3),
            cant_mm=assumed_cant_mm(curve.radius_m, curve.transition_m, speed_max_kmh),
        )
        for curve in (_ended(curve, fit.length_m) for curve in fit.curves)
        if curve.from_m < fit.length_m
    )
    ahead_m = begin_m + zero_m
    from_m = round(begin_m, 3) + 0.0  # no negative zero
    to_m = max([float(math.floor(fit.length_m - zero_m)), *(curve.to_m for curve in curves)])
    x_m = round(fit.east_m + ahead_m * math.sin(fit.bearing_rad), 3)
    y_m = round(fit.north_m + ahead_m * math.cos(fit.bearing_rad), 3)
    bearing_deg = round(math.degrees(fit.bearing_rad) % 360.0, 6)
    limits = tuple(
        replace(limit, from_m=max(limit.from_m, from_m), to_m=min(limit.to_m, to_m))
        for limit in curve_limits(curves, speed_max_kmh)
    )
    return Alignment("main", from_m, to_m, x_m, y_m, bearing_deg, 0.0, (), curves, limits, coverage=())


def _ended(curve: Curve, length_m: float) -> Curve:
    """A curve no longer than the track shows it: beyond its end only the transition back to straight."""
    to_m = min(curve.to_m, length_m + curve.transition_m)
    return replace(curve, to_m=to_m, transition_m=min(curve.transition_m, (to_m - curve.from_m) / 2.0))


def _check_track(file: Path, track: Floats) -> None:
    """A track in the plane, m, that is one: no jump in it, and not longer than a fit is made for."""
    steps_m = np.hypot(*np.diff(track, axis=0).T)
    if not np.all(np.isfinite(steps_m)) or np.any(steps_m > VERTEX_GAP_M_MAX):
        place = int(np.argmax(~np.isfinite(steps_m) | (steps_m > VERTEX_GAP_M_MAX)))
        expected = (
            f"vertices at most {VERTEX_GAP_M_MAX / 1000:g} km apart; after vertex {place} there is a jump"
        )
        raise InputError(str(file), "features", None, expected)
    if float(steps_m.sum()) > TRACK_M_MAX:
        raise InputError(str(file), "features", None, f"a track of at most {TRACK_M_MAX / 1000:g} km")


def _check_turns(file: Path, track: Floats, places: Floats, vertices: Floats) -> None:
    """A track in the plane, m, that does not turn back on itself: what is fitted to it would be longer by that.

    What an axis can be fitted through, a vertex or two beside the way, is left to the fit. `places`: its vertices in
    the plane, `vertices` in degrees, for the message.
    """
    along = chainage(track)
    at_m = np.arange(0.0, along[-1] - _TURN_M, _DEVIATION_STEP_M)
    ends = points_at(at_m + _TURN_M, along, track) - points_at(at_m, along, track)
    apart_m = np.hypot(ends[:, 0], ends[:, 1])
    if np.any(apart_m < _TURN_M / 3.0):
        tip = points_at(at_m[[np.argmin(apart_m)]] + _TURN_M / 2.0, along, track)[0]
        vertex = int(np.argmin(np.hypot(*(places - tip).T)))
        turns = "a track that does not turn back on itself, as here; one with a switchback is two lines"
        raise InputError(str(file), "features", tuple(map(float, vertices[vertex])), turns)


def _foot_m(track: Floats, place: Floats) -> float:
    """Chainage (m) of the vertex nearest a place."""
    return float(chainage(track)[int(np.argmin(np.hypot(*(track - place).T)))])


def _cut(track: Floats, stops: Floats) -> Floats:
    """The track from a little before the first station to a little beyond the last, in whole sides."""
    along = chainage(track)
    low_m, high_m = _foot_m(track, stops[0]) - _BEYOND_M, _foot_m(track, stops[-1]) + _BEYOND_M
    first = max(int(np.searchsorted(along, low_m, side="right")) - 1, 0)
    last = min(int(np.searchsorted(along, high_m)), len(track) - 1)
    return track[first : last + 1]


def _check_stations(
    file: Path, listed: Sequence[SourceStation], rows: Sequence[SourceStation], at_m: Floats, offset_m: Floats
) -> None:
    for index, (row, offset) in enumerate(zip(rows, offset_m, strict=True)):
        key = f"station_list[{listed.index(row)}]"
        if abs(float(offset)) > _STATION_FAR_M:
            expected = (
                f"a station within {_STATION_FAR_M:.0f} m of the track, not {abs(float(offset)):.0f} m off"
            )
            raise InputError(str(file), key, row.original_name, expected)
        if index and at_m[index] <= at_m[index - 1]:
            raise InputError(str(file), key, row.original_name, "stations in their order along the track")
