"""What a person sees on stderr while something takes its time: a bar, or a plain line now and then."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TextIO

if TYPE_CHECKING:
    from vehicle.compiling import Compilation


def print_aside(text: str) -> None:
    """A line on stderr, if anybody is left to read it: a terminal that is gone ends nothing."""
    _SILENCE.last_s, _SILENCE.times = time.monotonic(), 0
    with silence_stream(sys.stderr):
        sys.stderr.write(text + "\n")
        sys.stderr.flush()


@contextmanager
def silence_stream(stream: TextIO) -> Generator[None]:
    """Where a standard stream takes nothing more the rest goes nowhere: it would fail again as the interpreter ends."""
    try:
        yield
    except OSError:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


SPOKEN_AFTER_S: Final = 2.0  # of compiling
SILENT_S = 1e9 if os.environ.get("BRANCHLINE_QUIET") else 2.0  # after which a command says that it goes on


@dataclass(slots=True)
class _Silence:
    last_s: float = 0.0  # when anybody spoke
    times: int = 0  # that it was broken on end by saying that something goes on
    doing: str = ""


_SILENCE: Final = _Silence()


@contextmanager
def never_silent(what: str) -> Generator[None]:
    """Says that something goes on where nobody has said anything for longer than a person waits, ever less often."""
    began_s = _SILENCE.last_s = time.monotonic()
    _SILENCE.doing, ended = "", threading.Event()

    def watch() -> None:
        while not ended.wait(SILENT_S / 10):
            now_s, times = time.monotonic(), _SILENCE.times
            if now_s - _SILENCE.last_s >= SILENT_S * 2**times:
                print_aside(f"{what}: {now_s - began_s:.0f} s so far{_SILENCE.doing}")
                _SILENCE.times = times + 1

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        ended.set()
        watcher.join()


def going_on(doing: str) -> None:
    """What is being done from now on, to be said where it takes long."""
    _SILENCE.doing, _SILENCE.times = f", {doing}", 0


@contextmanager
def progress_of(title: str) -> Generator[Callable[[float, float, int], None]]:
    """A progress line on stderr; a plain line now and then where stderr is no terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        told = -1

        def tell_hour(now_s: float, _end_s: float, arrived: int) -> None:
            nonlocal told
            hour = int(now_s // 3600)
            if hour != told:
                told = hour
                print_aside(f"{title}: {hour:02d}:00, {arrived} trains arrived")

        yield tell_hour
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[clock]}  {task.fields[arrived]} trains arrived"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, transient=True, refresh_per_second=5) as bar:
        task = bar.add_task(title, total=1.0, clock="", arrived=0)
        first_s: list[float] = []

        def show(now_s: float, end_s: float, arrived: int) -> None:
            if not first_s:
                first_s.append(now_s)
            share = (now_s - first_s[0]) / max(end_s - first_s[0], 1.0)
            clock = f"{int(now_s // 3600):02d}:{int(now_s % 3600 // 60):02d}"
            _SILENCE.last_s = time.monotonic()
            bar.update(task, completed=share, clock=clock, arrived=arrived)

        yield show


@contextmanager
def progress_of_runs(title: str) -> Generator[Callable[[int, int], None]]:
    """How many runs are done, on stderr. The bar is drawn by this thread alone: a forked copy has no other."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        yield _told_by_quarters(title)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, auto_refresh=False) as bar:
        task = bar.add_task(title, total=None)

        def show(done: int, total: int) -> None:
            bar.update(task, completed=done, total=max(done, total), refresh=True)

        yield show


def _told_by_quarters(title: str, what: str = "runs") -> Callable[..., None]:
    told = 0

    def tell_quarter(done: int, total: int, more: str = "") -> None:
        nonlocal told
        quarter = 4 * done // max(total, 1)
        if quarter > told:
            told = quarter
            print_aside(f"{title}: {done} of about {total} {what}{more}")

    return tell_quarter


@contextmanager
def progress_of_days(title: str) -> Generator[Callable[[int, int, str], None]]:
    """How many days of a sweep are there, the time left at the pace so far, and how sure a figure is by now."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    pace = _Pace()
    if not console.is_terminal:
        said = _told_by_quarters(title, "days")

        def tell_days(there: int, total: int, found: str) -> None:
            pace.run += 1
            said(there, total, f"; {pace.left_text(there, total)}; {found}")

        yield tell_days
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[left]}  {task.fields[found]}"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, transient=True, refresh_per_second=2) as bar:
        task = bar.add_task(title, total=None, left="", found="")

        def show(there: int, total: int, found: str) -> None:
            pace.run += 1
            bar.update(task, completed=there, total=total, left=pace.left_text(there, total), found=found)

        yield show


class _Pace:
    """How long the rest takes at the pace of the days run so far."""

    def __init__(self) -> None:
        self.run = 0
        self._began_s = time.monotonic()

    def left_text(self, there: int, total: int) -> str:
        each_s = (time.monotonic() - self._began_s) / max(self.run, 1)
        left_s = round(each_s * max(total - there, 0))
        hours, minutes, seconds = left_s // 3600, left_s % 3600 // 60, left_s % 60
        text = f"{hours} h {minutes:02d} min" if hours else f"{minutes} min {seconds:02d} s"
        return f"{60.0 / max(each_s, 1e-9):.0f} days a minute, {text} left"


LINKED_SHARE: Final = 0.2  # of the time of a piece, for what comes after its last function


class CompilingShown:
    """Says what is being compiled where that takes a while, and how long the rest takes by the share of functions."""

    def __init__(self) -> None:
        self._name = ""
        self._began_s = self._said_s = 0.0

    def __call__(self, piece: Compilation) -> None:
        """Look at the clock, and say it or not."""
        now_s = time.monotonic()
        if piece.name != self._name:
            self._name, self._began_s, self._said_s = piece.name, now_s, now_s
        if now_s - self._said_s >= SPOKEN_AFTER_S or (piece.linked and self._said_s > self._began_s):
            self._said_s = now_s
            print_aside(compiling_text(piece, now_s - self._began_s))


def compiling_text(piece: Compilation, spent_s: float) -> str:
    """One line: what, how much of it, and how much longer at that pace."""
    share = (1.0 - LINKED_SHARE) * (1.0 if piece.linked else piece.written / piece.functions)
    left = f", about {spent_s / share - spent_s:.0f} s left" if share > 0.0 else ""
    what = "optimising" if piece.linked else f"{piece.written} of {piece.functions} functions"
    return f"compiling {piece.name}, once for this processor: {what}{left}"
