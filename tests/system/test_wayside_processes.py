"""The wayside devices as processes: one for each while a run lasts, none afterwards, however it ended."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import psutil
import pytest

from host.parties import PartyError
from host.planes import ANSWER_LIMIT_S
from scenario.scenario import load_scenario
from simulation.journal import read_journal
from study.outcome import Outcome
from study.runner.run import PartyLink, execute
from tests.nightly import others_nightly

GONE_WITHIN_S = 120.0  # on a machine that does much else; beyond it the test has failed
ENDS_WITHIN_S = 600.0  # so much a whole day may take there


@dataclass
class Running:
    """A run over Zenoh that has come as far as simulating, with its devices."""

    program: subprocess.Popen[str]
    devices: list[psutil.Process]
    cwd: Path
    temporary: Path
    said: dict[str, Any] = field(default_factory=dict[str, Any])  # the object on stdout

    def end(self) -> str:
        """Wait until the program has ended; what else it wrote on stderr."""
        assert self.program.stdout is not None
        assert self.program.stderr is not None
        rest, err = self.program.communicate(timeout=ENDS_WITHIN_S)
        self.said = json.loads(rest) if rest else {}
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


def passes(program: subprocess.Popen[str], real_s: float) -> None:
    """Real time passes, in which the program does not end."""
    with pytest.raises(subprocess.TimeoutExpired):
        program.wait(timeout=real_s)


@pytest.fixture(params=[signal.SIG_DFL])
def hang_up_is(request: pytest.FixtureRequest) -> Iterator[None]:
    """What the program finds set for SIGHUP: not what nohup may have set for these tests."""
    before = signal.signal(signal.SIGHUP, request.param)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.fixture
def running(command: tuple[str, ...], tmp_path: Path, hang_up_is: None) -> Iterator[Running]:
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
    """An impatient hand: the second one comes while the first is dealt with. Two of one kind could come as one."""
    program.send_signal(signal.SIGINT)
    program.send_signal(signal.SIGTERM)


def terminate(program: subprocess.Popen[str]) -> None:
    program.terminate()


def terminate_all(program: subprocess.Popen[str]) -> None:
    """As a service manager does it."""
    os.killpg(program.pid, signal.SIGTERM)


def hang_up(program: subprocess.Popen[str]) -> None:
    """As a terminal does it that is closed: to the whole process group."""
    os.killpg(program.pid, signal.SIGHUP)


STOPS: Final[Mapping[Callable[[subprocess.Popen[str]], None], Outcome]] = {
    ctrl_c: Outcome.INTERRUPTED,
    interrupt: Outcome.INTERRUPTED,
    terminate: Outcome.TERMINATED,
    terminate_all: Outcome.TERMINATED,
}


@pytest.mark.parametrize("stop", others_nightly(STOPS, [ctrl_c]))
def test_a_stopped_run_leaves_what_was_run_and_no_process(
    running: Running, stop: Callable[[subprocess.Popen[str]], None]
) -> None:
    outcome = STOPS[stop]
    stop(running.program)
    kept = running.cwd / "runs" / "karasuyama_weekday-incomplete"
    assert running.end().endswith(f"; what was run so far is in {kept}")
    assert (running.said["outcome"], running.said["out"]) == (outcome.value, str(kept))
    assert running.program.returncode == outcome.code
    assert alive(running.devices) == []
    assert list((running.cwd / "runs").iterdir()) == [kept]
    assert (kept / "report.html").exists()
    assert list(running.temporary.iterdir()) == []


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("stop", "outcome"),
    [(twice, Outcome.TERMINATED), (hang_up, Outcome.HUNG_UP)],
)
def test_a_second_signal_and_a_hang_up_leave_nothing(
    running: Running, stop: Callable[[subprocess.Popen[str]], None], outcome: Outcome
) -> None:
    stop(running.program)
    assert running.end().endswith("interrupted")
    assert running.said["outcome"] == outcome.value
    assert running.program.returncode == outcome.code
    assert alive(running.devices) == []
    assert list(running.cwd.iterdir()) == []
    assert list(running.temporary.iterdir()) == []


@pytest.mark.parametrize(
    "link", others_nightly([link.value for link in PartyLink], [PartyLink.SIMULATED.value])
)
def test_a_terminal_that_is_closed_ends_it_like_any_hang_up(
    command: tuple[str, ...], tmp_path: Path, hang_up_is: None, link: str
) -> None:
    """Its bar was being drawn there: what then fails to be written is not what ended the run."""
    ours, its = os.openpty()
    child = subprocess.Popen(
        ["setsid", "--ctty", "--wait", *command, "run", "karasuyama_weekday", "--link", link],
        cwd=tmp_path,
        env={**os.environ, "TERM": "xterm"},
        stdin=its,
        stdout=its,
        stderr=its,
    )
    os.close(its)
    shown = b""
    while b"05:" not in shown:
        shown += os.read(ours, 4096)
    devices = psutil.Process(child.pid).children(recursive=True)
    os.close(ours)
    assert child.wait(timeout=ENDS_WITHIN_S) == Outcome.HUNG_UP.code
    assert alive(devices) == []
    assert list(tmp_path.iterdir()) == []


@pytest.mark.nightly
@pytest.mark.parametrize("hang_up_is", [signal.SIG_IGN], indirect=True, ids=["nohup"])
def test_who_asked_for_it_is_not_hung_up(running: Running) -> None:
    hang_up(running.program)
    passes(running.program, 1.0)
    terminate(running.program)
    assert "what was run so far is in" in running.end()
    assert running.program.returncode == Outcome.TERMINATED.code


@pytest.mark.nightly
def test_a_simulator_that_was_stopped_blames_no_device(running: Running) -> None:
    """Asked, the device gives no answer while both are stopped; its own limit is long over when it wakes."""
    device = running.device("OGN-W")
    device.suspend()
    passes(running.program, 1.0)
    running.program.send_signal(signal.SIGSTOP)
    passes(running.program, ANSWER_LIMIT_S + 2.0)
    running.program.send_signal(signal.SIGCONT)
    passes(running.program, 1.0)
    device.resume()
    assert running.end().endswith("writing the report")
    assert (running.program.returncode, running.said["outcome"]) == (0, "good")
    day = execute(load_scenario("karasuyama_weekday"), PartyLink.SIMULATED)
    assert running.said["digest"] == day.result.digest


@pytest.mark.nightly
def test_devices_end_by_themselves_when_the_simulator_is_killed(
    running: Running, command: tuple[str, ...]
) -> None:
    """What it leaves on disk, hidden, the next start sweeps: the run directory begun, and temporary folders."""
    running.program.kill()
    running.program.wait(timeout=ENDS_WITHIN_S)
    assert alive(running.devices) == []
    runs = running.cwd / "runs"
    (left,) = runs.iterdir()
    assert left.name.startswith(".karasuyama_weekday-")
    assert {path.name.partition("-")[0] for path in running.temporary.iterdir()} == {"bl", "branchline"}
    again = subprocess.run(
        [*command, "run", "rtri_test_line", "--link", "zenoh", "--json"],
        cwd=running.cwd,
        env={**os.environ, "TMPDIR": str(running.temporary)},
        capture_output=True,
        check=False,
    )
    assert again.returncode == 0
    assert [path.name for path in runs.iterdir()] == ["rtri_test_line"]
    assert list(running.temporary.iterdir()) == []


def test_a_device_that_dies_unasked_ends_the_run_with_its_name(running: Running) -> None:
    running.device("OGN-W").kill()
    assert running.end().startswith("error: point terminal OGN-W was killed by SIGKILL")
    assert running.program.returncode == Outcome.COULD_NOT_RUN.code
    assert running.said["outcome"] == "could not run"
    assert alive(running.devices) == []
    (kept,) = (running.cwd / "runs").iterdir()
    assert kept.name == "karasuyama_weekday-incomplete"
    assert running.said["message"].endswith(f"; what was run so far is in {kept}")
    assert {path.name for path in kept.iterdir()} == {"journal.jsonl", "incomplete.txt"}
    assert read_journal(kept / "journal.jsonl")[-1].t_s > 5 * 3600.0
    assert list(running.temporary.iterdir()) == []


def test_an_error_inside_the_run_leaves_no_process() -> None:
    seen: list[psutil.Process] = []
    before = set(psutil.Process().children(recursive=True))  # what other tests of this worker started

    def fail(_now_s: float, _end_s: float, _arrived: int) -> None:
        seen.extend(set(psutil.Process().children(recursive=True)) - before)
        raise PartyError("made up")

    with pytest.raises(PartyError, match="made up"):
        execute(load_scenario("rtri_test_line"), PartyLink.ZENOH, progress=fail)
    assert len(seen) == 5  # the block manager and four terminals
    assert alive(seen) == []


def test_a_short_run_is_the_same_with_and_without_processes() -> None:
    runs = [execute(load_scenario("rtri_test_line"), link) for link in PartyLink]
    assert runs[0].result.digest == runs[1].result.digest
    assert runs[0].result.journal.to_bytes() == runs[1].result.journal.to_bytes()


TRAPS = (
    "host",
    "radio",
    "network",
    "study",
    "simulation",
    "wayside",
    "onboard",
    "numpy",
    "msgspec",
    "zenoh",
    "typer",
)
ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    "called",
    [
        ("-P", "-c", "from branchline.cli import main; main()"),
        ("-c", "from branchline.cli import main; main()"),
    ],
    ids=["as installed", "with the folder first"],
)
def test_no_module_of_the_folder_from_which_it_is_called_is_run(
    tmp_path: Path, called: tuple[str, ...]
) -> None:
    """With every process of it. The second way of calling shows that the traps are traps."""
    mark = f"from pathlib import Path\nPath({str(tmp_path / 'mark')!r}).touch()\nraise SystemExit(99)\n"
    cwd = tmp_path / "cwd"
    cwd.mkdir()
    for name in TRAPS:
        (cwd / f"{name}.py").write_text(mark, "utf-8")
    arguments = ["run", "rtri_test_line", "--link", "zenoh", "--units", "processes", "--out"]
    done = subprocess.run(
        [sys.executable, *called, *arguments, str(tmp_path / "run")],
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    if "-P" in called:
        assert (done.returncode, (tmp_path / "mark").exists()) == (0, False), done.stderr
    else:
        assert (done.returncode, (tmp_path / "mark").exists()) == (99, True)
