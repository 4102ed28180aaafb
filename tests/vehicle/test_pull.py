"""What a train can pull is what the plant settles at, and where it is said to stall the plant does."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.rows import Rows
from vehicle import pull, running_time
from vehicle.adhesion import DRY
from vehicle.dynamics import step
from vehicle.pull import full_pull_n, mean_gradient_permille
from vehicle.running_time import Conditions, Stall, stall_of
from vehicle.train_file import new_plant

NOTCH = 16.0
STEPS = 300
LIMIT = np.full(4001, 20.0)


def climbing(permille: float) -> NDArray[np.float64]:
    return np.arange(LIMIT.size) * permille * 1e-3


def ends(train: Rows, permille: float, conditions: Conditions) -> Rows:
    """The plant after half a minute at full notch from a stand on one gradient."""
    plant = new_plant(1, 0.0)
    plant["load_share"], plant["motors_share"], plant["adhesion_factor"] = conditions
    for _ in range(STEPS):
        step(plant[0], train[0], NOTCH, False, permille, 0.0, 0.1)
    return plant


@given(
    permille=st.floats(0.0, 80.0),
    load=st.floats(0.0, 1.0),
    motors=st.sampled_from([0.25, 0.5, 0.75, 1.0]),
    factor=st.floats(0.1, 1.0),
)
def test_a_train_that_is_said_to_start_starts_and_no_other(
    ev_e301: Rows, permille: float, load: float, motors: float, factor: float
) -> None:
    conditions = Conditions(load, motors, factor)
    stall = stall_of(ev_e301[0], conditions, climbing(permille), LIMIT, 100.0, 3900.0, 0.6, 0.5)
    plant = ends(ev_e301, permille, conditions)
    if stall is not None and stall.at_m == 100.0:
        assert float(plant["travelled_m"][0]) == 0.0
    else:
        assert float(plant["travelled_m"][0]) > 0.0


@pytest.mark.parametrize(
    ("less", "permille"),
    [(Conditions(0.0, 0.5), 80.0), (Conditions(0.0, 1.0, 0.2), 80.0), (Conditions(1.0), 120.0)],
    ids=["motors", "rail", "load"],
)
def test_each_of_its_conditions_counts(br642: Rows, less: Conditions, permille: float) -> None:
    """94.4 kN; empty it needs 53.4 kN on 80 permille and 80.1 kN on 120; with less pull or more load it stays."""
    way = (climbing(permille), LIMIT, 100.0, 3900.0, 0.6, 0.5)
    assert stall_of(br642[0], Conditions(0.0), *way) is None
    stall = stall_of(br642[0], less, *way)
    assert stall is not None
    assert stall.at_m == 100.0


def test_a_stall_says_where_and_what_is_missing(ev_e301: Rows, changed: Callable[..., Rows]) -> None:
    """Level for a kilometre, then 120 permille: it comes some way up by its momentum."""
    steep = np.where(np.arange(LIMIT.size) < 1000, 0.0, (np.arange(LIMIT.size) - 1000) * 0.12)
    stall = stall_of(ev_e301[0], Conditions(0.5), steep, LIMIT, 100.0, 3900.0, 0.6, 0.1)
    assert isinstance(stall, Stall)
    assert 1100.0 < stall.at_m < 1600.0
    assert stall.gradient_permille == pytest.approx(120.0)
    assert stall.pull_n < stall.needed_n
    weightless = changed(ev_e301, traction_force_max_n=1e6, traction_power_max_w=1e8, adhesion_dry=5.0)
    assert stall_of(weightless[0], Conditions(0.5), steep, LIMIT, 100.0, 3900.0, 0.6, 0.1) is None


def test_where_there_is_nothing_to_run_there_is_no_stall(ev_e301: Rows) -> None:
    assert stall_of(ev_e301[0], Conditions(1.0), climbing(150.0), LIMIT, 100.0, 100.0, 0.6, 0.5) is None


def test_fewer_motors_take_longer_and_none_for_ever(ev_e301: Rows) -> None:
    run = (climbing(5.0), LIMIT, 100.0, 3900.0, 50.0, 0.6, 0.1, 0.0, np.inf, np.empty((0, 3)))
    with_motors = [Conditions(0.5, share, DRY) for share in (1.0, 0.5, 0.25, 0.0)]
    times_s = [running_time._run(ev_e301[0], conditions, *run)[0] for conditions in with_motors]
    assert times_s == sorted(times_s)
    assert np.isinf(times_s[-1])


def test_the_mean_gradient_is_that_of_the_way_between_front_and_rear() -> None:
    climb_m = np.concatenate([np.zeros(100), np.arange(101) * 0.01])
    assert mean_gradient_permille(climb_m, 150.0, 40.0) == pytest.approx(10.0)
    assert mean_gradient_permille(climb_m, 120.0, 40.0) == pytest.approx(5.0, abs=0.3)
    assert mean_gradient_permille(climb_m, 90.0, 40.0) == 0.0


def test_a_pull_is_bounded_by_the_rail(ev_e301: Rows) -> None:
    train = ev_e301[0]
    assert full_pull_n(train, 0.0, 1.0, 1.0, 0.0) == pytest.approx(48_000.0)
    assert full_pull_n(train, 0.0, 1.0, 0.1, 0.0) == pull.grip_n(train, 0.0, 0.1, 0.0)
    assert full_pull_n(train, 0.0, 0.5, 0.1, 0.0) == 0.5 * pull.grip_n(train, 0.0, 0.1, 0.0)
