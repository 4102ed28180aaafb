"""What a scenario's `[sensors]` says of single sets, checked against those there are."""

from __future__ import annotations

from collections.abc import Sequence

from network.errors import InputError
from network.files.toml_input import one_of
from simulation.sensor_settings import Curvature
from simulation.settings import PositionSensor, Sensors

AT_LEAST_ONE = "at least one of " + ", ".join(PositionSensor) + ": wheels alone tell no train where it is"


def check_sensors(file: str, sensors: Sensors, stock_ids: Sequence[str]) -> None:
    """All sets that are named exist, and each carries something, nothing twice, or InputError."""
    if not sensors.carries and set(sensors.carries_of) != set(stock_ids):
        raise InputError(file, "sensors.carries", [], AT_LEAST_ONE)
    for stock_id, carries in sensors.carries_of.items():
        key = f"sensors.carries_of.{stock_id}"
        if stock_id not in stock_ids:
            raise InputError(file, key, stock_id, f"a stock id: {one_of(stock_ids, stock_id)}")
        if not carries:
            raise InputError(file, key, [], AT_LEAST_ONE)
        _each_once(file, key, carries)
    _each_once(file, "sensors.carries", sensors.carries)


def check_window(file: str, sensors: Sensors, curvature: Curvature) -> None:
    """What trains with a gyro compare with the map may be as long as it has to be at least, or InputError."""
    if sensors.any_gyro and curvature.window_least_m > curvature.window_m:
        raise InputError(
            file,
            "curvature.window_least_m",
            curvature.window_least_m,
            f"at most curvature.window_m, {curvature.window_m:g} m: no train would compare anything",
        )


def _each_once(file: str, key: str, carries: Sequence[PositionSensor]) -> None:
    if len(set(carries)) < len(carries):
        raise InputError(file, key, [str(one) for one in carries], "each sensor once")
