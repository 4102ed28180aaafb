"""How a command ends: every error becomes an `Outcome` here, with one line on stderr for a person to act on.

With `--json` stdout carries one object, which has the outcome, and nothing else; all else is on stderr.
"""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any, Final, NoReturn, Self, cast

import typer

from branchline.progress import print_aside, silence_stream
from study.outcome import Outcome, StoppedError, outcome_of, text_of

ASKING: Final = (signal.SIGINT, signal.SIGTERM)  # a run, to end where it is
STOPS: Final = (signal.SIGHUP, signal.SIGINT, signal.SIGTERM)
USAGE_COLUMNS: Final = 200  # of a usage error, which repeats what was typed
JSON_OPTION: Final = "--json"


def stop_by_signals() -> None:
    """From now on a signal is a `StoppedError`. What nohup has set for SIGHUP stays."""
    for number in STOPS:
        if number is not signal.SIGHUP or signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _stop)


def _stop(number: int, _frame: FrameType | None) -> None:
    """End like any other way: contexts close, processes go. Only once, so that the clearing up is not stopped."""
    for stop in STOPS:
        signal.signal(stop, signal.SIG_IGN)
    raise StoppedError(signal.Signals(number))


class AskedToStop:
    """As a context: the first SIGINT or SIGTERM only asks to stop, the next one ends the command as elsewhere.

    A terminal that hangs up is gone, so nobody could be told what was kept: SIGHUP ends the command at once.
    """

    def __init__(self) -> None:
        self.by: signal.Signals | None = None
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Self:
        self._before = {number: signal.signal(number, self._ask) for number in ASKING}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def __call__(self) -> bool:
        """Whether somebody has asked."""
        return self.by is not None

    def _ask(self, number: int, _frame: FrameType | None) -> None:
        self.by = signal.Signals(number)
        stop_by_signals()
        print_aside("stopping: what was run so far is being kept; a second time, and nothing is")


@contextmanager
def stopped_at_once(what: str) -> Generator[None]:
    """As a context, in which nothing can be kept yet: `what` goes on is said, and a signal ends the command."""
    print_aside(what)
    before = {number: signal.getsignal(number) for number in ASKING}
    stop_by_signals()
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def run_command(command: Callable[[], Outcome]) -> Outcome:
    """Run a command to its end, whatever that is; what is wrong is told."""
    try:
        outcome = command()
        sys.stdout.flush()
    except typer.TyperException as error:
        told = " ".join(error.format_message().split())[:USAGE_COLUMNS].rstrip(".") or "a command is missing"
        return _tell(Outcome.BAD_INPUT, f"command line: {told}; see branchline --help")
    except (Exception, StoppedError) as error:
        if (stopped := _stopped(error)) is not None:
            return _tell(outcome_of(stopped), "interrupted", label="")
        outcome = outcome_of(error)
        if outcome is Outcome.BUG:
            return _tell(Outcome.BUG, _bug(error), label="bug: ")
        return _tell(outcome, text_of(error))
    return outcome


def _stopped(error: BaseException | None) -> StoppedError | None:
    """The signal behind an error: as contexts close, one more may fail, with a terminal that is gone for one."""
    while error is not None and not isinstance(error, StoppedError):
        error = error.__context__
    return error


def judged_outcome(good: bool) -> Outcome:
    """How a command ends that came to its end."""
    return Outcome.GOOD if good else Outcome.BROKEN


def end(outcome: Outcome) -> NoReturn:
    """End a command here."""
    raise typer.Exit(outcome.code)


@contextmanager
def crashes_into(directory: Path | None) -> Generator[None]:
    """Where a run leaves its journal if a bug ends it."""
    from study.runner.crash import Crashed

    try:
        yield
    except Crashed as crashed:
        crashed.out = directory
        raise


def print_json(value: object, outcome: Outcome | None = None) -> None:
    """One object, and how the command ends."""
    if outcome is not None and isinstance(value, dict):
        value = {"outcome": outcome.value, **cast("dict[str, object]", value)}
    sys.stdout.write(json.dumps(value, ensure_ascii=False) + "\n")
    sys.stdout.flush()


def end_with(figures: dict[str, Any], lines: Iterable[str], *, good: bool, as_json: bool) -> NoReturn:
    """End with an answer: as one JSON object, or in lines for a person."""
    outcome = judged_outcome(good)
    if as_json:
        print_json(figures, outcome)
    else:
        sys.stdout.writelines(f"{line}\n" for line in lines)
    end(outcome)


def _tell(outcome: Outcome, text: str, label: str = "error: ") -> Outcome:
    """One line on stderr; one object on stdout, if one was asked for and stdout still takes it."""
    print_aside(f"{label}{text}")
    with silence_stream(sys.stdout):
        if JSON_OPTION in sys.argv[1:]:
            print_json({"message": text}, outcome)
        sys.stdout.flush()
    return outcome


def _bug(error: BaseException) -> str:
    """What a bug is; the traceback, and the journal of a run that was under way, go into files."""
    from study.runner.crash import Crashed, exception_line, keep_crashed, keep_traceback

    try:
        if isinstance(error, Crashed):
            return f"{error}; its journal so far and the traceback are in {keep_crashed(error)}"
        return f"{exception_line(error)}; the traceback is in {keep_traceback(error)}"
    except OSError as full:
        return f"{exception_line(error)}; nothing could be kept of it: {text_of(full)}"
