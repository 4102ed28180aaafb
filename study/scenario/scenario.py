"""Scenarios: line, timetable, trains, sensors, air and seed of a run, read from TOML and made into a Setup.

A scenario may extend another (`extends = "karasuyama_weekday"`) and patch the line (`[line_patch]`): that is a
what-if. Whatever it leaves out has the defaults of `simulation.setup`, which are assumed and shown by the report.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from importlib.resources import files
from math import inf
from pathlib import Path
from typing import Any, Final, Literal

from pydantic import Field

from network.errors import InputError
from network.files.line_file import load_line, validate_train_fits
from network.files.shipped import find_file, shipped_line, shipped_timetable
from network.files.toml_input import Record, one_of, parse_table, read_text, validate
from network.model import Line
from network.timetable import Timetable, load_timetable
from onboard.unit import UnitParameters
from radio.air import AirParameters, DelayShape
from simulation.setup import STEP_S, Belief, Driving, Sensors, Setup
from study.scenario.belief import belief_of, with_trains
from study.scenario.fleet_file import ScatterTable, TuningTable, VisionTable, scatter_of, tuning_of, vision_of
from study.scenario.law_choice import laws_of, without_laws
from study.scenario.script_file import ActTable, ExpectTable, FaultTable, script_of
from vehicle.train_file import TrainType, load_train, shipped_train
from wayside.config import ReentryMode

FOLDER: Final = "scenarios"
# of the tables that hold parameters: what makes no sense at 0, and what makes none above a bound
POSITIVE: Final = frozenset(
    {
        "service_guaranteed_share",
        "emergency_guaranteed_share",
        "standing_brake_share",
        "stop_deceleration_mps2",
        "stop_gain_per_s",
        "cruise_gain_per_s",
        "tag_accuracy_m",
        "tag_window_m",
        "restricted_mps",
    }
)
MOST: Final = {"wheel_factor_sigma": 0.1, "tag_read_sigma_m": 10.0}


class _Trains(Record):
    default: str
    stock: dict[str, str] = Field(default_factory=dict)
    load_share_mean: float = Field(default=0.2, ge=0.0, le=1.0)
    load_share_spread: float = Field(default=0.15, ge=0.0, le=0.5)


class _Air(Record):
    delay_min_s: float = Field(default=STEP_S, ge=STEP_S)
    delay_mean_s: float = Field(default=STEP_S, ge=STEP_S)
    delay_shape: Literal["constant", "exponential"] = "exponential"
    loss_good_p: float = Field(default=0.0, ge=0.0, le=1.0)
    loss_bad_p: float = Field(default=1.0, ge=0.0, le=1.0)
    good_to_bad_per_s: float = Field(default=0.0, ge=0.0)
    bad_to_good_per_s: float = Field(default=1.0, ge=0.0)
    duplicate_p: float = Field(default=0.0, ge=0.0, le=1.0)
    reorder_p: float = Field(default=0.0, ge=0.0, le=1.0)
    reorder_delay_s: float = Field(default=1.0, ge=0.0)
    flip_p: float = Field(default=0.0, ge=0.0, le=1.0)


class _Limits(Record):
    time_limit_s: float = Field(default=3600.0, gt=0.0)
    stall_limit_s: float = Field(default=3600.0, gt=0.0)


class _Operation(Record):
    portal_lead_s: float = Field(default=210.0, ge=0.0)
    change_ends_s: float = Field(default=60.0, ge=0.0)
    reentry: Literal["assisted", "by_hand"] = "assisted"


class _ScenarioFile(Record):
    id: str
    name: str
    line: str
    timetable: str
    seed: int = Field(default=1, ge=0)
    trains: _Trains
    air: _Air = Field(default_factory=_Air)
    unit: dict[str, float] = Field(default_factory=dict)
    driving: dict[str, float] = Field(default_factory=dict)
    sensors: dict[str, float] = Field(default_factory=dict)
    scatter: ScatterTable = Field(default_factory=ScatterTable)
    tuning: TuningTable | None = None
    vision: VisionTable | None = None
    limits: _Limits = Field(default_factory=_Limits)
    operation: _Operation = Field(default_factory=_Operation)
    line_patch: dict[str, Any] = Field(default_factory=dict)
    belief: dict[str, Any] = Field(default_factory=dict)
    fault: list[FaultTable] = Field(default_factory=list)
    act: list[ActTable] = Field(default_factory=list)
    expect: list[ExpectTable] = Field(default_factory=list)
    assumed: list[str] = Field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Scenario:
    """A scenario ready to run. `patched` says whether the line differs from its file."""

    id: str
    name: str
    file: str
    setup: Setup
    patched: bool
    assumed: tuple[str, ...]


def shipped_scenarios() -> tuple[str, ...]:
    """Names of the scenarios that come with the program."""
    return tuple(sorted(path.stem for path in _folder().glob("*.toml")))


def find_scenario(name: str) -> Path:
    """File of a shipped scenario, or the given .toml file. InputError otherwise."""
    return find_file(_folder(), "scenario", name)


def load_scenario(name: str, seed: int | None = None) -> Scenario:
    """Read a scenario with all that it names. InputError says which file, key and value is at fault."""
    path = find_scenario(name)
    model, chosen = _read(path)
    line = _line(path, model)
    timetable = load_timetable(_named(path, "timetable", model.timetable, shipped_timetable), line)
    trains = _trains(path, model, timetable)
    lengths_m = {stock_id: float(train.row[0]["length_m"]) for stock_id, train in trains.items()}
    validate_train_fits(line, lengths_m, timetable, str(path))
    setup = Setup(
        name=model.id,
        line=line,
        timetable=timetable,
        trains=trains,
        seed=model.seed if seed is None else seed,
        belief=_belief(path, model, line, trains),
        air=_air(path, model.air),
        unit=_fill(UnitParameters, {"dwell_min_s": timetable.dwell_min_s, **model.unit}, path, "unit"),
        driving=_fill(Driving, model.driving, path, "driving"),
        laws=laws_of(str(path), chosen, sorted(trains)),
        sensors=_fill(Sensors, model.sensors, path, "sensors"),
        scatter=scatter_of(str(path), model.scatter, trains),
        tuning=tuning_of(path, model.tuning, trains),
        vision=vision_of(str(path), model.vision, line),
        load_share_mean=model.trains.load_share_mean,
        load_share_spread=model.trains.load_share_spread,
        portal_lead_s=model.operation.portal_lead_s,
        change_ends_s=model.operation.change_ends_s,
        reentry=ReentryMode(model.operation.reentry),
        time_limit_s=model.limits.time_limit_s,
        stall_limit_s=model.limits.stall_limit_s,
    )
    setup = replace(setup, script=script_of(str(path), setup, model.fault, model.act, model.expect))
    assumed = (*model.assumed, *line.assumed, *timetable.assumed, *_train_assumptions(trains))
    return Scenario(model.id, model.name, str(path), setup, bool(model.line_patch), assumed)


def _folder() -> Path:
    return Path(str(files("study"))) / FOLDER


def _read(path: Path) -> tuple[_ScenarioFile, dict[str, Any]]:
    """The scenario's file, and which driving laws it chooses."""
    tables, chosen = without_laws(_merged(path, ()))
    return validate(tables, str(path), _ScenarioFile), chosen


def _merged(path: Path, above: tuple[Path, ...]) -> dict[str, Any]:
    """The tables of a scenario laid over those of the one that it extends."""
    if path in above:
        raise InputError(str(path), "extends", path.stem, "a scenario that does not extend itself")
    data = parse_table(read_text(path), str(path))
    base = data.pop("extends", None)
    if base is None:
        return data
    if not isinstance(base, str):
        raise InputError(str(path), "extends", base, "the name of a scenario")
    beside = path.parent / f"{base.removesuffix('.toml')}.toml"
    below = beside if beside.is_file() else _named(path, "extends", base, find_scenario)
    return _laid_over(_merged(below, (*above, path)), data)


def _laid_over(below: dict[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(below)
    for key, value in above.items():
        known = merged.get(key)
        if isinstance(known, dict) and isinstance(value, dict):
            merged[key] = _laid_over(known, value)
        else:
            merged[key] = value
    return merged


def _named(path: Path, key: str, name: str, shipped: Callable[[str], Path]) -> Path:
    """A file named relative to the scenario's own folder, or one that is shipped; InputError names the key."""
    near = path.parent / name
    if name.endswith(".toml") and near.is_file():
        return near
    try:
        return shipped(name)
    except InputError as error:
        raise InputError(str(path), key, name, error.expected) from error


def _line(path: Path, model: _ScenarioFile) -> Line:
    file = _named(path, "line", model.line, shipped_line)
    if not model.line_patch:
        return load_line(file)
    from network.files.patch import load_patched_line

    return load_patched_line(file, model.line_patch, str(path))


def _belief(path: Path, model: _ScenarioFile, line: Line, trains: Mapping[str, TrainType]) -> Belief | None:
    if not model.belief:
        return None
    file = _named(path, "line", model.line, shipped_line)
    belief = belief_of(str(path), file, line, model.line_patch, model.belief)
    return with_trains(str(path), belief, model.belief.get("trains", {}), trains)


def _trains(path: Path, model: _ScenarioFile, timetable: Timetable) -> dict[str, TrainType]:
    known = {diagram.stock_id for diagram in timetable.diagrams}
    for stock_id in model.trains.stock:
        if stock_id not in known:
            raise InputError(
                str(path), f"trains.stock.{stock_id}", stock_id, f"a stock id: {one_of(sorted(known))}"
            )
    named = {"trains.default": model.trains.default}
    named |= {f"trains.stock.{stock_id}": name for stock_id, name in model.trains.stock.items()}
    loaded = {name: load_train(_named(path, key, name, shipped_train)) for key, name in named.items()}
    return {
        stock_id: loaded[model.trains.stock.get(stock_id, model.trains.default)] for stock_id in sorted(known)
    }


def _air(path: Path, model: _Air) -> AirParameters:
    values = model.model_dump()
    values["delay_shape"] = DelayShape(values["delay_shape"])
    try:
        return AirParameters(**values)
    except InputError as error:
        raise InputError(str(path), f"air.{error.key}", error.value, error.expected) from error


def _fill(kind: type[Any], values: Mapping[str, float], path: Path, table: str) -> Any:  # noqa: ANN401
    """A parameter dataclass from a table; unknown keys and what cannot be are refused."""
    known = [field.name for field in fields(kind)]
    for key, value in values.items():
        if key not in known:
            raise InputError(str(path), f"{table}.{key}", value, one_of(known, key))
        most = 1.0 if key.endswith("_share") else MOST.get(key, inf)
        if not 0.0 <= value <= most or (value == 0.0 and key in POSITIVE):
            least = "above 0" if key in POSITIVE else "not below 0"
            expected = f"a number {least}" + (f" and at most {most:g}" if most < inf else "")
            raise InputError(str(path), f"{table}.{key}", value, expected)
    return kind(**values)


def _train_assumptions(trains: Mapping[str, TrainType]) -> tuple[str, ...]:
    kinds = {train.id: train for train in trains.values()}
    return tuple(f"{train.name}: {text}" for train in kinds.values() for text in train.assumed)
