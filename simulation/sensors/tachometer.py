"""The tachometer (速度発電機): counts the turning of one axle, by a circumference that may not be the wheel's.

The distance of one turn changes on the way (Harada, 2.1). A pulling wheel creeps forward against the rail, a braking
one backward. In a curve the leading axle of a bogie runs outwards until it rolls freely or its flange touches; the
outer wheel, which carries more, then rolls on a larger circle of its tread, and the inner one slips. That is the worst
case (assumed): if both slipped alike there would be no error.

It counts whole pulses. Its speed comes from the time between them, with the resolution of its clock.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Final, Protocol

import numpy as np

from onboard.board import SensedRow
from radio.chance import generator
from simulation.scatter import Individual
from simulation.sensors.scene import SceneRow
from simulation.setup import Setup
from vehicle.compiled import compiled
from vehicle.records import TrainRow
from vehicle.wheel import pulse_m

IN_ORDER: Final = -1.0  # what the compiled truth holds where nothing is stuck
CONTACT_HALF_M: Final = 0.56  # half of what wheels of 1067 mm gauge touch the rails apart


class TachometerRow(Protocol):
    """One train's tachometer."""

    wheel_factor: Annotated[float, "true circumference over the one it is set for"]
    pulse_m: Annotated[float, "way of one pulse by the circumference it is set for; 0: as fine as you like"]
    creep_share: Annotated[float, "by which it turns more where it pulls with all the adhesion"]
    slope_per_m: Annotated[float, "of its circle, as a share, that it runs outwards; 0: none"]
    outwards_m: Annotated[float, "it runs outwards by no more than this"]
    outwards_m2: Annotated[float, "by this times the curvature, 1/m, an axle would roll without creep"]
    turned_m: Annotated[float, "what has turned since the run began, by that circumference"]
    step_m: Annotated[float, "what of that has turned in the last step"]
    odometer_m: Annotated[float, "what it has counted of that, in whole pulses"]
    gain: Annotated[float, "1 in order, 0 silent"]
    miscount_share: Annotated[float, "of the distance, counted too much (< 0: pulses lost); speed is right"]
    frozen_mps: Annotated[float, "shows this speed for ever; negative: in order"]


def fit(own: TachometerRow, setup: Setup, stock_id: str) -> None:
    """A wheel that is worn as is known of it, or as the run's seed has it."""
    sigma = setup.sensors.wheel_factor_sigma
    drawn = generator(setup.seed, "sensors", stock_id).normal(0.0, sigma)
    known = setup.scatter.stock.get(stock_id, Individual()).wheel_factor
    factor = 1.0 + float(np.clip(drawn, -3.0 * sigma, 3.0 * sigma)) if known is None else known
    train: TrainRow = setup.trains[stock_id].row.view(np.recarray)[0]
    fit_train(own, train, factor)
    sensors, radius_m = setup.sensors, 0.5 * float(train.wheel_diameter_m)
    own.creep_share, own.outwards_m = sensors.creep_share, sensors.flangeway_m
    if sensors.tread_conicity > 0.0 and sensors.tachometer_axle == "leading":
        own.slope_per_m = sensors.tread_conicity / radius_m
        own.outwards_m2 = radius_m * CONTACT_HALF_M / sensors.tread_conicity


def fit_train(own: TachometerRow, train: TrainRow, wheel_factor: float = 1.0) -> None:
    """In order, for a kind of train, on a wheel of `wheel_factor` times the circumference that it is set for."""
    own.wheel_factor, own.gain, own.frozen_mps = wheel_factor, 1.0, IN_ORDER
    own.pulse_m = pulse_m(train)


@compiled
def counted_m(own: TachometerRow, turned_m: float) -> float:
    """What it shows of a turning, m: whole pulses."""
    if own.pulse_m <= 0.0:
        return turned_m
    return math.floor(turned_m / own.pulse_m) * own.pulse_m


@compiled
def turns_more(own: TachometerRow, scene: SceneRow) -> float:
    """What the wheel turns of what it would without creep and on the middle of its tread."""
    out_m = min(own.outwards_m, own.outwards_m2 * scene.curvature_per_m)
    return float((1.0 + own.creep_share * scene.used_adhesion) / (1.0 + own.slope_per_m * out_m))


@compiled
def tachometer(own: TachometerRow, _sensors: Any, scene: SceneRow, sensed: SensedRow) -> None:  # noqa: ANN401
    """Count the wheel's turning of one step and show its speed. A faulty one shows what it shows."""
    if own.frozen_mps >= 0.0:
        own.step_m = own.frozen_mps * scene.step_s
        sensed.speed_mps = own.frozen_mps
    else:
        gain = own.gain / own.wheel_factor
        if own.creep_share > 0.0 or own.slope_per_m > 0.0:
            gain *= turns_more(own, scene)
        own.step_m = scene.wheel_run_m * (gain * (1.0 + own.miscount_share))
        sensed.speed_mps = scene.wheel_mps * gain
    own.turned_m += own.step_m
    own.odometer_m = counted_m(own, own.turned_m)
    sensed.odometer_m = own.odometer_m
