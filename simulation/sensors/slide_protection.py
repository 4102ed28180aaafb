"""The slide protection (滑走防止装置): compares axles, and so tells whether the wheels slide or slip."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Final, Protocol

from onboard.board import SensedRow
from simulation.sensors.scene import SceneRow
from vehicle.compiled import compiled

if TYPE_CHECKING:
    from simulation.setup import Setup

SEEN_MPS: Final = 0.05  # it compares axles no finer than this


class SlideProtectionRow(Protocol):
    """One train's protection."""

    seen_mps: Annotated[float, "a difference up to this passes for rolling"]


def fit(own: SlideProtectionRow, _setup: Setup, _stock_id: str) -> None:
    """The same on every train."""
    own.seen_mps = SEEN_MPS


@compiled
def slide_protection(
    own: SlideProtectionRow,
    _sensors: Any,  # noqa: ANN401
    scene: SceneRow,
    sensed: SensedRow,
) -> None:
    """Show -1 where the wheels slide, 1 where they slip, 0 where they roll."""
    difference = scene.wheel_mps - scene.speed_mps
    sensed.wheel_slide = 0
    if abs(difference) > own.seen_mps:
        sensed.wheel_slide = -1 if difference < 0.0 else 1
