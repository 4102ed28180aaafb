"""The guaranteed brakes on the design adhesion: what is refused, and that the others really hold."""

from dataclasses import replace
from typing import Any, Final

import numpy as np
import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from onboard.driving_settings import Driving
from simulation.design import design_grip_mps2, overrated_brake
from simulation.setup import STEP_S, behaviour_row
from vehicle.dynamics import step
from vehicle.train_file import TrainType, load_train, new_plant, shipped_train

LINE_MPS: Final = load_line(shipped_line("karasuyama")).max_speed_mps  # 65 km/h


@pytest.fixture(scope="module")
def train() -> TrainType:
    return load_train(shipped_train("ev_e301"))


def test_grip_is_the_weight_of_all_axles_times_the_coefficient(train: TrainType) -> None:
    """EV-E301: dry 0.245 / (1 + 0.03 v); what turns has to be braked too."""
    inert = 1.0 + float(train.row[0]["rotating_mass_factor"])
    for share, speed_mps, coefficient in ((1.0, 0.0, 0.245), (0.5, 20.0, 0.5 * 0.245 / 1.6)):
        grip_mps2 = design_grip_mps2(Driving(design_adhesion_share=share), train, speed_mps)
        assert grip_mps2 == pytest.approx(9.81 * coefficient / inert, rel=1e-6)


def test_a_guarantee_is_refused_as_soon_as_it_needs_more_than_the_design_adhesion(train: TrainType) -> None:
    needed = Driving().design_adhesion_share * 1.0 / design_grip_mps2(Driving(), train, LINE_MPS)
    assert needed == pytest.approx(1.08 * (1.0 + 0.03 * 65 / 3.6) / (0.245 * 9.81), abs=1e-4)  # 0.693
    assert overrated_brake(Driving(design_adhesion_share=needed + 1e-6), train, LINE_MPS) is None
    found = overrated_brake(Driving(design_adhesion_share=needed - 1e-3), train, LINE_MPS)
    assert found is not None
    assert found[:2] == ("emergency_guaranteed_share", pytest.approx(1.0))
    service = Driving(design_adhesion_share=0.3, emergency_guaranteed_share=0.2)
    assert (overrated_brake(service, train, LINE_MPS) or ("",))[0] == "service_guaranteed_share"


def test_the_slower_of_line_and_train_counts(train: TrainType) -> None:
    driving = Driving(design_adhesion_share=0.65)
    assert overrated_brake(driving, train, LINE_MPS) is not None
    assert overrated_brake(driving, train, 12.5) is None
    slow = replace(train, row=train.row.copy())
    slow.row["speed_max_mps"] = 12.5
    assert overrated_brake(driving, slow, LINE_MPS) is None


def stops_in_m(train: TrainType, adhesion: float, *, emergency: bool) -> float:
    """How far a train runs from the line's speed to a stand on the level."""
    plants = new_plant(1)
    plant: Any = plants.view(np.recarray)[0]
    plant.adhesion_factor, plant.load_share = adhesion, 0.2
    plant.speed_mps = plant.wheel_speed_mps = LINE_MPS
    body: Any = train.row.view(np.recarray)[0]
    while plant.speed_mps > 0.0:
        step(plant, body, -float(body.brake_notches), emergency, 0.0, 0.0, STEP_S)
    return float(plant.travelled_m)


@pytest.mark.parametrize("emergency", [False, True])
def test_down_to_the_design_adhesion_the_train_stops_in_what_is_guaranteed(
    train: TrainType, emergency: bool
) -> None:
    row = behaviour_row(Driving(), train.row[0])
    name = "emergency" if emergency else "service"
    deceleration, reaction_s = float(row[f"{name}_guaranteed_mps2"]), float(row[f"{name}_reaction_s"])
    guaranteed_m = LINE_MPS * reaction_s + LINE_MPS**2 / (2.0 * deceleration)
    for adhesion in (1.0, Driving().design_adhesion_share):
        assert stops_in_m(train, adhesion, emergency=emergency) < guaranteed_m
    assert stops_in_m(train, 0.3, emergency=emergency) > guaranteed_m  # what the declaration is for
