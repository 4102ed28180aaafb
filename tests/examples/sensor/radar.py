"""A Doppler radar under the floor: the train's own speed, whatever its wheels do, wrong by a constant."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Final, Protocol

from onboard.board import SensedRow
from simulation.sensors.noise import source_of, uniform
from simulation.sensors.scene import SceneRow
from vehicle.compiled import compiled

if TYPE_CHECKING:
    from simulation.setup import Setup

BIAS_MAX_MPS: Final = 0.05  # assumed: how far it is mounted off its angle


class RadarRow(Protocol):
    """One train's radar."""

    bias_mps: Annotated[float, "shown less real speed"]


def fit(own: RadarRow, setup: Setup, stock_id: str) -> None:
    """Each train has a bias of its own, within the largest."""
    drawn = uniform(source_of(setup.seed, "radar", stock_id), 0)
    own.bias_mps = BIAS_MAX_MPS * (2.0 * drawn - 1.0)


@compiled
def radar(own: RadarRow, _sensors: Any, scene: SceneRow, sensed: SensedRow) -> None:  # noqa: ANN401
    """Show the train's speed."""
    sensed.readings.radar_run.speed_mps = scene.speed_mps + own.bias_mps
