"""A yaw gyro on the leading car's body: how fast the body turns, with the body's own motion, noise and bias.

The body follows the mean heading between its bogies like a mass on a spring with a damper,

    body'' + 2 damping w body' + w^2 body = w^2 bogies,    w = 2 pi frequency,

solved exactly over each step. Noise is white: a step shows the mean of its samples, so its standard deviation is that
of a sample divided by the root of their number. The bias is a constant of the train plus a slow random change. Harada,
Maki, Kazato and Ishiguri, section 3.3, name the body's yaw motion as what differs with type and speed.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from onboard.board import SensedRow
from radio.chance import generator
from simulation.sensors.noise import normal, source_of
from simulation.sensors.scene import SceneRow
from simulation.setup import Setup
from vehicle.compiled import compiled, compiled_when_called

IN_ORDER: Final = 0
DEAD: Final = 1
STUCK: Final = 2
WALKS_EVERY_STEPS: Final = 10  # the bias is no other from one step to the next
STATES: Final = 2
CUT_SIGMAS: Final = 3.0  # what belongs to a train lies within so many


class YawGyroRow(Protocol):
    """One train's gyro and the body that it stands on."""

    fitted: int
    source: Annotated[int, "of its noise"]
    walk_source: Annotated[int, "of its bias's walk"]
    sigma_radps: Annotated[float, "of the mean of a step"]
    gain: Annotated[float, "what it shows over what it should"]
    bias_radps: Annotated[float, "of the train"]
    walk_radps: Annotated[float, "beyond that, now"]
    walk_keeps: Annotated[float, "share of the walk that is left a second later"]
    walk_sigma_radps: Annotated[float, "of what comes to it in a second"]
    keeps: Annotated[list[float], STATES * STATES, "what a step makes of the body's rate and its change"]
    takes: Annotated[list[float], STATES, "what the bogies add to them, by their mean rate in the step"]
    turns: Annotated[list[float], STATES + 1, "by what the body turns in a step: of both, and of the bogies"]
    body_radps: Annotated[float, "the body's yaw rate"]
    body_radps2: float
    shown_radps: Annotated[float, "the last that it showed"]
    state: Annotated[int, "of faults: IN_ORDER, DEAD, STUCK"]
    stuck_radps: float
    jump_radps: Annotated[float, "of faults: on the bias"]
    noise_factor: Annotated[float, "of faults: on the noise"]


def body_matrices(
    frequency_hz: float, damping: float, step_s: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """What a step makes of the body: `keeps` (2, 2), `takes` (2,), `turns` (3,) of `YawGyroRow`."""
    from scipy.linalg import expm  # no train but one with a gyro needs it

    omega = 2.0 * math.pi * frequency_hz
    flow = np.zeros((4, 4))  # rate, its change, the angle, the bogies' rate
    flow[0, 1] = flow[2, 0] = 1.0
    flow[1] = [-omega * omega, -2.0 * damping * omega, 0.0, omega * omega]
    after = np.asarray(expm(flow * step_s), dtype=np.float64)
    return after[:2, :2], after[:2, 3], after[2, [0, 1, 3]]


def fit(own: YawGyroRow, setup: Setup, stock_id: str) -> None:
    """A gyro and a body as the run's seed has them, where the stock carries them."""
    own.noise_factor = 1.0
    if not setup.sensors.carries_gyro(stock_id):
        return
    gyro, step_s = setup.curvature, 1.0 / setup.steps_of(1.0)
    own.fitted = 1
    own.source = source_of(setup.seed, "yaw gyro", stock_id, *setup.today)
    own.walk_source = source_of(setup.seed, "yaw gyro bias", stock_id, *setup.today)
    chance = generator(setup.seed, "yaw gyro", stock_id)
    drawn = np.clip(chance.normal(size=4), -CUT_SIGMAS, CUT_SIGMAS)
    own.sigma_radps = gyro.noise_factor * gyro.stated_sigma_radps(step_s)
    own.bias_radps = math.radians(gyro.bias_sigma_degps) * float(drawn[0])
    own.gain = 1.0 + gyro.gain_sigma * float(drawn[1])
    frequency_hz = gyro.body_frequency_hz * (1.0 + gyro.body_spread * float(drawn[2]) / CUT_SIGMAS)
    damping = gyro.body_damping * (1.0 + gyro.body_spread * float(drawn[3]) / CUT_SIGMAS)
    own.walk_keeps = math.exp(-WALKS_EVERY_STEPS * step_s / gyro.bias_walk_s)
    walk_radps = math.radians(gyro.bias_walk_degps)
    own.walk_sigma_radps = walk_radps * math.sqrt(1.0 - own.walk_keeps**2)
    keeps, takes, turns = body_matrices(frequency_hz, damping, step_s)
    own.keeps[:], own.takes[:], own.turns[:] = keeps.ravel(), takes, turns


@compiled_when_called
def body_turned_rad(own: YawGyroRow, bogies_radps: float) -> float:
    """By what the body turns in a step in which the bogies turn at that mean rate."""
    rate, change = own.body_radps, own.body_radps2
    own.body_radps = own.keeps[0] * rate + own.keeps[1] * change + own.takes[0] * bogies_radps
    own.body_radps2 = own.keeps[2] * rate + own.keeps[3] * change + own.takes[1] * bogies_radps
    return float(own.turns[0] * rate + own.turns[1] * change + own.turns[2] * bogies_radps)


@compiled
def yaw_gyro(own: YawGyroRow, _sensors: Any, scene: SceneRow, sensed: SensedRow) -> None:  # noqa: ANN401
    """Show the body's mean yaw rate in this step, positive to the right; a faulty gyro shows what it shows."""
    if own.fitted == 0:
        return
    turned_rad = body_turned_rad(own, scene.turned_rad / scene.step_s)
    if scene.step % WALKS_EVERY_STEPS == 0:
        own.walk_radps = own.walk_keeps * own.walk_radps + own.walk_sigma_radps * normal(
            own.walk_source, scene.step
        )
    shown = sensed.readings.curvature
    shown.taken = 0 if own.state == DEAD else 1
    if own.state != STUCK:
        noise_radps = own.sigma_radps * own.noise_factor * normal(own.source, scene.step)
        bias_radps = own.bias_radps + own.walk_radps + own.jump_radps
        own.shown_radps = turned_rad / scene.step_s * own.gain + bias_radps + noise_radps
    shown.yaw_radps = own.shown_radps
