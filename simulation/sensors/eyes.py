"""The cameras of all trains in a line run: sampled frames instead of rendered ones, while a stop sign is in range.

A frame is taken `rate_hz` times a second of simulated time; between frames nothing is computed. The figures of the
error model were fitted to the renderer (`simulation.sensors.camera.fit_sighting_model`, 60 images a place at rest and
as many vibrating); a test compares them with it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import numpy as np

from onboard.localisation.sighting import SIGN_BEYOND_MARK_M
from radio.chance import generator
from simulation.agenda import Agenda, Due
from simulation.setup import STEPS_PER_S
from simulation.world.trains import Trains

if TYPE_CHECKING:
    from simulation.sensors.camera import SightingModel

# distance m, share seen, bias m, sigma m at rest, sigma m moving, exposed after s: LINE_CAMERA and LINE_SIGN
LINE_SIGHTINGS: Final = (
    (9.0, 1.0, 0.002, 0.001, 0.015, 0.0187),
    (12.0, 1.0, -0.002, 0.001, 0.026, 0.0168),
    (15.0, 1.0, 0.001, 0.003, 0.044, 0.0156),
    (21.0, 1.0, -0.003, 0.006, 0.073, 0.0142),
    (30.0, 1.0, 0.014, 0.015, 0.148, 0.0131),
    (39.0, 1.0, 0.046, 0.019, 0.299, 0.0126),
    (48.0, 1.0, 0.032, 0.048, 0.423, 0.0122),
    (60.0, 1.0, 0.002, 0.129, 0.619, 0.0119),
    (69.0, 1.0, -0.079, 0.117, 0.759, 0.0117),
    (78.0, 1.0, 0.040, 0.352, 0.834, 0.0116),
    (87.0, 0.983, 0.156, 0.322, 1.290, 0.0115),
)


def line_sightings() -> SightingModel:
    """The sampled error model of the line's camera and sign. Needs the extra [vision]."""
    from simulation.sensors.camera import SightingModel

    return SightingModel(*np.array(LINE_SIGHTINGS).T)


class Eyes:
    """When which camera looks, and what it sees; only at stations that have signs."""

    def __init__(self, trains: Trains, agenda: Agenda, next_target: Callable[[int], int]) -> None:
        self._trains = trains
        self._next_target = next_target
        self._agenda = agenda
        vision = trains.setup.vision
        self._vision = vision
        self._every_steps = max(1, round(STEPS_PER_S / vision.rate_hz))
        self._model = line_sightings() if vision.wanted else None
        setup = trains.setup
        self._chance = [generator(setup.seed, "camera", s, *setup.today) for s in trains.stock_ids]
        self._looking: set[int] = set()

    def look_ahead(self, slot: int) -> None:
        """Set from where the next sign may be seen."""
        if self._model is None or slot in self._looking:
            return
        sign_m = self._sign_m(slot)
        truth = self._trains.truths[slot]
        truth.camera_m = math.inf if sign_m is None else sign_m - self._model.distance_m[-1]

    def begin(self, slot: int, step: int) -> None:
        """The front has come within range of the sign."""
        self._looking.add(slot)
        self._again(slot, step)

    def frame(self, slot: int, step: int) -> float | None:
        """One frame: distance (m) from the front to the sign, None if it is not seen; the next one is put down."""
        sign_m = self._sign_m(slot)
        if self._model is None or sign_m is None:
            self._looking.discard(slot)
            return None
        self._again(slot, step)
        plant = self._trains.plants[slot]
        distance_m = sign_m - float(self._trains.truths[slot].position_m)
        return self._model.sample(distance_m, float(plant.speed_mps), self._chance[slot])

    def _again(self, slot: int, step: int) -> None:
        self._agenda.put(step + self._every_steps, Due.CAMERA, self._trains.stock_ids[slot])

    def _sign_m(self, slot: int) -> float | None:
        """Path coordinate of the sign of the next mark; None without one, or when the front is past the mark."""
        duty, following = self._trains.duties[slot], self._next_target(slot)
        if duty is None or following >= len(duty.mission.targets):
            return None
        target = duty.mission.targets[following]
        if not self._vision.has_sign(target.station_id):
            return None
        planned = (
            duty.mission.path.piece_ids
        )  # the true path goes on beyond it, unless points have sent it elsewhere
        if self._trains.true_path(slot).piece_ids[: len(planned)] != planned:
            return None
        if self._trains.truths[slot].position_m > target.mark_m + SIGN_BEYOND_MARK_M / 2.0:
            return None
        return target.mark_m + SIGN_BEYOND_MARK_M
