"""What there is to be sensed in one step. Sensors look at this and at nothing else of the truth."""

from __future__ import annotations

from typing import Annotated, Final, Protocol

from vehicle.record import dtype_of

NO_TAG_M: Final = -1.0  # scene.tag_beyond_m where the front has passed none, beacon_beyond_m likewise


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
    run_m: Annotated[float, "the way that the train has run in this step"]
    load_share: Annotated[float, "0 empty, 1 full"]
    tag_beyond_m: Annotated[float, "how far the front is past the tag that it passed in this step; -1: none"]
    sign_ahead_m: Annotated[float, "from the front to the next stop sign; +inf: none to be seen"]
    # for wheels that creep, or have treads with a slope (`truth.wheels_vary`)
    used_adhesion: Annotated[float, "force under the measured axle over what it can pass on; < 0: brakes"]
    # for trains that carry more than tags (`carries_more`)
    carries_more: Annotated[int, "1: what follows is filled"]
    turned_rad: Annotated[
        float, "by which the leading car has turned to the right in this step, over its bogies"
    ]
    curvature_per_m: Annotated[float, "mean |curvature| of the alignment under the train"]
    sky: Annotated[float, "what the leading car sees of it: network.profile.NO_SKY to OPEN_SKY"]
    front_m: Annotated[float, "path coordinate of the front"]
    kilometrage_m: Annotated[float, "of the metre that the front is on"]
    down: Annotated[float, "1 where kilometrages grow ahead, else -1"]
    beacon_beyond_m: Annotated[
        float, "how far the front is past the beacon that it passed in this step; -1: none"
    ]
    beacon_number: int
    beacon_told: Annotated[int, "1: it tells its number"]
    markers_ahead_m: Annotated[float, "from the front to the next markers' first row; +inf: none"]
    markers_number: Annotated[int, "the pattern they lie in"]


SCENE: Final = dtype_of(SceneRow)
