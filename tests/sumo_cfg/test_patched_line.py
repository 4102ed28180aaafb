"""A line with a track taken out is one that SUMO carries trains over, both ways."""

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest

from network.files.shipped import shipped_line
from network.graph import find_route
from network.model import Direction, Line
from network.patching.patch import load_patched_line
from sumo_cfg import build
from sumo_cfg.options import LANE_CHANGE_MODE, SPEED_MODE, STEP_S, add_train_type, sumo_command
from sumo_cfg.writer import edge_id

pytest.importorskip("sumo", reason="netconvert comes with the extra `net`")
libsumo = pytest.importorskip("libsumo")
SPEED_MPS = 50.0
START_M = 100.0  # in from the end of the first track


@pytest.fixture(scope="module")
def without_loop() -> Line:
    return load_patched_line(shipped_line("karasuyama"), {"remove_tracks": ["OGN.2"]}, "what_if.toml")


@pytest.fixture(scope="module")
def net(without_loop: Line, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build.net_for(without_loop, tmp_path_factory.mktemp("nets"))


@pytest.fixture
def simulation(net: Path) -> Iterator[None]:
    libsumo.start(sumo_command(net))
    add_train_type("railcar", 40.0)
    yield
    libsumo.close()


def test_its_net_is_built_and_has_no_points_at_ogane(without_loop: Line, net: Path) -> None:
    assert net.parent.name.startswith("nets")  # not the shipped one
    edges = {edge.attrib["id"]: edge for edge in ET.parse(net).getroot().iterfind("edge")}
    assert set(edges) == {edge_id(p, d) for p in without_loop.pieces for d in Direction}
    assert [name for name in edges if name.startswith("OGN.")] == [
        "OGN.1+", "OGN.1-", "OGN.E+", "OGN.E-", "OGN.W+", "OGN.W-",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("stops", "direction"),
    [
        (("HSK.1", "OGN.1", "KRS.1"), Direction.DOWN),
        (("KRS.1", "OGN.1", "HSK.1"), Direction.UP),
    ],
)
def test_a_train_runs_over_the_former_points(
    without_loop: Line, simulation: None, stops: tuple[str, str, str], direction: Direction
) -> None:
    pieces = [stops[0]]
    for start, goal in pairwise(stops):
        route = find_route(without_loop, start, goal, direction)
        assert route is not None
        pieces += route.piece_ids[1:]
    edges = [edge_id(piece, direction) for piece in pieces]
    libsumo.route.add("way", edges)
    libsumo.vehicle.add("train", "way", "railcar", departPos=str(START_M), departSpeed="0")
    libsumo.vehicle.setSpeedMode("train", SPEED_MODE)
    libsumo.vehicle.setLaneChangeMode("train", LANE_CHANGE_MODE)
    libsumo.vehicle.setSpeed("train", 0.0)
    libsumo.simulationStep()
    libsumo.vehicle.setSpeed("train", SPEED_MPS)
    steps, seen = 0, [edges[0]]
    while seen[-1] != edges[-1]:
        libsumo.simulationStep()
        steps += 1
        edge = libsumo.vehicle.getRoadID("train")
        if edge != seen[-1]:
            seen.append(edge)
        assert steps < 10_000
    assert seen == edges
    # From standstill: half a step's way is lost in the first, the trapezoid of the speeds set.
    run_m = (steps - 0.5) * STEP_S * SPEED_MPS
    lengths_m = sum(without_loop.pieces[piece].length_m for piece in pieces[:-1])
    assert START_M + run_m - lengths_m == pytest.approx(libsumo.vehicle.getLanePosition("train"), abs=1e-6)
