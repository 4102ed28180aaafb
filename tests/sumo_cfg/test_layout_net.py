"""A net from a layout: SUMO loads it, points lead only from stem to leg, and it comes back as it was."""

import os
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from exchange.layout import ForeignLayout
from exchange.osm import read_osm
from exchange.railml import read_railml
from exchange.sumo_net import read_sumo_net
from network.errors import InputError
from sumo_cfg.layout_net import plain_of, write_layout_net
from tests.exchange.layouts import OSM, RAILML_2

sumo = pytest.importorskip("sumo", reason="the extra net is not installed")
SHARED = Path(__file__).resolve().parents[2] / "../shared/data/osm/bad_hersfeld_rail.osm.xml"


def small(tmp_path: Path) -> ForeignLayout:
    path = tmp_path / "small.osm"
    path.write_text(OSM, "utf-8")
    return read_osm(path)


def shape_of(layout: ForeignLayout) -> tuple[object, object]:
    tracks = {t.id: (t.low_node, t.high_node, round(t.length_m, 2)) for t in layout.tracks}
    points = {p.node_id: (p.stem, p.normal, p.reverse, p.side) for p in layout.points}
    return tracks, points


def loads(net: Path) -> None:
    """SUMO takes the net without a word."""
    program = Path(sumo.SUMO_HOME) / "bin" / "sumo"
    done = subprocess.run(
        [str(program), "-n", str(net), "--end", "1", "--no-step-log", "--xml-validation.net", "always"],
        env={**os.environ, "SUMO_HOME": str(sumo.SUMO_HOME)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")


def movements(net: Path) -> set[tuple[str, str]]:
    root = ET.parse(net).getroot()
    return {(c.attrib["from"], c.attrib["to"]) for c in root.iterfind("connection")}


def test_a_small_layout_becomes_a_net_and_comes_back(tmp_path: Path) -> None:
    layout, net = small(tmp_path), tmp_path / "small.net.xml"
    write_layout_net(layout, net)
    loads(net)
    assert shape_of(read_sumo_net(net)) == shape_of(layout)


def test_no_train_runs_from_leg_to_leg(tmp_path: Path) -> None:
    layout, net = small(tmp_path), tmp_path / "small.net.xml"
    write_layout_net(layout, net)
    edges = {e.attrib["id"]: e for e in ET.parse(net).getroot().iterfind("edge")}
    over: set[tuple[str, frozenset[str]]] = {
        (edges[a].attrib["to"], frozenset((a[:-1], b[:-1]))) for a, b in movements(net) if a[:-1] != b[:-1]
    }
    expected = {
        (points.node_id, frozenset((points.stem, leg)))
        for points in layout.points
        for leg in (points.normal, points.reverse)
    }
    assert over == expected
    # A train may change ends anywhere.
    assert {(a, b) for a, b in movements(net) if a[:-1] == b[:-1]} == {
        pair for t in layout.tracks for pair in ((f"{t.id}+", f"{t.id}-"), (f"{t.id}-", f"{t.id}+"))
    }


@pytest.mark.skipif(not SHARED.is_file(), reason="OSM cut (../shared/data/osm) absent")
def test_the_cut_of_bad_hersfeld_becomes_a_net_with_its_points(tmp_path: Path) -> None:
    layout, net = read_osm(SHARED), tmp_path / "cut.net.xml"
    write_layout_net(layout, net)
    loads(net)
    back = read_sumo_net(net)
    assert shape_of(back) == shape_of(layout)
    tagged = {e.attrib["id"] for e in ET.parse(SHARED).getroot().iterfind("node") if _is_switch(e)}
    assert len(tagged) == 23
    assert tagged <= {points.node_id for points in back.points}


def _is_switch(node: ET.Element) -> bool:
    return any((t.get("k"), t.get("v")) == ("railway", "switch") for t in node.iterfind("tag"))


def test_a_layout_without_places_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "small.xml"
    path.write_text(RAILML_2, "utf-8")
    with pytest.raises(InputError, match="without them there is no net"):
        plain_of(read_railml(path))


def test_a_net_that_cannot_be_written_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="writable path"):
        write_layout_net(small(tmp_path), tmp_path / "no" / "such" / "folder.net.xml")
