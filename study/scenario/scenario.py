"""Scenarios: line, timetable, trains, sensors, air and seed of a run, read from TOML and made into a Setup.

A scenario may extend another (`extends = "karasuyama_weekday"`) and patch every file it names (`[patch]`): that is
a what-if. Whatever it leaves out has the defaults of its tables, which are assumed; `docs/files.md` lists them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import Final

from network.errors import InputError
from network.files.edits import Change, Data
from network.files.line_file import validate_train_fits
from network.files.patch import patched_line
from network.files.quantities import SEED
from network.files.shipped import find_file, shipped_line, shipped_timetable
from network.files.text_input import existing_file
from network.files.timetable_patch import patched_timetable
from network.files.toml_input import one_of
from network.timetable import Timetable
from onboard.unit_records import UnitParameters
from simulation.setup import Setup
from study.scenario.battery_choice import check_battery, heated
from study.scenario.belief import belief_of
from study.scenario.curvature_choice import curvature_map_of
from study.scenario.fleet_file import (
    check_centre,
    check_grip,
    check_margins,
    check_markers,
    check_parties,
    check_scatter,
    check_vision,
    check_wheels,
    learned_of,
)
from study.scenario.inputs import Inputs
from study.scenario.late_choice import check_late
from study.scenario.law_choice import laws_of
from study.scenario.layers import Pile, pile_of
from study.scenario.scenario_file import ScenarioFile
from study.scenario.script_file import script_of
from study.scenario.sensor_choice import check_sensors, check_window
from vehicle.train_file import TrainType, shipped_train
from vehicle.train_patch import patched_train

FOLDER: Final = "scenarios"


@dataclass(frozen=True, slots=True)
class Scenario:
    """A scenario ready to run. `changes` says what differs from what it names or extends; `inputs` are all tables."""

    id: str
    name: str
    file: str
    setup: Setup
    changes: tuple[Change, ...]
    assumed: tuple[str, ...]
    inputs: Inputs


def shipped_scenarios() -> tuple[str, ...]:
    """Names of the scenarios that come with the program."""
    return tuple(sorted(path.stem for path in _folder().glob("*.toml")))


def find_scenario(name: str) -> Path:
    """File of a shipped scenario, or the given .toml file. InputError otherwise."""
    return find_file(_folder(), "scenario", name)


def with_seed(scenario: Scenario, seed: int) -> Scenario:
    """The same scenario with another seed, as `load_scenario` would give it. InputError for a seed that is none."""
    _check_seed(seed)
    inputs = replace(scenario.inputs, scenario={**scenario.inputs.scenario, "seed": seed})
    return replace(scenario, setup=replace(scenario.setup, seed=seed), inputs=inputs)


def _check_seed(seed: int | None) -> None:
    if seed is not None and not SEED.holds(seed):
        raise InputError("command line", "--seed", seed, f"{SEED.text()} ({SEED.name})")


def load_scenario(name: str, seed: int | None = None) -> Scenario:
    """Read a scenario with all that it names. InputError says which file, key and value is at fault."""
    _check_seed(seed)
    path = find_scenario(name)
    pile = pile_of(path, lambda above, base: _named(above, "extends", base, find_scenario))
    model = pile.validated(path)
    line_file = _named(path, "line", model.line, shipped_line, pile)
    line, line_data, of_line = patched_line(line_file, pile.files.get("line", ()))
    file = _named(path, "timetable", model.timetable, shipped_timetable, pile)
    timetable, times_data, of_timetable = patched_timetable(file, line, pile.files.get("timetable", ()))
    check_parties(str(file), str(line_file), line, timetable)
    stock, loaded = _trains(path, model, timetable, pile)
    trains = heated({stock_id: loaded[name][0] for stock_id, name in stock.items()}, model.battery)
    lengths_m = {stock_id: float(train.row[0]["length_m"]) for stock_id, train in trains.items()}
    validate_train_fits(line, lengths_m, timetable, str(path))
    check_scatter(str(path), model.scatter, trains)
    check_centre(str(path), model.operation, line.stations)
    check_vision(str(path), model.vision, line.stations)
    check_margins(str(path), model.driving)
    check_wheels(str(path), model.sensors, model.unit, trains)
    check_battery(str(path), model.battery, timetable, trains)
    check_sensors(str(path), model.sensors, sorted(trains))
    check_window(str(path), model.sensors, model.curvature)
    check_grip(str(path), model.driving, trains, line.max_speed_mps)
    belief = belief_of(path, model.belief, line_file, pile.files.get("line", ()), line, trains)
    setup = Setup(
        name=model.id,
        line=line,
        timetable=timetable,
        trains=trains,
        seed=model.seed if seed is None else seed,
        air=model.air,
        unit=unit_of(model.unit, timetable),
        driving=model.driving,
        laws=laws_of(str(path), model.driving, sorted(trains)),
        law_settings=model.law,
        planning=model.planning,
        belief=belief,
        sensors=model.sensors,
        gnss=model.gnss,
        beacons=model.beacons,
        curvature=model.curvature,
        curvature_map=curvature_map_of(
            _folders(path, "curvature", pile), model, line if belief is None else belief.line
        ),
        scatter=model.scatter,
        tuning=model.tuning,
        learned=learned_of(path, model.tuning, trains),
        vision=model.vision,
        lidar=model.lidar,
        load=model.trains,
        limits=model.limits,
        operation=model.operation,
        dispatch=model.dispatch,
        battery=model.battery,
        people=model.people,
        late=model.late,
    )
    check_late(str(path), setup)
    check_markers(str(path), setup)
    setup = replace(setup, script=script_of(str(path), setup, model.fault, model.act, model.expect))
    assumed = (*model.assumed, *line.assumed, *timetable.assumed, *_train_assumptions(trains))
    of_trains = (change for _, _, changes in loaded.values() for change in changes)
    changes = (*pile.changes, *of_line, *of_timetable, *of_trains)
    inputs = Inputs(
        scenario=pile.data | {"seed": setup.seed},
        line=line_data,
        timetable=times_data,
        trains={name: data for name, (_, data, _) in loaded.items()},
        stock=stock,
        learned={stock_id: learned.as_dict() for stock_id, learned in setup.learned.items()},
        changes=changes,
        assumed=assumed,
    )
    return Scenario(model.id, model.name, str(path), setup, changes, assumed, inputs)


def _folder() -> Path:
    return Path(str(files("study"))) / FOLDER


def _named(path: Path, key: str, name: str, shipped: Callable[[str], Path], pile: Pile | None = None) -> Path:
    """A file beside the one that names it, beside the scenario itself, or shipped; InputError names the key."""
    said_in = path if pile is None else pile.said_in.get(key, path)
    for folder in dict.fromkeys((said_in.parent, path.parent)):
        if name.endswith(".toml") and existing_file(folder / name):
            return folder / name
    try:
        return shipped(name)
    except InputError as error:
        raise InputError(str(path), key, name, error.expected) from error


def _folders(path: Path, key: str, pile: Pile) -> tuple[Path, ...]:
    """Where a file that is named under a key may lie: beside the scenario that names it, or beside this one."""
    said_in = pile.said_in.get(key, path)
    return tuple(dict.fromkeys((said_in.parent, path.parent)))


def _trains(
    path: Path, model: ScenarioFile, timetable: Timetable, pile: Pile
) -> tuple[dict[str, str], dict[str, tuple[TrainType, Data, tuple[Change, ...]]]]:
    """The name of the train of each stock; by it the kind, its tables, and what patches have changed of them."""
    known = {diagram.stock_id for diagram in timetable.diagrams}
    for stock_id in model.trains.stock:
        if stock_id not in known:
            raise InputError(
                str(path), f"trains.stock.{stock_id}", stock_id, f"a stock id: {one_of(sorted(known))}"
            )
    named = {"trains.default": model.trains.default}
    named |= {f"trains.stock.{stock_id}": name for stock_id, name in model.trains.stock.items()}
    for train, patches in pile.trains.items():
        if train not in named.values():
            raise InputError(
                patches[0].file, patches[0].key, None, f"a train that runs, {one_of(named.values())}"
            )
    loaded = {
        name: patched_train(_named(path, key, name, shipped_train, pile), pile.trains.get(name, ()))
        for key, name in named.items()
    }
    return {
        stock_id: model.trains.stock.get(stock_id, model.trains.default) for stock_id in sorted(known)
    }, loaded


def unit_of(unit: UnitParameters, timetable: Timetable) -> UnitParameters:
    """The units' parameters; the shortest stop is the timetable's where the scenario gives none."""
    if "dwell_min_s" in unit.model_fields_set:
        return unit
    return unit.model_copy(update={"dwell_min_s": timetable.dwell_min_s})


def _train_assumptions(trains: Mapping[str, TrainType]) -> tuple[str, ...]:
    kinds = {train.id: train for train in trains.values()}
    return tuple(f"{train.name}: {text}" for train in kinds.values() for text in train.assumed)
