"""The tables of one run: what the simulation hands over, as polars frames, and their Parquet files.

Times are simulated seconds since midnight of the operating day, positions are kilometrage in m, speeds m/s,
energy kWh at the wire. A null is a time that was not planned or did not come; floats hold no other gaps.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from io import BytesIO
from pathlib import Path
from typing import Any, Final, TypeAlias

import polars as pl

from network.errors import InputError

Schema: TypeAlias = Mapping[str, type[pl.DataType]]

# One row a second of a moving train, and one at each of its events.
TRAJECTORY: Final[Schema] = {
    "t_s": pl.Float64,
    "unit": pl.String,
    "train": pl.String,
    "direction": pl.Int8,  # network.model.Direction
    "kilometrage_m": pl.Float64,  # of the front
    "piece": pl.String,
    "speed_mps": pl.Float64,
    "acceleration_mps2": pl.Float64,
    "notch": pl.Float64,  # > 0 power, < 0 brake
    "permitted_mps": pl.Float64,
    "target_mps": pl.Float64,
    "intervention": pl.Int8,  # 0: none; otherwise supervision brakes
    "estimate_error_m": pl.Float64,
    "bound_ahead_m": pl.Float64,
    "bound_behind_m": pl.Float64,
}
# One row a call of every train, in order of travel, from its first one on. Where it passes there is no arrival: it is
# planned to depart, and departs, when its front passes the mark.
STOPS: Final[Schema] = {
    "unit": pl.String,
    "train": pl.String,
    "revenue": pl.Boolean,
    "station": pl.String,
    "track": pl.String,
    "kind": pl.String,  # network.timetable.CallKind
    "planned_arrival_s": pl.Float64,
    "planned_departure_s": pl.Float64,
    "arrival_s": pl.Float64,
    "departure_s": pl.Float64,
    "late_arrival_s": pl.Float64,
    "late_departure_s": pl.Float64,
    "stop_error_m": pl.Float64,  # front beyond the mark is positive
}
# One row a section and grant: the manager's register (granted, released) and the truth (entered, cleared).
BLOCKS: Final[Schema] = {
    "section": pl.String,
    "unit": pl.String,
    "train": pl.String,
    "token": pl.Int64,
    "granted_s": pl.Float64,
    "released_s": pl.Float64,
    "entered_s": pl.Float64,
    "cleared_s": pl.Float64,
}
# One row a slice of an occupation (study.capacity.occupation), from when a section can be had until it is free again.
BLOCKING: Final[Schema] = {
    "occupation": pl.Int64,  # slices of one number make up one occupation
    "section": pl.String,
    "unit": pl.String,
    "train": pl.String,  # by which the stock came in
    "direction": pl.Int8,  # network.model.Direction
    "route": pl.String,  # by which it came in; "": it signed on there, or was there
    "part": pl.String,  # study.capacity.occupation.Part
    "cost": pl.String,  # study.capacity.occupation.Cost
    "from_s": pl.Float64,
    "to_s": pl.Float64,
    "enters_s": pl.Float64,  # its front; minus infinity: it was there, infinite: it never comes
    "leaves_s": pl.Float64,  # infinite: it stays
    "waited_s": pl.Float64,  # wanted while it, or its route, was another's: before the occupation begins
}
# One row a source, destination and kind; lost by the air, dropped by the receiver's checks.
TELEGRAMS: Final[Schema] = {
    "source": pl.String,
    "destination": pl.String,
    "kind": pl.String,
    "sent": pl.Int64,
    "delivered": pl.Int64,
    "lost": pl.Int64,
    "dropped": pl.Int64,
    "bytes": pl.Int64,
}
# Where the energy of a row went, kWh: with the auxiliaries the parts make up the net, but for the residual.
PARTS_KWH: Final[Schema] = {
    "kinetic_kwh": pl.Float64,  # change of kinetic energy, of what turns too
    "resistance_kwh": pl.Float64,  # running and starting resistance
    "gradient_kwh": pl.Float64,  # lifted; < 0 downhill
    "curve_kwh": pl.Float64,
    "friction_kwh": pl.Float64,  # taken by the air brake
    "traction_loss_kwh": pl.Float64,  # motors and inverters that pull or coast
    "regeneration_loss_kwh": pl.Float64,  # motors and inverters that brake, and resistors
    "rejected_kwh": pl.Float64,  # no part: not taken by battery or wire, burnt by resistors
    "residual_kwh": pl.Float64,  # what the parts leave open
}
# One row a train, from where it begins to move to where it ends; layovers have a table of their own.
ENERGY: Final[Schema] = {
    "unit": pl.String,
    "train": pl.String,
    "revenue": pl.Boolean,
    "cars": pl.Int64,
    "regenerated_to": pl.String,  # vehicle.train_file.Receiver
    "distance_km": pl.Float64,
    "running_s": pl.Float64,
    "standing_s": pl.Float64,
    "traction_kwh": pl.Float64,
    "regenerated_kwh": pl.Float64,
    "auxiliary_kwh": pl.Float64,
    "standing_kwh": pl.Float64,  # of the auxiliary: at stops, before stop limits, in portals
    "net_kwh": pl.Float64,  # traction and auxiliary, less what came back
    **PARTS_KWH,
}
# One row a train and leg: from a place where it stops to the next, with the stop there. Places: stations, portals.
ENERGY_LEGS: Final[Schema] = {
    "unit": pl.String,
    "train": pl.String,
    "revenue": pl.Boolean,
    "from_station": pl.String,
    "to_station": pl.String,
    **{
        name: dtype
        for name, dtype in ENERGY.items()
        if name not in ("unit", "train", "revenue", "regenerated_to")
    },
}
# One row an hour, stock and phase: what it took and gave in that hour, stabled stock too.
ENERGY_HOURS: Final[Schema] = {
    "hour_s": pl.Float64,  # when the hour begins
    "unit": pl.String,
    "phase": pl.String,  # simulation.result.Phase
    "traction_kwh": pl.Float64,
    "regenerated_kwh": pl.Float64,
    "auxiliary_kwh": pl.Float64,
    "net_kwh": pl.Float64,
}
# One row a stay where one train of a stock ends and the next begins.
LAYOVERS: Final[Schema] = {
    "unit": pl.String,
    "station": pl.String,
    "after_train": pl.String,
    "before_train": pl.String,
    "from_s": pl.Float64,
    "to_s": pl.Float64,
    "traction_kwh": pl.Float64,
    "regenerated_kwh": pl.Float64,
    "auxiliary_kwh": pl.Float64,
    "net_kwh": pl.Float64,
    **PARTS_KWH,
}
# One row a train and hop of the timetable: the margin as planned, and what was left of it on arrival.
MARGINS: Final[Schema] = {
    "unit": pl.String,
    "train": pl.String,
    "revenue": pl.Boolean,
    "from_station": pl.String,
    "to_station": pl.String,
    "planned_s": pl.Float64,  # from departure to the latest arrival that keeps arrival and next departure
    "least_s": pl.Float64,  # least running time at the limits of the line
    "attainable_s": pl.Float64,  # the same as far below the limits as trains are driven
    "margin_s": pl.Float64,  # planned - least
    "margin_percent": pl.Float64,  # of the least running time
    "run_s": pl.Float64,
    "left_s": pl.Float64,  # from the true arrival to that latest one
}
# One row a train and hop as driven: study.measures.driving.DrivenHop. Notches and jerk are counted every 0.1 s.
DRIVING: Final[Schema] = {
    "unit": pl.String,
    "train": pl.String,
    "revenue": pl.Boolean,
    "law": pl.String,  # onboard.driving.laws.table
    "from_station": pl.String,
    "to_station": pl.String,
    "begin_s": pl.Float64,  # when it began to move
    "run_s": pl.Float64,  # moving
    "distance_m": pl.Float64,
    "traction_kwh": pl.Float64,
    "regenerated_kwh": pl.Float64,
    "running_kwh": pl.Float64,  # traction less what came back, without auxiliaries
    "power_changes": pl.Int64,  # of the power notch, the first one too
    "brake_changes": pl.Int64,  # the same of the brake, the release at the start too; without steps: by a notch or more
    "jerk_max_mps3": pl.Float64,  # of the true acceleration from step to step; the step that ends in a stand left out
    "jerk_rms_mps3": pl.Float64,  # over the time in which it moved
    "jolt_mps2": pl.Float64,  # deceleration in the last whole step before the stand
    "coasting_time_percent": pl.Float64,  # neither power nor brake commanded
    "coasting_way_percent": pl.Float64,
    "cruising_time_percent": pl.Float64,  # power, and within 0.1 m/s2 of even speed
    "cruising_way_percent": pl.Float64,
    "braking_time_percent": pl.Float64,
    "braking_way_percent": pl.Float64,
    "late_s": pl.Float64,  # against the latest arrival that keeps the plan; negative: early
    "stop_error_m": pl.Float64,
}
# Our figures beside others': one row a figure.
COMPARISONS: Final[Schema] = {
    "figure": pl.String,
    "unit": pl.String,
    "ours": pl.Float64,
    "theirs": pl.Float64,
    "difference_percent": pl.Float64,  # of theirs
    "source": pl.String,
    "comparable": pl.String,
}
# One row a thing that a stock waits for, or does meanwhile, from the run's begin to its end: study.measures.wait.Wait.
WAITS: Final[Schema] = {
    "unit": pl.String,
    "train": pl.String,
    "from_s": pl.Float64,
    "to_s": pl.Float64,
    "cause": pl.String,  # study.measures.wait.Cause
    "place": pl.String,  # the station where it stands; "" elsewhere
    "at_m": pl.Float64,  # kilometrage of its front; of the stop limit where that slows it down
    "asked": pl.String,  # study.measures.wait.Asked
    "section": pl.String,
    "points": pl.String,
    "party": pl.String,  # who is waited for
    "party_train": pl.String,
    "since_s": pl.Float64,
    "until_s": pl.Float64,
    "reason": pl.String,
}
# One row a moment of a set that runs on a battery: each half minute and at each of its events; sums are of the day.
BATTERY: Final[Schema] = {
    "t_s": pl.Float64,
    "unit": pl.String,
    "train": pl.String,  # off the line the one before
    "event": pl.String,  # simulation.result.BatteryEvent
    "station": pl.String,  # where it stands; "" elsewhere
    "soc": pl.Float64,  # 0 to 1
    "soc_low": pl.Float64,  # low end of the window
    "soc_kept": pl.Float64,  # with what is to be kept back
    "stored_kwh": pl.Float64,  # between empty and that state of charge
    "above_low_kwh": pl.Float64,
    "power_kw": pl.Float64,  # at the terminals, the mean since the row before; > 0 out
    "supply_kw": pl.Float64,  # what charger or wire gives at most
    "given_kwh": pl.Float64,  # at the terminals, out
    "taken_kwh": pl.Float64,  # at the terminals, in
    "lost_kwh": pl.Float64,  # in its resistance
    "supplied_kwh": pl.Float64,  # by chargers and wires, to battery and train
    "missing_kwh": pl.Float64,  # asked for and not to be had
    "spilled_kwh": pl.Float64,  # came back and was not taken
}
# One row a charge, from the first current to the last.
CHARGES: Final[Schema] = {
    "unit": pl.String,
    "train": pl.String,  # that leaves with it
    "station": pl.String,  # "": off the line
    "from_s": pl.Float64,
    "to_s": pl.Float64,
    "soc_from": pl.Float64,
    "soc_to": pl.Float64,
    "gained_kwh": pl.Float64,
    "next_way_kwh": pl.Float64,  # what the battery lost from there to the next charge
    "margin_kwh": pl.Float64,  # above what is to be kept back, at the next charge
    "minutes": pl.Float64,
    "minutes_suffice": pl.Float64,  # so that it comes there with just that; none: no time would do
}
# Interventions, refusals, faults: what a person should hear of.
EVENTS: Final[Schema] = {
    "t_s": pl.Float64,
    "source": pl.String,
    "kind": pl.String,
    "text": pl.String,
    "text_ja": pl.String,
}
SCHEMAS: Final[Mapping[str, Schema]] = {
    "trajectory": TRAJECTORY,
    "stops": STOPS,
    "blocks": BLOCKS,
    "blocking": BLOCKING,
    "telegrams": TELEGRAMS,
    "energy": ENERGY,
    "energy_legs": ENERGY_LEGS,
    "energy_hours": ENERGY_HOURS,
    "layovers": LAYOVERS,
    "margins": MARGINS,
    "driving": DRIVING,
    "comparisons": COMPARISONS,
    "waits": WAITS,
    "battery": BATTERY,
    "charges": CHARGES,
    "events": EVENTS,
}


_WITH_GAPS: Final = ("stops", "blocks")
# Columns that runs of earlier versions lack, and what stands for them.
_ADDED: Final[Mapping[str, Mapping[str, str]]] = {"events": {"text_ja": ""}}


def make_table(name: str, columns: Mapping[str, Any] | None = None) -> pl.DataFrame:
    """The table `name` from columns (sequences or arrays of one length); none given makes it empty.

    In the tables of times, stops and blocks, NaN becomes null: arrays have no other way to say "not yet".
    Raises ValueError when the columns are not exactly those of the schema, TypeError for values that do not
    fit it.
    """
    schema = SCHEMAS[name]
    if columns is None:
        return pl.DataFrame(schema=schema)
    if set(columns) != set(schema):
        raise ValueError(f"table {name}: columns {sorted(set(columns) ^ set(schema))} missing or unknown")
    frame = pl.DataFrame({column: columns[column] for column in schema}, schema=schema)
    return frame.with_columns(pl.col(pl.Float64).fill_nan(None)) if name in _WITH_GAPS else frame


@dataclass(frozen=True, slots=True)
class RunTables:
    """The frames of a run, each exactly of its schema. Raises ValueError naming table and column if not."""

    trajectory: pl.DataFrame
    stops: pl.DataFrame
    blocks: pl.DataFrame
    blocking: pl.DataFrame
    telegrams: pl.DataFrame
    energy: pl.DataFrame
    energy_legs: pl.DataFrame
    energy_hours: pl.DataFrame
    layovers: pl.DataFrame
    margins: pl.DataFrame
    driving: pl.DataFrame
    comparisons: pl.DataFrame
    waits: pl.DataFrame
    battery: pl.DataFrame
    charges: pl.DataFrame
    events: pl.DataFrame

    def __post_init__(self) -> None:
        for name, schema in SCHEMAS.items():
            problem = _difference(getattr(self, name), schema)
            if problem:
                raise ValueError(f"table {name}: {problem}")

    def write(self, directory: Path) -> None:
        """Write one Parquet file a table; all are written aside before the first takes its name."""
        directory.mkdir(parents=True, exist_ok=True)
        aside = {name: directory / f".{name}.parquet.part" for name in SCHEMAS}
        for name, path in aside.items():
            written = BytesIO()  # an error of the disk then is one of ours, and no library's
            getattr(self, name).write_parquet(written, compression="zstd")
            path.write_bytes(written.getbuffer())
        for name, path in aside.items():
            path.replace(_file(directory, name))

    @classmethod
    def read(cls, directory: Path) -> RunTables:
        """Read what `write` wrote. Raises InputError for a file missing, unreadable or of another form."""
        return cls(**{field.name: _read(directory, field.name) for field in fields(cls)})


def _file(directory: Path, name: str) -> Path:
    return directory / f"{name}.parquet"


def _read(directory: Path, name: str) -> pl.DataFrame:
    path = _file(directory, name)
    try:
        frame = pl.read_parquet(path)
    except (OSError, pl.exceptions.PolarsError) as error:
        raise InputError(str(path), "", None, f"the {name} table of a run, in Parquet") from error
    missing = {c: v for c, v in _ADDED.get(name, {}).items() if c not in frame.columns}
    frame = frame.with_columns(**{column: pl.lit(value) for column, value in missing.items()})
    problem = _difference(frame, SCHEMAS[name])
    if problem:
        raise InputError(str(path), "", None, f"the {name} table of a run; {problem}")
    return frame


def _difference(frame: pl.DataFrame, schema: Schema) -> str:
    """What tells the frame from the schema, in words; empty when nothing does."""
    if list(frame.columns) != list(schema):
        odd = sorted(set(frame.columns) ^ set(schema))
        return f"columns {odd} missing or unknown" if odd else f"columns are not in the order {list(schema)}"
    for column, dtype in schema.items():
        if frame.schema[column] != dtype:
            return f"column {column} holds {frame.schema[column]}, not {dtype.__name__}"
    return ""
