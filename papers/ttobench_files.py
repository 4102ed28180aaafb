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
from typing import Annotated, Any, Final, Generic, Literal, TypeVar

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


_Unit = TypeVar("_Unit", bound=str)
_From0 = Annotated[float, msgspec.Meta(ge=0.0)]
_Above0 = Annotated[float, msgspec.Meta(gt=0.0)]
_Slope = Annotated[float, msgspec.Meta(ge=-200.0, le=200.0)]
_Share = Annotated[float, msgspec.Meta(gt=0.0, le=100.0)]


class _Value(msgspec.Struct, Generic[_Unit]):
    value: _From0
    unit: _Unit


class _Some(msgspec.Struct, Generic[_Unit]):
    """A value that must be above 0."""

    value: _Above0
    unit: _Unit


class _Percent(msgspec.Struct):
    value: _Share
    unit: Literal["%"]


class _Places(msgspec.Struct):
    values: Annotated[list[Annotated[float, msgspec.Meta(le=METRES_MAX)]], msgspec.Meta(min_length=2)]
    unit: Literal["m"]


class _LimitUnits(msgspec.Struct):
    position: Literal["m"]
    velocity: Literal["km/h"]


class _TrackLimits(msgspec.Struct):
    values: list[tuple[float, _Above0]]
    units: _LimitUnits


class _GradientUnits(msgspec.Struct):
    position: Literal["m"]
    slope: Literal["permil"]


class _TrackGradients(msgspec.Struct):
    values: list[tuple[float, _Slope]]
    units: _GradientUnits


class _TunnelUnits(msgspec.Struct):
    position: Literal["m"]
    length: Literal["m"]
    area: Literal["m^2"] = msgspec.field(name="cross section")


class _Tunnels(msgspec.Struct):
    values: list[tuple[_From0, _From0, float]]
    units: _TunnelUnits


class _DragUnits(msgspec.Struct):
    area: Literal["m^2"] = msgspec.field(name="cross section")
    coefficient: Literal["kN/(km/h)^2"]


class _Drag(msgspec.Struct):
    values: list[tuple[float, float]]
    units: _DragUnits


class _Metadata(msgspec.Struct):
    id: str


class _TrackFile(msgspec.Struct):
    metadata: _Metadata
    stops: _Places
    limits: _TrackLimits = msgspec.field(name="speed limits")
    gradients: _TrackGradients | None = None
    tunnels: _Tunnels | None = None


class _TrainFile(msgspec.Struct):
    metadata: _Metadata
    mass: _Some[Literal["kg"]]
    power: _Some[Literal["kW"]] = msgspec.field(name="max traction power")
    electric_power: _Value[Literal["kW"]] = msgspec.field(name="max reg braking power")
    force: _Some[Literal["kN"]] = msgspec.field(name="max traction force")
    electric: _Value[Literal["kN"]] = msgspec.field(name="max reg braking force")
    speed: _Some[Literal["km/h"]] = msgspec.field(name="max speed")
    r0: _Value[Literal["kN"]] = msgspec.field(name="rolling resistance r0")
    r1: _Value[Literal["kN/(km/h)"]] = msgspec.field(name="rolling resistance r1")
    r2: _Value[Literal["kN/(km/h)^2"]] = msgspec.field(name="rolling resistance r2")
    pulling: _Percent = msgspec.field(name="efficiency traction")
    regenerating: _Percent = msgspec.field(name="efficiency reg brake")
    friction: _Value[Literal["kN"]] | None = msgspec.field(name="max pn braking force", default=None)
    rho: _Value[Literal["%"]] | None = None
    length: _Some[Literal["m"]] | None = None
    acceleration: _Value[Literal["m/s^2"]] | None = msgspec.field(name="max acceleration", default=None)
    deceleration: _Value[Literal["m/s^2"]] | None = msgspec.field(name="max deceleration", default=None)
    tunnel: _Drag | None = msgspec.field(name="tunnel resistance", default=None)


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
    name, stops = str(file), tuple(raw.stops.values)
    if stops[0] != 0.0 or not _grows(stops):
        raise InputError(name, "stops", list(stops), "0 and positions that grow")
    limits = _steps(name, "speed limits", raw.limits.values, stops[-1])
    slopes = [(0.0, 0.0)] if raw.gradients is None else raw.gradients.values
    tunnels = () if raw.tunnels is None else tuple(raw.tunnels.values)
    if any(begin + length > stops[-1] for begin, length, _ in tunnels):
        raise InputError(name, "tunnels", None, "tunnels on the track")
    shown = tuple((at, limit / KMH_PER_MPS) for at, limit in limits)
    return TtobenchTrack(raw.metadata.id, stops, shown, _steps(name, "gradients", slopes, stops[-1]), tunnels)


def _given_or(value: _Value[_Unit] | None, factor: float, otherwise: float) -> float:
    """A value in another unit, or what holds where a file has none."""
    return otherwise if value is None else factor * value.value


def read_train(file: Path) -> BenchTrain:
    """Read a train. Raises InputError."""
    raw = read_json(file, _TrainFile)
    row = np.zeros(1, dtype=TRAIN)
    length_m = POINT_M if raw.length is None else raw.length.value
    weight_kn = raw.mass.value * GRAVITY_MPS2 * 1e-3
    resistance = {
        "motored_constant_n_per_kn": raw.r0.value * 1e3 / weight_kn,
        "motored_linear_n_per_kn_kmh": raw.r1.value * 1e3 / weight_kn,
        "air_n_per_kmh2": raw.r2.value * 1e3,
    }
    values = {
        "length_m": length_m,
        "mass_empty_kg": raw.mass.value,
        "rotating_mass_factor": _given_or(raw.rho, 1e-2, 0.0),
        "cars": 1.0,
        "motored_mass_share": 1.0,
        "traction_force_max_n": raw.force.value * 1e3,
        "traction_power_max_w": raw.power.value * 1e3,
        "motors": 1.0,
        "motored_axle_mass_share": 1.0,
        "regenerative_force_max_n": raw.electric.value * 1e3,
        "regenerative_power_max_w": raw.electric_power.value * 1e3,
        "regenerative_fade_from_mps": NEVER_MPS,
        "regenerative_fade_to_mps": NEVER_MPS,
        "efficiency_traction": raw.pulling.value * 1e-2,
        "efficiency_regeneration": raw.regenerating.value * 1e-2,
        "speed_max_mps": raw.speed.value * (1.0 / KMH_PER_MPS),
        "adhesion_dry": ADHESION,
    }
    for key, value in values.items():
        row[key] = value
    for key, value in resistance.items():
        row["resistance"][key] = value
    perfect = row.copy()
    perfect["efficiency_traction"] = perfect["efficiency_regeneration"] = 1.0
    drag = [] if raw.tunnel is None else raw.tunnel.values
    return BenchTrain(
        raw.metadata.id,
        row,
        perfect,
        length_m,
        _given_or(raw.friction, 1e3, 0.0),
        _given_or(raw.acceleration, 1.0, math.inf),
        _given_or(raw.deceleration, 1.0, NO_LIMIT_MPS2),
        tuple((area, factor * 1e3 * KMH_PER_MPS**2) for area, factor in drag),
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


def _grows(values: tuple[float, ...]) -> bool:
    return all(a < b for a, b in pairwise(values))


def _steps(
    name: str, key: str, pairs: list[tuple[float, float]], end_m: float
) -> tuple[tuple[float, float], ...]:
    places = tuple(at for at, _ in pairs)
    if not places or places[0] != 0.0 or not _grows(places) or places[-1] >= end_m:
        raise InputError(name, key, None, f"positions that grow from 0 and stay below {end_m:g} m")
    return tuple(pairs)
