"""What wire or battery can give and take now limits the motors; the air brake does what they may not."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.rows import Rows
from vehicle.dynamics import step
from vehicle.source import pull_within_n
from vehicle.train_file import load_train, new_plant, shipped_train
from vehicle.wire import power_at_grip_w

DT_S = 0.1
AUXILIARY_W = 30_000.0
commands = st.lists(st.tuples(st.integers(-7, 5), st.integers(5, 40)), min_size=1, max_size=6)
speeds = st.floats(0.0, 25.0)
gradients = st.floats(-25.0, 25.0)


def driven(
    train: np.void,
    commands: Sequence[tuple[int, int]],
    speed_mps: float,
    gradient: float,
    gives_w: float = math.inf,
    takes_w: float = math.inf,
) -> tuple[np.void, float, float]:
    """The plant after the commands, and the greatest powers drawn and given back with auxiliaries in a step, W."""
    plant = new_plant(1, speed_mps)[0]
    plant["source_gives_w"], plant["source_takes_w"] = gives_w, takes_w
    drawn_w = back_w = -math.inf
    for notch in (float(notch) for notch, steps in commands for _ in range(steps)):
        traction_j, regenerated_j = plant["energy_traction_j"], plant["energy_regenerated_j"]
        step(plant, train, notch, False, gradient, 0.0, DT_S)
        net_j = (plant["energy_traction_j"] - traction_j) - (plant["energy_regenerated_j"] - regenerated_j)
        drawn_w = max(drawn_w, net_j / DT_S + AUXILIARY_W)
        back_w = max(back_w, -net_j / DT_S - AUXILIARY_W)
    return plant, drawn_w, back_w


@given(
    commands=commands, speed=speeds, gradient=gradients, gives=st.floats(0.0, 5e5), takes=st.floats(0.0, 4e5)
)
def test_no_step_draws_or_gives_back_more_than_the_source_says(
    ev_e301: Rows,
    commands: list[tuple[int, int]],
    speed: float,
    gradient: float,
    gives: float,
    takes: float,
) -> None:
    _, drawn_w, back_w = driven(ev_e301[0], commands, speed, gradient, gives, takes)
    assert drawn_w <= max(gives, AUXILIARY_W) * (1.0 + 1e-9)  # the auxiliaries run on
    assert back_w <= takes * (1.0 + 1e-9) + 1e-3


def test_without_limits_more_is_drawn_and_given_back(ev_e301: Rows) -> None:
    """The bound above is no bound of the train itself: +inf switches the limit off."""
    _, drawn_w, back_w = driven(ev_e301[0], [(5, 200), (-7, 100)], 5.0, 0.0)
    assert drawn_w > 400e3
    assert back_w > 200e3


def test_by_a_map_of_losses_too_motors_pull_with_all_that_the_source_gives() -> None:
    train, plant = load_train(shipped_train("ev_e301_losses")).row[0], new_plant(1, 15.0)[0]
    plant["source_gives_w"] = 3e5
    pull_n = pull_within_n(plant, train, 48_000.0, 5_000.0, 1e5, 93_000.0, DT_S)
    middle_mps = 15.0 + (pull_n - 5_000.0) / 1e5 * DT_S / 2.0
    assert power_at_grip_w(train, 1.0, pull_n, middle_mps, 93_000.0) + AUXILIARY_W == pytest.approx(3e5)


@given(commands=commands, speed=speeds, gradient=gradients, takes=st.floats(0.0, 4e5))
def test_what_the_source_refuses_is_braked_by_air_and_counted_as_rejected(
    ev_e301: Rows, commands: list[tuple[int, int]], speed: float, gradient: float, takes: float
) -> None:
    free, _, _ = driven(ev_e301[0], commands, speed, gradient)
    held, _, _ = driven(ev_e301[0], commands, speed, gradient, takes_w=takes)
    assert held["travelled_m"] == pytest.approx(free["travelled_m"], abs=1e-6)
    assert held["speed_mps"] == pytest.approx(free["speed_mps"], abs=1e-9)
    back_j = held["energy_regenerated_j"] + held["energy_rejected_j"]
    assert back_j == pytest.approx(free["energy_regenerated_j"], rel=1e-6, abs=1.0)
    more_air_j = held["energy_friction_j"] - free["energy_friction_j"]
    assert more_air_j * 0.75 == pytest.approx(held["energy_rejected_j"], rel=1e-6, abs=1.0)
    assert free["energy_rejected_j"] == 0.0


def test_a_source_that_gives_nothing_leaves_the_train_to_roll(ev_e301: Rows) -> None:
    plant, drawn_w, _ = driven(ev_e301[0], [(5, 100)], 15.0, 0.0, gives_w=0.0)
    coasting, _, _ = driven(ev_e301[0], [(0, 100)], 15.0, 0.0)
    assert plant["energy_traction_j"] == 0.0
    assert drawn_w == pytest.approx(AUXILIARY_W)
    assert plant["speed_mps"] == coasting["speed_mps"]


def test_when_the_source_gives_again_the_pull_comes_back_within_the_limit_of_jerk(ev_e301: Rows) -> None:
    plant = new_plant(1, 15.0)[0]
    plant["source_gives_w"] = 100e3
    for _ in range(50):
        step(plant, ev_e301[0], 5.0, False, 0.0, 0.0, DT_S)
    plant["source_gives_w"] = math.inf
    before_n = float(plant["traction_force_n"])
    step(plant, ev_e301[0], 5.0, False, 0.0, 0.0, DT_S)
    assert before_n == pytest.approx(70e3 * 0.85 / 15.0, rel=0.05)
    assert 0.0 < plant["traction_force_n"] - before_n <= 0.8 * 77_900 * 1.08 * DT_S * (1.0 + 1e-9)


@given(commands=commands, speed=speeds, gradient=gradients, takes=st.sampled_from([0.0, 1e5, math.inf]))
def test_the_parts_make_up_what_was_drawn(
    ev_e301: Rows, commands: list[tuple[int, int]], speed: float, gradient: float, takes: float
) -> None:
    plant, _, _ = driven(ev_e301[0], commands, speed, gradient, takes_w=takes)
    parts = ("kinetic", "resistance", "gradient", "curve", "friction", "traction_loss", "regeneration_loss")
    net_j = plant["energy_traction_j"] - plant["energy_regenerated_j"]
    unclosed_j = net_j - sum(plant[f"energy_{part}_j"] for part in parts)
    # Where the model holds a train that would roll back, the gradient is left with one step's way: see vehicle.energy.
    held_j = 77_900 * 9.81 * 25e-3 * 0.5 * DT_S * 0.5
    assert abs(unclosed_j) <= 1e-6 * (1.0 + plant["energy_traction_j"]) + held_j
