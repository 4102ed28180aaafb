"""Fitting known axes, the real polyline, and what happens to input that is no track."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from exchange.curve_fit import chainage, find_curves, fit_curves, sample_axis, snap_radius
from exchange.geometry import (
    ImportedGeometry,
    assumed_cant_mm,
    curve_limits,
    curve_speed_kmh,
    deviation,
    equilibrium_cant_mm,
    fragment,
    import_geometry,
    plane_projection,
    read_geometry,
    read_polyline,
)
from network.alignment import curvature_table, positions
from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.files.toml_input import Record, parse_toml
from network.model import Curve
from tests.nightly import others_nightly

SHARED = Path(__file__).resolve().parents[2] / "../shared/data/geometry"
POLYLINE, STATIONS = SHARED / "polyline_11334.json", SHARED / "line_11334.json"
needs_shared = pytest.mark.skipif(
    not POLYLINE.exists(), reason="the geometry data is not beside this checkout"
)

KNOWN = (
    Curve(400.0, 700.0, 300.0, 42.0, 0.0),
    Curve(1000.0, 1250.0, -400.0, 42.0, 0.0),
    Curve(1600.0, 1900.0, 600.0, 42.0, 0.0),
)


def known_vertices(spacing_m: float = 25.0, noise_m: float = 0.0) -> NDArray[np.float64]:
    """Vertices of a known axis 2400 m long, shaken by `noise_m`."""
    axis = sample_axis(100.0, -50.0, curvature_table(0.0, 2400.0, 0.3, KNOWN), 2400.0)
    at_m = np.arange(0.0, 2400.1, spacing_m)
    points = np.column_stack([np.interp(at_m, axis.along_m, v) for v in (axis.east_m, axis.north_m)])
    return points + np.random.default_rng(7).normal(0.0, noise_m, points.shape) if noise_m else points


def deflection(curve: Curve) -> float:
    return (curve.to_m - curve.from_m - curve.transition_m) / curve.radius_m


def test_known_axis_is_found_again() -> None:
    fit = fit_curves(known_vertices())
    assert [c.radius_m for c in fit.curves] == pytest.approx([300.0, -400.0, 600.0], rel=0.05)
    assert [deflection(c) for c in fit.curves] == pytest.approx([deflection(c) for c in KNOWN], abs=0.01)
    assert fit.rms_m < 0.3
    assert fit.length_m == pytest.approx(2400.0, abs=1.0)
    assert math.degrees(fit.bearing_rad) == pytest.approx(math.degrees(0.3), abs=0.2)


def test_noise_of_a_metre_leaves_the_axis_within_a_metre() -> None:
    fit = fit_curves(known_vertices(noise_m=1.0))
    truth = sample_axis(100.0, -50.0, curvature_table(0.0, 2400.0, 0.3, KNOWN), 2400.0)
    table = curvature_table(0.0, fit.length_m, fit.bearing_rad, fit.curves)
    fitted = sample_axis(fit.east_m, fit.north_m, table, fit.length_m)
    _, lateral = truth.nearest(np.column_stack((fitted.east_m, fitted.north_m)))
    assert np.sqrt(np.mean(lateral**2)) < 1.0


def test_straight_track_has_no_curves() -> None:
    vertices = np.column_stack((np.arange(0.0, 2000.0, 50.0), np.zeros(40)))
    assert find_curves(vertices).shape == (0, 3)
    fit = fit_curves(vertices)
    assert fit.curves == ()
    assert fit.bearing_rad == pytest.approx(math.pi / 2)
    assert fit.max_m < 1e-6


def test_projection_gives_kilometrage_and_side() -> None:
    axis = sample_axis(0.0, 0.0, curvature_table(0.0, 1000.0, 0.0, ()), 1000.0)
    at_m, right_m = axis.nearest(np.array([[5.0, 300.0], [-7.0, 912.3]]))
    assert at_m == pytest.approx([300.0, 912.3])
    assert right_m == pytest.approx([5.0, -7.0])


def test_chainage_of_a_right_angle() -> None:
    assert chainage(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 10.0]])) == pytest.approx([0.0, 5.0, 11.0])


@pytest.mark.parametrize(
    ("fitted_m", "set_out_m"), [(296.0, 300.0), (120.0, 200.0), (1234.0, 1250.0), (2349.0, 2300.0)]
)
def test_radii_are_round_figures(fitted_m: float, set_out_m: float) -> None:
    assert snap_radius(fitted_m) == set_out_m


@pytest.mark.parametrize(
    ("radius_m", "speed_kmh"), [(200, 50), (250, 60), (-300, 65), (350, 70), (400, 75), (500, 85), (600, 90)]
)
def test_basic_speeds_of_curves(radius_m: float, speed_kmh: float) -> None:
    assert curve_speed_kmh(radius_m) == speed_kmh


@pytest.mark.parametrize("radius_m", range(200, 1000, 10))
def test_cant_deficiency_is_within_60_mm_on_a_full_transition(radius_m: int) -> None:
    # 60 mm is the usual bound of ordinary trains on 1067 mm gauge
    speed_kmh = min(85.0, curve_speed_kmh(radius_m))
    cant_mm = assumed_cant_mm(radius_m, 42.0, 85.0)
    assert 0.0 < cant_mm <= 105.0
    assert -5.0 <= equilibrium_cant_mm(speed_kmh, radius_m) - cant_mm <= 60.0


def test_cant_is_what_the_transition_brings_up() -> None:
    assert assumed_cant_mm(300.0, 20.0, 85.0) == 50.0


def test_equal_limits_closer_than_a_train_become_one() -> None:
    curves = [Curve(100.4, 300.0, 300.0, 42.0, 0.0), Curve(330.0, 500.2, -300.0, 42.0, 0.0)]
    limits = curve_limits(curves, 85.0)
    assert [(x.from_m, x.to_m) for x in limits] == [(100.0, 501.0)]
    assert limits[0].speed_mps == pytest.approx(65 / 3.6)
    assert curve_limits(curves, 65.0) == ()


# Fitting a real line takes ten seconds, so it is done by night; known axes, and long ones, are fitted in every run.
@pytest.fixture(scope="module")
def imported() -> ImportedGeometry:
    if not POLYLINE.exists():
        pytest.skip("the geometry data is not beside this checkout")
    pytest.importorskip("pyproj")
    return read_geometry(POLYLINE, STATIONS, begin_km=-1.0)


@pytest.mark.nightly
def test_karasuyama_polyline_is_reproduced(imported: ImportedGeometry) -> None:
    assert imported.rms_m < 2.0
    assert imported.max_m < 12.0


@pytest.mark.nightly
def test_karasuyama_is_as_long_as_the_sources_say(imported: ImportedGeometry) -> None:
    # 20.39 km is the sum between the stations of the source, 20.4 km the official length
    assert imported.stations[0].position_m == 0.0
    assert imported.stations[-1].position_m == pytest.approx(20_390.0, rel=0.01)
    assert [s.name_ja for s in imported.stations][::7] == ["宝積寺", "烏山"]
    official_m = [0, 3900, 5900, 8300, 12_700, 15_300, 17_500, 20_400]
    assert [s.position_m for s in imported.stations] == pytest.approx(official_m, abs=250.0)


@pytest.mark.nightly
def test_stations_lie_beside_the_axis(imported: ImportedGeometry) -> None:
    assert max(abs(s.offset_m) for s in imported.stations) < 15.0


@pytest.mark.nightly
def test_shipped_geometry_is_what_the_importer_makes(imported: ImportedGeometry) -> None:
    line, made = load_line(shipped_line("karasuyama")), imported.alignment
    main = line.alignments["main"]
    made_m = [s.position_m for s in imported.stations]
    assert made_m == pytest.approx([s.position_m for s in line.stations.values()], abs=2.0)
    assert [s.name_ja for s in imported.stations] == [s.name_ja for s in line.stations.values()]
    assert len(main.curves) == len(made.curves)
    # radii of short curves may hang on the last digits of a platform; the place of the track does not
    at_m = np.arange(main.from_m, min(main.to_m, made.to_m), 25.0)
    apart_m = np.hypot(*(positions(main, at_m) - positions(made, at_m))[:, :2].T)
    assert apart_m.max() < 2.0
    project = plane_projection(POLYLINE, imported.origin_lat_deg, imported.origin_lon_deg)
    rms_m, max_m = deviation(main, project(read_polyline(POLYLINE)))
    assert rms_m < 2.0
    assert max_m < 12.0


class _Any(Record):
    alignments: list[Any]
    stations: list[Any]


@needs_shared
@pytest.mark.nightly
def test_fragment_is_written_as_toml(tmp_path: Path, imported: ImportedGeometry) -> None:
    entry = parse_toml(fragment(imported), "fragment", _Any)
    assert len(entry.stations) == 8
    rows = entry.alignments[0]["curves"]
    assert [row["radius_m"] for row in rows] == [c.radius_m for c in imported.alignment.curves]
    out_file = tmp_path / "missing" / "out.toml"
    with pytest.raises(InputError, match="a writable path"):
        import_geometry(POLYLINE, STATIONS, out_file)


def write(tmp_path: Path, name: str, data: object) -> Path:
    path = tmp_path / name
    path.write_text(data if isinstance(data, str) else json.dumps(data), encoding="utf-8")
    return path


def polyline(*parts: list[list[float]], kind: str = "LineString") -> dict[str, object]:
    return {"features": [{"geometry": {"type": kind, "coordinates": part}} for part in parts]}


A, B, C, D = [140.0, 36.6], [140.01, 36.6], [140.02, 36.601], [140.03, 36.602]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ("{", "valid JSON"),
        ({"features": 3}, "features"),
        (polyline([A, B, C], kind="Point"), r"geometry.type is 'Point'; expected LineString"),
        (polyline([A, B], [C, D]), r"a line that goes on at \(140.01, 36.6\) or \(140.0, 36.6\)$"),
        (
            polyline([A, B, C], [B, D]),
            r"is \[\[140.01, 36.6\]\]; .* a line has no branches: one is a line of its own",
        ),
        (
            polyline([A, B, C, B, A]),
            r"is \[140.0, 36.6\]; expected a track that goes each way once; a line has no branch",
        ),
        (polyline([A, B]), "at least three vertices"),
        (polyline([A, A, A, A]), "features is 1; expected a track of at least three vertices"),
        (polyline([]), "features is 0; expected a track of at least three vertices"),
        (polyline([[36.6, 140.0], [36.6, 140.01], [36.6, 140.02]]), "longitude and latitude in degrees"),
        (polyline([A, B, [500.0, 36.0]]), "longitude and latitude"),
    ],
)
def test_polyline_that_is_none_is_refused(tmp_path: Path, data: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_polyline(write(tmp_path, "polyline.json", data))


def test_missing_file_is_an_input_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="a readable file"):
        read_polyline(tmp_path / "none.json")


def test_parts_are_joined(tmp_path: Path) -> None:
    path = write(tmp_path, "polyline.json", polyline([A, B], [B, C, D]))
    assert read_polyline(path).tolist() == [A, B, C, D]
    path = write(tmp_path, "polyline.json", polyline([[*A, 12.5], B], [B, [*C, 30.0], D]))
    assert read_polyline(path).tolist() == [A, B, C, D]  # heights may follow, which no figure comes of


@pytest.mark.parametrize(
    "parts", [([C, D], [A, B], [B, C]), ([B, A], [B, C], [D, C]), ([B, C], [B, A], [C, D])]
)
def test_parts_are_joined_in_whatever_order_and_direction_they_lie(
    tmp_path: Path, parts: tuple[list[list[float]], ...]
) -> None:
    got = read_polyline(write(tmp_path, "polyline.json", polyline(*parts))).tolist()
    assert got in ([A, B, C, D], [D, C, B, A])


def test_of_some_stations_only_their_part_of_the_track_is_taken(tmp_path: Path) -> None:
    pytest.importorskip("pyproj")
    row = [[140.0 + 0.002 * i, 36.6] for i in range(60)]
    table = stations(row[2], row[20], row[40], row[57])
    track, places = write(tmp_path, "p.json", polyline(row)), write(tmp_path, "s.json", table)
    got = read_geometry(track, places, only=(2, 1))  # and the other way round
    assert [s.name_ja for s in got.stations] == ["S2", "S1"]
    assert got.stations[1].position_m == pytest.approx(20 * 0.002 * 89_500.0, rel=0.01)
    assert got.alignment.to_m - got.alignment.from_m < got.stations[1].position_m + 4 * 300.0


def winding(curves: int, seed: int = 3) -> tuple[tuple[Curve, ...], float]:
    """Curves of a long winding track, and its length, m."""
    chance = np.random.default_rng(seed)
    made: list[Curve] = []
    at_m = 300.0
    for i in range(curves):
        length_m = float(chance.uniform(180.0, 420.0))
        radius_m = float(chance.uniform(250.0, 600.0)) * (-1.0 if i % 2 else 1.0)
        made.append(Curve(at_m, at_m + length_m, radius_m, 42.0, 0.0))
        at_m += length_m + float(chance.uniform(60.0, 500.0))
    return tuple(made), at_m + 300.0


@pytest.mark.parametrize("count", others_nightly([16, 44], [16]))
def test_a_long_winding_track_is_followed_to_its_end(count: int) -> None:
    """Many curves: fitted all at once the far end swings away; block by block each goes on from the last."""
    curves, length_m = winding(count)
    axis = sample_axis(0.0, 0.0, curvature_table(0.0, length_m, 0.4, curves), length_m)
    at_m = np.arange(0.0, length_m, 30.0)
    points = np.column_stack([np.interp(at_m, axis.along_m, v) for v in (axis.east_m, axis.north_m)])
    fit = fit_curves(points + np.random.default_rng(5).normal(0.0, 0.5, points.shape))
    assert fit.max_m < 15.0
    assert fit.length_m == pytest.approx(float(at_m[-1]), rel=0.002)
    assert sum(deflection(c) for c in fit.curves) == pytest.approx(
        sum(deflection(c) for c in curves), abs=0.1
    )


def test_a_track_that_no_axis_follows_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pyproj")
    lost = replace(fit_curves(known_vertices()), max_m=312.0)
    monkeypatch.setattr("exchange.geometry.fit_curves", lambda track: lost)
    track = write(tmp_path, "p.json", polyline([A, B, C, D]))
    with pytest.raises(InputError, match="the best one found lies up to 312 m off"):
        read_geometry(track, write(tmp_path, "s.json", stations(A, D)))


def test_a_curve_that_turns_far_may_be_sharp() -> None:
    assert snap_radius(157.0) == 200.0
    assert snap_radius(157.0, math.radians(30.0)) == 200.0
    assert snap_radius(157.0, math.radians(120.0)) == 160.0
    assert snap_radius(40.0, math.radians(120.0)) == 100.0


def stations(*places: list[float]) -> dict[str, object]:
    rows = [{"original_name": f"S{i}", "lng": lng, "lat": lat} for i, (lng, lat) in enumerate(places)]
    return {"name": "line", "station_list": rows}


@pytest.mark.parametrize(
    ("places", "begin_km", "message"),
    [
        ([A], None, "two or more stations"),
        ([A, [140.01, 36.7]], None, "a station within 300 m of the track"),
        ([A, C, B], None, "stations in their order"),
        ([B, C], 1.0, "begin_km is 1.0; expected at most"),
        ([A, [-40.0, 36.0]], None, r"station_list\[1\] is 'S1'; expected a station near the track"),
    ],
)
def test_stations_that_do_not_fit_are_refused(
    tmp_path: Path, places: list[list[float]], begin_km: float | None, message: str
) -> None:
    pytest.importorskip("pyproj")
    track = write(tmp_path, "polyline.json", polyline([A, B, C, D]))
    table = write(tmp_path, "stations.json", stations(*places))
    with pytest.raises(InputError, match=message):
        read_geometry(track, table, begin_km=begin_km)


def test_a_track_with_a_jump_is_none(tmp_path: Path) -> None:
    """One wrong digit would have the fit sample half the earth."""
    pytest.importorskip("pyproj")
    track = write(tmp_path, "polyline.json", polyline([A, B, [100.0, 36.0], C, D]))
    with pytest.raises(InputError, match="at most 10 km apart; after vertex 1"):
        read_geometry(track, write(tmp_path, "stations.json", stations(A, D)))


ALONG = [[140.0 + 0.001 * i, 36.6 + 0.00002 * i * i] for i in range(31)]  # 2.7 km with a vertex every 90 m
BACK = [[140.015, 36.6045], [140.018, 36.6054], [140.0151, 36.6046]]  # 280 m too far, and back
ZIGZAG = [[lon + 0.0003 * (-1) ** i, lat + 0.0006 * (-1) ** i] for i, (lon, lat) in enumerate(ALONG)]
TURNS_BACK = r"features is .140.01.*expected a track that does not turn back"


@pytest.mark.parametrize(
    ("track", "message"),
    [
        ([*ALONG[:15], *BACK, *ALONG[16:]], TURNS_BACK),
        ([*ALONG[:15], ALONG[18], *ALONG[15:]], TURNS_BACK),
        ([*ALONG[:15], ALONG[16], ALONG[15], *ALONG[17:]], TURNS_BACK),
        (ZIGZAG[:9], "a track that an axis can be fitted to"),
    ],
    ids=["a spike", "a vertex too soon", "two vertices in the wrong order", "from side to side"],
)
def test_a_track_that_turns_back_on_itself_is_refused_where_it_does(
    tmp_path: Path, track: list[list[float]], message: str
) -> None:
    """In a long track an axis is fitted to some of these as well, and has that way in its length."""
    pytest.importorskip("pyproj")
    file = write(tmp_path, "polyline.json", polyline(track))
    with pytest.raises(InputError, match=message):
        read_geometry(file, write(tmp_path, "stations.json", stations(ALONG[1], ALONG[7])))


def test_doubled_vertices_change_nothing(tmp_path: Path) -> None:
    pytest.importorskip("pyproj")
    table = write(tmp_path, "stations.json", stations(ALONG[1], ALONG[9]))
    doubled = [place for place in ALONG[:11] for _ in range(2)]
    once, twice = (
        read_geometry(write(tmp_path, f"{len(track)}.json", polyline(track)), table)
        for track in (ALONG[:11], doubled)
    )
    assert once == twice


def test_a_name_that_would_break_the_fragment_is_refused(tmp_path: Path) -> None:
    table = stations(A, D)
    table["name"] = "line\n[line]"
    track = write(tmp_path, "polyline.json", polyline([A, B, C, D]))
    with pytest.raises(InputError, match=r"name is .*expected one line"):
        read_geometry(track, write(tmp_path, "stations.json", table))


def test_track_is_turned_to_its_first_station(tmp_path: Path) -> None:
    pytest.importorskip("pyproj")
    track = write(tmp_path, "polyline.json", polyline([D, C, B, A]))
    got = read_geometry(track, write(tmp_path, "stations.json", stations(A, D)))
    assert got.stations[-1].position_m > 2000.0
    assert got.alignment.bearing_deg == pytest.approx(90.0, abs=1.0)
    assert math.copysign(1.0, got.alignment.from_m) == 1.0


def test_a_long_side_with_two_stations_on_it_is_turned_too(tmp_path: Path) -> None:
    """Both are nearer to its one end than to any other vertex."""
    pytest.importorskip("pyproj")
    track = write(tmp_path, "polyline.json", polyline([[140.06, 36.6], [140.03, 36.6], A]))
    table = stations([140.005, 36.6], [140.012, 36.6])
    got = read_geometry(track, write(tmp_path, "stations.json", table), only=(0, 1))
    assert got.stations[1].position_m == pytest.approx(0.007 * 89_500.0, rel=0.01)


def test_a_track_that_begins_and_ends_in_curves_has_their_limits_within_it(tmp_path: Path) -> None:
    """A limit is in whole metres, and the track is not: a line file takes none that reaches beyond its alignment."""
    pytest.importorskip("pyproj")
    turned = np.concatenate((np.linspace(-1.0, 0.0, 30), np.zeros(20), np.linspace(0.0, 1.0, 30)))
    sides = np.column_stack((np.sin(turned) / 89_500.0, np.cos(turned) / 111_000.0)) * 10.0
    row = (np.array([140.0, 36.6]) + np.vstack(([0.0, 0.0], np.cumsum(sides, axis=0)))).tolist()
    table = write(tmp_path, "stations.json", stations(row[4], row[-5]))
    line = read_geometry(write(tmp_path, "polyline.json", polyline(row)), table).alignment
    assert len(line.limits) == 2
    assert line.limits[0].from_m == line.from_m
    assert line.limits[-1].to_m == line.to_m
