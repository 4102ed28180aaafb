"""What becomes of a layout: a station list, JSON, and what keeps it from being a line."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from exchange.layout import (
    ForeignLayout,
    LayoutCrossing,
    LayoutNode,
    LayoutStation,
    LayoutTrack,
    NodeKind,
    Spot,
)
from exchange.layout_text import as_dict, obstacles, station_list_toml, stations_in_order
from exchange.new_line import NewLineOptions, make_line
from exchange.railml import read_railml
from network.errors import InputError
from network.model import CrossingClass, CrossingControl, Line
from tests.exchange.layouts import RAILML_2, RAILML_3


def small(tmp_path: Path, text: str = RAILML_2) -> ForeignLayout:
    path = tmp_path / "small.xml"
    path.write_text(text, "utf-8")
    return read_railml(path)


def layout(
    tracks: tuple[LayoutTrack, ...], stations: tuple[LayoutStation, ...], nodes: tuple[LayoutNode, ...] = ()
) -> ForeignLayout:
    ids = {end for track in tracks for end in (track.low_node, track.high_node)}
    nodes = nodes or tuple(LayoutNode(name, NodeKind.OPEN) for name in sorted(ids))
    return ForeignLayout("L", "made by hand", nodes, tracks, (), stations, (), (), (), (), ())


def track(name: str, low: str, high: str, from_m: float, to_m: float) -> LayoutTrack:
    return LayoutTrack(
        name, name, "main", low, high, to_m - from_m, (), ((0.0, from_m), (to_m - from_m, to_m))
    )


def station(name: str, position_m: float | None, *spots: Spot) -> LayoutStation:
    return LayoutStation(name, "", name, position_m, spots)


def test_a_list_has_names_kilometrage_tracks_and_ends(tmp_path: Path) -> None:
    listed = [tomllib.loads(station_list_toml(small(tmp_path, text))) for text in (RAILML_2, RAILML_3)]
    for table in listed:
        assert table["line"]["name"] == "Small"
        assert table["stations"] == [
            {"name": "Birch", "id": "BIR", "km": 1.2, "tracks": 2, "track_names": "1 2", "end": "portal"},
            {"name": "Cedar", "km": 1.9},
        ]
    assert any(text.startswith("left out: 1 derailer") for text in listed[0]["line"]["assumed"])


def test_a_single_line_with_a_loop_can_be_a_line(tmp_path: Path) -> None:
    assert obstacles(small(tmp_path)) == ()


def test_what_is_in_the_way_is_named(tmp_path: Path) -> None:
    double = layout(
        (track("1", "a", "b", 0, 900), track("2", "c", "d", 0, 900)), (station("A", 10), station("B", 800))
    )
    assert obstacles(double) == (
        "2 tracks side by side between A and B, at km 0.405: a line is single between stations",
    )
    one = layout((track("1", "a", "b", 0, 900),), (station("A", 10), station("nowhere", None)))
    assert obstacles(one) == ("1 station with a name and a kilometrage: a line has two at least",)
    crossing = small(
        tmp_path, RAILML_3.replace('id="s1" type="ordinarySwitch"', 'id="s1" type="doubleSwitchCrossing"')
    )
    assert any("1 crossing or slip (km 1.000)" in text for text in obstacles(crossing))
    ring = layout((track("1", "a", "a", 0, 900),), (station("A", 10), station("B", 800)))
    assert obstacles(ring) == ("track 1 comes back to where it begins: a line has two ends",)
    jump = LayoutTrack("1", "1", "", "a", "b", 900, (), ((0, 0), (300, 300), (300, 350), (900, 950)))
    jumping = layout((jump,), (station("A", 10), station("B", 800)))
    assert obstacles(jumping) == (
        "the kilometrage jumps from km 0.300 to 0.350 on track 1: an alignment's runs on metre for metre",
    )


def test_of_two_stations_at_one_place_or_of_one_name_the_first_stays() -> None:
    names = [
        s.name
        for s in stations_in_order(
            layout((), (station("B", 20.0), station("A", 10.0), station("C", 20.0), station("A", 30.0)))
        )
    ]
    assert names == ["A", "B"]


def test_names_that_toml_must_escape_stay_what_they_are() -> None:
    odd = 'Say "Ha\\n" \x7f 駅'
    text = station_list_toml(layout((), (station(odd, 1.0), station("Z", 2.0))))
    assert tomllib.loads(text)["stations"][0]["name"] == 'Say "Ha\\n"  駅'


def test_json_has_all_of_the_layout(tmp_path: Path) -> None:
    table = json.loads(json.dumps(as_dict(small(tmp_path))))
    assert {entry["length_m"] for entry in table["tracks"]} == {1000.0, 400.0, 600.0, 404.0}
    assert {entry["name"] for entry in table["points"]} == {"P1", "P2"}
    assert table["stations"][0]["position_m"] == 1200.0
    assert "1 derailer" in table["left"]


def test_level_crossings_go_into_the_list_where_one_track_lies_and_from_there_onto_the_line(
    tmp_path: Path,
) -> None:
    """At km 2.4, on the one track between A and B. Not those over two tracks, beyond B and without a kilometrage."""
    tracks = (
        track("1", "a", "b", 0, 3000),
        track("2", "b", "c", 3000, 3200),
        track("3", "b", "c", 3000, 3200),
        track("4", "c", "d", 3200, 6200),
        LayoutTrack("5", "5", "", "d", "e", 100.0),
    )
    crossings = (
        LayoutCrossing("Mill lane", "1", 2400.0, CrossingClass.WARNING),
        LayoutCrossing("", "2", 100.0, None),
        LayoutCrossing("", "4", 2950.0, CrossingClass.BARRIERS),
        LayoutCrossing("", "5", 50.0, None),
    )
    drawn = replace(layout(tracks, (station("A", 200), station("B", 6000))), crossings=crossings)
    text = station_list_toml(drawn)
    assert tomllib.loads(text)["crossings"] == [{"km": 2.4, "name": "Mill lane", "kind": "3"}]
    assert "# 3 level crossings left out" in text
    (tmp_path / "stations.toml").write_text(text, "utf-8")
    line = make_line(tmp_path / "stations.toml", "l", NewLineOptions()).line
    (crossing,) = line.crossings.values()
    assert (crossing.id, crossing.name, crossing.position_m) == ("X1", "Mill lane", 2400.0)
    assert (crossing.kind, crossing.control) == (CrossingClass.WARNING, CrossingControl.RADIO)
    assert as_dict(drawn)["level_crossings"][0] == ["Mill lane", "1", 2400.0, "3"]


def test_stations_that_the_list_leaves_out_are_said() -> None:
    """One at the place of another, one of its name, one without kilometrage; beside them two tracks side by side."""
    tracks = (track("1", "a", "b", 0, 3000), track("2", "a", "b", 0, 3000))
    stations = (
        station("A", 200),
        station("A2", 200),
        station("B", 2800),
        station("A", 900),
        station("C", None),
    )
    text = station_list_toml(layout(tracks, stations))
    assert [row["name"] for row in tomllib.loads(text)["stations"]] == ["A", "B"]
    assert (
        "# 3 stations left out, without a name or kilometrage, or with those of another: A2, A, C\n" in text
    )
    (said,) = tomllib.loads(text)["line"]["assumed"]
    assert said.startswith("left out: 2 tracks side by side between A and B, at km 1.500")


LIST = "name,km,tracks\nA,0.2,1\nB,3.0,2\nC,6.0,1\n"


def made_with(tmp_path: Path, crossings: str, stations: str = LIST) -> Line:
    (tmp_path / "stations.csv").write_text(stations, "utf-8")
    (tmp_path / "crossings.csv").write_text(crossings, "utf-8")
    options = NewLineOptions(crossings=tmp_path / "crossings.csv")
    return make_line(tmp_path / "stations.csv", "l", options).line


def test_a_line_is_made_with_a_list_of_crossings(tmp_path: Path) -> None:
    line = made_with(tmp_path, "km,id,kind,width_m\n1.4,,,\n4.5,R7,4,3.5\n")
    assert {c.id: (c.position_m, c.kind.value, c.width_m) for c in line.crossings.values()} == {
        "X1": (1400.0, "1", 6.0),
        "R7": (4500.0, "4", 3.5),
    }
    assert line.pieces[line.crossings["X1"].piece_id].from_m < 1400.0


@pytest.mark.parametrize(("km", "points"), [(2.84, "B.12"), (3.16, "B.22")])
def test_no_road_lies_on_the_first_of_three_tracks_where_points_of_the_others_are(
    tmp_path: Path, km: float, points: str
) -> None:
    """The track that parts first begins 80 m before the others do: beside it lie the points between these."""
    with pytest.raises(InputError, match=rf"clear of points .*\(there: B\.[123], {points}\)"):
        made_with(tmp_path, f"km\n{km}\n", LIST.replace("B,3.0,2", "B,3.0,3"))


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("km\n3.0\n", "crossings[0].km is 3.0; expected a place on one track"),  # two tracks
        ("km\n9.0\n", "nothing of the line"),
        ("km\nnear\n", "crossings[0].km is 'near'; expected a number"),
        ("km,kind\n1.4,2\n", "crossings[0].kind"),
        ("km,id\n1.4,R\n4.5,R\n", "crossings[1].id is 'R'; expected an id that no other"),
        ("km,width_m\n1.4,0\n", "crossings[0].width_m"),
        ("id\nR\n", "a column km"),
        ("km,road\n1.4,R\n", "columns, each one of"),
    ],
)
def test_bad_rows_of_crossings_are_named(tmp_path: Path, rows: str, said: str) -> None:
    with pytest.raises(InputError) as refusal:
        made_with(tmp_path, rows)
    assert "crossings.csv" in str(refusal.value)
    assert said in str(refusal.value)
