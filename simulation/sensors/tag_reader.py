"""The tag reader (地上子読取): latches the tachometer where the front passed a tag, a little early or late.

Which id it reads, or that it reads none, is the tag's own fault; see `Trains.tag_faults`.
"""

from __future__ import annotations

from typing import Annotated, Protocol

from simulation.sensors.noise import normal
from simulation.sensors.tachometer import TachometerRow
from vehicle.compiled import compiled


class TagReaderRow(Protocol):
    """One train's reader."""

    source: Annotated[int, "of its noise"]
    sigma_m: Annotated[float, "standard deviation of where it reads"]
    most_m: Annotated[float, "beyond this it discards"]
    latched_m: Annotated[float, "the tachometer when it read the last tag"]


@compiled
def latch(reader: TagReaderRow, tachometer: TachometerRow, beyond_m: float, step: int) -> None:
    """Read the tag that the front passed in this step and is `beyond_m` past now."""
    error_m = min(max(reader.sigma_m * normal(reader.source, step), -reader.most_m), reader.most_m)
    counted_m = beyond_m * tachometer.gain / tachometer.wheel_factor * (1.0 + tachometer.miscount_share)
    at_tag_m = tachometer.odometer_m - counted_m
    reader.latched_m = at_tag_m + error_m
