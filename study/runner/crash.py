"""A bug in the loop ends a run, but not without a trace: what it was, when, and the journal so far on disk."""

from __future__ import annotations

import os
import tempfile
import traceback
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path

from host.parties import PartyError
from network.clock import clock
from network.errors import InputError
from simulation.loop import Simulation
from simulation.setup import STEPS_PER_S
from study.outcome import Outcome, outcome_of
from study.record.directory import CRASH_FILE, JOURNAL_FILE, replacing_folder


class Crashed(RuntimeError):  # noqa: N818 - names what happened
    """An exception that nobody raises on purpose has ended a run. Its cause is that exception."""

    def __init__(self, error: Exception, scenario: str, seed: int, step: int, journal: bytes) -> None:
        where = f"scenario {scenario}, seed {seed}, step {step}, simulated time {_clock(step)}"
        super().__init__(f"{exception_line(error)}; {where}")
        self.scenario = scenario
        self.journal = journal
        self.out: Path | None = None  # the run directory, where one was asked for


@contextmanager
def bugs_named(scenario: str, simulation: Simulation, *, processes: bool) -> Generator[None]:
    """Any exception becomes a `Crashed`, save those that are no bug: they say what they are.

    Without `processes` no party can be lost: one that is down is the simulator's own fault.
    """
    try:
        yield
    except Exception as error:
        lost = isinstance(error, PartyError) and not processes
        if outcome_of(error) is not Outcome.BUG and not lost:
            with suppress(OSError):
                simulation.journal.spill()
            raise
        setup = simulation.setup
        journal = simulation.journal.to_bytes()
        raise Crashed(error, scenario, setup.seed, simulation.step, journal) from error


def exception_line(error: BaseException) -> str:
    """An exception in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())


def keep_crashed(crashed: Crashed) -> Path:
    """Write the journal so far and the traceback into the run directory; returns where they are.

    Without one they go to runs/<scenario>-crash, and where nothing can be written to a folder for temporary files.
    """
    out = crashed.out or (Path("runs") / f"{crashed.scenario}-crash").resolve()
    try:
        with replacing_folder(out) as folder:
            folder.mkdir()
            _fill(crashed, folder)
    except (InputError, OSError):
        out = Path(tempfile.mkdtemp(prefix="branchline-crash-"))
        _fill(crashed, out)
    return out


def keep_traceback(error: BaseException) -> Path:
    """Write the traceback of a bug outside any run; returns its file."""
    file = Path(tempfile.mkdtemp(prefix="branchline-crash-")) / CRASH_FILE
    file.write_text(text_of(error), "utf-8")
    return file


def text_of(error: BaseException) -> str:
    """The traceback, causes and all."""
    return "".join(traceback.format_exception(error))


def _fill(crashed: Crashed, folder: Path) -> None:
    _write_through(folder / JOURNAL_FILE, crashed.journal)
    _write_through(folder / CRASH_FILE, text_of(crashed).encode())


def _write_through(file: Path, data: bytes) -> None:
    """On disk when this returns."""
    with file.open("wb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(stream.fileno())


def _clock(step: int) -> str:
    return f"{clock(int(step / STEPS_PER_S))}.{int(step % STEPS_PER_S)}"
