"""The sensors that a train has. A new one is a file and one entry in SENSORS; its faults are a file of its name.

A sensor is a compiled function of its own row, the rows of all sensors, the scene and what is shown: it looks at the
scene of this step and writes into `sensed`. Its noise is counted by (seed, stock, step), so that the length of a
stretch changes nothing. The order of the table is the order in which they look.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
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
class SensorPage:
    """What docs/sensors.md says of a sensor: what it may do to the `estimate` and to the `bounds`.

    `meant_by` is the module of `onboard.localisation` that says what it means; `settings` has the tables of a scenario
    with its settings, each with its keys there, none where it has all of them.
    """

    title: str
    estimate: str
    bounds: str
    meant_by: str = ""
    settings: Mapping[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]])


@dataclass(frozen=True, slots=True)
class Sensor:
    """One sensor: its compiled function, the class of its own row, and what fills that row when a run begins.

    `fit_reader` gives its reader on board the settings that it goes by, in the readers' rows. `carried` is its word in
    `sensors.carries`, None where all trains have it.
    """

    function: Callable[..., None]
    row: type
    fit: Callable[[Any, Setup, str], None]  # own row, setup, stock id
    page: SensorPage
    fit_reader: Callable[[Any, Setup, str], None] = no_reader
    carried: PositionSensor | None = None

    @property
    def name(self) -> str:
        """Name of its row."""
        return self.function.__name__


SENSORS: Final = (
    Sensor(
        tacho.tachometer,
        tacho.TachometerRow,
        tacho.fit,
        SensorPage(
            title="Wheels (速度発電機)",
            estimate="moves with every pulse",
            bounds="widened only: by distance, by slides and slips, by the difference to another axle",
            meant_by="tachometer",
            settings={
                "sensors": (
                    "wheel_factor_sigma",
                    "creep_share",
                    "tread_conicity",
                    "flangeway_m",
                    "tachometer_axle",
                )
            },
        ),
    ),
    Sensor(
        slide_protection.slide_protection,
        slide_protection.SlideProtectionRow,
        slide_protection.fit,
        SensorPage(
            title="Slide protection (滑走防止装置)",
            estimate="none of its own: shows the wheels' reader when not to rely on wheels, and another axle",
            bounds="widened while wheels slide or slip, and by the difference of the two axles",
            meant_by="axles",
        ),
    ),
    Sensor(
        load.load_sensor,
        load.LoadSensorRow,
        load.fit,
        SensorPage(
            title="Load sensor (応荷重)",
            estimate="none: it measures the load",
            bounds="none",
        ),
    ),
    Sensor(
        tag_reader.tag_reader,
        tag_reader.TagReaderRow,
        tag_reader.fit,
        SensorPage(
            title="Tags (地上子)",
            estimate="moved to the tag",
            bounds="set from the tags read last; a tag that disagrees widens them",
            meant_by="tags",
            settings={"sensors": ("tag_read_sigma_m", "tag_read_max_m", "tags", "tag_bit_error_factor")},
        ),
        carried=PositionSensor.TAGS,
    ),
    Sensor(
        sign_camera.sign_camera,
        sign_camera.SignCameraRow,
        sign_camera.fit,
        SensorPage(
            title="Camera (停止位置目標)",
            estimate="moved towards each sighting, inside the bounds",
            bounds="none",
            meant_by="sighting",
            settings={"vision": ()},
        ),
    ),
    Sensor(
        gnss.gnss_receiver,
        gnss.GnssReceiverRow,
        gnss.fit,
        SensorPage(
            title="Satellites (GNSS)",
            estimate="moved; inside the bounds only, where part of the sky is hidden",
            bounds="cut to the protection level under an open sky, plus the receiver's errors seen so far",
            meant_by="gnss",
            settings={"gnss": ()},
        ),
        carried=PositionSensor.GNSS,
    ),
    Sensor(
        beacon.beacon_receiver,
        beacon.BeaconReceiverRow,
        beacon.fit,
        SensorPage(
            title="Beacons of the train stop (ATS 地上子)",
            estimate="moved towards a beacon in its window, inside the bounds",
            bounds='cut by a beacon with a number, by no other (`trust = "paper"` is for the reproduction)',
            meant_by="beacons",
            settings={"beacons": ()},
        ),
        fit_reader=beacon.fit_reader,
        carried=PositionSensor.BEACONS,
    ),
    Sensor(
        yaw_gyro.yaw_gyro,
        yaw_gyro.YawGyroRow,
        yaw_gyro.fit,
        SensorPage(
            title="Curvature (線路曲率照合): a yaw gyro and a map",
            estimate="moved to the best match",
            bounds="cut to the shifts that noise and one jump of the bias can explain",
            meant_by="curvature",
            settings={"curvature": ()},
        ),
        carried=PositionSensor.CURVATURE,
    ),
    Sensor(
        lidar.lidar,
        lidar.LidarSensorRow,
        lidar.fit,
        SensorPage(
            title="LiDAR and markers (ターゲットマーカ)",
            estimate="moved to a marker that was read",
            bounds="cut to the greatest error of a marker that was read",
            meant_by="lidar",
            settings={"lidar": ()},
        ),
        fit_reader=lidar.fit_reader,
        carried=PositionSensor.LIDAR,
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
