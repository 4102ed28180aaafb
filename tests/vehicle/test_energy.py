"""Where each step's energy goes: the parts close at every instant, and fail to without any one of them."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.rows import Rows
from vehicle.dynamics import step
from vehicle.train_file import load_train, new_plant, shipped_train

DT_S: Final = 0.1
PARTS: Final = (
    "kinetic", "resistance", "gradient", "curve", "friction", "traction_loss", "regeneration_loss",
)  # fmt: skip
TRAINS: Final = ("br642", "ev_e301", "ev_e301_losses", "hitachi_train", "oda_scale_car", "oda_train")
ROWS: Final = {name: load_train(shipped_train(name)).row for name in TRAINS}
commands = st.lists(st.tuples(st.integers(-7, 5), st.integers(5, 40)), min_size=1, max_size=6)


def driven(
    train: np.void,
    notches: Sequence[tuple[int, int]],
    speed_mps: float,
    gradient: float,
    adhesion: float = 1.0,
    curvature: float = 1 / 400,
) -> np.void:
    plant = new_plant(1, speed_mps)[0]
    plant["adhesion_factor"], plant["load_share"] = adhesion, 0.4
    for notch in (float(notch) for notch, steps in notches for _ in range(steps)):
        step(plant, train, notch, False, gradient, curvature, DT_S)
    return plant


def unclosed_j(plant: np.void, without: str = "") -> float:
    """What the parts leave open, J."""
    net_j = plant["energy_traction_j"] - plant["energy_regenerated_j"]
    return float(net_j - sum(plant[f"energy_{part}_j"] for part in PARTS if part != without))


def allowed_j(train: np.void, speed_mps: float, gradient: float) -> float:
    """Rounding, and what the gradient does in the step in which a train is held that would roll back."""
    mass = float(train["mass_empty_kg"]) + 0.4 * float(train["mass_load_full_kg"])
    pull = 9.81 * max(gradient, 0.0) * 1e-3
    return 1e-9 * mass * (10.0 + speed_mps) ** 2 + mass * pull * 0.5 * pull * DT_S**2


@pytest.mark.parametrize("name", TRAINS)
@given(notches=commands, speed=st.floats(0.0, 3.0), gradient=st.floats(-25.0, 25.0), rail=st.floats(0.1, 1.0))
def test_the_parts_close_whatever_happens(
    name: str, notches: list[tuple[int, int]], speed: float, gradient: float, rail: float
) -> None:
    """Starts, stops, slip and slide, on any gradient; of slow trains, which stop and start most."""
    train = ROWS[name][0]
    plant = driven(train, notches, speed, gradient, rail)
    assert abs(unclosed_j(plant)) <= allowed_j(train, speed, gradient)


@pytest.mark.parametrize("part", PARTS)
def test_a_part_left_out_is_found_out(ev_e301: Rows, part: str) -> None:
    plant = driven(ev_e301[0], [(5, 200), (0, 30), (-7, 60)], 10.0, 5.0)
    assert plant["speed_mps"] > 1.0  # kinetic energy is there
    assert abs(unclosed_j(plant)) < 1e-6 * plant["energy_traction_j"]
    assert abs(unclosed_j(plant, part)) > 1e-3 * plant["energy_traction_j"]


@pytest.mark.parametrize("name", TRAINS)
@pytest.mark.parametrize("speed", [0.02, 0.3, 1.0])
@pytest.mark.parametrize("notch", [-7.0, 0.0])
def test_the_step_that_stops_does_no_more_work_than_there_is(name: str, speed: float, notch: float) -> None:
    """On the level and uphill it comes to a stand within some step, at whatever speed that step began."""
    train = ROWS[name][0]
    for gradient in (0.0, 3.0):
        plant = driven(train, [(int(notch), 1200)], speed, gradient, curvature=0.0)
        assert plant["speed_mps"] == 0.0
        mass = float(train["mass_empty_kg"]) + 0.4 * float(train["mass_load_full_kg"])
        kinetic_j = 0.5 * mass * (1.0 + float(train["rotating_mass_factor"])) * speed**2
        assert -plant["energy_kinetic_j"] == pytest.approx(kinetic_j)
        spent_j = plant["energy_friction_j"] + plant["energy_resistance_j"] + plant["energy_gradient_j"]
        motors_j = plant["energy_regenerated_j"] - plant["energy_traction_j"]
        lost_j = plant["energy_regeneration_loss_j"] + plant["energy_traction_loss_j"]
        assert spent_j + motors_j + lost_j == pytest.approx(kinetic_j, abs=allowed_j(train, speed, gradient))
        assert min(plant["energy_friction_j"], plant["energy_resistance_j"]) >= 0.0


def test_what_stands_uses_nothing_but_its_auxiliaries(ev_e301: Rows) -> None:
    plant = driven(ev_e301[0], [(-7, 100)], 0.0, 15.0)
    assert plant["energy_auxiliary_j"] == pytest.approx(30_000.0 * 10.0)
    assert all(plant[f"energy_{part}_j"] == 0.0 for part in (*PARTS, "traction", "regenerated", "rejected"))


def test_a_brake_on_slippery_rail_still_closes(ev_e301: Rows) -> None:
    plant = driven(ev_e301[0], [(-7, 150)], 15.0, -10.0, adhesion=0.25)
    assert plant["energy_friction_j"] > 0.0
    assert abs(unclosed_j(plant)) < 1e-6 * plant["energy_friction_j"]
