"""Nets with roads over crossings: the track stays what it is, and plain SUMO runs the road."""

import os
import subprocess
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from network.files.crossing_road import LANE_WIDTH_M, CrossingRoad
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import Line
from sumo_cfg.build import net_for, shipped_net
from sumo_cfg.road_net import RoadAt, RoadPart, RoadWay
from sumo_cfg.road_traffic import CAR, HEAVY, RoadVehicle, road_routes_xml
from sumo_cfg.truth_map import read_net

ROAD = CrossingRoad(vehicles_per_h=(100.0,), lanes=2)


@pytest.fixture(scope="module")
def rtri() -> Line:
    return load_line(shipped_line("rtri_test_line"))


@pytest.fixture(scope="module")
def roads() -> tuple[RoadAt, ...]:
    return RoadAt("C1", "6", 700.0, ROAD), RoadAt("C2", "3", 400.0, ROAD)


@pytest.fixture(scope="module")
def net(rtri: Line, roads: tuple[RoadAt, ...], tmp_path_factory: pytest.TempPathFactory) -> Path:
    return net_for(rtri, tmp_path_factory.mktemp("nets"), roads)


def track(net: Path) -> Iterator[bytes]:
    """What a net says of its track: edges, connections and junctions, but for those of roads."""
    for element in ET.parse(net).getroot():
        name = element.get("id") or element.get("from") or ""
        if element.tag in ("edge", "connection", "junction") and not name.startswith("road."):
            yield ET.tostring(element).strip()


def test_the_track_is_that_of_the_shipped_net_to_the_byte(rtri: Line, net: Path) -> None:
    shipped = shipped_net(rtri.id)
    assert list(track(net)) == list(track(shipped))
    assert read_net(net) == read_net(shipped)
    assert read_net(net).edges.keys() == {f"{piece}{sign}" for piece in rtri.pieces for sign in "+-"}


def test_the_same_net_on_another_day(
    rtri: Line, roads: tuple[RoadAt, ...], net: Path, tmp_path: Path
) -> None:
    assert net_for(rtri, tmp_path, roads).read_bytes() == net.read_bytes()
    assert net_for(rtri, tmp_path, roads[:1]).name != net.name
    assert net_for(rtri, tmp_path) == shipped_net(rtri.id)


def test_lanes_lie_to_the_left_of_the_middle_and_meet_the_track_where_they_say(
    roads: tuple[RoadAt, ...], net: Path
) -> None:
    """Piece 6 is straight there: the middles of its lane and of each lane over it cross at right angles."""
    import numpy as np

    lanes = {
        lane.attrib["id"]: np.array(
            [[float(x) for x in p.split(",")[:2]] for p in lane.attrib["shape"].split()]
        )
        for lane in ET.parse(net).getroot().iterfind("edge/lane")
    }
    rail = lanes["6+_0"]
    along = (rail[-1] - rail[0]) / np.linalg.norm(rail[-1] - rail[0])
    middle = rail[0] + along * (700.0 - 530.0)
    for way in RoadWay:
        for index, lane_id in enumerate(roads[0].lanes(way, RoadPart.OVER)):
            first, last = lanes[lane_id]
            assert np.dot((first + last) / 2.0 - middle, along) == pytest.approx(
                roads[0].lane_at_m(way, index), abs=0.01
            )
            heading = (last - first) / np.linalg.norm(last - first)
            left = np.array([-heading[1], heading[0]])
            assert np.dot((first + last) / 2.0 - middle, left) == pytest.approx(
                (index + 0.5) * LANE_WIDTH_M, abs=0.01
            )
            assert np.linalg.norm(last - first) == pytest.approx(roads[0].over_m, abs=0.01)


def sumo_home() -> Path:
    """Where SUMO's programs are."""
    spec = find_spec("sumo")
    assert spec is not None
    assert spec.submodule_search_locations is not None
    return Path(spec.submodule_search_locations[0])


def test_the_net_can_be_edited(net: Path, tmp_path: Path) -> None:
    """netconvert reads it as netedit does, which wants a display, without a warning; what it writes has its track."""
    home, again = sumo_home(), tmp_path / "again.net.xml"
    said = subprocess.run(
        [home / "bin" / "netconvert", "--sumo-net-file", net, "--output-file", again],
        env={**os.environ, "SUMO_HOME": str(home)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (said.returncode, said.stderr) == (0, "")
    edges = [{edge.attrib["id"] for edge in ET.parse(file).iterfind("edge")} for file in (net, again)]
    assert edges[0] - {name for name in edges[0] if name.startswith(":")} <= edges[1]


def test_plain_sumo_runs_the_road(roads: tuple[RoadAt, ...], net: Path, tmp_path: Path) -> None:
    """The signals' own programs let vehicles pass; nothing of ours runs here."""
    vehicles = [
        RoadVehicle(f"v{k}", roads[k % 2], way, kind, 10.0 * k, 1.0, stall_s=5.0 * (k == 3))
        for k in range(10)
        for way, kind in [(RoadWay.RIGHT, CAR) if k % 3 else (RoadWay.LEFT, HEAVY)]
    ]
    routes = tmp_path / "road.rou.xml"
    routes.write_bytes(road_routes_xml(roads, vehicles))
    home = sumo_home()
    said = subprocess.run(
        [
            home / "bin" / "sumo",
            "-n",
            net,
            "-r",
            routes,
            "--step-method.ballistic",
            "true",
            "--step-length",
            "0.1",
            "--tripinfo-output",
            "t.xml",
            "-e",
            "600",
        ],
        cwd=tmp_path,
        env={**os.environ, "SUMO_HOME": str(home)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (said.returncode, said.stderr) == (0, "")
    arrived = {trip.attrib["id"] for trip in ET.parse(tmp_path / "t.xml").getroot()}
    assert arrived == {vehicle.id for vehicle in vehicles}
