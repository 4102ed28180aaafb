"""The command, in this process and as a process of its own, and scenarios that tests of several packages run."""

import gc
import io
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import pytest
from hypothesis import HealthCheck, settings

from study.runner.collector import MORE_OBJECTS
from tests.trains import timetable_of

# Some hundred commands run as processes: bytecode is kept for them, also where the environment would have none.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False
gc.set_threshold(MORE_OBJECTS)
os.environ["BRANCHLINE_QUIET"] = "1"  # how long a command takes depends on the machine

# No verdict depends on how fast the machine is, and the same examples are tried everywhere. Fixtures are shared by the
# examples of a test: who changes one sets it anew. `make nightly` asks for the profile of many.
settings.register_profile(
    "few",
    max_examples=10,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
settings.register_profile("many", settings.get_profile("few"), max_examples=300)
settings.load_profile("few")

TESTS: Final = Path(__file__).parent


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session: pytest.Session) -> None:
    """Every second process imports all tests from the last to the first: it reads what the others have compiled."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "gw0")
    if session.config.args_source is not pytest.Config.ArgsSource.TESTPATHS or int(worker[2:]) % 2 == 0:
        return
    for file in sorted(TESTS.rglob("test_*.py"), reverse=True):
        with suppress(Exception, pytest.skip.Exception):  # said where it is collected
            import_module(".".join(file.relative_to(TESTS.parent).with_suffix("").parts))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What opens a browser stands in its folder."""
    for item in items:
        if item.path.relative_to(TESTS).parts[0] == "browser":
            item.add_marker("browser")


def pytest_collection_finish() -> None:
    """What was imported stays: the collector need not go through it after each day that a test runs."""
    gc.freeze()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """What tests record as `figures`, one line each, at the end."""
    for reports in terminalreporter.stats.values():
        for report in reports:
            for name, value in getattr(report, "user_properties", ()):
                if name == "figures" and getattr(report, "when", "call") == "call":
                    terminalreporter.write_line(str(value))


TURN_BACK_TIMETABLE = timetable_of(
    "turn_back",
    "karasuyama",
    "1D down, portal:HSK.MD to becomes:2U: HSK -/05:37; SHN 05:42/05:43; OGN 1 05:57/-",
    "2U up, from:1D to stabled: OGN 1 -/06:05; HSK 06:26/-",
    dwell_min_s=20,
    V1="1D 2U",
)
TURN_BACK_SCENARIO = """
extends = "karasuyama_weekday"
id = "turn_back"
name = "One set to Ogane and back"
timetable = "turn_back_times.toml"
"""


def turn_back_in(folder: Path) -> str:
    """A scenario file: one set of the Karasuyama line that changes ends at Ogane, with the weekday's air."""
    (folder / "turn_back_times.toml").write_text(TURN_BACK_TIMETABLE, "utf-8")
    file = folder / "turn_back.toml"
    file.write_text(TURN_BACK_SCENARIO, "utf-8")
    return str(file)


@pytest.fixture
def turn_back(tmp_path: Path) -> str:
    """`turn_back_in` the test's own folder."""
    return turn_back_in(tmp_path)


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    code: int
    out: str
    err: str

    def figures(self) -> dict[str, Any]:
        """The one JSON object that stdout is."""
        assert self.out.count("\n") == 1, self.out
        found: dict[str, Any] = json.loads(self.out)
        return found


@pytest.fixture(scope="session")
def command() -> tuple[str, ...]:
    """What starts the program."""
    return (sys.executable, "-m", "branchline")


@pytest.fixture(scope="session")
def branchline(command: tuple[str, ...]) -> Callable[..., Ended]:
    """Run the command as a process; `cwd` must be a folder of the test."""

    def run(*arguments: str, cwd: Path) -> Ended:
        done = subprocess.run([*command, *arguments], cwd=cwd, capture_output=True, text=True, check=False)
        return Ended(done.returncode, done.stdout, done.stderr)

    return run


def ended_in_process(arguments: Sequence[str], cwd: Path, output: Callable[[], tuple[str, str]]) -> Ended:
    """Run the command in this process; `output` gives what was written to stdout and stderr since it was asked last."""
    from branchline import cli, ending

    before = {number: signal.getsignal(number) for number in ending.STOPS}
    output()
    with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as ended:
        patch.chdir(cwd)
        patch.setattr(sys, "argv", ["branchline", *arguments])
        cli.main()
    for number, handler in before.items():
        signal.signal(number, handler)
    code = ended.value.code
    return Ended(code if isinstance(code, int) else 0, *output())


@pytest.fixture
def main(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[..., Ended]:
    """Run the command in this process, in the test's own folder: the same entry point, without the imports."""
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: ended_in_process(arguments, tmp_path, capfd.readouterr)


@pytest.fixture(scope="session")
def main_in() -> Callable[..., Ended]:
    """As `main`, for runs that the tests of a module share; `cwd` must be a folder of the test."""

    def run(*arguments: str, cwd: Path) -> Ended:
        out, err = io.StringIO(), io.StringIO()
        with redirect_stdout(out), redirect_stderr(err):
            return ended_in_process(arguments, cwd, lambda: (out.getvalue(), err.getvalue()))

    return run
