"""What a person sees on stderr while something takes its time: a bar, or a plain line now and then."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import TextIO


def tell(text: str) -> None:
    """A line on stderr, if anybody is left to read it: a terminal that is gone ends nothing."""
    with silenced(sys.stderr):
        sys.stderr.write(text + "\n")
        sys.stderr.flush()


@contextmanager
def silenced(stream: TextIO) -> Generator[None]:
    """Where a standard stream takes nothing more the rest goes nowhere: it would fail again as the interpreter ends."""
    try:
        yield
    except OSError:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


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
                tell(f"{title}: {hour:02d}:00, {arrived} trains arrived")

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


def _told_by_quarters(title: str) -> Callable[[int, int], None]:
    told = 0

    def tell_quarter(done: int, total: int) -> None:
        nonlocal told
        quarter = 4 * done // max(total, 1)
        if quarter > told:
            told = quarter
            tell(f"{title}: {done} of about {total} runs")

    return tell_quarter
