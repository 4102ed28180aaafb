"""Days on other machines, by a Dask scheduler that is there already: it says who runs which day, and knows no more.

A worker files its days itself, in the directory that all machines share. What a worker, the scheduler or the client
takes with it when it goes is at most the days at hand. Extra `cluster`.
"""

from __future__ import annotations

import logging
import queue
from collections.abc import Generator, Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Final

import msgspec

from network.errors import InputError
from study.runner.crash import exception_line
from study.sweep.local import GivenUpError, failed_by, filed_by_client
from study.sweep.store import check_shared, day_name
from study.sweep.worker import RETRIES, FiledDay, Task, crashed, task_done

if TYPE_CHECKING:
    from distributed import Client, Future

CONNECT_S: Final = 20.0  # a scheduler that has not answered by then is not there, or no longer
WORKERS_S: Final = 60  # within this time a worker must have come
LOOK_S: Final = 1.0  # so often it is looked whether the scheduler is still there
AHEAD: Final = 2  # days given to the scheduler for each worker, so that none waits for the client
OPTION: Final = "--scheduler"


class FailedDayError(Exception):
    """A day failed on a worker of the cluster; the scheduler has it run again, so often as it may."""


class NoMoreError(Exception):
    """A worker of the cluster can run no day at all."""


class ClusterPump:
    """The workers of a scheduler, whoever they are. The scheduler's own ways are kept: `retries`, lost workers."""

    def __init__(self, address: str, out: Path, token: str) -> None:
        if find_spec("distributed") is None:
            raise InputError("command line", OPTION, address, "the extra: pip install 'branchline[cluster]'")
        self._address: Final = address
        self._out: Final = out
        self._token: Final = token
        self._ended: queue.SimpleQueue[Future] = queue.SimpleQueue()
        self._workers: frozenset[str] = frozenset()

    def run(self, tasks: Iterator[Task]) -> Generator[FiledDay]:
        """See `study.sweep.local.Pump`. Workers that join on the way have days from the next look on."""
        with ExitStack() as stack:
            client = _client(self._address)
            stack.callback(_close, client)
            self._begin(client)
            at_hand: dict[str, Task] = {}
            ended = 0
            while True:
                room = AHEAD * max(len(self._workers), 1)
                while len(at_hand) < room and (task := next(tasks, None)) is not None:
                    at_hand[self._submit(client, task)] = task
                if not at_hand:
                    return
                future = self._next(client)
                if future is None or (ended := ended + 1) % room == 0:
                    self._look(client)
                task = None if future is None else at_hand.pop(future.key, None)
                if future is not None and task is not None:
                    yield self._done(future, task)

    def _submit(self, client: Client, task: Task) -> str:
        """Give a day to the scheduler; the name that it has there."""
        future = client.submit(
            run_there,
            msgspec.msgpack.encode(task),
            key=f"{self._token}-{day_name(task.spec, task.index)}",
            retries=RETRIES,
            pure=False,
        )
        future.add_done_callback(self._ended.put)
        return future.key

    def _next(self, client: Client) -> Future | None:
        """The next day that has ended; None: none for a while. Raises GivenUpError when the scheduler is gone."""
        with suppress(queue.Empty):
            return self._ended.get(timeout=LOOK_S)
        if client.status != "running":
            raise self._gone()
        return None

    def _done(self, future: Future, task: Task) -> FiledDay:
        """What came of a day; one that has failed as often as it may is filed as crashed."""
        error = future.exception() if future.status == "error" else None
        if isinstance(error, NoMoreError):
            raise GivenUpError(str(error))
        if error is None:
            return msgspec.msgpack.decode(self._result(future), type=FiledDay)
        begun = msgspec.structs.replace(task, tries=RETRIES + 1)
        return filed_by_client(
            crashed(begun, " ".join(f"{type(error).__name__}: {error}".split())), self._out
        )

    def _result(self, future: Future) -> bytes:
        """What a worker has sent back, by way of the scheduler; the day itself is on disk by now."""
        try:
            return future.result()
        except (OSError, CancelledError) as error:  # all is cancelled as the client loses it, for good
            raise self._gone() from error

    def _gone(self) -> GivenUpError:
        return GivenUpError(f"the scheduler at {self._address} is gone")

    def _begin(self, client: Client) -> None:
        """The first workers. InputError for those that cannot run days."""
        try:
            client.wait_for_workers(1, timeout=WORKERS_S)
        except TimeoutError as error:
            raise InputError("command line", OPTION, self._address, "a scheduler that has workers") from error
        try:
            self._look(client)
        except GivenUpError as error:
            raise InputError("command line", OPTION, self._address, str(error)) from error

    def _look(self, client: Client) -> None:
        """Which workers there are now. Raises GivenUpError for a new one that cannot run days."""
        try:
            threads: dict[str, int] = client.nthreads()
            new = sorted(threads.keys() - self._workers)
            files = (
                client.run(missing_on_worker, str(self._out), self._token, workers=new, on_error="return")
                if new
                else {}
            )
        except (OSError, CancelledError) as error:
            raise self._gone() from error
        for name in new:
            if threads[name] != 1:
                raise GivenUpError(
                    f"workers of one thread, since a process has one SUMO; {name} has {threads[name]}"
                )
        for name, text in sorted(files.items()):
            if isinstance(text, str) and text:
                raise GivenUpError(f"a worker that can run days; {name}: {text}")
        self._workers = frozenset(threads)


def run_there(packed: bytes) -> bytes:
    """On a worker: run a day and file it. An error of the day is raised, and the scheduler has it run again."""
    task = msgspec.msgpack.decode(packed, type=Task)
    try:
        return msgspec.msgpack.encode(task_done(task))
    except Exception as error:
        failed = failed_by(error)
        if failed.given_up:
            raise NoMoreError(failed.why) from None
        raise FailedDayError(failed.why) from None


def missing_on_worker(out: str, token: str) -> str:
    """On a worker: empty if it sees the client's directory, else what it sees."""
    try:
        check_shared(Path(out), token)
    except Exception as error:
        return str(error) or exception_line(error)
    return ""


def _client(address: str) -> Client:
    from distributed import Client

    # What becomes of the scheduler is told in a line of our own.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    try:
        return Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(
            "command line",
            OPTION,
            address,
            f"a scheduler that answers ({' '.join(str(error).split())[:200]})",
        ) from error


def _close(client: Client) -> None:
    """Whether the scheduler is still there or not."""
    with suppress(Exception):
        client.close(timeout=1)
