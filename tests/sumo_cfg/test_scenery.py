"""What stands along the track: each thing once, and where its kilometrage is, as SUMO itself places it."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest

from network.alignment import positions
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import Line
from sumo_cfg.build import shipped_net
from sumo_cfg.scenery import scenery_xml, stop_id

sumolib = pytest.importorskip("sumolib", reason="the extra net is not installed")
LINES = ("karasuyama", "busy_line", "rtri_test_line")


@pytest.fixture(params=LINES)
def line(request: pytest.FixtureRequest) -> Line:
    return load_line(shipped_line(request.param))


def points_of(root: ET.Element, start: str) -> dict[str, ET.Element]:
    return {poi.attrib["id"]: poi for poi in root.iterfind("poi") if poi.attrib["id"].startswith(start)}


def test_every_tag_and_mark_is_where_its_kilometrage_is(line: Line) -> None:
    """A point's `lane` and `pos`, walked along that lane's shape in the net, come out at the place on the alignment."""
    root = ET.fromstring(scenery_xml(line))
    net = sumolib.net.readNet(str(shipped_net(line.id)))
    expected = {f"tag.{tag.id}": (tag.piece_id, tag.position_m) for tag in line.tags.values()}
    for station in line.stations.values():
        for track in station.tracks:
            for direction, mark_m in track.marks_m.items():
                expected[f"mark.{stop_id(track, direction)}"] = track.piece_id, mark_m
    found = points_of(root, "tag.") | points_of(root, "mark.")
    assert found.keys() == expected.keys()
    for name, (piece_id, kilometrage_m) in expected.items():
        lane = net.getLane(found[name].attrib["lane"])
        piece = line.pieces[piece_id]
        # The lane's length is the kilometrage's; its shape is a few millimetres longer or shorter.
        share = float(found[name].attrib["pos"]) / lane.getLength()
        shape = lane.getShape()
        shape_m = sumolib.geomhelper.polyLength(shape)
        x, y = sumolib.geomhelper.positionAtShapeOffset(shape, share * shape_m)
        axis = line.alignments[piece.alignment_id]
        there, right = (positions(axis, np.array([kilometrage_m]), piece.offset_m + m)[0] for m in (0.0, 1.0))
        off = np.array([x, y]) - there[:2]
        to_right = right[:2] - there[:2]
        along_m, beside_m = abs(off[0] * to_right[1] - off[1] * to_right[0]), abs(off @ to_right)
        assert along_m < 0.3, name
        # The leg of points swings out from one track to the other.
        assert beside_m < (abs(piece.offset_m) + 4.0 if piece.points_id else 0.3), name


def test_ends_of_sections_and_points_are_at_their_nodes(line: Line) -> None:
    root = ET.fromstring(scenery_xml(line))
    net = sumolib.net.readNet(str(shipped_net(line.id)))

    def place(poi: ET.Element) -> str:
        """The node at which a point lies."""
        lane = net.getLane(poi.attrib["lane"])
        at_m = float(poi.attrib["pos"])
        assert at_m == pytest.approx(0.0, abs=1e-3) or at_m == pytest.approx(lane.getLength(), abs=1e-3)
        edge = lane.getEdge()
        return str((edge.getFromNode() if at_m < 1e-3 else edge.getToNode()).getID())

    for name, poi in points_of(root, "end.").items():
        assert name.endswith(f".{place(poi)}")
    toes = {name.removeprefix("points."): place(poi) for name, poi in points_of(root, "points.").items()}
    assert toes == {points.id: points.node_id for points in line.points.values()}
    # Every section has ends, and between two sections the joint is an end of both.
    for section in line.sections.values():
        assert any(name.startswith(f"end.{section.id}.") for name in points_of(root, "end."))


def test_ids_are_each_their_own_and_nothing_is_missing(line: Line) -> None:
    root = ET.fromstring(scenery_xml(line))
    ids = [element.attrib["id"] for element in root]
    assert len(ids) == len(set(ids))
    polygons = [poly.attrib["id"] for poly in root.iterfind("poly")]
    for section in line.sections.values():
        assert any(
            name == f"section.{section.id}" or name.startswith(f"section.{section.id}.") for name in polygons
        )
    platforms = sum(track.platform_m is not None for s in line.stations.values() for track in s.tracks)
    assert sum(name.startswith("platform.") for name in polygons) == platforms
    stops = sum(len(track.marks_m) for s in line.stations.values() for track in s.tracks)
    assert len(root.findall("trainStop")) == stops
    for stop in root.iterfind("trainStop"):
        assert 0.0 <= float(stop.attrib["startPos"]) < float(stop.attrib["endPos"])


def test_a_track_without_a_platform_has_a_stop_and_no_platform() -> None:
    line = load_line(shipped_line("karasuyama"))
    ogane = line.stations["OGN"]
    bare = replace(ogane, tracks=tuple(replace(track, platform_m=None) for track in ogane.tracks))
    root = ET.fromstring(scenery_xml(replace(line, stations={**line.stations, "OGN": bare})))
    assert not [p for p in root.iterfind("poly") if p.attrib["id"].startswith("platform.OGN")]
    assert len([s for s in root.iterfind("trainStop") if s.attrib["id"].startswith("OGN.")]) == 4
