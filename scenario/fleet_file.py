"""What a scenario says of single trains and stations, checked against those there are; what trains have learned."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from network.errors import InputError
from network.files.json_input import read_json
from network.files.text_input import existing_file
from network.files.toml_input import one_of
from network.model import Line
from network.raw import is_table
from network.timetable import Timetable
from onboard.driving.tuning import Learned, learned_from
from onboard.driving_settings import Driving
from onboard.localisation.marker_patterns import PATTERNS
from onboard.unit_records import UnitParameters
from simulation.design import overrated_brake
from simulation.events import WORLD
from simulation.scatter import ScatterSettings
from simulation.settings import Dispatch, Interlocking, Operation, PositionSensor, Sensors, Tuning, Vision
from simulation.setup import Setup
from vehicle.train_file import TrainType
from wayside.config import MANAGER_ID

PEOPLE: Final = ("controller", "staff", "crew")
_OWN_NAME: Final = "a name that is no other party's"


def check_parties(timetable_file: str, line_file: str, line: Line, timetable: Timetable) -> None:
    """Stock, terminals, level crossings, the block manager, the world and people have names that no two share."""
    taken: dict[str, str] = dict.fromkeys((MANAGER_ID, WORLD, *PEOPLE), "a party of every run")
    devices = [(f"points.{p.id}.terminal", p.terminal_id, "a point terminal") for p in line.points.values()]
    devices += [(f"crossings.{name}.id", name, "a level crossing") for name in line.crossings]
    for key, name, what in devices:
        if taken.setdefault(name, what) != what:
            raise InputError(line_file, key, name, f"{_OWN_NAME}; {taken[name]} has it")
    for i, diagram in enumerate(timetable.diagrams):
        if (whose := taken.get(diagram.stock_id)) is not None:
            key = f"diagrams[{i}].stock"
            raise InputError(timetable_file, key, diagram.stock_id, f"{_OWN_NAME}; {whose} has it")


def check_centre(file: str, operation: Operation, stations: Collection[str]) -> None:
    """A centre is named only where there is one, at a station that exists, or InputError."""
    if operation.centre is None:
        return
    if operation.interlocking is Interlocking.ONBOARD:
        expected = 'no such key with interlocking = "onboard"'
        raise InputError(file, "operation.centre", operation.centre, expected)
    if operation.centre not in stations:
        expected = f"a station: {one_of(sorted(stations), operation.centre)}"
        raise InputError(file, "operation.centre", operation.centre, expected)


def check_given(file: str, dispatch: Dispatch, stock_ids: Iterable[str]) -> None:
    """An order of the day names sets that exist, or InputError."""
    known = sorted(stock_ids)
    if strangers := [stock_id for stock_id in dispatch.given if stock_id not in known]:
        raise InputError(file, "dispatch.given", strangers[0], f"a set: {one_of(known, strangers[0])}")


def check_cuts(file: str, dispatch: Dispatch, stations: Collection[str], trains: Collection[str]) -> None:
    """Stations where trains may turn back and trains that may be left out exist, or InputError."""
    for key, what, known in (("turn_back_at", "station", stations), ("cancel_trains", "train", trains)):
        for index, name in enumerate(getattr(dispatch, key)):
            if name not in known:
                expected = f"a {what}: {one_of(sorted(known), name)}"
                raise InputError(file, f"dispatch.{key}[{index}]", name, expected)


def check_scatter(file: str, scatter: ScatterSettings, stock_ids: Iterable[str]) -> None:
    """Every stock named exists, or InputError."""
    known = sorted(stock_ids)
    for stock_id in scatter.stock:
        if stock_id not in known:
            raise InputError(
                file, f"scatter.stock.{stock_id}", None, f"a stock id, {one_of(known, stock_id)}"
            )


def check_markers(file: str, setup: Setup) -> None:
    """Markers lie in patterns of the catalogue, where trains carry a LiDAR that looks for them."""
    if not any(PositionSensor.LIDAR in setup.sensors.carried_by(stock_id) for stock_id in setup.trains):
        return
    for line in (setup.line, setup.believed_line):
        for group in line.markers.values():
            if group.pattern > PATTERNS:
                raise InputError(
                    file,
                    f"markers.{group.id}.pattern",
                    group.pattern,
                    f"one of the catalogue, 1 to {PATTERNS}",
                )


def check_vision(file: str, vision: Vision, stations: Collection[str]) -> None:
    """Every station named exists and the camera's extra is installed, or InputError."""
    if vision.wanted and find_spec("cv2") is None:
        raise InputError(file, "vision", None, "the extra [vision] to be installed")
    for index, station_id in enumerate(() if vision.stations == "all" else vision.stations):
        if station_id not in stations:
            expected = f"a station id, {one_of(stations, station_id)}, or all"
            raise InputError(file, f"vision.stations[{index}]", station_id, expected)


def check_grip(file: str, driving: Driving, trains: Mapping[str, TrainType], line_max_mps: float) -> None:
    """No brake is guaranteed more than the design adhesion gives it on this line, or InputError."""
    for stock_id, train in trains.items():
        found = overrated_brake(driving, train, line_max_mps)
        if found is None:
            continue
        key, asked_mps2, grip_mps2 = found
        share, design = getattr(driving, key), driving.design_adhesion_share
        most = math.floor(100.0 * share * grip_mps2 / asked_mps2) / 100.0
        expected = (
            f"at most {most:.2f}: on driving.design_adhesion_share = {design:g} of the dry rail's adhesion,"
            f" {stock_id} ({train.id}) has grip for {grip_mps2:.2f} m/s^2 at its greatest speed here,"
            f" and this guarantees {asked_mps2:.2f}"
        )
        raise InputError(file, f"driving.{key}", share, expected)


def check_wheels(file: str, sensors: Sensors, unit: UnitParameters, trains: Mapping[str, TrainType]) -> None:
    """What a turn of the wheel is worth changes by no more than units allow for, or InputError."""
    left = unit.wheel_varies_share
    for stock_id, train in trains.items():
        varies = sensors.wheel_varies_share(float(train.row[0]["wheel_diameter_m"]))
        if sensors.wheels_vary and varies > left:
            expected = (
                f"creep and tread together at most {left:g}, which unit.wheel_error_share leaves beyond"
                f" unit.wheel_scale_limit: on the wheels of {stock_id} ({train.id}) they come to {varies:.4f}"
            )
            raise InputError(file, "sensors.creep_share", sensors.creep_share, expected)


def check_margins(file: str, driving: Driving) -> None:
    """The service brake comes before the emergency brake, or InputError."""
    least_mps = driving.service_margin_mps
    if driving.emergency_margin_mps < least_mps:
        expected = f"at least driving.service_margin_mps = {least_mps:g}: that brake comes first"
        raise InputError(file, "driving.emergency_margin_mps", driving.emergency_margin_mps, expected)


def learned_of(folders: Sequence[Path], tuning: Tuning, stock_ids: Iterable[str]) -> dict[str, Learned]:
    """What trains know to begin with, by stock id: from the file that `tuning` names, in the first folder with it."""
    if tuning.learned is None:
        return {}
    files = [folder / tuning.learned for folder in folders]
    known = read_learned(next(filter(existing_file, files), files[0]))
    return {stock_id: known[stock_id] for stock_id in stock_ids if stock_id in known}


def read_learned(path: Path) -> dict[str, Learned]:
    """What the trains of an earlier run learned, by stock id. InputError for a file that is not of that kind."""
    data = read_json(path, object)
    if not is_table(data) or not all(is_table(kept) for kept in data.values()):
        raise InputError(str(path), "", None, "an object of trains, as a run with [tuning] leaves it")
    return {str(stock_id): learned_from(str(path), kept) for stock_id, kept in data.items()}


def learned_json(learned: Mapping[str, Learned]) -> str:
    """The file's text, by stock id."""
    kept: dict[str, Any] = {stock_id: learned[stock_id].as_dict() for stock_id in sorted(learned)}
    return json.dumps(kept, indent=1) + "\n"
