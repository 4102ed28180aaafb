"""The sensors that a train has. A new one is a file of its own and one entry in SENSORS.

A sensor is a compiled function of its own row, the rows of all sensors, the scene and what is shown: it looks at the
scene of this step and writes into `sensed`. Its noise is counted by (seed, stock, step), so that the length of a
stretch changes nothing. The order of the table is the order in which they look.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Protocol, cast

from onboard.board import SensedRow
from simulation.sensors import beacon_receiver as beacon
from simulation.sensors import gnss, lidar, sign_camera, slide_protection, tag_reader, yaw_gyro
from simulation.sensors import load_sensor as load
from simulation.sensors import tachometer as tacho
from simulation.sensors.scene import SceneRow
from vehicle.compiled import compiled_lines
from vehicle.record import dtype_of

if TYPE_CHECKING:
    from simulation.setup import Setup


def no_reader(_readers: Any, _setup: Setup, _stock_id: str) -> None:  # noqa: ANN401 - rows of all readers
    """What a sensor shows needs no settings on board."""


@dataclass(frozen=True, slots=True)
class Sensor:
    """One sensor: its compiled function, the class of its own row, and what fills that row when a run begins.

    `fit_reader` gives its reader on board the settings that it goes by, in the readers' rows.
    """

    function: Callable[..., None]
    row: type
    fit: Callable[[Any, Setup, str], None]  # own row, setup, stock id
    fit_reader: Callable[[Any, Setup, str], None] = no_reader

    @property
    def name(self) -> str:
        """Name of its row."""
        return self.function.__name__


SENSORS: Final = (
    Sensor(tacho.tachometer, tacho.TachometerRow, tacho.fit),
    Sensor(slide_protection.slide_protection, slide_protection.SlideProtectionRow, slide_protection.fit),
    Sensor(load.load_sensor, load.LoadSensorRow, load.fit),
    Sensor(tag_reader.tag_reader, tag_reader.TagReaderRow, tag_reader.fit),
    Sensor(sign_camera.sign_camera, sign_camera.SignCameraRow, sign_camera.fit),
    Sensor(gnss.gnss_receiver, gnss.GnssReceiverRow, gnss.fit),
    Sensor(beacon.beacon_receiver, beacon.BeaconReceiverRow, beacon.fit, beacon.fit_reader),
    Sensor(yaw_gyro.yaw_gyro, yaw_gyro.YawGyroRow, yaw_gyro.fit),
    Sensor(lidar.lidar, lidar.LidarSensorRow, lidar.fit, lidar.fit_reader),
)


class SensorsRow(Protocol):
    """A row for each sensor under its name."""

    if TYPE_CHECKING:  # those that code outside the sensors' own files names
        tachometer: tacho.TachometerRow
        slide_protection: slide_protection.SlideProtectionRow
        tag_reader: tag_reader.TagReaderRow
        lidar: lidar.LidarSensorRow


SensorsRow.__annotations__.update({sensor.name: sensor.row for sensor in SENSORS})
SENSORS_ROW: Final = dtype_of(SensorsRow)

SenseAll = Callable[[SensorsRow, SceneRow, SensedRow], None]


def _sense_all() -> SenseAll:
    lines = ["def sense_all(sensors, scene, sensed):"]
    lines += [f"    {s.name}(sensors.{s.name}, sensors, scene, sensed)" for s in SENSORS]
    return cast("SenseAll", compiled_lines(lines, {s.name: s.function for s in SENSORS}, __name__))


sense_all: Final = _sense_all()
