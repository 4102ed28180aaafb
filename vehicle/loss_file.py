"""The table `[losses]` of a train file, and what of it goes into a TRAIN record."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from network.files.kinds import about
from network.files.quantities import GearLoss, MotorLossW, SpeedMps
from network.files.toml_input import Record


class Losses(Record):
    """`[losses]`: of one motor with its inverter and gear, in place of the two efficiencies; `vehicle.losses`."""

    base_speed_mps: Annotated[SpeedMps, about("full flux up to it; above, flux falls as 1 / speed")]
    standby_w: Annotated[MotorLossW, about("inverter and control while they switch")]
    magnetising_w: Annotated[MotorLossW, about("copper loss of the magnetising current at full flux")]
    hysteresis_w: Annotated[MotorLossW, about("iron loss proportional to speed, at base speed")]
    eddy_w: Annotated[MotorLossW, about("iron loss proportional to speed squared, at base speed")]
    inverter_w: Annotated[
        MotorLossW, about("inverter loss proportional to current, at force_max shared by the motors")
    ]
    copper_w: Annotated[
        MotorLossW, about("loss by the load current, squared, at force_max shared by the motors")
    ]
    gear_share: Annotated[GearLoss, about("share of the power at the rim lost in the gear")]
    motors_cut_out: Annotated[
        bool, about("the equipment runs as many motors as lose least; else all in service run")
    ]
    magnetised_coasting: Annotated[
        bool, about("motors stay magnetised when the train coasts, unless motors are cut out")
    ]


def set_losses(row: NDArray[np.void], losses: Losses | None) -> None:
    """Put the table, where there is one, into a TRAIN record that has its traction already."""
    if losses is None:
        return
    row["losses_given"] = 1.0
    row["loss_force_n"] = row["traction_force_max_n"].item() / row["motors"].item()
    row["motors_cut_out"] = float(losses.motors_cut_out)
    row["magnetised_coasting"] = float(losses.magnetised_coasting)
    for key, value in losses.model_dump(exclude={"motors_cut_out", "magnetised_coasting"}).items():
        row[f"loss_{key}"] = value
