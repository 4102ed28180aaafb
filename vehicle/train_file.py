"""Reads a train file (TOML) into a TRAIN row, and makes PLANT rows.

Keys end in their unit. Where people write other units than SI the ending says so and the value is converted:
`_kmh` and `_kmhps` (km/h, km/h/s), `_t`, `_kn`, `_kw`, `_kwh`, `_mm`. Every figure must be named in `[provenance]`,
by its key (`"body.length_m"`) or its table (`"body"`), with a source or a text that begins with "assumed".
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError, model_validator

from network.errors import InputError
from network.files import quantities
from network.files.kinds import about
from network.files.names import Identifier, Prose, Title
from network.files.quantity import OUT_OF_RANGE, Quantity
from network.files.text_input import existing_file
from network.files.toml_input import Record, parse_table, read_text
from network.raw import is_list, is_table
from vehicle.battery import battery_row
from vehicle.battery_file import BatteryTable
from vehicle.loss_file import Losses, set_losses
from vehicle.record import put_settings
from vehicle.records import CURVE_POINTS_MAX, NOTCHES_MAX, PLANT, TRAIN
from vehicle.resistance_file import RunningResistance
from vehicle.train_checks import check_train

TRAINS_FOLDER: Final = Path(__file__).parent / "trains"
CURVE_ROWS_MAX: Final = 1000  # of a measured curve, read to an even grid of CURVE_POINTS_MAX
HOLDING_NOTCH: Final = -3.0
HOLDING_DECELERATION_MPS2: Final = 0.4

# Ending of a key in the file, ending in SI, factor and divisor (both, so that 36 km/h is 10 m/s to the bit).
UNITS: Final = (
    ("_kmhps", "_mps2", 1.0, 3.6),
    ("_kmh", "_mps", 1.0, 3.6),
    ("_kn", "_n", 1e3, 1.0),
    ("_kw", "_w", 1e3, 1.0),
    ("_mm", "_m", 1.0, 1e3),
    ("_kwh", "_j", 3.6e6, 1.0),
    ("_t", "_kg", 1e3, 1.0),
)
WRITTEN: Final = {
    "_kmhps": "km/h/s",
    "_kmh": "km/h",
    "_kn": "kN",
    "_kw": "kW",
    "_mm": "mm",
    "_t": "t",
    "_kwh": "kWh",
}


class _Body(Record):
    """`[body]`."""

    length_m: Annotated[quantities.TrainLength, about("length over couplers")]
    mass_empty_kg: Annotated[quantities.MassKg, about("mass empty, in working order")]
    mass_load_full_kg: Annotated[quantities.LoadKg, about("mass of a full load")]
    rotating_mass_factor: Annotated[quantities.RotatingMass, about("equivalent mass is mass times 1 + this")]
    cars: Annotated[quantities.Cars, about("number of cars")]
    motored_mass_share: Annotated[
        quantities.Share, about("share of the mass on motored cars, for the running resistance")
    ]
    motored_axle_mass_share: Annotated[
        quantities.ShareAbove0, about("share of the weight on driven axles, for adhesion")
    ]
    speed_max_mps: Annotated[quantities.SpeedMps, about("greatest speed")]


class _Traction(Record):
    """`[traction]`: force and power limits, or a measured curve in their place."""

    force_max_n: Annotated[quantities.ForceN, about("greatest force at the rim")]
    power_max_w: Annotated[quantities.PowerW, about("greatest power at the rim")]
    weak_field_speed_mps: Annotated[
        quantities.SpeedFrom0Mps, about("above it the force falls with the square of speed; 0: never")
    ] = 0.0
    notch_share: Annotated[
        list[quantities.ShareAbove0],
        Field(min_length=1, max_length=NOTCHES_MAX - 1),
        about("share of the full force, by notch"),
    ]
    notch_speed_cap_mps: Annotated[
        list[quantities.SpeedFrom0Mps], about("a notch pulls up to this speed; 0: no cap")
    ] = Field(default_factory=list[float])
    load_compensated: Annotated[bool, about("the force limit grows with the load")] = False
    curve_speed_mps: Annotated[
        list[quantities.SpeedFrom0Mps],
        Field(max_length=CURVE_ROWS_MAX),
        about("measured curve: speeds, from 0"),
    ] = Field(default_factory=list[float])
    curve_force_n: Annotated[
        list[quantities.BrakeForceN],
        Field(max_length=CURVE_ROWS_MAX),
        about("measured curve: full-notch force"),
    ] = Field(default_factory=list[float])
    dead_time_s: Annotated[quantities.DeadTime, about("time from command to first force")]
    lag_s: Annotated[quantities.Lag, about("time constant of the build-up")]
    jerk_max_mps3: Annotated[quantities.Jerk, about("limit of the build-up; 0: none")]
    motors: Annotated[quantities.Motors, about("number of motors")]

    @model_validator(mode="after")
    def _lists_agree(self) -> _Traction:
        if self.notch_speed_cap_mps and len(self.notch_speed_cap_mps) != len(self.notch_share):
            raise ValueError("as many notch speed caps as notch shares (0: no cap)")
        if any(b < a for a, b in pairwise(self.notch_share)):
            raise ValueError("notch shares that do not fall from notch to notch")
        speeds = self.curve_speed_mps
        if len(speeds) != len(self.curve_force_n) or len(speeds) == 1:
            raise ValueError("curve speeds and curve forces of equal length, at least two")
        if speeds and (speeds[0] != 0.0 or any(b <= a for a, b in pairwise(speeds))):
            raise ValueError("curve speeds that start at 0 and rise")
        return self


class _Brakes(Record):
    """`[brakes]`: the service brake, at any load."""

    notch_deceleration_mps2: Annotated[
        list[quantities.Deceleration],
        Field(min_length=1, max_length=NOTCHES_MAX - 1),
        about("deceleration by notch, rising"),
    ]
    stepless: Annotated[bool, about("fractional notches are allowed")]
    dead_time_s: Annotated[quantities.DeadTime, about("time from command to first deceleration")]
    lag_s: Annotated[quantities.Lag, about("time constant of the build-up")]
    jerk_max_mps3: Annotated[quantities.Jerk, about("limit of the build-up; 0: none")]

    @model_validator(mode="after")
    def _notches_rise(self) -> _Brakes:
        notches = self.notch_deceleration_mps2
        if any(b <= a for a, b in pairwise(notches)):
            raise ValueError("decelerations that rise from notch to notch")
        return self


class _Emergency(Record):
    """`[emergency]`: the emergency brake."""

    deceleration_mps2: Annotated[quantities.Deceleration, about("deceleration")]
    dead_time_s: Annotated[quantities.DeadTime, about("time from command to first deceleration")]
    lag_s: Annotated[quantities.Lag, about("time constant of the build-up")]


class _Regeneration(Record):
    """`[regeneration]`: the electric part of the service brake; air supplies the rest."""

    force_max_n: Annotated[quantities.BrakeForceN, about("greatest force at the rim")]
    power_max_w: Annotated[quantities.BrakePowerW, about("greatest power at the rim")]
    fade_from_mps: Annotated[quantities.SpeedFrom0Mps, about("below it the electric brake fades")]
    fade_to_mps: Annotated[quantities.SpeedFrom0Mps, about("below it there is none")]

    @model_validator(mode="after")
    def _fades_downwards(self) -> _Regeneration:
        if self.fade_from_mps < self.fade_to_mps:
            raise ValueError("a fade that ends at a lower speed than it starts from")
        return self


class RegenerationReceiver(StrEnum):
    """What takes the energy that the motors give back."""

    BATTERY = "battery"
    OTHER_TRAINS = "other_trains"
    SUBSTATION = "substation"
    RESISTORS = "resistors"


class _Energy(Record):
    """`[energy]`: at the wire or the battery."""

    efficiency_traction: Annotated[quantities.Efficiency, about("rim over wire, without `[losses]`")]
    efficiency_regeneration: Annotated[quantities.EfficiencyOr0, about("wire over rim, without `[losses]`")]
    auxiliary_power_w: Annotated[
        quantities.AuxiliaryPowerW, about("lighting, compressors, heating and cooling")
    ]
    regenerated_to: Annotated[
        RegenerationReceiver,
        Field(strict=False),
        about(
            "what takes regenerated energy: the train's own battery, other trains on the wire, the substation, or"
            " resistors, from which nothing comes back",
            "assumed: other trains take all of it",
        ),
    ] = RegenerationReceiver.OTHER_TRAINS


class _Adhesion(Record):
    """`[adhesion]`: dry / (1 + factor times speed)."""

    dry: Annotated[quantities.Adhesion, about("adhesion coefficient on dry rail at rest")]
    speed_factor_s_per_m: Annotated[quantities.AdhesionSlope, about("how it falls with speed")]
    slide_share_max: Annotated[
        quantities.ShareAbove0,
        about("deepest slide the protection allows, of train speed; 1: wheels may lock"),
    ]


class _Sensors(Record):
    """`[sensors]`: on the axle."""

    wheel_diameter_m: Annotated[quantities.WheelDiameterM, about("wheel diameter of the tachometer's axle")]
    pulses_per_revolution: Annotated[quantities.Pulses, about("pulses of the tachometer per turn")]


class TrainFile(Record):
    """A whole train file; keys may end in other units, see `UNITS`."""

    id: Annotated[Identifier, about("name of the kind of train")]
    name: Annotated[Title, Field(min_length=1), about("display name")]
    body: _Body
    resistance: RunningResistance
    traction: _Traction
    brakes: _Brakes
    emergency: _Emergency
    regeneration: _Regeneration
    energy: _Energy
    losses: Losses | None = None
    adhesion: _Adhesion
    sensors: _Sensors
    battery: Annotated[BatteryTable | None, about("its traction battery")] = None
    provenance: Annotated[
        dict[str, Annotated[Prose, Field(min_length=1)]],
        about('source of each figure, by key ("body.length_m") or table, or "assumed: why"'),
    ]


@dataclass(frozen=True)
class TrainType:
    """A kind of train; `row` is one TRAIN record, shape (1,), read-only: hand `row[0]` to the compiled laws.

    `regenerated_to` is what takes regenerated energy; `battery` one BATTERY record, if it has one. `sources` and
    `assumed` hold "key: text" of the file's provenance, for reports.
    """

    id: str
    name: str
    sources: tuple[str, ...]
    assumed: tuple[str, ...]
    row: NDArray[np.void]
    regenerated_to: RegenerationReceiver = RegenerationReceiver.OTHER_TRAINS
    battery: NDArray[np.void] | None = None


def shipped_train(name: str) -> Path:
    """Path of a train file that comes with the project; InputError names those there are."""
    path = TRAINS_FOLDER / f"{name}.toml"
    if Path(name).name == name and path.is_file():
        return path
    names = sorted(file.stem for file in TRAINS_FOLDER.glob("*.toml"))
    raise InputError("vehicle/trains", "name", name, "one of " + ", ".join(names))


def train_named(name: str) -> Path:
    """Path of a train by its name: a file (`.toml`) that there is, else one that comes with the project. InputError."""
    own = name.endswith(".toml") and existing_file(Path(name))
    return Path(name) if own else shipped_train(name)


def load_train(path: Path) -> TrainType:
    """Read and check a train file; raises InputError naming file, key, value and what was expected."""
    return train_of(read_train(path), str(path))


def read_train(path: Path) -> dict[str, Any]:
    """The tables of a train file as they are written. Raises InputError."""
    return parse_table(read_text(path), str(path))


def train_of(raw: Mapping[str, Any], file: str, *, has_run: bool = False) -> TrainType:
    """The kind of train that the tables of a file describe; `file` names it in errors. Raises InputError.

    What its figures come to together is not looked at again where it `has_run`: it takes compiled code.
    """
    tables: dict[str, object] = {}
    written: dict[str, str] = {}
    for key, value in raw.items():
        if is_table(value) and key != "provenance":
            tables[key] = _table_in_si(file, key, value, written)
        else:
            tables[key] = value
    try:
        model = TrainFile.model_validate(tables)
    except ValidationError as error:
        raise _input_error(file, error, written, raw) from error
    _check_provenance(file, raw, model.provenance)
    texts = [f"{key}: {text}" for key, text in model.provenance.items()]
    assumed = tuple(text for text in texts if text.partition(": ")[2].lower().startswith("assumed"))
    sources = tuple(text for text in texts if text not in assumed)
    row = _row(model)
    if not has_run:
        check_train(file, row[0], written, lambda key: _value_at(raw, key.split(".", 1)))
    battery = None if model.battery is None else battery_row(model.battery)
    return TrainType(model.id, model.name, sources, assumed, row, model.energy.regenerated_to, battery)


def new_plant(n: int, speed_mps: float = 0.0) -> NDArray[np.void]:
    """`n` PLANT records: empty trains on dry rail with nominal brakes.

    At rest they stand with a holding brake applied, as in a station, until the first command's dead time is
    over; with a speed they are coasting.
    """
    plants = np.zeros(n, dtype=PLANT)
    plants["adhesion_factor"] = 1.0
    plants["brake_factor"] = 1.0
    plants["emergency_factor"] = 1.0
    plants["motors_share"] = 1.0
    plants["source_gives_w"] = plants["source_takes_w"] = np.inf
    plants["speed_mps"] = speed_mps
    plants["wheel_speed_mps"] = plants["last_wheel_speed_mps"] = speed_mps
    if speed_mps <= 0.0:
        plants["command_notch"] = HOLDING_NOTCH
        plants["service_deceleration_mps2"] = HOLDING_DECELERATION_MPS2
    return plants


def _table_in_si(
    file: str, table: str, values: Mapping[str, object], written: dict[str, str]
) -> dict[str, object]:
    """One table with SI keys and values; `written` learns how the file spelt each key."""
    result: dict[str, object] = {}
    for key, value in values.items():
        si_key, factor, divisor = key, 1.0, 1.0
        for ending, si_ending, up, down in UNITS:
            if key.endswith(ending) and "_per_" not in key:
                si_key, factor, divisor = key.removesuffix(ending) + si_ending, up, down
                break
        if si_key in result:
            raise InputError(file, f"{table}.{key}", value, "the quantity once, in one unit")
        written[f"{table}.{si_key}"] = f"{table}.{key}"
        result[si_key] = value if si_key == key else _scaled(value, factor, divisor)
    return result


def _scaled(value: object, factor: float, divisor: float) -> object:
    """A number or a list of numbers converted; anything else as it is, for the validator to refuse."""
    if is_list(value):
        return [_scaled(item, factor, divisor) for item in value]
    if isinstance(value, int | float) and not isinstance(value, bool):
        # A whole number may be too large for a float: it is out of every range as it is.
        return value * factor / divisor if abs(value) <= sys.float_info.max else value
    return value


def _input_error(
    file: str, error: ValidationError, written: Mapping[str, str], raw: Mapping[str, Any]
) -> InputError:
    """The first complaint of pydantic as one line about key and value as the file spells them."""
    first = error.errors()[0]
    place = first["loc"]
    head = ".".join(str(part) for part in place[:2])
    spelt = written.get(head, head)
    key = spelt + "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place[2:])
    if first["type"] == "missing":
        return InputError(file, key, None, "this key to be present (or the same quantity in another unit)")
    value = _value_at(raw, [*spelt.split(".", 1), *place[2:]])
    if first["type"] == "extra_forbidden":
        return InputError(file, key, value, "no such key")
    message = first["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    quantity = first.get("ctx", {}).get("quantity")
    if first["type"] == OUT_OF_RANGE and isinstance(quantity, Quantity):
        message = f"{_range_as_written(quantity, spelt, head)} ({quantity.name})"
    return InputError(file, key, None if is_table(value) else value, message)


def _value_at(raw: object, path: Sequence[str | int]) -> object:
    """What a file has at a path of keys and indices; None where there is nothing."""
    for step in path:
        if is_table(raw):
            raw = raw.get(str(step))
        elif is_list(raw) and isinstance(step, int) and step < len(raw):
            raw = raw[step]
        else:
            return None
    return raw


def _range_as_written(quantity: Quantity, spelt: str, si_key: str) -> str:
    """The range of a figure in the unit that the file's key ends in."""
    for ending, _, up, down in UNITS:
        if spelt != si_key and spelt.endswith(ending):
            return quantity.text_in(WRITTEN[ending], down / up)
    return quantity.text()


def _check_provenance(file: str, raw: Mapping[str, object], provenance: Mapping[str, str]) -> None:
    """Every figure has a source or is marked assumed, and nothing is named that is not there."""
    figures = {f"{t}.{k}" for t, v in raw.items() if is_table(v) and t != "provenance" for k in v}
    for figure in sorted(figures):
        if figure not in provenance and figure.partition(".")[0] not in provenance:
            raise InputError(file, "provenance", None, f'a source or "assumed: why" for {figure}')
    tables = {figure.partition(".")[0] for figure in figures}
    for key, text in provenance.items():
        if key not in figures and key not in tables:
            raise InputError(file, f"provenance.{key}", text, "the name of a key or table of this file")


def _row(model: TrainFile) -> NDArray[np.void]:
    """The checked file as one TRAIN record."""
    row = np.zeros(1, dtype=TRAIN)
    plain: dict[str, float] = {**model.body.model_dump()}
    plain |= {**model.energy.model_dump(exclude={"regenerated_to"}), **model.sensors.model_dump()}
    for table, prefix in ((model.emergency, "emergency_"), (model.regeneration, "regenerative_")):
        plain |= {prefix + key: value for key, value in table.model_dump().items()}
    traction, brakes, adhesion = model.traction, model.brakes, model.adhesion
    plain |= {
        "power_notches": len(traction.notch_share),
        "traction_force_max_n": traction.force_max_n,
        "traction_power_max_w": traction.power_max_w,
        "traction_weak_field_speed_mps": traction.weak_field_speed_mps,
        "traction_dead_time_s": traction.dead_time_s,
        "traction_lag_s": traction.lag_s,
        "traction_jerk_max_mps3": traction.jerk_max_mps3,
        "traction_load_compensated": float(traction.load_compensated),
        "motors": traction.motors,
        "brake_notches": len(brakes.notch_deceleration_mps2),
        "brake_stepless": float(brakes.stepless),
        "brake_dead_time_s": brakes.dead_time_s,
        "brake_lag_s": brakes.lag_s,
        "brake_jerk_max_mps3": brakes.jerk_max_mps3,
        "adhesion_dry": adhesion.dry,
        "adhesion_speed_factor_s_per_m": adhesion.speed_factor_s_per_m,
        "wheel_slide_share_max": adhesion.slide_share_max,
    }
    for key, value in plain.items():
        row[key] = value
    put_settings(row.view(np.recarray)[0].resistance, model.resistance)
    row["traction_notch_share"][0, 1 : len(traction.notch_share) + 1] = traction.notch_share
    row["traction_speed_cap_mps"][0, 1 : len(traction.notch_speed_cap_mps) + 1] = traction.notch_speed_cap_mps
    row["brake_deceleration_mps2"][0, 1 : len(brakes.notch_deceleration_mps2) + 1] = (
        brakes.notch_deceleration_mps2
    )
    _set_curve(row, traction)
    set_losses(row, model.losses)
    row.flags.writeable = False
    return row


def _set_curve(row: NDArray[np.void], traction: _Traction) -> None:
    """Put the measured traction curve, if any, on an even grid: 1 km/h where that reaches its end."""
    if not traction.curve_speed_mps:
        return
    top = traction.curve_speed_mps[-1]
    step = max(1.0 / 3.6, top / (CURVE_POINTS_MAX - 1))
    points = min(int(np.ceil(top / step - 1e-9)) + 1, CURVE_POINTS_MAX)
    row["traction_curve_points"] = points
    row["traction_curve_step_mps"] = step
    row["traction_curve_n"][0, :points] = np.interp(
        np.arange(points) * step, traction.curve_speed_mps, traction.curve_force_n
    )
