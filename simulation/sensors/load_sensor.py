"""The load sensor (応荷重装置): the pressure of the air springs, as a share of the full load."""

from __future__ import annotations

from typing import Annotated, Any, Protocol

from onboard.board import SensedRow
from simulation.sensors.scene import SceneRow
from simulation.setup import Setup
from vehicle.compiled import compiled


class LoadSensorRow(Protocol):
    """One train's load sensor."""

    factor: Annotated[float, "load shown over real load"]


def fit(own: LoadSensorRow, _setup: Setup, _stock_id: str) -> None:
    """Shows the load as it is."""
    own.factor = 1.0


@compiled
def load_sensor(own: LoadSensorRow, _sensors: Any, scene: SceneRow, sensed: SensedRow) -> None:  # noqa: ANN401
    """Show the load."""
    sensed.load_share = own.factor * scene.load_share
