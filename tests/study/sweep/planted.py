"""A day that takes no time, for tests of who runs days: it can be told to wait, to fail, and to be another on SUMO.

What is asked for lies in a folder beside the sweep's directory, by the number of the day: `hold-3` is a pipe that the
day reads from once, after it has said on the pipe `begun` its number and which process has it at hand.
"""

import os
from collections import Counter
from contextlib import suppress
from pathlib import Path

from radio.chance import generator
from study.measures.day_figures import DayFigures
from study.sweep.records import DayOutcome, DayRecord
from study.sweep.worker import Task

RUNNER = "tests.study.sweep.planted:day"
BEGUN = "begun"


def control_of(out: Path) -> Path:
    return out.with_name(f"{out.name}-control")


def day(task: Task) -> DayRecord:
    control = control_of(Path(task.out))
    if control.is_dir():
        _as_told(control, task)
    late_s = round(float(generator(task.spec.seed, "planted").normal(30.0, 10.0)), 3)
    figures = DayFigures(1, 1, (), 2, 2, (0.5, 1.0, 1.0), late_s, late_s, late_s, 2 * late_s, "T1", "B", 1.0)
    digest = f"digest of {task.spec.seed}"
    other = (control / f"other-{task.index}").exists()
    again = ("another" if other else digest) if task.again else ""
    return DayRecord(task.spec, task.index, DayOutcome.GOOD, "", figures, digest, digest, again=again)


def _as_told(control: Path, task: Task) -> None:
    with (control / "began.txt").open("ab", buffering=0) as stream:
        stream.write(f"{task.index}\n".encode())
    if (control / f"fail-{task.index}").exists():
        raise ValueError("planted")
    if (control / f"die-{task.index}").exists():
        os.kill(os.getpid(), 9)
    hold = control / f"hold-{task.index}"
    with suppress(FileNotFoundError):  # the other point has a day of that number too: one of the two is held
        hold.rename(control / f"held-{task.index}")
        with (control / BEGUN).open("wb", buffering=0) as stream:
            stream.write(f"{task.index}/{os.getpid()} ".encode())
        (control / f"held-{task.index}").open("rb").close()


def begun_counts(out: Path) -> Counter[int]:
    """How often each day was begun."""
    return Counter(map(int, (control_of(out) / "began.txt").read_text("utf-8").split()))
