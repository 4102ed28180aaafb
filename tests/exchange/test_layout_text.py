"""What becomes of a layout: a station list, JSON, and what keeps it from being a line."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

from exchange.layout import ForeignLayout, LayoutNode, LayoutStation, LayoutTrack, NodeKind, Spot
from exchange.layout_text import as_dict, obstacles, station_list_toml, stations_in_order
from exchange.railml import read_railml
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
