"""`[battery]` of a train file: what the train's traction battery is; read by `vehicle.train_file`."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Final

import numpy as np
from pydantic import Field, model_validator

from network.files.kinds import about
from network.files.quantities import (
    BatteryEnergyJ,
    BatteryPowerW,
    CurrentA,
    ResistanceOhm,
    Share,
    ShareAbove0,
    VoltageV,
)
from network.files.toml_input import Record

OCV_POINTS_MAX: Final = 12
SAG_SHARE_MAX: Final = 0.5  # beyond it more current gives less power: no battery is built to that


class BatteryTable(Record):
    """`[battery]`: the traction battery as one pack; a scenario's `[battery]` lets trains run on it."""

    capacity_j: Annotated[BatteryEnergyJ, about("energy from empty to full when new")]
    capacity_share: Annotated[
        ShareAbove0, about("share of the capacity that is left, by age", "assumed: new")
    ] = 1.0
    open_circuit_soc: Annotated[
        list[Share],
        Field(min_length=2, max_length=OCV_POINTS_MAX),
        about("states of charge of the open-circuit voltage, rising from 0 to 1"),
    ]
    open_circuit_v: Annotated[
        list[VoltageV],
        Field(min_length=2, max_length=OCV_POINTS_MAX),
        about("open-circuit voltage there, not falling"),
    ]
    resistance_ohm: Annotated[ResistanceOhm, about("internal resistance of the pack")]
    soc_low: Annotated[Share, about("low end of the window that is used")]
    soc_high: Annotated[Share, about("high end of the window that is used")]
    taper_from_soc: Annotated[Share, about("state of charge from which the charging current falls linearly")]
    taper_to_share: Annotated[Share, about("share of the greatest current that is left at soc_high")]
    discharge_max_w: Annotated[BatteryPowerW, about("greatest power taken out")]
    charge_max_w: Annotated[BatteryPowerW, about("greatest power from a charger")]
    regeneration_max_w: Annotated[BatteryPowerW, about("greatest power from the motors")]
    discharge_max_a: Annotated[CurrentA, about("greatest current taken out")]
    charge_max_a: Annotated[CurrentA, about("greatest charging current")]
    voltage_min_v: Annotated[VoltageV, about("least voltage at the terminals")]
    voltage_max_v: Annotated[VoltageV, about("greatest voltage at the terminals")]

    @model_validator(mode="after")
    def _curve_rises(self) -> BatteryTable:
        soc, volts = self.open_circuit_soc, self.open_circuit_v
        if len(soc) != len(volts):
            raise ValueError("as many voltages as states of charge")
        if soc[0] != 0.0 or soc[-1] != 1.0 or any(b <= a for a, b in pairwise(soc)):
            raise ValueError("states of charge that rise from 0 to 1")
        if any(b < a for a, b in pairwise(volts)):
            raise ValueError("open-circuit voltages that do not fall")
        return self

    @model_validator(mode="after")
    def _window_opens(self) -> BatteryTable:
        if not self.soc_low < self.taper_from_soc < self.soc_high:
            raise ValueError("soc_low below taper_from_soc below soc_high")
        low_v, high_v = np.interp(
            (self.soc_low, self.soc_high), self.open_circuit_soc, self.open_circuit_v
        ).tolist()
        if not self.voltage_min_v < low_v:
            raise ValueError(f"voltage_min_v below the open-circuit voltage at soc_low, {low_v:.0f} V")
        if not high_v < self.voltage_max_v:
            raise ValueError(f"voltage_max_v above the open-circuit voltage at soc_high, {high_v:.0f} V")
        if self.resistance_ohm * self.discharge_max_a > SAG_SHARE_MAX * low_v:
            raise ValueError("a resistance at which discharge_max_a takes less than half of the voltage")
        return self
