"""The wayside devices as processes: one for each while a run lasts, none afterwards, however it ended."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import psutil
import pytest

from host.parties import PartyError
from study.run.run import Link, execute
from study.scenario.scenario import load_scenario

pytestmark = pytest.mark.system

GONE_WITHIN_S = 15.0


@dataclass
class Running:
    """A run over Zenoh that has come as far as simulating, with its devices."""

    program: subprocess.Popen[str]
    devices: list[psutil.Process]
    cwd: Path
    temporary: Path

    def end(self) -> str:
        """Wait until the program has ended; what else it wrote on stderr."""
        assert self.program.stdout is not None
        assert self.program.stderr is not None
        rest, err = self.program.communicate(timeout=60)
        assert rest == ""
        return "\n".join(text for text in err.splitlines() if ":00, " not in text)

    def device(self, name: str) -> psutil.Process:
        return next(d for d in self.devices if name in d.cmdline())


def alive(processes: list[psutil.Process]) -> list[psutil.Process]:
    """Those that still run after a while; one that only waits to be reaped does not."""
    _, left = psutil.wait_procs(processes, timeout=GONE_WITHIN_S)
    running = []
    for process in left:
        with suppress(psutil.NoSuchProcess):
            if process.status() != psutil.STATUS_ZOMBIE:
                running.append(process)
    return running


@pytest.fixture
def running(command: tuple[str, ...], tmp_path: Path) -> Iterator[Running]:
    temporary, cwd = tmp_path / "temporary", tmp_path / "cwd"
    temporary.mkdir()
    cwd.mkdir()
    program = subprocess.Popen(
        [*command, "run", "karasuyama_weekday", "--link", "zenoh", "--json"],
        cwd=cwd,
        env={**os.environ, "TMPDIR": str(temporary)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        assert program.stderr is not None
        assert "05:00, 0 trains arrived" in program.stderr.readline()
        devices = psutil.Process(program.pid).children(recursive=True)
        assert len(devices) == 4
        yield Running(program, devices, cwd, temporary)
    finally:
        with suppress(ProcessLookupError):
            os.killpg(program.pid, signal.SIGKILL)
        program.communicate()


def ctrl_c(program: subprocess.Popen[str]) -> None:
    """As a terminal does it: to the whole process group."""
    os.killpg(program.pid, signal.SIGINT)


def interrupt(program: subprocess.Popen[str]) -> None:
    program.send_signal(signal.SIGINT)


def twice(program: subprocess.Popen[str]) -> None:
    """An impatient hand: the second one comes while the first is dealt with."""
    program.send_signal(signal.SIGINT)
    program.send_signal(signal.SIGINT)


def terminate(program: subprocess.Popen[str]) -> None:
    program.terminate()


@pytest.mark.parametrize(("stop", "code"), [(ctrl_c, 130), (interrupt, 130), (twice, 130), (terminate, 143)])
def test_a_stopped_run_leaves_nothing_behind(
    running: Running, stop: Callable[[subprocess.Popen[str]], None], code: int
) -> None:
    stop(running.program)
    assert running.end() == "interrupted"
    assert running.program.returncode == code
    assert alive(running.devices) == []
    assert list(running.cwd.iterdir()) == []
    assert list(running.temporary.iterdir()) == []


def test_devices_end_by_themselves_when_the_simulator_is_killed(running: Running) -> None:
    running.program.kill()
    running.program.wait(timeout=60)
    assert alive(running.devices) == []
    assert list(running.cwd.iterdir()) == []


def test_a_device_that_dies_unasked_ends_the_run_with_its_name(running: Running) -> None:
    running.device("OGN-W").kill()
    assert running.end().startswith("error: party OGN-W")
    assert running.program.returncode == 1
    assert alive(running.devices) == []
    assert list(running.cwd.iterdir()) == []
    assert list(running.temporary.iterdir()) == []


def test_an_error_inside_the_run_leaves_no_process() -> None:
    seen: list[psutil.Process] = []

    def fail(_now_s: float, _end_s: float, _arrived: int) -> None:
        seen.extend(psutil.Process().children(recursive=True))
        raise PartyError("made up")

    with pytest.raises(PartyError, match="made up"):
        execute(load_scenario("rtri_test_line"), Link.ZENOH, progress=fail)
    assert len(seen) == 5  # the block manager and four terminals
    assert alive(seen) == []


def test_a_short_run_is_the_same_with_and_without_processes() -> None:
    runs = [execute(load_scenario("rtri_test_line"), link) for link in Link]
    assert runs[0].result.digest == runs[1].result.digest
    assert runs[0].result.journal.to_bytes() == runs[1].result.journal.to_bytes()
