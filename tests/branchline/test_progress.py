"""What a person is told while something takes its time."""

from collections.abc import Callable
from threading import Event
from typing import Any

import pytest

from branchline import progress
from branchline.progress import CompilingShown, Silence, said_if_long
from vehicle.compiling import Compilation


def test_compiling_that_takes_a_while_is_told_with_the_time_left(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    show = CompilingShown()
    told: list[list[str]] = []
    for at_s, piece in (
        (0.0, Compilation("a.law", 10, 0, linked=False)),
        (1.5, Compilation("a.law", 10, 9, linked=True)),  # quick enough to be silent
        (10.0, Compilation("the.kernel", 40, 0, linked=False)),
        (11.9, Compilation("the.kernel", 40, 5, linked=False)),
        (14.0, Compilation("the.kernel", 40, 10, linked=False)),  # a quarter of 80 % in 4 s: 16 s more
        (15.0, Compilation("the.kernel", 40, 11, linked=False)),
        (26.0, Compilation("the.kernel", 40, 38, linked=True)),  # 80 % in 16 s
    ):
        monkeypatch.setattr(progress.time, "monotonic", lambda at_s=at_s: at_s)
        show(piece)
        told.append(capsys.readouterr().err.splitlines())
    head = "compiling the.kernel, once for this processor:"
    assert told == [
        [], [], [], [],
        [f"{head} 10 of 40 functions, about 16 s left"],
        [],
        [f"{head} optimising, about 4 s left"],
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("rarer", "told_s", "waits_s"),
    [(True, (2, 4, 8), [2.0, 2.0, 4.0, 8.0]), (False, (2, 4, 6), [2.0, 2.0, 2.0, 2.0])],
)
def test_what_takes_long_says_so_ever_less_often_or_every_2_s(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    rarer: bool,
    told_s: tuple[int, ...],
    waits_s: list[float],
) -> None:
    waited_s: list[float] = []
    done, told = Event(), Event()

    class Watched(Event):
        def wait(self, timeout: float | None = None) -> bool:
            if timeout is None:  # a thread's own, that it has started
                return super().wait()
            told.wait()
            waited_s.append(timeout)
            if len(waited_s) <= 3:
                return False
            done.set()
            return super().wait()

    monkeypatch.setattr(progress.threading, "Event", Watched)
    with said_if_long("fitting", ever_rarer=rarer) as tell:
        tell("curve 2")
        told.set()
        done.wait()
    assert capsys.readouterr().err.splitlines() == [f"fitting: {s} s so far, curve 2" for s in told_s]
    assert waited_s == waits_s


def test_a_command_is_never_silent_for_long_whoever_speaks(
    main: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Said after 2 s of silence, 4, 8; two seconds after anybody else has spoken it begins anew."""
    silence = Silence(10.0)
    asked = [(11.9, 10.0), (12.0, 10.0), (15.9, 10.0), (16.0, 10.0), (23.0, 23.0), (24.9, 23.0), (25.0, 23.0)]
    assert [silence.is_due(*at) for at in asked] == [False, True, False, True, False, False, True]
    monkeypatch.setattr("branchline.progress.SILENT_S", 0.01)
    said = main("headway", "karasuyama_weekday", "--theory").err
    assert "headway: 0 s so far\n" in said and said.count("so far") < 20
    said = main("check", "karasuyama_weekday").err  # which speaks for itself, of where trains meet
    assert said.count("check: ") < 10
