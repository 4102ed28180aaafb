"""What a scenario's `[sensors]` says of single sets, checked against those there are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from network.errors import InputError
from network.files.toml_input import one_of
from simulation.settings import Carried, Sensors
from simulation.setup import Setup

AT_LEAST_ONE = "at least one of " + ", ".join(Carried) + ": wheels alone tell no train where it is"


def check_sensors(file: str, sensors: Sensors, stock_ids: Sequence[str]) -> None:
    """All sets that are named exist, and each carries something, or InputError."""
    if not sensors.carries and set(sensors.carries_of) != set(stock_ids):
        raise InputError(file, "sensors.carries", [], AT_LEAST_ONE)
    for stock_id, carries in sensors.carries_of.items():
        key = f"sensors.carries_of.{stock_id}"
        if stock_id not in stock_ids:
            raise InputError(file, key, stock_id, f"a stock id: {one_of(stock_ids, stock_id)}")
        if not carries:
            raise InputError(file, key, [], AT_LEAST_ONE)


def carrying(setup: Setup, *carries: Carried) -> Setup:
    """The same run with every stock carrying these sensors and no others."""
    return replace(setup, sensors=setup.sensors.model_copy(update={"carries": carries, "carries_of": {}}))
