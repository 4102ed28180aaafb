"""Each role killed, stopped for a while, and restarted at twenty points of a run over Zenoh in which all are processes.

A killed one ends the run with its name; one that was stopped for less than the patience of who asks it changes nothing;
a restart is as it is where telegrams are simulated. Nothing is left of any.
"""

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Timer
from typing import Final

import psutil
import pytest

from host.parties import PartyError
from network.clock import clock
from radio.noted import Sent
from scenario.scenario import Scenario, load_scenario
from simulation.events import JournalEntry
from simulation.journal import Journal
from simulation.result import RunResult
from study.runner.run import CarrierKind, PartyLink, RunOptions, UnitsAt, carrier_factory, run_to_end
from sumo_cfg.build import net_for
from sumo_cfg.truth_map import read_net
from tests.nightly import others_nightly

ROLES: Final = {"block-manager": "block manager", "B-W": "point terminal B-W", "K1": "on-board unit K1"}
TWO_TRAINS: Final = """
extends = "rtri_test_line"
id = "two"
name = "two"
timetable = "rtri_two_trains"
people.react = true
"""
POINTS: Final = 20
FROM_S, EVERY_S = 36_000, 15
STOPPED_S: Final = 0.2  # real time, far below the patience of who asks
EVERY: Final = [(role, point) for role in ROLES for point in range(POINTS)]
IN_EVERY_RUN: Final = [("B-W", 8)]
at_each_point = pytest.mark.parametrize(("role", "point"), others_nightly(EVERY, IN_EVERY_RUN, columns=True))


def run_of(
    scenario: Scenario, folder: Path, link: PartyLink, watch: Callable[[JournalEntry], None] | None = None
) -> RunResult:
    """On plain track; over Zenoh with a process for each party, units too."""

    def journal() -> Journal:
        made = Journal()
        if watch is not None:
            made.watch(watch)
        return made

    folder.mkdir(exist_ok=True)
    net = net_for(scenario.setup.line, folder)
    units = UnitsAt.PROCESSES if link is PartyLink.ZENOH else UnitsAt.SIMULATOR
    make = carrier_factory(CarrierKind.PLAIN, scenario.setup.line, net)
    options = RunOptions(make, read_net(net), folder, link, units, journal=journal)
    return run_to_end(scenario, options)[1]


@pytest.fixture(scope="module")
def two_trains(tmp_path_factory: pytest.TempPathFactory) -> Scenario:
    return written(tmp_path_factory.mktemp("two"), "")


def written(folder: Path, more: str) -> Scenario:
    file = folder / "two.toml"
    file.write_text(TWO_TRAINS + more, "utf-8")
    return load_scenario(str(file))


@pytest.fixture(scope="module")
def undisturbed(two_trains: Scenario, tmp_path_factory: pytest.TempPathFactory) -> RunResult:
    return run_of(two_trains, tmp_path_factory.mktemp("undisturbed"), PartyLink.SIMULATED)


def at_point(point: int, undisturbed: RunResult, does: Callable[[], None]) -> Callable[[JournalEntry], None]:
    """Does it once, as the run sends one of its telegrams."""
    sent = sum(isinstance(entry.event, Sent) for entry in undisturbed.journal.entries)
    left = max(sent * point // POINTS, 1)

    def watch(entry: JournalEntry) -> None:
        nonlocal left
        left -= isinstance(entry.event, Sent)
        if left == 0:
            left = -1
            does()

    return watch


def process_of(role: str) -> psutil.Process:
    return next(p for p in psutil.Process().children(recursive=True) if role in p.cmdline())


@pytest.fixture
def nothing_is_left() -> Iterator[None]:
    before = set(psutil.Process().children(recursive=True))
    yield
    gone, left = psutil.wait_procs(set(psutil.Process().children(recursive=True)) - before, timeout=20.0)
    assert not left, gone


@at_each_point
def test_a_killed_one_ends_the_run_with_its_name(
    role: str, point: int, two_trains: Scenario, undisturbed: RunResult, tmp_path: Path, nothing_is_left: None
) -> None:
    watch = at_point(point, undisturbed, lambda: process_of(role).kill())
    with pytest.raises(PartyError, match=rf"^{ROLES[role]} was killed by SIGKILL"):
        run_of(two_trains, tmp_path / "run", PartyLink.ZENOH, watch)


@at_each_point
def test_one_that_is_stopped_for_a_while_changes_nothing(
    role: str, point: int, two_trains: Scenario, undisturbed: RunResult, tmp_path: Path, nothing_is_left: None
) -> None:
    goes_on: list[Timer] = []

    def stop() -> None:
        process = process_of(role)
        process.suspend()
        goes_on.append(Timer(STOPPED_S, os.kill, (process.pid, signal.SIGCONT)))
        goes_on[0].start()

    result = run_of(two_trains, tmp_path / "run", PartyLink.ZENOH, at_point(point, undisturbed, stop))
    goes_on[0].join()
    assert result.digest == undisturbed.digest


@at_each_point
def test_a_party_killed_at_any_point_leaves_nothing_and_the_day_ends(
    role: str, point: int, tmp_path: Path, nothing_is_left: None
) -> None:
    """Killed and begun anew by a fault: the run is the one without processes."""
    at = clock(FROM_S + EVERY_S * point)
    killed = written(tmp_path, f'[[fault]]\nkind = "restart"\ntarget = "{role}"\nstart = "{at}"\n')
    apart, alone = (run_of(killed, tmp_path / link.value, link) for link in reversed(PartyLink))
    assert apart.digest == alone.digest
    assert not apart.unfinished
    assert not apart.violations
