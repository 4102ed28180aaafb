"""The tag reader (地上子読取): latches the tachometer where the front passed a tag, a little early or late. What the
tachometer has counted since is what it shows of the step evenly, also where wheels slide or it is out of order.

A fault of the tag may give a wrong id or none. In a run that reads tags bit by bit, transmission errors do so too
(`tag_air`).
"""

from __future__ import annotations

from typing import Annotated, Protocol

from onboard.board import SensedRow
from simulation.sensors.noise import normal, source_of
from simulation.sensors.scene import SceneRow
from simulation.sensors.tachometer import TachometerRow, counted_m
from simulation.setup import Setup
from vehicle.compiled import compiled


class TagReaderRow(Protocol):
    """One train's reader."""

    source: Annotated[int, "of its noise"]
    sigma_m: Annotated[float, "standard deviation of where it reads"]
    most_m: Annotated[float, "beyond this it discards"]
    latched_m: Annotated[float, "the tachometer when it read the last tag"]


class WithTachometer(Protocol):
    """The sensors of a train, as far as the reader needs them."""

    tachometer: TachometerRow


def fit(own: TagReaderRow, setup: Setup, stock_id: str) -> None:
    """A reader with noise of its own."""
    own.source = source_of(setup.seed, "tag reader", stock_id)
    own.sigma_m, own.most_m = setup.sensors.tag_read_sigma_m, setup.sensors.tag_read_max_m


@compiled
def tag_reader(own: TagReaderRow, sensors: WithTachometer, scene: SceneRow, _sensed: SensedRow) -> None:
    """Read the tag that the front passed in this step, if it passed one."""
    if scene.tag_beyond_m >= 0.0:
        latch(own, sensors.tachometer, scene, scene.tag_beyond_m)


@compiled
def latch(reader: TagReaderRow, tachometer: TachometerRow, scene: SceneRow, beyond_m: float) -> None:
    """Read the tag that the front passed in this step and is `beyond_m` past now."""
    error_m = min(max(reader.sigma_m * normal(reader.source, scene.step), -reader.most_m), reader.most_m)
    since_m = tachometer.step_m * beyond_m / scene.run_m if scene.run_m > 0.0 else 0.0
    reader.latched_m = counted_m(tachometer, tachometer.turned_m - since_m) + error_m
