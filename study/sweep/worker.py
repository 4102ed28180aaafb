"""A day in whatever process it is run: run, filed in the sweep's directory, and a small record of it sent back.

A process has one SUMO, so it runs one day at a time; imports, nets and compiled code stay from day to day.
"""

from __future__ import annotations

import atexit
import gc
import resource
import shlex
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Final, cast

import msgspec
import psutil

from host.scratch import scratch
from network.errors import InputError
from scenario.scenario import Scenario
from study.runner.run import TEMPORARY, CarrierKind
from study.sweep.day import ProcessCache, run_day
from study.sweep.digest import code_digest, inputs_digest
from study.sweep.kept import is_kept, kept_day
from study.sweep.point import point_id, scenario_of
from study.sweep.records import DayOutcome, DayRecord, DaySpec
from study.sweep.store import NotSharedError, check_shared, day_name, filed_day, write_day

RETRIES: Final = 2  # a day that fails is begun so often again, then filed as crashed
RUNNER: Final = "study.sweep.worker:real_day"
NO_DIGEST: Final = "none: it crashed"  # of a day that came to an end on one carrier alone


class Task(msgspec.Struct, frozen=True):
    """A day to be run. `again`: also on SUMO; `tries`: how often it was begun before; `runner`: what runs it."""

    out: str
    token: str
    spec: DaySpec
    index: int
    again: bool = False
    keep: tuple[str, ...] = ()
    tries: int = 0
    runner: str = RUNNER


class FiledDay(msgspec.Struct, frozen=True, tag=True):
    """A day that is filed; how long it took, and what the process has taken of the machine at most."""

    record: DayRecord
    wall_s: float
    cpu_s: float
    rss_bytes: int
    peak_bytes: int
    where: str


def run_task(task: Task) -> FiledDay:
    """Run a day and file it. Raises InputError where this process does not see the client's directory."""
    check_shared(Path(task.out), task.token)
    began_s, began_cpu_s = time.perf_counter(), time.process_time()
    record = _runner(task.runner)(task)
    record = msgspec.structs.replace(record, tries=task.tries + record.tries, code=code_digest())
    write_day(Path(task.out), record)
    _tidy()
    return FiledDay(
        record,
        round(time.perf_counter() - began_s, 4),
        round(time.process_time() - began_cpu_s, 4),
        psutil.Process().memory_info().rss,
        resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
        f"pid {psutil.Process().pid}",
    )


def task_done(task: Task) -> FiledDay:
    """Run a day and file it, or take it as this code has filed and kept it: who did was lost before it could say so."""
    out = Path(task.out)
    check_shared(out, task.token)
    record = filed_day(out, day_name(task.spec, task.index))
    if record is None or record.code != code_digest() or not is_kept(record, out, task.keep):
        return run_task(task)
    return FiledDay(record, 0.0, 0.0, 0, 0, f"pid {psutil.Process().pid}")


def real_day(task: Task) -> DayRecord:
    """The day on its carrier, and where that is asked for on SUMO too. A crash is tried again, should it be chance.

    Raises NotSharedError where its files are no longer those of the sweep: that is no crash.
    """
    warm = _warm()
    warm.scenario(task.spec)
    tries = 0
    while True:
        tries += 1
        day = task.spec, task.index
        record = kept_day(*day, Path(task.out), task.keep, warm) if task.keep else run_day(*day, warm)
        if record.outcome is not DayOutcome.CRASHED or task.tries + tries > RETRIES:
            break
    record = msgspec.structs.replace(record, tries=tries)
    if not task.again or not record.digest:
        return record
    spec = msgspec.structs.replace(task.spec, carrier=CarrierKind.SUMO.value)
    other = run_day(spec, task.index, warm)
    return msgspec.structs.replace(record, again=other.digest or NO_DIGEST)


def crashed(task: Task, why: str) -> DayRecord:
    """The record of a day that no process has brought to an end, for whoever waits for it to file."""
    return DayRecord(
        task.spec, task.index, DayOutcome.CRASHED, why, None, tries=task.tries, code=code_digest()
    )


def replay_command(spec: DaySpec, out: str = "") -> str:
    """The command that runs a day again, with its report; the file is written beside the sweep's report."""
    file = Path(out) / replay_name(spec)
    run = f"runs/{point_id(spec)}-{spec.seed}"
    return f"branchline run {shlex.quote(str(file))} --seed {spec.seed} --carrier {spec.carrier} --out {run}"


def replay_name(spec: DaySpec) -> str:
    """The scenario file of a day, in the sweep's directory: that of its point, where nothing is drawn."""
    seed = f"-{spec.seed}" if spec.drawn else ""
    return f"replays/{point_id(spec)}{seed}.toml"


def _tidy() -> None:
    """Give back what the day has left in circles, tens of megabytes a day; what stays is looked through only once."""
    gc.collect()
    _keep_what_is_there()


@cache
def _keep_what_is_there() -> None:
    gc.freeze()


@cache
def _warm() -> ProcessCache:
    """What this process keeps from day to day; its folder is gone when the process ends."""
    stack = ExitStack()
    atexit.register(stack.close)
    folder = stack.enter_context(scratch(TEMPORARY))

    def of(spec: DaySpec) -> Scenario:
        changed = (
            f"files of {spec.scenario} have changed since the sweep began: the same command takes them anew"
        )
        try:
            point = scenario_of(msgspec.structs.replace(spec, drawn=()), folder)
        except InputError as error:
            raise NotSharedError(f"{changed}: {error}") from error
        if inputs_digest(point.setup) != spec.inputs:
            raise NotSharedError(changed)
        return scenario_of(spec, folder) if spec.drawn else point

    return stack.enter_context(ProcessCache(of, replay_command))


@cache
def _runner(name: str) -> Callable[[Task], DayRecord]:
    module, _, function = name.partition(":")
    return cast("Callable[[Task], DayRecord]", getattr(import_module(module), function))
