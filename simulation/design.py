"""What the design counts on: no brake is guaranteed more than the design adhesion gives it (decision 010)."""

from __future__ import annotations

from typing import Final

from onboard.driving_settings import Driving
from simulation.setup import behaviour_row
from vehicle.adhesion import grip_mps2
from vehicle.train_file import TrainType

# each a share in `[driving]`, and what it comes to
BRAKES: Final = ("service_guaranteed", "emergency_guaranteed")


def design_grip_mps2(driving: Driving, train: TrainType, speed_mps: float) -> float:
    """What all axles together can brake with on the design adhesion, m/s^2: the least up to a speed is that at it."""
    return float(grip_mps2(train.row[0], driving.design_adhesion_share, speed_mps))


def overrated_brake(
    driving: Driving, train: TrainType, line_max_mps: float
) -> tuple[str, float, float] | None:
    """The first brake that is guaranteed more than the design adhesion gives it at the train's greatest speed.

    The key of its share, what is guaranteed and what there is, m/s^2; None where each has the grip that it needs.
    """
    available_mps2 = design_grip_mps2(driving, train, min(line_max_mps, float(train.row[0]["speed_max_mps"])))
    guaranteed = behaviour_row(driving, train.row[0])
    for brake in BRAKES:
        asked_mps2 = float(guaranteed[f"{brake}_mps2"])
        if asked_mps2 > available_mps2:
            return f"{brake}_share", asked_mps2, available_mps2
    return None
