"""What there is to be sensed in one step. Sensors look at this and at nothing else of the truth."""

from __future__ import annotations

from typing import Annotated, Final, Protocol

from vehicle.record import dtype_of

NO_TAG_M: Final = -1.0  # scene.tag_beyond_m where the front has passed none


class SceneRow(Protocol):
    """The truth of one step, as far as any sensor can show it; the kernel fills it."""

    step: Annotated[int, "since midnight; counts a sensor's noise"]
    now_s: Annotated[float, "simulated time since midnight"]
    step_s: float
    speed_mps: Annotated[float, "the train's"]
    acceleration_mps2: float
    wheel_mps: Annotated[float, "of the axle that is measured; not the train's while it slides"]
    last_wheel_mps: Annotated[float, "of the last axle"]
    wheel_run_m: Annotated[float, "what that axle has rolled in this step"]
    load_share: Annotated[float, "0 empty, 1 full"]
    tag_beyond_m: Annotated[float, "how far the front is past the tag that it passed in this step; -1: none"]
    sign_ahead_m: Annotated[float, "from the front to the next stop sign; +inf: none to be seen"]


SCENE: Final = dtype_of(SceneRow)
