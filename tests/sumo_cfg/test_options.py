"""SUMO run with our options carries trains exactly, turns them in place and finds collisions."""

import random
from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path

import pytest

from network.model import Line
from sumo_cfg import build
from sumo_cfg.options import LANE_CHANGE_MODE, SPEED_MODE, STEP_S, add_train_type, sumo_command
from sumo_cfg.truth_map import read_net
from sumo_cfg.writer import Positions, write_plain

pytest.importorskip("sumo", reason="netconvert comes with the extra `net`")
libsumo = pytest.importorskip("libsumo")
TRAIN_LENGTH_M = 18.0
NAMES = (f"train{number}" for number in count())


@pytest.fixture(scope="module")
def net(line: Line, positions: Positions, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("net") / "hand.net.xml"
    path.write_bytes(build.convert(write_plain(line, positions), "hand"))
    return path


@pytest.fixture(scope="module")
def simulation(net: Path) -> Iterator[None]:
    libsumo.start(sumo_command(net))
    add_train_type("railcar", TRAIN_LENGTH_M)
    yield
    libsumo.close()


@pytest.fixture
def add(simulation: None) -> Iterator[Callable[..., str]]:
    """Put a train on the net, standing; all trains leave after the test."""

    def put(route: list[str], front_m: float) -> str:
        name = next(NAMES)
        libsumo.route.add(name, route)
        libsumo.vehicle.add(name, name, "railcar", departLane="0", departPos=str(front_m), departSpeed="0")
        libsumo.vehicle.setSpeedMode(name, SPEED_MODE)
        libsumo.vehicle.setLaneChangeMode(name, LANE_CHANGE_MODE)
        libsumo.vehicle.setSpeed(name, 0.0)
        libsumo.simulationStep()
        return name

    yield put
    for name in libsumo.vehicle.getIDList():
        libsumo.vehicle.remove(name)
    libsumo.simulationStep()


def place(name: str) -> tuple[str, float]:
    return libsumo.vehicle.getRoadID(name), libsumo.vehicle.getLanePosition(name)


def drive(name: str, speed_mps: float, steps: int) -> None:
    libsumo.vehicle.setSpeed(name, speed_mps)
    for _ in range(steps):
        libsumo.simulationStep()


def until_collision(steps: int) -> list[tuple[str, str, str]]:
    for _ in range(steps):
        libsumo.simulationStep()
        found = [(c.collider, c.victim, c.type) for c in libsumo.simulation.getCollisions()]
        if found:
            return found
    return []


def test_lengths_in_sumo_are_those_of_the_pieces(simulation: None, line: Line, net: Path) -> None:
    edges = read_net(net).edges
    for piece in line.pieces.values():
        for sign in "+-":
            length_m = libsumo.lane.getLength(f"{piece.id}{sign}_0")
            assert length_m == pytest.approx(piece.to_m - piece.from_m, abs=1e-6)
            assert length_m == edges[piece.id + sign].length_m


def test_position_is_the_trapezoid_of_the_speeds(add: Callable[..., str]) -> None:
    route = ["west+", "stem1+", "reverse1+", "track2+", "reverse2+", "stem2+", "east+"]
    train = add(route, 25.0)
    starts_m, start_m = {}, 0.0
    for edge in route:
        starts_m[edge], start_m = start_m, start_m + libsumo.lane.getLength(edge + "_0")
    rng = random.Random(7)
    speed_mps, wanted_m, worst_m = 0.0, 25.0, 0.0
    for _ in range(300):
        next_mps = min(40.0, max(0.0, speed_mps + rng.uniform(-1.0, 1.5)))
        libsumo.vehicle.setSpeed(train, next_mps)
        libsumo.simulationStep()
        wanted_m += (speed_mps + next_mps) / 2.0 * STEP_S
        speed_mps = next_mps
        edge, front_m = place(train)
        worst_m = max(worst_m, abs(starts_m[edge] + front_m - wanted_m))
    assert wanted_m > 700.0  # it went through both points
    assert worst_m < 1e-9


def test_a_standing_train_reverses_in_place(add: Callable[..., str]) -> None:
    train = add(["track2+"], 100.0)
    libsumo.vehicle.setRoute(train, ["track2+", "track2-"])
    libsumo.simulationStep()
    edge, front_m = place(train)
    assert edge == "track2-"
    assert front_m == pytest.approx(260.0 - 100.0 + TRAIN_LENGTH_M, abs=1.1e-3)


def test_a_train_across_points_reverses_over_the_edges_under_it(add: Callable[..., str]) -> None:
    train = add(["west+", "stem1+", "reverse1+"], 295.0)
    drive(train, 20.0, 10)
    drive(train, 0.0, 1)
    edge, front_m = place(train)
    assert edge == "reverse1+"
    assert front_m < TRAIN_LENGTH_M - 10.0  # so the rear is behind the stem, on the line
    libsumo.vehicle.setRoute(train, ["reverse1+", "reverse1-"])
    drive(train, 0.0, 2)
    assert place(train) == (edge, front_m)
    libsumo.vehicle.setRoute(train, ["reverse1+", "reverse1-", "stem1-", "west-"])
    drive(train, 0.0, 1)
    edge, turned_front_m = place(train)
    assert edge == "west-"
    assert turned_front_m == pytest.approx(TRAIN_LENGTH_M - 10.0 - front_m, abs=1.1e-3)


def test_two_trains_on_one_track_collide_head_on(add: Callable[..., str]) -> None:
    down, up = add(["west+"], 50.0), add(["west-"], 300.0 - 80.0)
    libsumo.vehicle.setSpeed(down, 10.0)
    libsumo.vehicle.setSpeed(up, 10.0)
    # 30 m at 20 m/s, and half a step until both are at speed.
    assert until_collision(15) == []
    ((_, _, kind),) = until_collision(3)
    assert kind == "frontal"


def test_head_on_across_points_is_found(add: Callable[..., str]) -> None:
    down = add(["west+", "stem1+", "normal1+"], 280.0)
    up = add(["reverse1-", "stem1-", "west-"], 5.0)
    libsumo.vehicle.setSpeed(down, 10.0)
    libsumo.vehicle.setSpeed(up, 10.0)
    ((_, _, kind),) = until_collision(40)
    assert kind == "frontal"


def test_a_train_runs_into_the_rear_of_another(add: Callable[..., str]) -> None:
    ahead, behind = add(["west+"], 100.0), add(["west+"], 60.0)
    libsumo.vehicle.setSpeed(behind, 10.0)
    # 22 m to the rear of the one ahead.
    assert until_collision(22) == []
    assert until_collision(2) == [(behind, ahead, "collision")]


def test_trains_on_neighbouring_tracks_pass(add: Callable[..., str]) -> None:
    down, up = add(["track1+"], 50.0), add(["track2-"], 50.0)
    libsumo.vehicle.setSpeed(down, 20.0)
    libsumo.vehicle.setSpeed(up, 20.0)
    assert until_collision(100) == []


def test_sumo_prints_nothing(add: Callable[..., str], capfd: pytest.CaptureFixture[str]) -> None:
    add(["west+"], 100.0)
    train = add(["west+"], 70.0)
    drive(train, 30.0, 3)
    assert until_collision(20)
    assert capfd.readouterr() == ("", "")
