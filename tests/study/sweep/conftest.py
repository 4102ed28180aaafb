"""A small sweep, and its directory in which days can be held."""

import gc
import os
import select
from collections.abc import Iterator
from pathlib import Path

import pytest

from study.sweep.table import days_csv
from tests.study.sweep.here import swept
from tests.study.sweep.planted import BEGUN, control_of

SWEEP = """
id = "tiny"
name = "Radio on the paper's line"
scenario = "rtri_test_line"
watch = ["mean_late_s"]

[seeds]
first = 1
days = 12

[[axis]]
name = "radio delay"
key = "air.delay_mean_s"
values = [0.1, 0.5]
labels = ["0.1 s", "0.5 s"]
"""
DRAW = """
[[draw]]
name = "shortest_stop"
key = "unit.dwell_min_s"
distribution = "uniform"
low = 20.0
high = 40.0
"""
WAIT_S = 120.0  # for a process to do what it does in seconds; beyond it the test has failed


@pytest.fixture(scope="module", autouse=True)
def what_was_there_stays() -> None:
    """A process tidies up after each day: only what the day has left, not what all tests before have."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def sweep_file(tmp_path: Path) -> Path:
    file = tmp_path / "tiny.toml"
    file.write_text(SWEEP, "utf-8")
    return file


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """Where the sweep goes; the folder beside it says what days are to do."""
    control_of(tmp_path / "out").mkdir()
    os.mkfifo(control_of(tmp_path / "out") / BEGUN)
    return tmp_path / "out"


class Held:
    """Days that wait: who has them at hand, and how they go on."""

    def __init__(self, out: Path) -> None:
        self._control = control_of(out)
        self._begun = os.open(self._control / BEGUN, os.O_RDWR | os.O_NONBLOCK)

    def hold(self, *days: int) -> None:
        for day in days:
            os.mkfifo(self._control / f"hold-{day}")

    def next_day(self) -> tuple[int, int]:
        """The next day that is held, and its process."""
        ready, _, _ = select.select([self._begun], [], [], WAIT_S)
        assert ready, "no day was begun"
        heard = b""
        while not heard.endswith(b" "):
            heard += os.read(self._begun, 1)
        day, pid = map(int, heard.split(b"/"))
        return day, pid

    def next_pid(self) -> int:
        """The process of the next day that is held."""
        return self.next_day()[1]

    def let_go(self, *days: int) -> None:
        """Days that are held go on."""
        for day in days:
            (self._control / f"held-{day}").open("wb").close()

    def close(self) -> None:
        os.close(self._begun)


@pytest.fixture
def held(out: Path) -> Iterator[Held]:
    found = Held(out)
    yield found
    found.close()


@pytest.fixture
def expected(sweep_file: Path, tmp_path: Path) -> str:
    """The table of a sweep that nothing has disturbed."""
    state = swept(sweep_file, tmp_path / "undisturbed")
    assert state.run == 24
    return days_csv(state)
