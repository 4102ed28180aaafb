"""What a question is asked of: a scenario or a finished run, by name or as it was loaded."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from branchline.ending import crashes_into
from branchline.progress import progress_of
from network.errors import COMMAND_LINE, InputError
from network.files.toml_input import one_of
from network.station_names import station_id_of
from scenario.scenario import Scenario, load_scenario
from study.capacity.blocking_table import read_blocking
from study.capacity.rules import MINIMAL
from study.capacity.theory import occupations
from study.feasibility.check import refuse
from study.record.read_back import RunRead, read_run
from study.record.setup_back import setup_of
from study.runner.run import PartyLink, execute

if TYPE_CHECKING:
    from network.model import Line
    from simulation.setup import Setup
    from study.capacity.occupation import Occupation


def loaded_source(source: str | Path | Scenario | RunRead) -> Scenario | RunRead:
    """The run of a directory, or the scenario of that name or file. InputError for neither."""
    if isinstance(source, Scenario | RunRead):
        return source
    return read_run(Path(source)) if Path(source).is_dir() else load_scenario(str(source))


def setup_of_source(loaded: Scenario | RunRead) -> Setup:
    """Line, timetable, trains and tables."""
    return loaded.setup if isinstance(loaded, Scenario) else setup_of(loaded)


def occupations_as_run(loaded: Scenario | RunRead, *, shown: bool) -> tuple[Occupation, ...]:
    """Blocking times of a finished run, or of a scenario that is run for them, its progress on stderr if `shown`."""
    if isinstance(loaded, RunRead):
        return read_blocking(loaded.tables.blocking)
    refuse(loaded.called, loaded.setup, anyway=False)
    with (
        crashes_into(Path("runs") / loaded.id),
        progress_of(loaded.id) if shown else nullcontext() as progress,
    ):
        done = execute(loaded, PartyLink.SIMULATED, progress=progress)
    return read_blocking(done.tables.blocking)


def occupations_of(loaded: Scenario | RunRead, *, theory: bool, shown: bool) -> tuple[Occupation, ...]:
    """Blocking times as run, or by theory with ways set as late as can be."""
    if theory:
        return occupations(setup_of_source(loaded), MINIMAL)
    return occupations_as_run(loaded, shown=shown)


def stop_of(line: Line, station: str | None) -> str | None:
    """The id of a station where headways are measured, by id or name; None of none. InputError for a halt."""
    if station is None:
        return None
    found = station_id_of(line, station)
    if line.stations[found].is_halt:
        known = [each.id for each in line.stations.values() if not each.is_halt]
        raise InputError(COMMAND_LINE, "--station", station, one_of(known, station))
    return found
