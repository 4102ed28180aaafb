"""A run watched in sumo-gui: the same run; and where there is no window, one message."""

import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from network.errors import InputError
from simulation.carriers import sumo_api
from simulation.carriers.lost import CarrierLostError
from simulation.carriers.sumo_api import GuiWindow, in_window
from study.outcome import Outcome, outcome_of
from tests.conftest import Ended
from tests.nightly import others_nightly

XVFB = shutil.which("Xvfb")
needs_screen = pytest.mark.skipif(
    XVFB is None or find_spec("sumo") is None,
    reason="no Xvfb (Debian: xvfb) to draw on, or the extra net is not installed",
)


@pytest.fixture(scope="module")
def display() -> Iterator[str]:
    """A screen that nobody sees."""
    reading, writing = os.pipe()
    assert XVFB is not None
    server = subprocess.Popen(
        [XVFB, "-displayfd", str(writing), "-screen", "0", "800x600x24", "-nolisten", "tcp"],
        pass_fds=(writing,),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(writing)
    with os.fdopen(reading) as told:
        number = told.readline().strip()
    yield f":{number}"
    server.terminate()
    server.wait()


@needs_screen
@pytest.mark.parametrize("scenario", others_nightly(["rtri_test_line", "turn_back"], ["rtri_test_line"]))
def test_a_run_that_is_watched_is_the_same_run(
    scenario: str,
    turn_back: str,
    display: str,
    branchline: Callable[..., Ended],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    name = turn_back if scenario == "turn_back" else scenario
    plain = branchline("run", name, "--json", "--out", "plain", cwd=tmp_path)
    monkeypatch.setenv("DISPLAY", display)
    watched = branchline("run", name, "--json", "--gui", "--gui-delay", "0", "--out", "watched", cwd=tmp_path)
    assert (plain.code, watched.code) == (0, 0), watched.err
    one, other = plain.figures(), watched.figures()
    assert (one["carrier"], other["carrier"]) == ("sumo", "sumo-gui")
    for key in ("digest", "motion_digest", "trains_arrived"):
        assert one[key] == other[key]


def test_without_a_display_the_option_is_bad_input(
    main: Callable[..., Ended], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("sumo", reason="the extra net is not installed")
    monkeypatch.delenv("DISPLAY", raising=False)
    ended = main("run", "rtri_test_line", "--gui")
    assert ended.code == 2
    assert "DISPLAY" in ended.err
    assert not Path("runs").exists()


def test_without_sumo_gui_the_option_is_bad_input(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere(_name: str) -> None:
        return None

    monkeypatch.setattr(sumo_api, "find_spec", nowhere)
    monkeypatch.setenv("DISPLAY", ":0")
    with pytest.raises(InputError, match=r"branchline\[net\]"):
        in_window(GuiWindow())


def test_the_plain_carrier_has_no_window(main: Callable[..., Ended]) -> None:
    ended = main("run", "rtri_test_line", "--gui", "--carrier", "plain")
    assert ended.code == 2
    assert "--gui" in ended.err


def test_a_window_that_is_lost_is_no_bug() -> None:
    assert outcome_of(CarrierLostError("its window was closed")) is Outcome.COULD_NOT_RUN
