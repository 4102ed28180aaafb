"""The slide protection (滑走防止装置): compares its axles with one another and with what a train can do.

It gets pulses of the first and the last axle; it does not know the train's speed. An axle slides if it turns slower
than the other one, or slows down faster than any brake could slow the train. It slips if it turns faster, or
accelerates faster than the motors could. During a slide the brake of the last axle is released (`last_axle_released`):
its wheels roll again and show the speed to which the first axle has to return.

It also shows the unit how fast the last axle turns, converted to the circumference for which the tachometer is set; it
learns the ratio of the wheels itself while all of them roll. These pulses are not the tachometer's.
"""

from __future__ import annotations

from typing import Annotated, Final, Protocol

import numpy as np

from onboard.board import SensedRow
from radio.chance import generator
from simulation.sensors.scene import SceneRow
from simulation.sensors.tag_reader import WithTachometer
from simulation.setup import Setup
from vehicle.compiled import compiled
from vehicle.mass import equivalent_mass_kg
from vehicle.records import TrainRow
from vehicle.traction import full_force_n

SEEN_MPS: Final = 0.05  # it compares axles no finer than this
SEEN_SHARE: Final = 0.01  # nor than wheels of one train may differ in diameter
DIAMETERS_SIGMA: Final = (
    0.0025  # assumed: wheels of one train are turned to within 1 % of each other (4 sigma)
)
GRADIENT_MPS2: Final = 0.4  # assumed: 35 permille and the running resistance, beyond brakes or motors
STRONG_BRAKE: Final = 1.25  # assumed: no brake gives more than this share of its nominal deceleration
SURE_S: Final = 1.0  # an axle that was let go rolls after this, unless it still gains speed


class SlideProtectionRow(Protocol):
    """One train's protection."""

    last_wheel_share: Annotated[float, "speed shown of the last axle over the one it has"]
    slows_mps2: Annotated[float, "no train slows down faster than this"]
    gains_mps2: Annotated[float, "nor gains speed faster than this"]
    highest_mps: Annotated[float, "what the train may have at most, by its fastest axle"]
    lowest_mps: Annotated[float, "and at least, by its slowest"]
    last_mps: Annotated[float, "of the last axle, a step ago"]
    since_s: Annotated[float, "how long it has seen a slide or a slip"]
    shows_axle: Annotated[int, "1: it shows its unit the last axle"]
    state: Annotated[int, "-1 slides, 1 slips, 0 rolls"]


def fit(own: SlideProtectionRow, setup: Setup, stock_id: str) -> None:
    """Wheels that differ as the run's seed has it."""
    drawn = generator(setup.seed, "axles", stock_id).normal(0.0, DIAMETERS_SIGMA)
    limit = 4.0 * DIAMETERS_SIGMA
    fit_train(own, setup.trains[stock_id].row.view(np.recarray)[0], float(np.clip(drawn, -limit, limit)))
    own.shows_axle = 1


def fit_train(own: SlideProtectionRow, train: TrainRow, diameters_differ: float = 0.0) -> None:
    """For a kind of train; `diameters_differ`: of the last wheels over the first, as a share beyond 1."""
    own.last_wheel_share = 1.0 + diameters_differ
    brake_mps2 = max(float(train.emergency_deceleration_mps2), float(np.max(train.brake_deceleration_mps2)))
    own.slows_mps2 = STRONG_BRAKE * brake_mps2 + GRADIENT_MPS2
    own.gains_mps2 = full_force_n(train, 0.0, 0.0) / equivalent_mass_kg(train, 0.0) + GRADIENT_MPS2


@compiled
def rolls_at(own: SlideProtectionRow, speed_mps: float) -> None:
    """Begin with all axles rolling at this speed."""
    own.highest_mps = own.lowest_mps = own.last_mps = speed_mps
    own.state = 0


@compiled
def slide_protection(
    own: SlideProtectionRow,
    sensors: WithTachometer,
    scene: SceneRow,
    sensed: SensedRow,
) -> None:
    """Show -1 where the wheels of the first axle slide, 1 where they slip, 0 where they roll."""
    first, last = scene.wheel_mps, scene.last_wheel_mps * own.last_wheel_share
    seen = SEEN_MPS + SEEN_SHARE * max(first, last)
    slows, gains = own.slows_mps2 * scene.step_s, own.gains_mps2 * scene.step_s
    # An axle that slips says nothing of how fast the train may be, one that slides nothing of how slow.
    own.highest_mps = max(last if own.state > 0 else max(first, last), own.highest_mps - slows)
    own.lowest_mps = min(last if own.state < 0 else min(first, last), own.lowest_mps + gains)
    rolls = own.last_mps - slows <= last <= own.last_mps + gains
    own.last_mps = last
    own.since_s += scene.step_s
    if own.state != 0 and abs(first - last) <= seen and rolls and own.since_s >= SURE_S:
        own.state = 0
        own.highest_mps, own.lowest_mps = max(first, last), min(first, last)
    # While the first axle slips, the last one tells that wheels slide.
    slowest = min(first, last) if own.state > 0 else first
    if own.state >= 0 and slowest < own.highest_mps - seen:
        own.state, own.since_s = -1, 0.0
    elif own.state <= 0 and first > own.lowest_mps + seen:
        own.state, own.since_s = 1, 0.0
    sensed.wheel_slide = own.state
    sensed.last_axle_taken = own.shows_axle
    sensed.last_axle_mps = scene.last_wheel_mps / sensors.tachometer.wheel_factor
