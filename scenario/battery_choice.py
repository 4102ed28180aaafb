"""What a scenario's `[battery]` says of sets and trains, checked against those there are; trains on a cold day."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from network.errors import InputError
from network.files.toml_input import one_of
from network.timetable import AtPortal, Timetable
from simulation.battery_settings import BatterySettings
from vehicle.train_file import TrainType


def check_battery(
    file: str, battery: BatterySettings | None, timetable: Timetable, trains: Mapping[str, TrainType]
) -> None:
    """Some set has a battery, and all sets and trains that are named exist, or InputError."""
    if battery is None:
        return
    with_one = sorted(stock_id for stock_id, kind in trains.items() if kind.battery is not None)
    if not with_one:
        expected = "a train file with a [battery] for a set at least, as ev_e301 has one"
        raise InputError(file, "battery", None, expected)
    for stock_id in battery.start_of:
        if stock_id not in with_one:
            expected = f"a stock id of a set with a battery, {one_of(with_one, stock_id)}"
            raise InputError(file, f"battery.start_of.{stock_id}", stock_id, expected)
    leaving = [t.number for t in timetable.trains.values() if isinstance(t.ends, AtPortal)]
    for number in battery.beyond_after:
        if number not in leaving:
            expected = f"a train that leaves the line by a portal, {one_of(leaving, number)}"
            raise InputError(file, f"battery.beyond_after.{number}", number, expected)


def heated_trains(trains: Mapping[str, TrainType], battery: BatterySettings | None) -> dict[str, TrainType]:
    """Trains with the auxiliaries of the scenario's day."""
    if battery is None or battery.heating_kw == 0.0:
        return dict(trains)
    return {stock_id: _heated(kind, battery.heating_kw) for stock_id, kind in trains.items()}


def _heated(kind: TrainType, heating_kw: float) -> TrainType:
    row = kind.row.copy()
    row["auxiliary_power_w"] += heating_kw * 1e3
    row.flags.writeable = False
    return replace(kind, row=row)
