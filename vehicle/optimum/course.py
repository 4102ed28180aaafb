"""What is asked of the optimum and what comes back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class TooShort(ValueError):  # noqa: N818 - it says what is wrong, as a reader would
    """The running time asked for is below the least; `least_s` is that."""

    SAYS = "{:.2f} s is too short: the least running time is {:.2f} s"

    def __init__(self, time_s: float, least_s: float) -> None:
        super().__init__(self.SAYS.format(time_s, least_s))
        self.time_s = time_s
        self.least_s = least_s


class NotFound(TooShort):
    """The mesh holds no run of that time: so little above the least, or so slow over humps within its stretches."""

    SAYS = "no run of {:.2f} s was found; the least running time is {:.2f} s"


class EndsNotKept(NotFound):
    """The mesh's run, made possible on every metre, is slower at an end than asked for."""

    SAYS = "the run of {:.2f} s that is possible does not keep the speeds asked for at its ends"


@dataclass(frozen=True, slots=True)
class Course:
    """One run of a train on the 1 m grid of its path, from `start_m` to `stop_m`.

    `climb_m[i]` is the height at metre i, curves included (`vehicle.resistance.climb_m`); `limit_mps[i]` holds for the
    front from metre i to i + 1, train length folded in; both reach beyond ceil(stop_m). Deceleration is kept to
    `deceleration_mps2`, acceleration to `acceleration_mps2`, as motion and not as force. ValueError for what is no run.
    """

    train: Any  # a record of TRAIN
    load_share: float
    climb_m: Floats
    limit_mps: Floats
    start_m: float
    stop_m: float
    deceleration_mps2: float
    initial_mps: float = 0.0
    final_mps: float = 0.0
    regeneration: float = 1.0  # share of what the wire gets back that counts
    auxiliaries: bool = False  # their energy counts
    friction_brake_n: float = math.inf  # beside the motors; 0: they brake alone
    acceleration_mps2: float = math.inf
    drag_n_per_mps2: Floats | None = None  # further resistance of each metre's tunnel, N/(m/s)^2

    def __post_init__(self) -> None:
        last = math.ceil(self.stop_m)
        if not 0.0 <= self.start_m < self.stop_m:
            raise ValueError(f"a run from {self.start_m} m to {self.stop_m} m: the stop has to lie ahead")
        if min(len(self.climb_m), len(self.limit_mps)) <= last:
            raise ValueError(f"the grid ends before the stop at {self.stop_m} m")
        if self.drag_n_per_mps2 is not None and len(self.drag_n_per_mps2) <= last:
            raise ValueError(f"the resistance of tunnels ends before the stop at {self.stop_m} m")
        if not (self.deceleration_mps2 > 0.0 and self.acceleration_mps2 > 0.0):
            raise ValueError("deceleration and acceleration have to be above 0")
        if not 0.0 <= self.regeneration <= 1.0:
            raise ValueError(f"{self.regeneration} is no share of what comes back")
        if not float(np.min(self.limit_mps[int(self.start_m) : last])) > 0.0:
            raise ValueError("a limit of 0 on the way: no run ends beyond it")


@dataclass(frozen=True, slots=True)
class Profile:
    """Speed over position, straight in its square between the points, and the time at each."""

    position_m: Floats
    speed_mps: Floats
    time_s: Floats


@dataclass(frozen=True, slots=True)
class Optimum:
    """A run of least energy; forces and power hold from their point to the next (one fewer than points).

    `price_w`: energy saved by each second more, J/s. `costate`: what m^2/s^2 of v^2/2 are worth on each stretch,
    J/(kg m^2/s^2) of equivalent mass. `time_s[-1]` is within a ten-thousandth of the time asked for, not above it.
    """

    position_m: Floats
    speed_mps: Floats
    time_s: Floats
    force_n: Floats  # motors, at the rim; below 0 the electric brake
    brake_n: Floats  # air, 0 or above
    energy_j: float  # at the wire, by what the course counts
    price_w: float
    costate: Floats
    rounds: int  # Newton steps
