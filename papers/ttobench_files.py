"""Tracks and trains of TTOBench (nuorail, release 1.5), in the project's own terms.

A track is its stops, and limits and gradients that hold from a position to the next; curvatures play no part here. A
train is a mass with limits of force and power and a quadratic resistance; efficiencies are constant. Names of keys
are those of the files.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from network.errors import InputError
from network.files.json_input import read_json
from vehicle.mass import GRAVITY_MPS2
from vehicle.optimum import Course
from vehicle.records import TRAIN
from vehicle.resistance import KMH_PER_MPS

Floats = NDArray[np.float64]

POINT_M: Final = 1.0  # length of a train whose file has none: gradients and limits are those of a point
NO_LIMIT_MPS2: Final = 1.0  # deceleration where a file has none, assumed: that of a metro's service brake
ADHESION: Final = 10.0  # the files know no adhesion: none that binds
NEVER_MPS: Final = -1.0  # the electric brake does not fade
METRES_MAX: Final = 500_000


class _Value(msgspec.Struct):
    value: float
    unit: str


class _Values(msgspec.Struct):
    values: list[float]
    unit: str


class _Pairs(msgspec.Struct):
    values: list[tuple[float, float]]
    units: dict[str, str]


class _Triples(msgspec.Struct):
    values: list[tuple[float, float, float]]
    units: dict[str, str]


class _Metadata(msgspec.Struct):
    id: str


class _TrackFile(msgspec.Struct):
    metadata: _Metadata
    stops: _Values
    limits: _Pairs = msgspec.field(name="speed limits")
    gradients: _Pairs | None = None
    tunnels: _Triples | None = None


class _TrainFile(msgspec.Struct):
    metadata: _Metadata
    mass: _Value
    power: _Value = msgspec.field(name="max traction power")
    electric_power: _Value = msgspec.field(name="max reg braking power")
    force: _Value = msgspec.field(name="max traction force")
    electric: _Value = msgspec.field(name="max reg braking force")
    speed: _Value = msgspec.field(name="max speed")
    r0: _Value = msgspec.field(name="rolling resistance r0")
    r1: _Value = msgspec.field(name="rolling resistance r1")
    r2: _Value = msgspec.field(name="rolling resistance r2")
    pulling: _Value = msgspec.field(name="efficiency traction")
    regenerating: _Value = msgspec.field(name="efficiency reg brake")
    friction: _Value | None = msgspec.field(name="max pn braking force", default=None)
    rho: _Value | None = None
    length: _Value | None = None
    acceleration: _Value | None = msgspec.field(name="max acceleration", default=None)
    deceleration: _Value | None = msgspec.field(name="max deceleration", default=None)
    tunnel: _Pairs | None = msgspec.field(name="tunnel resistance", default=None)


@dataclass(frozen=True, slots=True)
class TtobenchTrack:
    """A track; pairs are a position (m) and what holds from it on (m/s, permille), tunnels begin, length, area."""

    id: str
    stops_m: tuple[float, ...]
    limits: tuple[tuple[float, float], ...]
    gradients: tuple[tuple[float, float], ...]
    tunnels: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True, slots=True)
class BenchTrain:
    """A train; `row` has the file's efficiencies, `perfect` none lost. Tunnels by cross-section, N/(m/s)^2."""

    id: str
    row: NDArray[np.void]
    perfect: NDArray[np.void]
    length_m: float
    friction_n: float
    acceleration_mps2: float
    deceleration_mps2: float
    tunnel_n_per_mps2: tuple[tuple[float, float], ...]


def read_track(file: Path) -> TtobenchTrack:
    """Read a track. Raises InputError."""
    raw = read_json(file, _TrackFile)
    name = str(file)
    stops = tuple(raw.stops.values)
    _unit(name, "stops", raw.stops.unit, "m")
    if len(stops) < 2 or stops[0] != 0.0 or not _grows(stops) or not stops[-1] <= METRES_MAX:
        raise InputError(name, "stops", list(stops), f"0 and positions that grow, at most {METRES_MAX} m")
    _units(name, "speed limits", raw.limits.units, {"position": "m", "velocity": "km/h"})
    limits = _steps(name, "speed limits", raw.limits.values, stops[-1])
    if any(limit <= 0.0 for _, limit in limits):
        raise InputError(name, "speed limits", None, "limits above 0 km/h")
    gradients: tuple[tuple[float, float], ...] = ((0.0, 0.0),)
    if raw.gradients is not None:
        _units(name, "gradients", raw.gradients.units, {"position": "m", "slope": "permil"})
        gradients = _steps(name, "gradients", raw.gradients.values, stops[-1])
        if any(abs(slope) > 200.0 for _, slope in gradients):
            raise InputError(name, "gradients", None, "gradients of at most 200 permille")
    tunnels: tuple[tuple[float, float, float], ...] = ()
    if raw.tunnels is not None:
        wanted = {"position": "m", "length": "m", "cross section": "m^2"}
        _units(name, "tunnels", raw.tunnels.units, wanted)
        tunnels = tuple(raw.tunnels.values)
        if any(begin < 0.0 or length < 0.0 or begin + length > stops[-1] for begin, length, _ in tunnels):
            raise InputError(name, "tunnels", None, "tunnels on the track")
    shown = tuple((at, limit / KMH_PER_MPS) for at, limit in limits)
    return TtobenchTrack(raw.metadata.id, stops, shown, gradients, tunnels)


def read_train(file: Path) -> BenchTrain:
    """Read a train. Raises InputError."""
    raw = read_json(file, _TrainFile)
    name = str(file)

    def number(key: str, value: _Value | None, unit: str, factor: float, otherwise: float = 0.0) -> float:
        if value is None:
            return otherwise
        _unit(name, key, value.unit, unit)
        if not (math.isfinite(value.value) and value.value >= 0.0):
            raise InputError(name, key, value.value, "0 or above")
        return value.value * factor

    mass_kg = number("mass", raw.mass, "kg", 1.0)
    if mass_kg <= 0.0:
        raise InputError(name, "mass", mass_kg, "above 0 kg")
    row = np.zeros(1, dtype=TRAIN)
    length_m = number("length", raw.length, "m", 1.0, POINT_M)
    weight_kn = mass_kg * GRAVITY_MPS2 * 1e-3
    resistance = {
        "motored_constant_n_per_kn": number("rolling resistance r0", raw.r0, "kN", 1e3) / weight_kn,
        "motored_linear_n_per_kn_kmh": number("rolling resistance r1", raw.r1, "kN/(km/h)", 1e3) / weight_kn,
        "air_n_per_kmh2": number("rolling resistance r2", raw.r2, "kN/(km/h)^2", 1e3),
    }
    values = {
        "length_m": length_m,
        "mass_empty_kg": mass_kg,
        "rotating_mass_factor": number("rho", raw.rho, "%", 1e-2),
        "cars": 1.0,
        "motored_mass_share": 1.0,
        "traction_force_max_n": number("max traction force", raw.force, "kN", 1e3),
        "traction_power_max_w": number("max traction power", raw.power, "kW", 1e3),
        "motors": 1.0,
        "motored_axle_mass_share": 1.0,
        "regenerative_force_max_n": number("max reg braking force", raw.electric, "kN", 1e3),
        "regenerative_power_max_w": number("max reg braking power", raw.electric_power, "kW", 1e3),
        "regenerative_fade_from_mps": NEVER_MPS,
        "regenerative_fade_to_mps": NEVER_MPS,
        "efficiency_traction": _share(name, "efficiency traction", raw.pulling),
        "efficiency_regeneration": _share(name, "efficiency reg brake", raw.regenerating),
        "speed_max_mps": number("max speed", raw.speed, "km/h", 1.0 / KMH_PER_MPS),
        "adhesion_dry": ADHESION,
    }
    for key, value in values.items():
        row[key] = value
    for key, value in resistance.items():
        row["resistance"][key] = value
    if (
        min(
            length_m,
            *(values[key] for key in ("traction_force_max_n", "traction_power_max_w", "speed_max_mps")),
        )
        <= 0.0
    ):
        raise InputError(name, "", None, "length, force, power and speed above 0")
    perfect = row.copy()
    perfect["efficiency_traction"] = perfect["efficiency_regeneration"] = 1.0
    tunnel: tuple[tuple[float, float], ...] = ()
    if raw.tunnel is not None:
        _units(
            name,
            "tunnel resistance",
            raw.tunnel.units,
            {"cross section": "m^2", "coefficient": "kN/(km/h)^2"},
        )
        tunnel = tuple((area, factor * 1e3 * KMH_PER_MPS**2) for area, factor in raw.tunnel.values)
    return BenchTrain(
        raw.metadata.id,
        row,
        perfect,
        length_m,
        number("max pn braking force", raw.friction, "kN", 1e3),
        number("max acceleration", raw.acceleration, "m/s^2", 1.0, math.inf),
        number("max deceleration", raw.deceleration, "m/s^2", 1.0, NO_LIMIT_MPS2),
        tunnel,
    )


def read_tracks(folder: Path) -> dict[str, TtobenchTrack]:
    """Every track of a folder by its id. Raises InputError."""
    tracks = [read_track(file) for file in sorted(folder.glob("*.json"))]
    if not tracks:
        raise InputError(str(folder), "", None, "tracks, a JSON file each")
    return {track.id: track for track in tracks}


def read_trains(folder: Path) -> dict[str, BenchTrain]:
    """Every train of a folder by its id. Raises InputError."""
    trains = [read_train(file) for file in sorted(folder.glob("*.json"))]
    if not trains:
        raise InputError(str(folder), "", None, "trains, a JSON file each")
    return {train.id: train for train in trains}


def course_of(
    track: TtobenchTrack,
    train: BenchTrain,
    *,
    perfect: bool,
    end_mps: float = 0.0,
    friction: bool = True,
    from_m: float = 0.0,
    to_m: float | None = None,
) -> Course:
    """The run of a train over a track, or a part of it, with this speed at both ends.

    A limit holds for the front until the rear has left it; a tunnel resists by the share of the train inside.
    InputError where a train that knows tunnels does not know the cross-section of one.
    """
    stop_m = track.stops_m[-1] if to_m is None else to_m
    metres = math.ceil(track.stops_m[-1]) + 2
    at_m = np.arange(metres, dtype=np.float64)
    rows: Any = train.perfect if perfect else train.row
    return Course(
        rows[0],
        0.0,
        _heights_m(track, at_m),
        _limits_mps(track, train, metres),
        from_m,
        stop_m,
        deceleration_mps2=train.deceleration_mps2,
        initial_mps=end_mps,
        final_mps=end_mps,
        friction_brake_n=train.friction_n if friction else 0.0,
        acceleration_mps2=train.acceleration_mps2,
        drag_n_per_mps2=_drag(track, train, metres),
    )


def _heights_m(track: TtobenchTrack, at_m: Floats) -> Floats:
    """Height above the start at each metre."""
    places = [at for at, _ in track.gradients]
    slopes = np.array([slope for _, slope in track.gradients]) * 1e-3
    ends = np.array([*places, max(float(at_m[-1]), places[-1] + 1.0)])
    heights = np.concatenate(([0.0], np.cumsum(slopes * np.diff(ends))))
    return np.interp(at_m, ends, heights)


def _limits_mps(track: TtobenchTrack, train: BenchTrain, metres: int) -> Floats:
    """The limit for the front on each metre."""
    limit = np.full(metres, math.inf)
    behind_m = train.length_m if train.length_m > POINT_M else 0.0
    ends = [at for at, _ in track.limits[1:]] + [float(metres)]
    for (begin, mps), end in zip(track.limits, ends, strict=True):
        cut = slice(math.floor(begin), math.ceil(end + behind_m))
        limit[cut] = np.minimum(limit[cut], mps)
    return limit


def _drag(track: TtobenchTrack, train: BenchTrain, metres: int) -> Floats | None:
    """Further resistance of tunnels on each metre, N/(m/s)^2."""
    if not track.tunnels or not train.tunnel_n_per_mps2:
        return None
    by_area = dict(train.tunnel_n_per_mps2)
    middle = np.arange(metres) + 0.5
    drag = np.zeros(metres)
    for begin, length, area in track.tunnels:
        if area not in by_area:
            known = ", ".join(f"{a:g}" for a in by_area)
            raise InputError(track.id, "tunnels", area, f"a cross-section that {train.id} knows: {known}")
        inside = np.minimum(middle, begin + length) - np.maximum(middle - train.length_m, begin)
        drag += by_area[area] * np.clip(inside / train.length_m, 0.0, 1.0)
    return drag


def _share(name: str, key: str, value: _Value) -> float:
    _unit(name, key, value.unit, "%")
    if not 0.0 < value.value <= 100.0:
        raise InputError(name, key, value.value, "above 0 and at most 100 %")
    return value.value * 1e-2


def _grows(values: tuple[float, ...]) -> bool:
    return all(math.isfinite(value) for value in values) and all(a < b for a, b in pairwise(values))


def _steps(
    name: str, key: str, pairs: list[tuple[float, float]], end_m: float
) -> tuple[tuple[float, float], ...]:
    places = tuple(at for at, _ in pairs)
    if not places or places[0] != 0.0 or not _grows(places) or places[-1] >= end_m:
        raise InputError(name, key, None, f"positions that grow from 0 and stay below {end_m:g} m")
    if not all(math.isfinite(value) for _, value in pairs):
        raise InputError(name, key, None, "finite numbers")
    return tuple(pairs)


def _unit(name: str, key: str, unit: str, wanted: str) -> None:
    if unit != wanted:
        raise InputError(name, f"{key}.unit", unit, wanted)


def _units(name: str, key: str, units: dict[str, str], wanted: dict[str, str]) -> None:
    for part, unit in wanted.items():
        _unit(name, f"{key}.units.{part}", units.get(part, ""), unit)
