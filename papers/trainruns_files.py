"""Train and path of railtoolkit's schemas (running-path, rolling-stock; 2022.05), as TrainRuns reads them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Final, Literal

import msgspec

from network.errors import InputError
from network.files.json_input import read_yaml
from papers.trainruns_model import ReferenceTrain, UniformSection
from vehicle.resistance import KMH_PER_MPS

KG_PER_T: Final = 1000.0
# what that model takes where a file has nothing
BRAKING_FREIGHT_MPS2, BRAKING_PASSENGER_MPS2 = 0.225, 0.375
LOCO_FACTOR, CARS_FACTOR = 1.09, 1.06
FASTEST_MPS: Final = 140.0

_Finite = Annotated[float, msgspec.Meta(ge=-1e9, le=1e9)]
_Above0 = Annotated[float, msgspec.Meta(gt=0.0, le=1e9)]
_From0 = Annotated[float, msgspec.Meta(ge=0.0, le=1e9)]


class _Way(msgspec.Struct):
    """One path: m, km/h, permille of its breaks; m, name and part of the train of its points."""

    characteristic_sections: Annotated[list[tuple[_Finite, _Above0, _Finite]], msgspec.Meta(min_length=2)]
    points_of_interest: list[tuple[_Finite, str | float, Literal["front", "rear"]]] = []


class _PathFile(msgspec.Struct):
    schema: Literal["https://railtoolkit.org/schema/running-path.json"]
    paths: Annotated[list[_Way], msgspec.Meta(min_length=1)]


class _Vehicle(msgspec.Struct, kw_only=True):
    """One vehicle: m, t, km/h, m/s^2 and permille; pairs of km/h and N."""

    id: str
    length: _Above0
    mass: _Above0
    vehicle_type: str = ""
    load_limit: _From0 = 0.0
    mass_traction: _From0 | None = None
    speed_limit: _Above0 = FASTEST_MPS * KMH_PER_MPS
    a_braking: Annotated[float, msgspec.Meta(lt=0.0, ge=-1e9)] | None = None
    rotation_mass: _Above0 | None = None
    base_resistance: _From0 = 0.0
    rolling_resistance: _From0 = 0.0
    air_resistance: _From0 = 0.0
    tractive_effort: tuple[tuple[_From0, _From0], ...] = ()

    @property
    def powered(self) -> bool:
        """Whether it has motors."""
        return self.vehicle_type in ("traction unit", "multiple unit")


class _Formed(msgspec.Struct):
    formation: list[str]


class _StockFile(msgspec.Struct):
    schema: Literal["https://railtoolkit.org/schema/rolling-stock.json"]
    trains: Annotated[list[_Formed], msgspec.Meta(min_length=1)]
    vehicles: list[_Vehicle]


@dataclass(frozen=True, slots=True)
class ReferencePath:
    """Breaks of limit and gradient as the file has them (m, km/h, permille), and its points (m, of front or rear)."""

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
    """Read the first path of a file. Raises InputError."""
    way = read_yaml(file, _PathFile).paths[0]
    breaks = tuple(sorted(way.characteristic_sections))
    _check_growing(file, "characteristic_sections", breaks)
    return ReferencePath(breaks, tuple((at_m, part == "rear") for at_m, _, part in way.points_of_interest))


def read_train(file: Path) -> ReferenceTrain:
    """Read the first train of a file: its formation of vehicles, one of them with motors. Raises InputError."""
    raw = read_yaml(file, _StockFile)
    vehicles = {vehicle.id: vehicle for vehicle in raw.vehicles}
    formation = raw.trains[0].formation
    missing = [name for name in formation if name not in vehicles]
    if missing:
        raise InputError(str(file), "formation", missing[0], "one of the vehicles: " + ", ".join(vehicles))
    formed = [vehicles[name] for name in formation]
    powered = [vehicle for vehicle in formed if vehicle.powered]
    if len(powered) != 1:
        raise InputError(str(file), "formation", len(powered), "one vehicle with motors")
    if not powered[0].tractive_effort:
        raise InputError(str(file), "tractive_effort", None, "pairs of km/h and N")
    _check_growing(file, "tractive_effort", powered[0].tractive_effort)
    return _train(powered[0], [vehicle for vehicle in formed if not vehicle.powered])


def _check_growing(file: Path, key: str, rows: Sequence[tuple[float, ...]]) -> None:
    """Each row begins above the one before. Raises InputError."""
    if any(after[0] <= before[0] for before, after in pairwise(rows)):
        raise InputError(str(file), key, None, "places or speeds that grow")


def _train(unit: _Vehicle, cars: list[_Vehicle]) -> ReferenceTrain:
    everyone = [unit, *cars]
    freight = all(vehicle.vehicle_type in ("freight", "traction unit") for vehicle in everyone)
    driving_t = unit.mass if unit.mass_traction is None else unit.mass_traction
    own_factor = LOCO_FACTOR if unit.rotation_mass is None else unit.rotation_mass
    turning_t = own_factor * unit.mass
    turning_t += sum((car.rotation_mass or CARS_FACTOR) * car.mass for car in cars)
    braking_mps2 = BRAKING_FREIGHT_MPS2 if freight else BRAKING_PASSENGER_MPS2

    def mean(values: Sequence[float]) -> float:
        return sum(values) / len(values) if values else 0.0

    return ReferenceTrain(
        length_m=sum(vehicle.length for vehicle in everyone),
        mass_kg=sum(vehicle.mass + vehicle.load_limit for vehicle in everyone) * KG_PER_T,
        driving_kg=driving_t * KG_PER_T,
        carrying_kg=(unit.mass - driving_t) * KG_PER_T,
        cars_kg=sum(car.mass + car.load_limit for car in cars) * KG_PER_T,
        mass_factor=turning_t / sum(vehicle.mass for vehicle in everyone) if cars else own_factor,
        limit_mps=min(vehicle.speed_limit for vehicle in everyone) / KMH_PER_MPS,
        braking_mps2=braking_mps2 if unit.a_braking is None else -unit.a_braking,
        freight=freight,
        driving_permille=unit.base_resistance,
        carrying_permille=unit.rolling_resistance,
        air_permille=unit.air_resistance,
        cars_base_permille=mean([car.base_resistance for car in cars]),
        cars_rolling_permille=mean([car.rolling_resistance for car in cars]),
        cars_air_permille=mean([car.air_resistance for car in cars]),
        effort=tuple((kmh / KMH_PER_MPS, newton) for kmh, newton in unit.tractive_effort),
    )
