"""Days on this machine: a few processes of our own, each with one SUMO, fed one day at a time.

A process is spawned, not forked, so that it holds nothing of another's; it goes after a number of days or when it has
grown too large, and another takes its place. One that dies loses the day it had at hand, which is run again.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections import deque
from collections.abc import Generator, Iterator
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Final, Protocol, cast

import msgspec

from network.errors import is_want_of_resources
from study.outcome import StoppedError, text_of
from study.runner.crash import exception_line
from study.sweep.records import DayRecord
from study.sweep.store import NotSharedError, write_day
from study.sweep.worker import RETRIES, FiledDay, Task, crashed, task_done

RECYCLE_DAYS: Final = 200  # assumed: what a library may leak in so many days is little
MEMORY_MAX_BYTES: Final = 490_000_000  # a process that has grown to this is replaced
STARTS_MAX: Final = 3  # processes one after the other that die before their first day: none will live


class Failed(msgspec.Struct, frozen=True, tag=True):
    """A day could not be run or filed. `given_up`: the machine or the directory is at fault, so no day can be."""

    why: str
    given_up: bool


class WorkerReady(msgspec.Struct, frozen=True, tag=True):
    """A process has all that it needs."""


class GivenUpError(Exception):
    """No day can be run any more; those that are filed stay."""


class Pump(Protocol):
    """Whatever runs days: takes them from an iterator as there is room for them, in any order back."""

    def run(self, tasks: Iterator[Task]) -> Generator[FiledDay]:
        """Every day given is filed when it comes back. Raises GivenUpError."""
        ...


Said = FiledDay | Failed | WorkerReady


class _Worker:
    """A process of ours, and the day it has at hand."""

    def __init__(self, days: int) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process: SpawnProcess = context.Process(target=serve, args=(theirs,), daemon=True)
        self.process.start()
        theirs.close()
        self.task: Task | None = None
        self.ready = False
        self.left = days

    def give(self, task: Task) -> None:
        """A day; whether it arrives shows as the process dies or answers."""
        self.task = task
        self.left -= 1
        try:
            self.pipe.send_bytes(msgspec.msgpack.encode(task))
        except OSError:  # it is dead: heard of as its end is looked at
            self.ready = False

    def heard(self) -> Said | None:
        """What it has said; None: it is dead."""
        try:
            return cast("Said", msgspec.msgpack.decode(self.pipe.recv_bytes(), type=Said))
        except (EOFError, OSError):
            return None

    def end(self) -> str:
        """It is gone when this returns; how it ended."""
        self.pipe.close()
        self.process.kill()
        self.process.join()
        code = self.process.exitcode or 0
        return f"ended by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code}"


class LocalPump:
    """Processes of this machine, `jobs` of them."""

    def __init__(self, jobs: int, recycle_days: int = RECYCLE_DAYS) -> None:
        self.jobs: Final = jobs
        self._recycle_days = recycle_days
        self._workers: list[_Worker] = []
        self._lost: deque[Task] = deque()
        self._stillborn = 0
        self.spawned = 0

    def run(self, tasks: Iterator[Task]) -> Generator[FiledDay]:
        """See `Pump`. What is at hand when the generator is closed is lost."""
        try:
            while True:
                self._feed(tasks)
                busy = [worker for worker in self._workers if worker.task is not None]
                if not busy:
                    return
                ready = set(wait([worker.pipe for worker in self._workers]))
                for worker in [worker for worker in self._workers if worker.pipe in ready]:
                    done = self._hear(worker)
                    if done is not None:
                        yield done
        finally:
            for worker in self._workers:
                worker.end()
            self._workers.clear()

    def _feed(self, tasks: Iterator[Task]) -> None:
        """A day for everyone that has none, as long as there are days; a process only where there is one for it."""
        for place in range(self.jobs):
            idle = place < len(self._workers) and self._workers[place].task is None
            if place < len(self._workers) and not idle:
                continue
            task = self._lost.popleft() if self._lost else next(tasks, None)
            if task is None:
                return
            if not idle:
                self._workers.append(_Worker(self._recycle_days))
                self.spawned += 1
            self._workers[-1 if not idle else place].give(task)

    def _hear(self, worker: _Worker) -> FiledDay | None:
        said = worker.heard()
        match said:
            case WorkerReady():
                worker.ready, self._stillborn = True, 0
                return None
            case FiledDay():
                worker.task = None
                if worker.left <= 0 or said.rss_bytes > MEMORY_MAX_BYTES:
                    self._end(worker)
                return said
            case Failed(why, given_up):
                task, worker.task = worker.task, None
                if given_up or task is None:
                    raise GivenUpError(why)
                return self._again(task, why)
            case None:
                return self._dead(worker)

    def _dead(self, worker: _Worker) -> FiledDay | None:
        """Its day is run again; a process that dies before it is ready says nothing of the day."""
        task, ready = worker.task, worker.ready
        why = self._end(worker)
        if not ready:
            self._stillborn += 1
            if self._stillborn >= STARTS_MAX:
                raise GivenUpError(f"processes that are to run days end as they begin: {why}")
            if task is not None:
                self._lost.append(task)
            return None
        return None if task is None else self._again(task, why)

    def _again(self, task: Task, why: str) -> FiledDay | None:
        """Once more, or filed as crashed."""
        begun = msgspec.structs.replace(task, tries=task.tries + 1)
        if begun.tries <= RETRIES:
            self._lost.append(begun)
            return None
        return filed_by_client(crashed(begun, why), Path(task.out))

    def _end(self, worker: _Worker) -> str:
        self._workers.remove(worker)
        return worker.end()


def filed_by_client(record: DayRecord, out: Path) -> FiledDay:
    """A day filed by the client, which no process came to the end of."""
    write_day(out, record)
    return FiledDay(record, 0.0, 0.0, 0, 0, "client")


def serve(pipe: Connection) -> None:
    """What a process of ours does until nobody has a day for it: the client has closed the pipe, or is dead."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the client ends it
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # stdout has the client's one object and nothing else
    pipe.send_bytes(msgspec.msgpack.encode(WorkerReady()))
    while True:
        try:
            task = msgspec.msgpack.decode(pipe.recv_bytes(), type=Task)
        except (EOFError, OSError):
            return
        try:
            said: Said = task_done(task)
        except (Exception, StoppedError) as error:
            said = failed_by(error)
        try:
            pipe.send_bytes(msgspec.msgpack.encode(said))
        except OSError:
            return


def failed_by(error: BaseException) -> Failed:
    """What a failure means: of the machine and of what is shared no day can come, a bug is of this day alone."""
    if isinstance(error, NotSharedError) or is_want_of_resources(error):
        return Failed(text_of(error), given_up=True)
    return Failed(exception_line(error), given_up=False)
