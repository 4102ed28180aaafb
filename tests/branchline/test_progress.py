"""What a person is told while something takes its time."""

from collections.abc import Callable
from typing import Any

import pytest

from branchline import progress
from branchline.progress import CompilingShown
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


def test_a_command_is_never_silent_for_long_whoever_speaks(
    main: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("branchline.progress.SILENT_S", 0.01)
    said = main("headway", "karasuyama_weekday", "--theory").err
    assert "headway karasuyama_weekday: 0 s so far\n" in said and said.count("so far") < 20
