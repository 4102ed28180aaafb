"""Scenarios: line, timetable, trains, sensors, air and seed of a run, read from TOML and made into a Setup.

A scenario may extend another (`extends = "karasuyama_weekday"`) and patch the line (`[line_patch]`): that is a
what-if. Whatever it leaves out has the defaults of `simulation.setup`, which are assumed and shown by the report.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import Any, Final

from network.errors import InputError
from network.files.line_file import load_line, validate_train_fits
from network.files.shipped import find_file, shipped_line, shipped_timetable
from network.files.toml_input import one_of, parse_table, read_text, validate
from network.model import Line
from network.timetable import Timetable, load_timetable
from onboard.unit_records import UnitParameters
from simulation.setup import Setup
from study.scenario.fleet_file import check_scatter, check_vision, learned_of
from study.scenario.scenario_file import ScenarioFile
from study.scenario.script_file import script_of
from vehicle.train_file import TrainType, load_train, shipped_train

FOLDER: Final = "scenarios"


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
    model = _read(path)
    line = _line(path, model)
    timetable = load_timetable(_named(path, "timetable", model.timetable, shipped_timetable), line)
    trains = _trains(path, model, timetable)
    lengths_m = {stock_id: float(train.row[0]["length_m"]) for stock_id, train in trains.items()}
    validate_train_fits(line, lengths_m, timetable, str(path))
    check_scatter(str(path), model.scatter, trains)
    check_vision(str(path), model.vision, line.stations)
    setup = Setup(
        name=model.id,
        line=line,
        timetable=timetable,
        trains=trains,
        seed=model.seed if seed is None else seed,
        air=model.air,
        unit=_unit(model.unit, timetable),
        driving=model.driving,
        sensors=model.sensors,
        scatter=model.scatter,
        tuning=model.tuning,
        learned=learned_of(path, model.tuning, trains),
        vision=model.vision,
        load=model.trains,
        limits=model.limits,
        operation=model.operation,
    )
    setup = replace(setup, script=script_of(str(path), setup, model.fault, model.act, model.expect))
    assumed = (*model.assumed, *line.assumed, *timetable.assumed, *_train_assumptions(trains))
    return Scenario(model.id, model.name, str(path), setup, bool(model.line_patch), assumed)


def _folder() -> Path:
    return Path(str(files("study"))) / FOLDER


def _read(path: Path) -> ScenarioFile:
    return validate(_merged(path, ()), str(path), ScenarioFile)


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


def _line(path: Path, model: ScenarioFile) -> Line:
    file = _named(path, "line", model.line, shipped_line)
    if not model.line_patch:
        return load_line(file)
    from network.files.patch import load_patched_line

    return load_patched_line(file, model.line_patch, str(path))


def _trains(path: Path, model: ScenarioFile, timetable: Timetable) -> dict[str, TrainType]:
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


def _unit(unit: UnitParameters, timetable: Timetable) -> UnitParameters:
    """The units' parameters; the shortest stop is the timetable's where the scenario gives none."""
    if "dwell_min_s" in unit.model_fields_set:
        return unit
    return unit.model_copy(update={"dwell_min_s": timetable.dwell_min_s})


def _train_assumptions(trains: Mapping[str, TrainType]) -> tuple[str, ...]:
    kinds = {train.id: train for train in trains.values()}
    return tuple(f"{train.name}: {text}" for train in kinds.values() for text in train.assumed)
