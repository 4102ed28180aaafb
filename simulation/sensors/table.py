"""The sensors that a train has. A new one is a file and one entry in SENSORS; its faults are a file of its name.

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
from simulation.settings import PositionSensor
from simulation.setup import Setup
from vehicle.compiled import compiled_lines
from vehicle.record import dtype_of


def no_reader(_readers: Any, _setup: Setup, _stock_id: str) -> None:  # noqa: ANN401 - rows of all readers
    """What a sensor shows needs no settings on board."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """One sensor: its compiled function, the class of its own row, and what fills that row when a run begins.

    `fit_reader` gives its reader on board the settings that it goes by, in the readers' rows. `carried` is its word in
    `sensors.carries`, None where all trains have it. The rest is for docs/sensors.md: what it may do to the `estimate`
    and to the `bounds`, the module of `onboard.localisation` that says what it means, the table of a scenario that has
    its settings, and its keys there where they are not all.
    """

    function: Callable[..., None]
    row: type
    fit: Callable[[Any, Setup, str], None]  # own row, setup, stock id
    fit_reader: Callable[[Any, Setup, str], None] = no_reader
    carried: PositionSensor | None = None
    title: str
    estimate: str
    bounds: str
    meant_by: str = ""
    table: str = ""
    keys: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name of its row."""
        return self.function.__name__


SENSORS: Final = (
    Sensor(
        function=tacho.tachometer,
        row=tacho.TachometerRow,
        fit=tacho.fit,
        title="Wheels (速度発電機)",
        estimate="moves with every pulse",
        bounds="widened only: by distance, by slides and slips, by the difference to another axle",
        meant_by="tachometer",
        table="sensors",
        keys=("wheel_factor_sigma", "creep_share", "tread_conicity", "flangeway_m", "tachometer_axle"),
    ),
    Sensor(
        function=slide_protection.slide_protection,
        row=slide_protection.SlideProtectionRow,
        fit=slide_protection.fit,
        title="Slide protection (滑走防止装置)",
        estimate="none of its own: shows the wheels' reader when not to rely on wheels, and another axle",
        bounds="widened while wheels slide or slip, and by the difference of the two axles",
        meant_by="axles",
    ),
    Sensor(
        function=load.load_sensor,
        row=load.LoadSensorRow,
        fit=load.fit,
        title="Load sensor (応荷重)",
        estimate="none: it measures the load",
        bounds="none",
    ),
    Sensor(
        function=tag_reader.tag_reader,
        row=tag_reader.TagReaderRow,
        fit=tag_reader.fit,
        carried=PositionSensor.TAGS,
        title="Tags (地上子)",
        estimate="moved to the tag",
        bounds="set from the tags read last; a tag that disagrees widens them",
        meant_by="tags",
        table="sensors",
        keys=("tag_read_sigma_m", "tag_read_max_m", "tags", "tag_bit_error_factor"),
    ),
    Sensor(
        function=sign_camera.sign_camera,
        row=sign_camera.SignCameraRow,
        fit=sign_camera.fit,
        title="Camera (停止位置目標)",
        estimate="moved towards each sighting, inside the bounds",
        bounds="none",
        meant_by="sighting",
        table="vision",
    ),
    Sensor(
        function=gnss.gnss_receiver,
        row=gnss.GnssReceiverRow,
        fit=gnss.fit,
        carried=PositionSensor.GNSS,
        title="Satellites (GNSS)",
        estimate="moved; inside the bounds only, where part of the sky is hidden",
        bounds="cut to the protection level under an open sky, plus the receiver's errors seen so far",
        meant_by="gnss",
        table="gnss",
    ),
    Sensor(
        function=beacon.beacon_receiver,
        row=beacon.BeaconReceiverRow,
        fit=beacon.fit,
        fit_reader=beacon.fit_reader,
        carried=PositionSensor.BEACONS,
        title="Beacons of the train stop (ATS 地上子)",
        estimate="moved towards a beacon in its window, inside the bounds",
        bounds='cut by a beacon with a number, by no other (`trust = "paper"` is for the reproduction)',
        meant_by="beacons",
        table="beacons",
    ),
    Sensor(
        function=yaw_gyro.yaw_gyro,
        row=yaw_gyro.YawGyroRow,
        fit=yaw_gyro.fit,
        carried=PositionSensor.CURVATURE,
        title="Curvature (線路曲率照合): a yaw gyro and a map",
        estimate="moved to the best match",
        bounds="cut to the shifts that noise and one jump of the bias can explain",
        meant_by="curvature",
        table="curvature",
    ),
    Sensor(
        function=lidar.lidar,
        row=lidar.LidarSensorRow,
        fit=lidar.fit,
        fit_reader=lidar.fit_reader,
        carried=PositionSensor.LIDAR,
        title="LiDAR and markers (ターゲットマーカ)",
        estimate="moved to a marker that was read",
        bounds="cut to the greatest error of a marker that was read",
        meant_by="lidar",
        table="lidar",
    ),
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
