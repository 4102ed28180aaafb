"""Scenarios: line, timetable, trains, sensors, air and seed of a run, read from TOML and made into a Setup.

A scenario may extend another (`extends = "karasuyama_weekday"`) and patch every file it names (`[patch]`): that is
a what-if. Whatever it leaves out has the defaults of its tables, which are assumed; `docs/files.md` lists them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from importlib.resources import files
from pathlib import Path
from typing import Any, Final

from network.errors import InputError
from network.files.crossing_road import roads_of
from network.files.edits import Change, Data
from network.files.quantities import SEED
from network.files.shipped import find_file, shipped_line, shipped_timetable
from network.files.text_input import existing_file
from network.files.toml_input import one_of
from network.model import Line
from network.networks import has_second, with_first_alone
from network.patching.patch import patched_line
from network.patching.timetable_patch import patched_timetable
from network.timetable import Timetable
from network.train_fit import validate_train_fits
from scenario.battery_choice import check_battery, heated_trains
from scenario.belief import belief_of
from scenario.curvature_choice import curvature_map_of
from scenario.fleet_file import (
    check_centre,
    check_cuts,
    check_given,
    check_grip,
    check_margins,
    check_markers,
    check_parties,
    check_scatter,
    check_vision,
    check_wheels,
    learned_of,
)
from scenario.inputs import Inputs
from scenario.late_choice import check_late
from scenario.law_choice import laws_of
from scenario.layers import ScenarioLayers, layers_of
from scenario.line_signals_choice import check_line_signals
from scenario.scenario_file import ScenarioFile
from scenario.script_file import script_of
from scenario.sensor_choice import check_sensors, check_window
from scenario.substitute_choice import check_substitute
from simulation.settings import Tables
from simulation.setup import Setup
from vehicle.train_file import TrainType, shipped_train
from vehicle.train_patch import patched_train

FOLDER: Final = "scenarios"


@dataclass(frozen=True, slots=True)
class Scenario:
    """A scenario ready to run; `inputs` are all its tables, and what of them is not as the files say."""

    id: str
    name: str
    file: str
    setup: Setup = field(repr=False)
    inputs: Inputs = field(repr=False)

    @property
    def called(self) -> str:
        """What a command takes for it: the name of a shipped one, else its file."""
        file = Path(self.file)
        return file.stem if file.parent == _folder() else self.file


def shipped_scenarios() -> tuple[str, ...]:
    """Names of the scenarios that come with the program."""
    return tuple(sorted(path.stem for path in _folder().glob("*.toml")))


def find_scenario(name: str) -> Path:
    """File of a shipped scenario, or the given .toml file. InputError otherwise."""
    return find_file(_folder(), "scenario", name)


def with_seed(scenario: Scenario, seed: int) -> Scenario:
    """The same scenario with another seed, as `load_scenario` would give it. InputError for a seed that is none."""
    _check_seed(seed)
    inputs = scenario.inputs.model_copy(update={"scenario": scenario.inputs.scenario | {"seed": seed}})
    return replace(scenario, setup=replace(scenario.setup, seed=seed), inputs=inputs)


def _check_seed(seed: int | None) -> None:
    if seed is not None and not SEED.holds(seed):
        raise InputError("command line", "--seed", seed, f"{SEED.text()} ({SEED.name})")


def load_scenario(name: str, seed: int | None = None, tables: Mapping[str, object] | None = None) -> Scenario:
    """Read a scenario with all that it names. InputError says which file, key and value is at fault.

    `tables` override its own, as those of a scenario file that extends it would.
    """
    _check_seed(seed)
    path = find_scenario(name)
    layers = layers_of(path, lambda above, base: _named(above, "extends", base, find_scenario), tables)
    with layers.naming_the_patch(path):
        return _loaded(path, layers, seed)


def _loaded(path: Path, layers: ScenarioLayers, seed: int | None) -> Scenario:
    model = layers.validated(path)
    line_file = _named(path, "line", model.line, shipped_line, layers)
    line, line_data, of_line = patched_line(line_file, layers.files.get("line", ()))
    line = with_radios(str(path), line, second=model.tables.second_air is not None)
    file = _named(path, "timetable", model.timetable, shipped_timetable, layers)
    timetable, times_data, of_timetable = patched_timetable(file, line, layers.files.get("timetable", ()))
    check_parties(str(file), str(line_file), line, timetable)
    stock, loaded = _trains(path, model, timetable, layers)
    tables = model.tables
    trains = heated_trains({stock_id: loaded[name][0] for stock_id, name in stock.items()}, tables.battery)
    lengths_m = {stock_id: float(train.row[0]["length_m"]) for stock_id, train in trains.items()}
    validate_train_fits(line, lengths_m, timetable, str(path))
    check_scatter(str(path), tables.scatter, trains)
    check_given(str(path), tables.dispatch, stock)
    check_cuts(str(path), tables.dispatch, line.stations, timetable.trains)
    check_centre(str(path), tables.operation, line.stations)
    check_vision(str(path), tables.vision, line.stations)
    check_margins(str(path), tables.driving)
    check_wheels(str(path), tables.sensors, tables.unit, trains)
    check_battery(str(path), tables.battery, timetable, trains)
    check_sensors(str(path), tables.sensors, sorted(trains))
    check_window(str(path), tables.sensors, tables.curvature)
    check_grip(str(path), tables.driving, trains, line.max_speed_mps)
    folders = _folders(path, "belief.trains", layers)
    belief = belief_of(folders, path, model.belief, line_file, layers.files.get("line", ()), line, trains)
    believed = line if belief is None else belief.line
    setup = Setup(
        name=model.id,
        line=line,
        timetable=timetable,
        trains=trains,
        seed=model.seed if seed is None else seed,
        laws=laws_of(str(path), tables.driving, sorted(trains)),
        belief=belief,
        curvature_map=curvature_map_of(
            _folders(path, "curvature.map", layers), path, tables.curvature, believed
        ),
        learned=learned_of(_folders(path, "tuning.learned", layers), tables.tuning, trains),
        load=model.trains,
        roads=roads_of(line_data, str(line_file)),
        **run_tables(tables, timetable),
    )
    check_late(str(path), setup)
    check_substitute(str(path), setup)
    check_line_signals(str(path), setup)
    check_markers(str(path), setup)
    setup = replace(setup, script=script_of(str(path), setup, model.fault, model.act, model.expect))
    of_trains = (change for _, _, changes in loaded.values() for change in changes)
    inputs = Inputs(
        scenario=layers.data | {"seed": setup.seed},
        line=line_data,
        timetable=times_data,
        trains={name: data for name, (_, data, _) in loaded.items()},
        stock=stock,
        learned={stock_id: learned.as_dict() for stock_id, learned in setup.learned.items()},
        changes=[*layers.changes, *of_line, *of_timetable, *of_trains],
        assumed=[*model.assumed, *line.assumed, *timetable.head.assumed, *_train_assumptions(trains)],
    )
    return Scenario(model.id, model.name, str(path), setup, inputs)


def with_radios(file: str, line: Line, *, second: bool) -> Line:
    """The line for trains with the radios that they have; InputError where a second network reaches nowhere."""
    if not second:
        return with_first_alone(line)
    if not has_second(line):
        expected = "a line that says where a second network reaches (alignments.second_coverage)"
        raise InputError(file, "second_air", None, expected)
    return line


def _folder() -> Path:
    return Path(str(files("study"))) / FOLDER


def _named(
    path: Path, key: str, name: str, shipped: Callable[[str], Path], layers: ScenarioLayers | None = None
) -> Path:
    """A file beside the one that names it, beside the scenario itself, or shipped; InputError names the key."""
    for folder in (path.parent,) if layers is None else _folders(path, key, layers):
        if name.endswith(".toml") and existing_file(folder / name):
            return folder / name
    try:
        return shipped(name)
    except InputError as error:
        raise InputError(str(path), key, name, error.expected) from error


def _folders(path: Path, key: str, layers: ScenarioLayers) -> tuple[Path, ...]:
    """Where a file that is named under a key may lie: beside the scenario that names it, or beside this one."""
    return tuple(dict.fromkeys(file.parent for file in (*layers.files_of(key), path)))


def _trains(
    path: Path, model: ScenarioFile, timetable: Timetable, layers: ScenarioLayers
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
    for train, patches in layers.trains.items():
        if train not in named.values():
            raise InputError(
                patches[0].file, patches[0].key, None, f"a train that runs, {one_of(named.values())}"
            )
    loaded = {
        name: patched_train(_named(path, key, name, shipped_train, layers), layers.trains.get(name, ()))
        for key, name in named.items()
    }
    return {
        stock_id: model.trains.stock.get(stock_id, model.trains.default) for stock_id in sorted(known)
    }, loaded


def run_tables(tables: Tables, timetable: Timetable) -> dict[str, Any]:
    """A scenario's tables by name, as a run has them: the shortest stop is the timetable's where none is given."""
    found = {each.name: getattr(tables, each.name) for each in fields(tables)}
    if "dwell_min_s" not in tables.unit.model_fields_set:
        found["unit"] = tables.unit.model_copy(update={"dwell_min_s": timetable.head.dwell_min_s})
    return found


def _train_assumptions(trains: Mapping[str, TrainType]) -> tuple[str, ...]:
    kinds = {train.id: train for train in trains.values()}
    return tuple(f"{train.name}: {text}" for train in kinds.values() for text in train.assumed)
