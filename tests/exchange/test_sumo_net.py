"""SUMO nets: our own come back as they were made, others as they are."""

import gzip
from pathlib import Path

import pytest

from exchange.layout import ForeignLayout, NodeKind, TurnoutSide
from exchange.sumo_net import read_sumo_net
from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from sumo_cfg.build import shipped_net
from sumo_cfg.scenery import scenery_xml

# Toe at (100, 0): the stem from the west, a leg on to the east, a branch to the north; a road beside it.
NET = """<?xml version="1.0" encoding="UTF-8"?>
<net version="1.20">
  <location netOffset="0,0"/>
  <edge id=":toe_0" function="internal">
    <lane id=":toe_0_0" index="0" allow="rail" length="0.1" shape="0,0 1,0"/></edge>
  <edge id="-s" from="toe" to="west" bidi="s">
    <lane id="-s_0" index="0" allow="rail" length="100" shape="100,0 0,0"/></edge>
  <edge id="s" from="west" to="toe" bidi="-s" name="1">
    <lane id="s_0" index="0" allow="rail" length="100" shape="0,0 100,0"/></edge>
  <edge id="l" from="toe" to="east" bidi="-l">
    <lane id="l_0" index="0" allow="rail rail_fast" length="80" shape="100,0,5 180,0,5"/></edge>
  <edge id="-l" from="east" to="toe" bidi="l">
    <lane id="-l_0" index="0" allow="rail" length="80" shape="180,0 100,0"/></edge>
  <edge id="b" from="toe" to="north">
    <lane id="b_0" index="0" allow="rail" length="81" shape="100,0 140,6 180,14"/></edge>
  <edge id="road" from="west" to="east">
    <lane id="road_0" index="0" disallow="rail" length="180" shape="0,9 180,9"/></edge>
  <junction id="west" type="dead_end" x="0" y="0"/><junction id="toe" type="unregulated" x="100" y="0"/>
  <junction id="east" type="dead_end" x="180" y="0"/><junction id="north" type="dead_end" x="180" y="14"/>
  <connection from="s" to="l" fromLane="0" toLane="0"/><connection from="-l" to="-s" fromLane="0" toLane="0"/>
  <connection from="s" to="b" fromLane="0" toLane="0"/><connection from="s" to="-s" fromLane="0" toLane="0"/>
</net>
"""
STOPS = """<additional>
  <trainStop id="w" lane="s_0" startPos="10" endPos="60" name="West">
    <param key="kilometrage_m" value="1060"/></trainStop>
  <busStop id="w2" lane="-s_0" startPos="0" endPos="-20" name="West">
    <param key="kilometrage_m" value="1020"/></busStop>
  <trainStop id="r" lane="road_0" startPos="0" endPos="50"/>
  <poi id="p" x="0" y="0"/>
</additional>
"""


def read(tmp_path: Path, text: str, stops: str | None = None) -> ForeignLayout:
    net = tmp_path / "small.net.xml"
    net.write_text(text, "utf-8")
    if stops is None:
        return read_sumo_net(net)
    additional = tmp_path / "small.add.xml"
    additional.write_text(stops, "utf-8")
    return read_sumo_net(net, additional)


def test_a_small_net_is_as_drawn(tmp_path: Path) -> None:
    layout = read(tmp_path, NET, STOPS)
    assert {t.id: (t.low_node, t.high_node, t.length_m) for t in layout.tracks} == {
        "s": ("west", "toe", 100.0),
        "l": ("toe", "east", 80.0),
        "b": ("toe", "north", 81.0),
    }
    (points,) = layout.points
    assert (points.stem, points.normal, points.reverse, points.side) == ("s", "l", "b", TurnoutSide.LEFT)
    (station,) = layout.stations
    assert (station.name, station.position_m) == ("West", pytest.approx(1040.0))
    # 80 m along the way back is 20 m from the west
    assert [s.offset_m for s in station.spots] == [60.0, 20.0]
    assert layout.km_of("l", 80.0) == pytest.approx(1180.0)
    assert "1 edge without a way back: a track all the same" in layout.assumed
    assert "1 edge for other traffic than trains" in layout.left
    assert "1 stop that lies on none of the tracks" in layout.left


def test_an_edge_may_say_which_leg_is_normal(tmp_path: Path) -> None:
    said = NET.replace(
        'shape="100,0 140,6 180,14"/></edge>',
        'shape="100,0 140,6 180,14"/><param key="normal_at" value="toe"/></edge>',
    )
    (points,) = read(tmp_path, said).points
    assert (points.stem, points.normal, points.reverse, points.side) == ("s", "b", "l", TurnoutSide.RIGHT)


def test_a_junction_where_all_lead_to_all_is_no_set_of_points(tmp_path: Path) -> None:
    every = NET.replace("</net>", '<connection from="-l" to="b"/></net>')
    layout = read(tmp_path, every)
    assert layout.points == ()
    assert any(text.startswith("not among points: junction toe") for text in layout.left)
    assert {n.id: n.kind for n in layout.nodes}["toe"] is NodeKind.CROSSING


@pytest.mark.parametrize("name", ["karasuyama", "busy_line", "rtri_test_line"])
def test_our_own_net_comes_back_as_the_line(name: str, tmp_path: Path) -> None:
    line = load_line(shipped_line(name))
    additional = tmp_path / "a.add.xml"
    additional.write_bytes(scenery_xml(line))
    layout = read_sumo_net(shipped_net(name), additional)
    assert {t.id: (t.low_node, t.high_node, t.length_m) for t in layout.tracks} == {
        p.id: (p.low_node, p.high_node, pytest.approx(p.length_m, abs=1e-6)) for p in line.pieces.values()
    }
    assert {p.node_id: (p.stem, p.normal, p.reverse) for p in layout.points} == {
        p.node_id: (p.stem_piece, p.normal_piece, p.reverse_piece) for p in line.points.values()
    }
    # A halt's two marks lie on either side of its kilometrage, a terminus has a mark for each direction too.
    marks = {
        station.id: [mark_m for track in station.tracks for mark_m in track.marks_m.values()]
        for station in line.stations.values()
    }
    for station in layout.stations:
        assert station.position_m == pytest.approx(
            sum(marks[station.code]) / len(marks[station.code]), abs=2e-3
        )
        names = {track.name for track in line.stations[station.code].tracks}
        assert {spot.track_name for spot in station.spots} == names
    for piece in line.pieces.values():
        assert layout.km_of(piece.id, 0.0) == pytest.approx(piece.from_m, abs=0.01)
        assert layout.km_of(piece.id, piece.length_m) == pytest.approx(piece.to_m, abs=0.01)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<net ", "<routes ", "outermost element is routes"),
        ("rail", "bus", "an edge on which trains are allowed"),
        ('length="80"', 'length="0"', "length"),
        ('length="80"', 'length="eighty"', "length"),
        ('shape="0,0 100,0"', 'shape="0,0"', "two points"),
        ('shape="0,0 100,0"', 'shape="here"', "shape"),
        (' from="west" to="toe"', ' to="toe"', "edge s: from"),
    ],
)
def test_a_wrong_file_gets_one_line(tmp_path: Path, old: str, new: str, said: str) -> None:
    text = NET.replace(old, new)
    text = text.replace("</net>", "</routes>") if "routes" in new else text
    with pytest.raises(InputError) as refusal:
        read(tmp_path, text)
    assert said in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_truncated_files_and_foreign_stops_get_one_line(tmp_path: Path) -> None:
    for share in (0.3, 0.9):
        with pytest.raises(InputError, match="whole and valid XML"):
            read(tmp_path, NET[: int(len(NET) * share)])
    with pytest.raises(InputError, match="outermost element is net"):
        read(tmp_path, NET, NET)
    packed = tmp_path / "p.net.xml.gz"
    packed.write_bytes(gzip.compress(NET.encode()))
    assert len(read_sumo_net(packed).tracks) == 3
