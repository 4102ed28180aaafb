"""Train, path and settings of railtoolkit's schemas (running-path, rolling-stock; 2022.05), as TrainRuns reads them.

The few shapes of YAML that these files have: scalars, and lists of a line each. Everything else is bad input.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

from network.errors import InputError
from papers.trainruns_model import ReferenceTrain, UniformSection

KMH_PER_MPS: Final = 3.6
KG_PER_T: Final = 1000.0
LIST_ROW: Final = re.compile(r"^\s*-\s*\[(.*)\]\s*$")
SCALAR: Final = re.compile(r"^\s*(?:-\s+)?(\w+):\s*(.+?)\s*$")
HEAD: Final = re.compile(r"^(\s*)(?:-\s+)?(\w+):\s*$")
PATH_SCHEMA: Final = "https://railtoolkit.org/schema/running-path.json"
TRAIN_SCHEMA: Final = "https://railtoolkit.org/schema/rolling-stock.json"
# what that model takes where a file has nothing
AIR_PERMILLE: Final = 0.0
BRAKING_FREIGHT_MPS2, BRAKING_PASSENGER_MPS2 = 0.225, 0.375
LOCO_FACTOR, CARS_FACTOR = 1.09, 1.06
FASTEST_MPS: Final = 140.0


@dataclass(frozen=True, slots=True)
class ReferencePath:
    """Breaks of limit and gradient as the file has them (m, km/h, permille), and its points (m, of front or rear)."""

    file: str
    breaks: tuple[tuple[float, float, float], ...]
    points: tuple[tuple[float, bool], ...]  # m, whether the rear is meant

    @property
    def length_m(self) -> float:
        """From the first break to the last."""
        return self.breaks[-1][0] - self.breaks[0][0]

    def sections(self, train: ReferenceTrain) -> tuple[UniformSection, ...]:
        """Stretches of one limit and one gradient for a train, each with the points in it."""
        kept: list[tuple[float, float, float]] = []
        for begin_m, limit_kmh, permille in self.breaks[:-1]:
            limit_mps = min(limit_kmh / KMH_PER_MPS, train.limit_mps)
            if not kept or (limit_mps, permille) != kept[-1][1:]:
                kept.append((begin_m, limit_mps, permille))
        points_m = sorted(at_m + train.length_m * rear for at_m, rear in self.points)
        ends_m = [begin_m for begin_m, _, _ in kept[1:]] + [self.breaks[-1][0]]
        return tuple(
            UniformSection(b, e, limit, permille, (*(p for p in points_m if b < p < e), e))
            for (b, limit, permille), e in zip(kept, ends_m, strict=True)
        )


def read_path(file: Path) -> ReferencePath:
    """Read a path. Raises InputError."""
    lines = _lines(file, PATH_SCHEMA)
    rows = _lists(file, lines, "characteristic_sections")
    breaks = tuple(sorted((*_numbers(file, "characteristic_sections", row, 3),) for row in rows))
    if len(breaks) < 2 or any(after[0] <= before[0] for before, after in pairwise(breaks)):
        raise InputError(str(file), "characteristic_sections", len(breaks), "two places or more, each once")
    if any(limit_kmh <= 0.0 for _, limit_kmh, _ in breaks):
        raise InputError(str(file), "characteristic_sections", None, "speed limits above 0 km/h")
    points: list[tuple[float, bool]] = []
    for row in _lists(file, lines, "points_of_interest", needed=False):
        if len(row) != 3 or row[2] not in ("front", "rear"):
            raise InputError(str(file), "points_of_interest", ", ".join(row), "m, a name, front or rear")
        points.append((_number(file, "points_of_interest", row[0]), row[2] == "rear"))
    return ReferencePath(str(file), tuple((b[0], b[1], b[2]) for b in breaks), tuple(points))


def read_train(file: Path) -> ReferenceTrain:
    """Read a train: its formation of vehicles, one of them with motors. Raises InputError."""
    lines = _lines(file, TRAIN_SCHEMA)
    formation_text = _scalar(file, lines, "formation").strip("[]")
    formation = [name.strip() for name in formation_text.split(",")]
    vehicles = _vehicles(file, lines)
    missing = [name for name in formation if name not in vehicles]
    if missing:
        raise InputError(str(file), "formation", missing[0], "one of the vehicles: " + ", ".join(vehicles))
    powered = [name for name in dict.fromkeys(formation) if vehicles[name].powered]
    if len(powered) != 1 or formation.count(powered[0]) != 1:
        raise InputError(str(file), "formation", formation_text, "one vehicle with motors")
    unit = vehicles[powered[0]]
    cars = [vehicles[name] for name in formation if name != powered[0]]
    return _train(file, unit, cars)


@dataclass(frozen=True, slots=True)
class _Vehicle:
    """One vehicle: its scalars by key and its tractive effort."""

    file: Path
    values: Mapping[str, str]
    effort: tuple[tuple[float, float], ...]

    @property
    def kind(self) -> str:
        return self.values.get("vehicle_type", "")

    @property
    def powered(self) -> bool:
        return self.kind in ("traction unit", "multiple unit")

    def number(self, key: str, otherwise: float | None = None) -> float:
        text = self.values.get(key)
        if text is None and otherwise is not None:
            return otherwise
        return _number(self.file, key, text)

    @property
    def loaded_t(self) -> float:
        return self.number("mass") + self.number("load_limit", 0.0)


def _train(file: Path, unit: _Vehicle, cars: list[_Vehicle]) -> ReferenceTrain:
    everyone = [unit, *cars]
    freight = all(vehicle.kind in ("freight", "traction unit") for vehicle in everyone)
    unit_t, driving_t = unit.number("mass"), unit.number("mass_traction", unit.number("mass"))
    empty_t = sum(vehicle.number("mass") for vehicle in everyone)
    turning_t = unit.number("rotation_mass", LOCO_FACTOR) * unit_t
    turning_t += sum(car.number("rotation_mass", CARS_FACTOR) * car.number("mass") for car in cars)
    factor = turning_t / empty_t if cars else unit.number("rotation_mass", LOCO_FACTOR)
    braking = unit.number("a_braking", -(BRAKING_FREIGHT_MPS2 if freight else BRAKING_PASSENGER_MPS2))
    if braking >= 0.0:
        raise InputError(str(file), "a_braking", braking, "below 0 m/s^2")
    if not unit.effort:
        raise InputError(str(file), "tractive_effort", None, "pairs of km/h and N")

    def mean(key: str) -> float:
        return sum(car.number(key, 0.0) for car in cars) / len(cars) if cars else 0.0

    limits_kmh = [vehicle.number("speed_limit", FASTEST_MPS * KMH_PER_MPS) for vehicle in everyone]
    return ReferenceTrain(
        length_m=sum(vehicle.number("length") for vehicle in everyone),
        mass_kg=sum(vehicle.loaded_t for vehicle in everyone) * KG_PER_T,
        driving_kg=driving_t * KG_PER_T,
        carrying_kg=(unit_t - driving_t) * KG_PER_T,
        cars_kg=sum(car.loaded_t for car in cars) * KG_PER_T,
        mass_factor=factor,
        limit_mps=min(limits_kmh) / KMH_PER_MPS,
        braking_mps2=-braking,
        freight=freight,
        driving_permille=unit.number("base_resistance", 0.0),
        carrying_permille=unit.number("rolling_resistance", 0.0),
        air_permille=unit.number("air_resistance", AIR_PERMILLE),
        cars_base_permille=mean("base_resistance"),
        cars_rolling_permille=mean("rolling_resistance"),
        cars_air_permille=mean("air_resistance"),
        effort=tuple((kmh / KMH_PER_MPS, newton) for kmh, newton in unit.effort),
    )


def _vehicles(file: Path, lines: list[str]) -> dict[str, _Vehicle]:
    begin = next((i for i, line in enumerate(lines) if line.rstrip() == "vehicles:"), None)
    if begin is None:
        raise InputError(str(file), "vehicles", None, "a list of vehicles")
    blocks: list[list[str]] = []
    for line in lines[begin + 1 :]:
        if re.match(r"^ {0,2}-\s+\w+:", line):
            blocks.append([])
        if blocks:
            blocks[-1].append(line)
    found: dict[str, _Vehicle] = {}
    for block in blocks:
        values = {m[1]: _plain(m[2]) for line in block if (m := SCALAR.match(line)) is not None}
        rows = _lists(file, block, "tractive_effort", needed=False)
        effort = tuple(tuple(_numbers(file, "tractive_effort", row, 2)) for row in rows)
        pairs = tuple((pair[0], pair[1]) for pair in effort)
        if any(after[0] <= before[0] for before, after in pairwise(pairs)):
            raise InputError(str(file), "tractive_effort", None, "speeds that grow")
        if "id" not in values:
            raise InputError(str(file), "vehicles", values.get("name"), "an id")
        found[values["id"]] = _Vehicle(file, values, pairs)
    return found


def _lines(file: Path, schema: str) -> list[str]:
    """Lines without comments, of a file of this schema."""
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(file), "", None, "a file that can be read") from error
    lines = [re.sub(r"(^|\s)#.*$", "", line).rstrip() for line in text.splitlines()]
    lines = [line for line in lines if line]
    if _plain(_scalar(file, lines, "schema")) != schema:
        raise InputError(str(file), "schema", _scalar(file, lines, "schema"), schema)
    return lines


def _plain(text: str) -> str:
    return text.strip().strip("\"'")


def _scalar(file: Path, lines: list[str], key: str) -> str:
    values = (m[2] for line in lines if (m := SCALAR.match(line)) is not None and m[1] == key)
    found = next(values, None)
    if found is None:
        raise InputError(str(file), key, None, "a value")
    return found


def _lists(file: Path, lines: list[str], key: str, *, needed: bool = True) -> list[list[str]]:
    """The rows of the list of lists under a key."""
    heads = [i for i, line in enumerate(lines) if (m := HEAD.match(line)) is not None and m[2] == key]
    if not heads:
        if needed:
            raise InputError(str(file), key, None, "a list of lists")
        return []
    rows: list[list[str]] = []
    for line in lines[heads[0] + 1 :]:
        row = LIST_ROW.match(line)
        if row is None:
            break
        rows.append([_plain(cell) for cell in row[1].split(",")])
    return rows


def _numbers(file: Path, key: str, row: list[str], count: int) -> tuple[float, ...]:
    if len(row) != count:
        raise InputError(str(file), key, ", ".join(row), f"{count} numbers")
    return tuple(_number(file, key, cell) for cell in row)


def _number(file: Path, key: str, text: str | None) -> float:
    try:
        value = float(text or "")
    except ValueError:
        raise InputError(str(file), key, text, "a number") from None
    if not math.isfinite(value):
        raise InputError(str(file), key, text, "a finite number")
    return value
