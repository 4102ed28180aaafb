"""Faults of the yaw gyro: silent, stuck, a jump on its bias, more noise."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from pydantic import Field

from network.files.quantities import NoiseFactor, YawRateDegps
from simulation.faults.fault import UnitFault
from simulation.settings import PositionSensor


@dataclass(frozen=True, slots=True)
class Gyro:
    """What a gyro makes of the yaw rate: silent, stuck, a jump (rad/s) on its bias, more noise."""

    is_silent: bool = False
    is_stuck: bool = False
    jump_radps: float = 0.0
    noise_factor: float = 1.0


class GyroFault(UnitFault[Gyro]):
    """What the yaw gyro of a train shows; a train without one does not mind."""

    changes = "gyro"
    in_order = Gyro()
    of_sensor = PositionSensor.CURVATURE


class GyroDead(GyroFault):
    """The gyro has no output, even if it was stuck before."""

    kind = "gyro_dead"

    def applied_to(self, gyro: Gyro) -> Gyro:
        return replace(gyro, is_silent=True)


class GyroStuck(GyroFault):
    """The gyro's output stays as it is when the fault begins."""

    kind = "gyro_stuck"

    def applied_to(self, gyro: Gyro) -> Gyro:
        return replace(gyro, is_stuck=True)


class GyroBias(GyroFault):
    """The gyro's bias jumps."""

    kind = "gyro_bias"
    jump_degps: YawRateDegps = Field(description="added to the bias, to the right")

    def applied_to(self, gyro: Gyro) -> Gyro:
        return replace(gyro, jump_radps=gyro.jump_radps + math.radians(self.jump_degps))


class GyroNoise(GyroFault):
    """The gyro is noisier."""

    kind = "gyro_noise"
    factor: NoiseFactor = Field(description="multiple of the standard deviation of its noise")

    def applied_to(self, gyro: Gyro) -> Gyro:
        return replace(gyro, noise_factor=gyro.noise_factor * self.factor)
