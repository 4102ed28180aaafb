"""A Doppler radar under the floor: the train's own speed, whatever its wheels do, wrong by a constant."""

from __future__ import annotations

from typing import Annotated, Any, Protocol

from onboard.board import SensedRow
from simulation.sensors.noise import source_of, uniform
from simulation.sensors.scene import SceneRow
from simulation.settings import PositionSensor
from simulation.setup import Setup
from vehicle.compiled import compiled


class RadarRow(Protocol):
    """One train's radar."""

    fitted: Annotated[int, "1: the train has one"]
    bias_mps: Annotated[float, "shown less real speed"]
    knocked_mps: Annotated[float, "what a fault adds"]


def fit(own: RadarRow, setup: Setup, stock_id: str) -> None:
    """Each train has a bias of its own, within the largest."""
    drawn = uniform(source_of(setup.seed, "radar", stock_id), 0)
    own.fitted = int(PositionSensor.RADAR in setup.sensors.carried_by(stock_id))
    own.bias_mps = setup.radar.bias_max_mps * (2.0 * drawn - 1.0)


@compiled
def radar(own: RadarRow, _sensors: Any, scene: SceneRow, sensed: SensedRow) -> None:  # noqa: ANN401
    """Show the train's speed."""
    sensed.readings.radar_run.shown = own.fitted
    sensed.readings.radar_run.speed_mps = scene.speed_mps + own.bias_mps + own.knocked_mps
