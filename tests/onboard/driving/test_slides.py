"""The bound of a train's true speed while its wheels slide, by hand and against the plant on random rails."""

import random
from collections.abc import Callable

import numpy as np
import pytest

from onboard.driving.pattern import pattern_of
from onboard.driving.slides import bound_slid_speed, gains_back_mps2
from onboard.driving.supervision import fastest_mps, supervise
from onboard.driving.tuning import Learned
from onboard.driving_settings import Driving
from onboard.records import EMERGENCY_INTERVENTION, BehaviourRow, UnitRow
from onboard.unit_records import UnitParameters
from papers.single_train import new_track, prepared_row
from simulation.sensors.slide_protection import rolls_at
from simulation.world.kernel import step_one
from tests.rows import Rows
from vehicle.records import TrainRow
from vehicle.train_file import load_train, shipped_train

TRACK_M = 4000
LEAST = Driving().least_adhesion
BLIND_MPS = (
    1.0  # both axles may slide by so much before the protection sees it: what the judge allows to be gained
)


def test_an_axle_that_is_let_go_gains_what_the_rail_gives_it(train: TrainRow) -> None:
    """Of EV-E301 8 % turn: 0.02 g / 0.08 = 2.45 m/s2, less 0.2 that the train loses and 0.4 on a descent."""
    assert gains_back_mps2(train, 0.02) == pytest.approx(1.86, abs=0.01)


@pytest.fixture
def slides(train: TrainRow, behaviour: BehaviourRow, unit: UnitRow) -> Callable[..., float]:
    """Steps of 0.1 s in which both axles show a speed; what the train may then run at, m/s."""
    unit.odometer_scale, unit.bound_growth = 1.0, 0.02
    unit.notch, unit.slid_mps, unit.last_axle_mps, unit.seen_within_mps = -7.0, 0.0, 20.0, 0.0
    unit.speed_mps = 20.0

    def run(state: int, first_mps: float, last_mps: float, steps: int = 1, own_mps2: float = 0.0) -> float:
        for _ in range(steps):
            before_mps, axle_mps = unit.speed_mps, unit.last_axle_mps
            unit.wheel_slide, unit.speed_mps, unit.last_axle_mps = state, first_mps, last_mps
            bound_slid_speed(unit, train, behaviour, before_mps, axle_mps, 1.0, own_mps2, 0.5)
        return float(unit.slid_mps)

    return run


def test_nothing_is_bounded_while_wheels_roll(slides: Callable[..., float]) -> None:
    assert slides(0, 19.9, 19.9, 50) == 0.0


def test_a_slide_begins_with_the_speed_that_wheels_had(slides: Callable[..., float]) -> None:
    assert slides(-1, 19.0, 19.5) == pytest.approx(20.0 * 1.02)


def test_a_descent_adds_to_it(slides: Callable[..., float]) -> None:
    """A step down a gradient that is worth 0.2 m/s2."""
    slides(-1, 19.0, 19.0)
    assert slides(-1, 15.0, 15.0, 1, -0.2) == pytest.approx(20.0 * 1.02 + 0.02)


def test_the_axle_that_was_let_go_tells_it_once_it_gains_no_more(slides: Callable[..., float]) -> None:
    slides(-1, 15.0, 15.0)
    for mps in (15.3, 15.6, 15.9, 16.2):  # 3 m/s2: it comes back
        assert slides(-1, 14.0, mps) == pytest.approx(20.0 * 1.02)
    assert slides(-1, 14.0, 16.3) == pytest.approx(16.3 * 1.02)


def test_an_axle_under_its_brake_tells_nothing(slides: Callable[..., float]) -> None:
    """What is called a slip may be a slide, and then the protection lets nothing go."""
    slides(-1, 15.0, 15.0)
    assert slides(1, 15.0, 15.0, 30) == pytest.approx(20.0 * 1.02)


def test_where_no_least_adhesion_is_stated_the_speed_before_the_slide_stays(
    slides: Callable[..., float], behaviour: BehaviourRow
) -> None:
    behaviour.settings.least_adhesion = 0.0
    slides(-1, 15.0, 15.0, 3)
    assert slides(-1, 14.0, 16.3, 40) == pytest.approx(20.0 * 1.02)
    assert slides(0, 16.0, 16.0, 9) == pytest.approx(20.0 * 1.02)
    assert slides(0, 16.0, 16.0, 2) == 0.0  # they have rolled for a second


@pytest.mark.parametrize(("slid_mps", "brakes"), [(0.0, False), (20.1, True)])
def test_supervision_goes_by_it(
    train: TrainRow,
    behaviour: BehaviourRow,
    track: Callable[..., Rows],
    unit: UnitRow,
    slid_mps: float,
    brakes: bool,
) -> None:
    """Limit 18 m/s, the emergency brake from 20."""
    unit.path_rows, unit.bound_growth = TRACK_M, 0.0
    unit.speed_mps, unit.slid_mps = 15.0, slid_mps
    supervise(unit, train, behaviour, track(np.zeros(TRACK_M)))
    assert bool(unit.intervention == EMERGENCY_INTERVENTION) is brakes


def slide_along(seed: int) -> list[tuple[float, float, float, int]]:
    """A random train on a random rail: true speed, what supervision takes, the least limit under it, intervention."""
    drawn = random.Random(seed)
    kind = load_train(shipped_train(drawn.choice(["ev_e301", "skr200_4", "br642", "flirt3_3"]))).row
    stock = prepared_row(kind, kind, Driving(), UnitParameters(), Learned("train", 0.8), pulses=True)
    row = stock.view(np.recarray)[0]
    slopes = [drawn.uniform(-25.0, 25.0) for _ in range(17)]
    elevation_m = np.cumsum(np.interp(np.arange(TRACK_M), np.arange(17) * 250.0, slopes)) / 1000.0
    top_mps = drawn.uniform(12.0, 24.0)
    limits_mps, grip = np.full(TRACK_M, top_mps), np.full(TRACK_M, drawn.uniform(0.3, 1.0))
    for _ in range(4):
        slow_m, slick_m = drawn.randrange(800, 3000), drawn.randrange(400, 3000)
        limits_mps[slow_m : slow_m + drawn.randrange(50, 500)] = drawn.uniform(3.0, top_mps)
        grip[slick_m : slick_m + drawn.randrange(20, 800)] = drawn.uniform(0.0, 0.4)
    path = pattern_of(elevation_m, np.zeros(TRACK_M), limits_mps, row.board.kind, row.board.behaviour)
    track = new_track(row.body, row.board.behaviour, TRACK_M - 2.0)._replace(pattern=path)
    track.profile["elevation_m"] = elevation_m
    unit, plant, speed_mps = row.board.unit, row.plant, 0.9 * float(limits_mps[:600].min())
    unit.path_rows = row.truth.profile_rows = TRACK_M
    row.truth.position_m = row.truth.offset_m = unit.position_m = 300.0
    unit.stop_limit_m, unit.target_stop_m = 3600.0, 3590.0
    plant.speed_mps = plant.wheel_speed_mps = plant.last_wheel_speed_mps = speed_mps
    worn = drawn.uniform(-0.015, 0.015)
    row.sensors.tachometer.wheel_factor = 1.0 + worn
    unit.speed_mps = unit.train_mps = speed_mps / (1.0 + worn)
    rolls_at(row.sensors.slide_protection, speed_mps)
    row.sensors.slide_protection.shows_axle = 1
    seen = []
    for step in range(2500):
        at_m = int(row.truth.position_m)
        slope = 1.0 + row.body.adhesion_speed_factor_s_per_m * plant.speed_mps
        plant.adhesion_factor = max(grip[at_m], LEAST * slope / row.body.adhesion_dry)
        step_one(row, track, step + 1)
        rear_m = max(int(row.truth.position_m - row.body.length_m), 0)
        limit_mps = float(limits_mps[rear_m : int(row.truth.position_m) + 1].min())
        fast_mps = fastest_mps(unit, unit.speed_mps * (unit.odometer_scale + unit.bound_growth))
        seen.append((float(plant.speed_mps), float(fast_mps), limit_mps, int(unit.intervention)))
        if plant.speed_mps == 0.0 and step > 50:
            break
    return seen


def true_speed_stays_below(seeds: range) -> None:
    slid = 0
    for seed in seeds:
        for true_mps, fast_mps, limit_mps, intervention in slide_along(seed):
            assert true_mps <= fast_mps + BLIND_MPS
            assert true_mps <= limit_mps + 2.0 + BLIND_MPS or intervention != 0
            slid += fast_mps > true_mps
    assert slid > 0


def test_no_train_runs_faster_than_supervision_takes_it_to_run() -> None:
    true_speed_stays_below(range(6))


@pytest.mark.nightly
def test_nor_does_any_of_many() -> None:
    true_speed_stays_below(range(6, 200))
