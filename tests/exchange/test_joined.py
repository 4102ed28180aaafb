"""Stations joined to a track by name, gradients and limits joined from tables, and what is said of each."""

import json
from pathlib import Path

import pytest

from exchange.joined import joined_limits, prolonged_axis, read_gradients, read_limits
from exchange.new_line import NewLine, NewLineOptions, make_line
from network.errors import InputError
from network.making.kana import romanised
from network.model import Alignment, Curve, Direction, SpeedLimit

DOWN, UP = Direction.DOWN, Direction.UP
# 10 km due east at 36.6 N, where a degree of longitude is some 89.5 km
TRACK = [[140.0 + i * 0.002, 36.6] for i in range(57)]
PLACES = (("甲", "こう", 140.0), ("乙", "おつ", 140.03), ("丙", "へい", 140.07), ("丁", "ちょう", 140.11))


@pytest.fixture
def geometry(tmp_path: Path) -> tuple[Path, Path]:
    pytest.importorskip("pyproj")
    polyline, stations = tmp_path / "polyline.json", tmp_path / "stations.json"
    feature = {"geometry": {"type": "LineString", "coordinates": TRACK}}
    polyline.write_text(json.dumps({"features": [feature]}), "utf-8")
    rows = [{"original_name": n, "name_kana": kana, "lng": lng, "lat": 36.6002} for n, kana, lng in PLACES]
    stations.write_text(json.dumps({"name": "試験線", "station_list": rows}), "utf-8")
    return polyline, stations


def table(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "table.csv"
    path.write_text(text, "utf-8")
    return path


def joined(tmp_path: Path, geometry: tuple[Path, Path], text: str) -> NewLine:
    path = table(tmp_path, text)
    return make_line(path, "joined", NewLineOptions(polyline=geometry[0], stations_geometry=geometry[1]))


def test_places_come_from_the_track_by_name_in_either_script(
    tmp_path: Path, geometry: tuple[Path, Path]
) -> None:
    new = joined(tmp_path, geometry, "name,tracks\n甲,1\nOtsu,2\nChō,1\n")
    east_m = 89_500.0
    assert [s.position_m for s in new.line.stations.values()] == pytest.approx(
        [0.0, 0.03 * east_m, 0.11 * east_m], rel=0.01
    )
    assert new.rows[1].endswith("as the polyline")
    assert new.remarks == ()
    assert "CC BY-SA 4.0" in new.text


def test_a_list_the_other_way_round_turns_the_track(tmp_path: Path, geometry: tuple[Path, Path]) -> None:
    new = joined(tmp_path, geometry, "name\n丁\n乙\n")
    assert [s.name for s in new.line.stations.values()] == ["丁", "乙"]
    assert new.line.stations["S02"].position_m == pytest.approx(0.08 * 89_500.0, rel=0.01)
    assert new.line.alignments["main"].bearing_deg == pytest.approx(270.0, abs=1.0)


def test_a_station_that_the_track_lacks_lies_where_the_list_says_between_its_neighbours(
    tmp_path: Path, geometry: tuple[Path, Path]
) -> None:
    new = joined(tmp_path, geometry, "name,km\n甲,10\nNova,12\n丙,16.2\n丁,20\n")
    places = {s.name: s.position_m for s in new.line.stations.values()}
    assert places["甲"] == 10_000.0  # the list says where counting begins
    assert places["Nova"] == pytest.approx(10_000.0 + (places["丙"] - 10_000.0) * 2.0 / 6.2, abs=1.0)
    assert any("Nova" in text for text in new.line.assumed)
    assert any("丁 lies at km 19.8" in text for text in new.remarks) is (abs(places["丁"] - 20_000.0) > 250.0)


def test_the_first_kilometrage_that_is_known_says_where_counting_begins(
    tmp_path: Path, geometry: tuple[Path, Path]
) -> None:
    new = joined(tmp_path, geometry, "name,km\n甲,\n乙,12.7\n丁,19.9\n")
    places = {s.name: s.position_m for s in new.line.stations.values()}
    assert places["乙"] == pytest.approx(12_700.0, abs=1.0)
    assert not any("lies at km" in text for text in new.remarks)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name\n甲\nNova\n丁\n", r"a station named Nova \(NOV\); it has"),
        ("name\nFoo\nBar\n", "a station named Foo"),
        ("name,km\n甲,0\nNova,1\n", "two or more stations of"),
        ("name\n甲\n丙\n乙\n", "stations in their order along the track"),
        ("name,km\n甲,\nNova,1\n丁,\n", "kilometrages of this station and of one that the geometry has"),
    ],
)
def test_stations_without_a_place_are_named(
    tmp_path: Path, geometry: tuple[Path, Path], text: str, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        joined(tmp_path, geometry, text)


def test_a_signal_station_of_which_only_the_neighbours_are_known_lies_in_their_middle(
    tmp_path: Path, geometry: tuple[Path, Path]
) -> None:
    new = joined(tmp_path, geometry, "name,tracks,kind\n甲,1,\nMiddle,2,signal station\n乙,1,\n丁,1,\n")
    places = {s.name: s.position_m for s in new.line.stations.values()}
    assert places["Middle"] == pytest.approx((places["甲"] + places["乙"]) / 2.0, abs=1.0)
    assert any(text.startswith("places of Middle: in the middle") for text in new.line.assumed)


def test_a_list_without_geometry_may_leave_out_where_a_signal_station_is(tmp_path: Path) -> None:
    path = table(tmp_path, "name,km,tracks,kind\nAsa,0,2,\nMiddle,,2,signal station\nBato,6,2,\n")
    new = make_line(path, "listed", NewLineOptions())
    assert [s.position_m for s in new.line.stations.values()] == [0.0, 3000.0, 6000.0]
    assert any(text.startswith("Middle (MDD): km 3.000, in the middle") for text in new.rows)


@pytest.mark.parametrize(
    "rows",
    [
        "Asa,0,2,\nOne,,2,signal station\nTwo,,2,signal station\nBato,6,2,\n",
        "Asa,,2,signal station\nBato,6,2,\nChu,9,2,\n",
        "Asa,0,2,\nMiddle,,2,station\nBato,6,2,\n",
    ],
    ids=["two", "at the end", "a station"],
)
def test_others_of_which_nobody_says_where_they_are_are_refused(tmp_path: Path, rows: str) -> None:
    path = table(tmp_path, f"name,km,tracks,kind\n{rows}")
    with pytest.raises(InputError, match="a kilometrage: there is no geometry"):
        make_line(path, "listed", NewLineOptions())


def test_a_poor_fit_is_remarked_on(tmp_path: Path, geometry: tuple[Path, Path]) -> None:
    spike = [[140.05595, 36.6], [140.056, 36.6004], [140.05605, 36.6]]  # one vertex 44 m to the north
    bent = [*TRACK[:28], *spike, *TRACK[29:]]
    feature = {"geometry": {"type": "LineString", "coordinates": bent}}
    geometry[0].write_text(json.dumps({"features": [feature]}), "utf-8")
    new = joined(tmp_path, geometry, "name\n甲\n丁\n")
    assert any("from the polyline" in text and "km 5.0" in text for text in new.remarks)
    assert any("from the polyline" in text for text in new.line.assumed)


def test_one_file_of_the_geometry_is_not_enough(tmp_path: Path) -> None:
    path = table(tmp_path, "name,km\nA,0\nB,3\n")
    with pytest.raises(InputError, match="--stations-geometry"):
        make_line(path, "x", NewLineOptions(polyline=path))


def test_gradients_are_level_in_gaps_and_cut_at_the_ends(tmp_path: Path) -> None:
    path = table(tmp_path, "from_km,to_km,permille\n-1,1,5\n2,3.5,-12.5\n3.5,9,2\n")
    found, remarks = read_gradients(path, 0.0, 8000.0)
    assert [(g.from_m, g.to_m, g.permille) for g in found] == [
        (0.0, 1000.0, 5.0),
        (1000.0, 2000.0, 0.0),
        (2000.0, 3500.0, -12.5),
        (3500.0, 8000.0, 2.0),
    ]
    assert len(remarks) == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("from_km,to_km,permille\n", "gradients"),
        ("from_km,to_km\n0,1\n", "a column permille"),
        ("from_km,to_km,permille\n0,1,500\n", r"gradients\[0\].permille is 500"),
        ("from_km,to_km,permille\n1,1,5\n", r"gradients\[0\].to_km is 1.0; expected more than"),
        ("from_km,to_km,permille\n0,2,5\n1,3,5\n", r"gradients\[1\].from_km is 1.0; expected at least 2.0"),
        ("from_km,to_km,permille\n20,30,5\n", r"0.000 to 8.000, the range of the line"),
        ("from_km,to_km,permille\n0,x,5\n", "'x'; expected a number"),
    ],
)
def test_gradients_that_are_none_are_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_gradients(table(tmp_path, text), 0.0, 8000.0)


def test_limits_have_directions(tmp_path: Path) -> None:
    text = "from_km,to_km,speed_kmh,directions\n1,2,36,\n2,3,54,up\n3,4,18,down up\n"
    found, _ = read_limits(table(tmp_path, text), 0.0, 8000.0)
    assert [(x.speed_mps, x.directions) for x in found] == [
        (10.0, (DOWN, UP)),
        (15.0, (UP,)),
        (5.0, (DOWN, UP)),
    ]
    with pytest.raises(InputError, match=r"limits\[0\].directions"):
        read_limits(table(tmp_path, "from_km,to_km,speed_kmh,directions\n1,2,36,left\n"), 0.0, 8000.0)


def test_a_limit_that_is_known_counts_before_a_derived_one() -> None:
    derived = [SpeedLimit(1000.0, 2000.0, 15.0, (DOWN, UP))]
    known = [SpeedLimit(1200.0, 1500.0, 20.0, (DOWN, UP)), SpeedLimit(1800.0, 3000.0, 18.0, (DOWN,))]
    assert joined_limits(derived, known) == (
        SpeedLimit(1000.0, 1200.0, 15.0, (DOWN, UP)),
        known[0],
        SpeedLimit(1500.0, 1800.0, 15.0, (DOWN, UP)),
        SpeedLimit(1800.0, 2000.0, 15.0, (UP,)),
        known[1],
    )


def test_a_line_says_that_limits_of_a_file_count_before_those_of_stubs(tmp_path: Path) -> None:
    """The last 30 km/h are gone, and what stands in `assumed` does not leave it at that."""
    path = table(tmp_path, "name,km\nA,0\nB,5\n")
    limits = tmp_path / "limits.csv"
    limits.write_text("from_km,to_km,speed_kmh\n-1,6,60\n", "utf-8")
    made = make_line(path, "x", NewLineOptions(limits=limits)).line
    assert {limit.speed_mps for limit in made.alignments["main"].limits} == {60 / 3.6}
    assert (
        "limits of the file: where it has any they count, and not those of curves and stubs" in made.assumed
    )


def test_an_axis_is_prolonged_straight_on() -> None:
    axis = Alignment(
        "main", 0.0, 100.0, 10.0, 20.0, 90.0, 0.0, (), (Curve(5.0, 90.0, 300.0, 20.0, 0.0),), (), ()
    )
    longer = prolonged_axis(axis, -50.0, 70.0)
    assert (longer.from_m, longer.to_m) == (-50.0, 100.0)
    assert (longer.x_m, longer.y_m) == pytest.approx((-40.0, 20.0))


@pytest.mark.parametrize(
    ("kana", "letters"),
    [
        ("きさらづ", "kisarazu"),
        ("くるり", "kururi"),
        ("しろみがおか", "shiromigaoka"),
        ("ほっこく", "hokkoku"),
        ("まっちゃ", "matcha"),
        ("じゅうじょう", "juujou"),
        ("りょうごく", "ryougoku"),
    ],
)
def test_kana_in_hepburn_letters(kana: str, letters: str) -> None:
    assert romanised(kana) == letters
