"""How a command ends, as a word and an exit code: the one type for it, and the one place that gives an error its own.

A run that came to its end is judged by `study.runner.outcome`; what ended another one says what it was by its type.
"""

from __future__ import annotations

import signal
from enum import Enum
from typing import Final

from host.parties import PartyBug, PartyError
from network.errors import InputError, wanting
from simulation.carriers.lost import CarrierLostError

SIGNALLED: Final = 128  # plus the number of the signal, as shells have it


class Outcome(Enum):
    """How a command ended; the value is the word in `--json`."""

    GOOD = "good"
    BROKEN = "broken"
    BAD_INPUT = "bad input"
    COULD_NOT_RUN = "could not run"
    BUG = "bug"
    HUNG_UP = "hung up"
    INTERRUPTED = "interrupted"
    TERMINATED = "terminated"

    @property
    def code(self) -> int:
        """The exit code."""
        return CODES[self]

    @property
    def meaning(self) -> str:
        """What it says, in a sentence."""
        return MEANINGS[self]


CODES: Final = {
    Outcome.GOOD: 0,
    Outcome.BROKEN: 1,
    Outcome.BAD_INPUT: 2,
    Outcome.COULD_NOT_RUN: 3,
    Outcome.BUG: 70,  # EX_SOFTWARE of sysexits.h
    Outcome.HUNG_UP: SIGNALLED + signal.SIGHUP,
    Outcome.INTERRUPTED: SIGNALLED + signal.SIGINT,
    Outcome.TERMINATED: SIGNALLED + signal.SIGTERM,
}
MEANINGS: Final = {
    Outcome.GOOD: "it ran, and all that is expected of it holds",
    Outcome.BROKEN: "it ran, and an expectation or an invariant is broken, or a figure misses its criterion",
    Outcome.BAD_INPUT: "a file, an option or an argument cannot be used",
    Outcome.COULD_NOT_RUN: "what the run needs is gone: a process of a party, an endpoint, room on the disk, memory",
    Outcome.BUG: "the program is at fault; the line says where its log is",
    Outcome.HUNG_UP: "SIGHUP",
    Outcome.INTERRUPTED: "SIGINT, Ctrl-C",
    Outcome.TERMINATED: "SIGTERM",
}
BY_SIGNAL: Final = {
    signal.SIGHUP: Outcome.HUNG_UP,
    signal.SIGINT: Outcome.INTERRUPTED,
    signal.SIGTERM: Outcome.TERMINATED,
}


class StoppedError(BaseException):
    """A signal ends the command. Not a KeyboardInterrupt, which libraries take for their own."""

    def __init__(self, number: signal.Signals) -> None:
        super().__init__(number)
        self.outcome: Final = BY_SIGNAL[number]


class CutShortError(Exception):
    """A run could not go on; what was run so far is kept."""

    def __init__(self, why: str, kept: str) -> None:
        super().__init__(f"{why}; what was run so far is in {kept}")


def outcome_of(error: BaseException) -> Outcome:
    """How a command ends that this error ends."""
    match error:
        case StoppedError():
            return error.outcome
        case InputError():
            return Outcome.BAD_INPUT
        case PartyBug():
            return Outcome.BUG
        case PartyError() | CarrierLostError() | CutShortError():
            return Outcome.COULD_NOT_RUN
        case _:
            return Outcome.COULD_NOT_RUN if wanting(error) else Outcome.BUG


def text_of(error: BaseException) -> str:
    """What a person is told of an error that is no bug, in one line."""
    match error:
        case BrokenPipeError():
            text = "the reader of the output has closed it"
        case OSError():
            text = f"{error.filename or 'writing'}: {error.strerror}"
        case MemoryError():
            text = "out of memory"
        case _:
            text = str(error)
    return " ".join(text.split())
