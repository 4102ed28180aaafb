"""The road in real SUMO: it waits for barriers alone, and a train strikes what stands."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Protocol

import pytest

from network.files.crossing_road import CrossingRoad
from network.model import Direction
from simulation.carriers.road_demand import road_vehicles
from study.evaluate.road_queueing import RISING_S, RoadRun
from tests.simulation.carriers.roads import CROSSING, PIECE, POSITION_M, Detected, carried, road_at, road_of

WAY = ["1", "P2.stem", "P2.normal", "3", "P5.normal", "P5.stem", "6", "P7.stem", "P7.normal", "8"]
STEP_S = 0.1


class WithRoad(Protocol):
    """`carried` in a folder of the test; what it made before is closed."""

    def __call__(
        self, road: CrossingRoad, closures: Sequence[tuple[float, float]] = (), end_s: float = 3600.0
    ) -> RoadRun: ...


@pytest.fixture
def with_road(tmp_path: Path) -> Iterator[WithRoad]:
    made: list[RoadRun] = []

    def make(
        road: CrossingRoad, closures: Sequence[tuple[float, float]] = (), end_s: float = 3600.0
    ) -> RoadRun:
        for one in made:
            one.carrier.close()
        made.append(carried(tmp_path, road, closures, end_s))
        return made[-1]

    yield make
    for one in made:
        one.carrier.close()


def test_all_come_and_none_is_under_a_lowered_barrier(with_road: WithRoad) -> None:
    closures = [(200.0 * k + 50.0, 200.0 * k + 130.0) for k in range(9)]
    road = road_of(vehicles_per_h=(900.0,), lanes=2)
    run = with_road(road, closures, end_s=1799.0)
    late = [t_s for t_s, _ in run.entries(1900.0) if any(a + 1.0 < t_s <= b + RISING_S for a, b in closures)]
    assert late == []
    came = [v for v in road_vehicles([road_at(road)], 1, (), 0.0, 1799.0) if v.depart_s < 1800.0]
    # some are still on their way
    assert sum(t.passages for t in run.road.totals.of.values()) >= len(came) - 15


def test_an_open_crossing_stops_nobody(with_road: WithRoad) -> None:
    run = with_road(road_of(vehicles_per_h=(60.0,), heavy_share=0.0))
    run.run([], 40_000)
    totals = run.road.totals.of.values()
    passages = sum(total.passages for total in totals)
    assert passages > 40
    assert [total.queue for total in totals] == [0] * len(totals)
    assert sum(total.waited_s for total in totals) / passages < 1.5  # behind a slower one, at times


def test_the_road_is_the_same_with_a_train_elsewhere(with_road: WithRoad) -> None:
    """A train runs to 250 m before the crossing and back; SUMO's road is the same to the last step."""
    seen = []
    for train in (False, True):
        run = with_road(road_of(vehicles_per_h=(1200.0,), lanes=2, stall_share=0.02), [(300.0, 400.0)])
        speeds = [10.0] * 250 + [0.0] * 100
        if train:
            run.carrier.insert("T", WAY, Direction.DOWN, 120.0, 40.0)
        run.run([("T", speeds)] if train else [], 350)
        if train:
            run.carrier.reverse("T", ["3", "P2.normal", "P2.stem", "1"], Direction.UP)
        run.run([("T", speeds)] if train else [], 350)
        seen.append(run.entries(900.0))
    assert seen[0] == seen[1]
    assert len(seen[0]) > 200


@pytest.mark.parametrize(
    ("first_m", "speed_mps", "brake_mps2"), [(600.0, 20.0, 1.0), (650.0, 15.0, 0.0), (645.0, 12.0, 1.2)]
)
def test_a_vehicle_that_stands_is_struck_at_the_trains_speed(
    with_road: WithRoad, first_m: float, speed_mps: float, brake_mps2: float
) -> None:
    """From `first_m` on, the train brakes evenly: v^2 = u^2 - 2 b s as it comes to the near side of the vehicle."""
    run = with_road(road_of(), [(1.0, 1000.0)])
    run.carrier.insert("T", WAY, Direction.DOWN, 220.0, 40.0)  # its front at 300 m
    speeds = [min(0.2 * k, speed_mps) for k in range(1, 200)]
    run.run([("T", speeds)], len(speeds))
    to_go_m = first_m - (
        300.0 + sum((a + b) / 2.0 * STEP_S for a, b in zip([0.0, *speeds], speeds, strict=False))
    )
    steps = int(to_go_m / speed_mps / STEP_S)
    first_m -= to_go_m - steps * speed_mps * STEP_S
    run.run([("T", [speed_mps] * steps)], steps)
    run.road.stall(CROSSING, stands=True)
    braked = [max(0.0, speed_mps - brake_mps2 * STEP_S * k) for k in range(1, 300)]
    hit = 0
    while not run.carrier.collisions() and hit < len(braked):
        hit += run.carrier.run([("T", braked[hit:])], len(braked) - hit) or len(braked)
    (struck,) = run.road.struck
    # The lane towards the right lies 1.5 m beyond the crossing's middle, a car is 1.8 m wide.
    way_m = POSITION_M + 1.5 - 0.9 - first_m
    expected_mps = math.sqrt(speed_mps**2 - 2.0 * brake_mps2 * way_m)
    assert 3.6 * abs(struck.speed_mps - expected_mps) < 0.5
    assert struck.speed_mps == pytest.approx(expected_mps, abs=0.02)
    assert run.carrier.truth("T").offset_m == pytest.approx(POSITION_M + 0.6 - 530.0, abs=2.0)
    assert struck.text in run.carrier.collisions()


def test_who_stops_short_or_passes_first_strikes_nothing(with_road: WithRoad) -> None:
    run = with_road(road_of(), [(1.0, 1000.0)])
    run.carrier.insert("T", ["6", "P7.stem"], Direction.DOWN, 100.0, 40.0)  # at 630 m
    run.run([("T", [5.0] * 130 + [0.0])], 131)  # to 695.25 m
    run.road.stall(CROSSING, stands=True)
    run.run([], 20)
    assert run.carrier.collisions() == ()
    run.road.stall(CROSSING, stands=False)
    run.run([], 200)
    run.run([("T", [5.0] * 300)], 120)  # its rear at 715 m
    run.road.stall(CROSSING, stands=True)
    run.run([], 20)
    assert run.carrier.collisions() == ()


def test_a_train_on_the_crossing_is_there_to_its_rear_after_it_has_turned(with_road: WithRoad) -> None:
    run = with_road(road_of(), [(1.0, 1000.0)])
    run.carrier.insert("T", [PIECE, "P7.stem"], Direction.DOWN, 200.0, 40.0)  # from 690 m to 730 m
    run.run([], 1)
    run.carrier.reverse("T", [PIECE, "P5.stem", "P5.normal", "3"], Direction.UP)
    run.run([("T", [1.0] * 10 + [0.0])], 11)
    run.road.stall(CROSSING, stands=True)
    run.run([("T", [0.0])], 1)
    (struck,) = run.road.struck
    assert (struck.unit_id, struck.crossing_id, struck.speed_mps) == ("T", CROSSING, 0.0)


def test_a_detector_hears_of_a_vehicle_on_a_closed_crossing_alone(with_road: WithRoad) -> None:
    run = with_road(road_of(), [(20.0, 60.0)])
    run.road.stall(CROSSING, stands=True)
    run.run([], 300)
    run.road.stall(CROSSING, stands=False)
    run.run([], 300)
    assert isinstance(run.detectors, Detected)
    (first, second) = run.detectors.told
    assert first == (CROSSING, 200, True)  # as the barriers are down
    assert second[0::2] == (CROSSING, False)
    assert 300 < second[1] <= 350  # in five seconds it has run clear of the track


def test_who_looks_sees_what_stands_there_whatever_is_closed(with_road: WithRoad) -> None:
    run = with_road(road_of())
    assert not run.road.blocked(CROSSING)
    run.road.stall(CROSSING, stands=True)
    run.run([], 10)
    assert run.road.blocked(CROSSING)
    run.road.stall(CROSSING, stands=False)
    run.run([], 50)
    assert not run.road.blocked(CROSSING)


def test_who_drives_over_it_blocks_nothing(with_road: WithRoad) -> None:
    run = with_road(road_of(vehicles_per_h=(900.0,)))
    while not run.road.over():
        run.run([], 1)
    for _ in range(20):
        run.run([], 1)
        assert not run.road.blocked(CROSSING)


def test_drivers_stop_for_a_train_that_creeps_over_an_open_crossing_until_it_is_gone(
    with_road: WithRoad,
) -> None:
    """It stands 30 m before the middle for 20 s, and its rear, 40 m long, is 15 m beyond after 85 m at 5 m/s."""
    run = with_road(road_of(vehicles_per_h=(1200.0,), heavy_share=0.0))
    run.carrier.insert("T", WAY[6:], Direction.DOWN, POSITION_M - 530.0 - 30.0, 40.0)
    run.run([], 600)
    run.road.creeps_over(CROSSING, "T")
    run.run([("T", [0.0] * 200)], 200)
    assert run.road.over() == set()
    for _ in range(16):
        run.run([("T", [5.0] * 10)], 10)
        assert run.road.over() == set()
    run.run([("T", [5.0] * 60)], 60)
    assert run.road.over() != set()
    assert run.road.struck == []


def test_a_vehicle_that_is_there_stalls_at_once_and_drives_on_in_the_end(with_road: WithRoad) -> None:
    """Nobody is put there then, and whoever comes behind it waits, as it does, for what the fault lasts."""
    run = with_road(road_of(vehicles_per_h=(900.0,), heavy_share=0.0))
    while not (there := {v for v in run.road.over() if ".right." in v}):
        run.run([], 1)
    run.road.stall(CROSSING, stands=True)
    run.run([], 600)
    assert {v for v in run.road.over() if ".right." in v} >= there
    run.road.stall(CROSSING, stands=False)
    run.run([], 600)
    assert run.road.over().isdisjoint(there)
    total = run.road.totals.of[CROSSING, 0]
    assert 60.0 < total.waited_s_max < 70.0
    assert total.queue >= 3  # of 450 an hour, in a minute seven or eight come


@pytest.mark.parametrize("half", [True, False])
def test_drivers_go_round_half_barriers_when_their_patience_is_over(with_road: WithRoad, half: bool) -> None:
    road = road_of(vehicles_per_h=(300.0,), half_barriers=half, round_share=1.0, round_after_s=10.0)
    run = with_road(road, [(60.0, 360.0)])
    inside = [(t_s, vehicle_id) for t_s, vehicle_id in run.entries(360.0) if t_s > 62.0]
    assert bool(inside) is half
    patience_s = {v.id: v.patience_s for v in road_vehicles([road_at(road)], 1, (), 0.0, 1.0)}
    depart_s = {v.id: v.depart_s for v in road_vehicles([road_at(road)], 1, (), 0.0, 1.0)}
    for t_s, vehicle_id in inside:
        assert t_s > depart_s[vehicle_id] + 295.0 / (1.2 * road.speed_mps) + patience_s[vehicle_id]


def test_nobody_goes_round_who_is_not_drawn_to(with_road: WithRoad) -> None:
    run = with_road(road_of(vehicles_per_h=(300.0,), half_barriers=True), [(60.0, 360.0)])
    assert [t_s for t_s, _ in run.entries(360.0) if t_s > 62.0] == []


def test_a_share_stalls_on_the_track_for_as_long_as_drawn(with_road: WithRoad) -> None:
    road = road_of(vehicles_per_h=(20.0,), stall_share=1.0, stall_s=60.0)
    vehicles = [v for v in road_vehicles([road_at(road)], 1, (), 0.0, 3599.0) if v.depart_s < 3600.0]
    run = with_road(road)
    run.run([], 60_000)
    waited_s = sum(total.waited_s for total in run.road.totals.of.values())
    stalled_s = sum(v.stall_s for v in vehicles)
    queued_s = waited_s - stalled_s  # braking, starting, and those behind
    assert stalled_s > 300.0
    assert waited_s > stalled_s
    assert queued_s / len(vehicles) < 60.0


def test_what_is_drawn_of_vehicles_follows_the_settings_and_nothing_else() -> None:
    road = road_of(vehicles_per_h=tuple(float(50 * hour) for hour in range(24)))
    at = road_at(road)
    day = road_vehicles([at], 1, (), 0.0, 86_399.0)
    for hour in (0, 4, 12, 23):
        number = sum(hour * 3600.0 <= v.depart_s < (hour + 1) * 3600.0 for v in day)
        assert abs(number - 50 * hour) <= 4.0 * math.sqrt(50 * hour)  # of a Poisson variable
    other = replace(at, road=road.model_copy(update={"stall_share": 0.5, "heavy_share": 1.0}))
    changed = road_vehicles([other], 1, (), 0.0, 86_399.0)
    assert [(v.id, v.depart_s, v.speed_share) for v in changed] == [
        (v.id, v.depart_s, v.speed_share) for v in day
    ]
    assert 0.45 < sum(v.stall_s > 0.0 for v in changed) / len(changed) < 0.55
    assert road_vehicles([at], 2, (), 0.0, 86_399.0) != day
    assert road_vehicles([at], 1, (), 36_000.0, 36_001.0) == tuple(
        v for v in day if 36_000 <= v.depart_s < 39_600
    )
