"""Work in forked copies of this process, so that many futures begin from one past.

A copy has everything that the process has, SUMO's state and compiled code too, and shares nothing that it writes. It
must print nothing and touch no library that keeps threads (polars): only the thread that forks lives on in it. What it
finds comes back through a pipe. It may die by an exception, by a signal, or at the limit of its processor time.
"""

from __future__ import annotations

import faulthandler
import os
import resource
import selectors
import signal
import sys
import warnings
from collections.abc import Callable
from typing import Final, Generic, NoReturn, Self, TypeVar

import msgspec

from study.runner.crash import exception_line

T = TypeVar("T")
Key = tuple[str, int]

CPU_LIMIT_S: Final = 600  # of one copy: far beyond any run, so only an endless loop meets it


class CopyDied(msgspec.Struct, frozen=True, tag=True):
    """A copy ended without a result: `why` names the exception or the signal, `text` is all that is known."""

    why: str
    text: str


class _Done(msgspec.Struct, frozen=True, tag=True):
    """What a copy found, as bytes."""

    found: bytes


class _Copy:
    """One forked process: where its result comes from."""

    def __init__(self, pid: int, pipe: int) -> None:
        self.pid = pid
        self.pipe = pipe
        self.heard: list[bytes] = []


class Forks(Generic[T]):
    """At most `jobs` copies at a time; `results` are those that have ended, by their keys.

    A context manager: the copies are gone when the context ends, however it ends. `kind` is what a copy finds,
    `take` is given each result as it comes.
    """

    def __init__(
        self, kind: type[T], jobs: int, take: Callable[[Key, T | CopyDied], None] | None = None
    ) -> None:
        self._kind: Final = kind
        self._jobs: Final = jobs
        self._take: Final = take
        self._running: dict[int, tuple[Key, _Copy]] = {}  # by pipe
        self._selector = selectors.DefaultSelector()
        self.results: dict[Key, T | CopyDied] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for _, copy in self._running.values():
            os.kill(copy.pid, signal.SIGKILL)
            os.waitpid(copy.pid, 0)
            os.close(copy.pipe)
        self._running.clear()
        self._selector.close()

    def start(self, key: Key, work: Callable[[], T]) -> None:
        """Fork, and let the copy do `work`; waits while all jobs are busy."""
        while len(self._running) >= self._jobs:
            self._hear()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        from_copy, to_parent = os.pipe()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of Python 3.12 on where there are threads
            pid = os.fork()
        if pid == 0:
            _work(work, to_parent)
        os.close(to_parent)
        self._running[from_copy] = (key, _Copy(pid, from_copy))
        self._selector.register(from_copy, selectors.EVENT_READ)

    @property
    def under_way(self) -> int:
        """How many copies run."""
        return len(self._running)

    def wait(self) -> None:
        """Until all copies have ended."""
        while self._running:
            self._hear()

    def _hear(self) -> None:
        """Wait for one copy to say something, and take the results of those that have ended."""
        for ready, _ in self._selector.select():
            key, copy = self._running[ready.fd]
            data = os.read(ready.fd, 1 << 16)
            if data:
                copy.heard.append(data)
                continue
            self._selector.unregister(ready.fd)
            os.close(ready.fd)
            del self._running[ready.fd]
            _, status = os.waitpid(copy.pid, 0)
            found = self.results[key] = self._result(b"".join(copy.heard), status)
            if self._take is not None:
                self._take(key, found)

    def _result(self, heard: bytes, status: int) -> T | CopyDied:
        if os.WIFSIGNALED(status):
            name = signal.Signals(os.WTERMSIG(status)).name
            return CopyDied(name, f"ended by {name}")
        try:
            answer = msgspec.msgpack.decode(heard, type=_Done | CopyDied)
        except msgspec.MsgspecError:
            return CopyDied("exit", f"ended with code {os.waitstatus_to_exitcode(status)} and no result")
        if isinstance(answer, CopyDied):
            return answer
        found: T = msgspec.msgpack.decode(answer.found, type=self._kind)
        return found


def result_of_copy(kind: type[T], work: Callable[[], T]) -> T:
    """The result of one copy. RuntimeError where it has none."""
    with Forks(kind, 1) as one:
        one.start(("", 0), work)
        one.wait()
        found = one.results["", 0]
    if isinstance(found, CopyDied):
        raise RuntimeError(found.text)
    return found


def _work(work: Callable[[], object], to_parent: int) -> NoReturn:
    """All that a copy does."""
    faulthandler.disable()  # the parent says what it died of
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    used_s = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    resource.setrlimit(resource.RLIMIT_CPU, (int(used_s) + CPU_LIMIT_S, hard))
    answer: _Done | CopyDied
    try:
        answer = _Done(msgspec.msgpack.encode(work()))
    except BaseException as error:
        cause = error.__cause__ or error
        answer = CopyDied(type(cause).__name__, exception_line(error))
    data = memoryview(msgspec.msgpack.encode(answer))
    while data:
        data = data[os.write(to_parent, data) :]
    os._exit(0)


def jobs_of(asked: int | None) -> int:
    """How many copies run at a time: as asked, or one for each processor."""
    return asked or len(os.sched_getaffinity(0))
