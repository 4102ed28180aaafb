"""How errors end a command: each kind its own outcome, each outcome its own exit code."""

import errno
import signal
from pathlib import Path

import pytest

from host.parties import ForeignError, PartyBug, PartyError
from network.errors import InputError
from study.outcome import MEANINGS, Outcome, StoppedError, outcome_of, text_of


@pytest.mark.parametrize(
    ("error", "outcome"),
    [
        (InputError("f", "k", 1, "2"), Outcome.BAD_INPUT),
        (PartyError("block manager was killed by SIGKILL"), Outcome.COULD_NOT_RUN),
        (ForeignError("a foreign session has joined the run"), Outcome.COULD_NOT_RUN),
        (PartyBug("point terminal A-E failed: KeyError"), Outcome.BUG),
        (OSError(errno.ENOSPC, "No space left on device"), Outcome.COULD_NOT_RUN),
        (OSError(errno.EFBIG, "File too large"), Outcome.COULD_NOT_RUN),
        (OSError(errno.EDQUOT, "Disk quota exceeded"), Outcome.COULD_NOT_RUN),
        (PermissionError(errno.EACCES, "Permission denied"), Outcome.COULD_NOT_RUN),
        (BrokenPipeError(errno.EPIPE, "Broken pipe"), Outcome.COULD_NOT_RUN),
        (MemoryError(), Outcome.COULD_NOT_RUN),
        (FileNotFoundError(errno.ENOENT, "No such file"), Outcome.BUG),
        (KeyError("x"), Outcome.BUG),
        (ValueError("x"), Outcome.BUG),
        (StoppedError(signal.SIGHUP), Outcome.HUNG_UP),
        (StoppedError(signal.SIGINT), Outcome.INTERRUPTED),
        (StoppedError(signal.SIGTERM), Outcome.TERMINATED),
    ],
)
def test_an_error_has_one_outcome(error: BaseException, outcome: Outcome) -> None:
    assert outcome_of(error) is outcome
    assert "\n" not in text_of(error)


def test_exit_codes_are_told_apart() -> None:
    codes = {outcome.name: outcome.code for outcome in Outcome}
    assert codes == {
        "GOOD": 0,
        "BROKEN": 1,
        "BAD_INPUT": 2,
        "COULD_NOT_RUN": 3,
        "BUG": 70,
        "HUNG_UP": 129,
        "INTERRUPTED": 130,
        "TERMINATED": 143,
    }


def test_the_page_has_every_outcome() -> None:
    page = (Path(__file__).parents[2] / "docs" / "architecture.md").read_text("utf-8")
    for outcome in Outcome:
        assert f"| {outcome.code} | {outcome.value} | {outcome.meaning} |" in page
    assert set(MEANINGS) == set(Outcome)


def test_a_file_that_cannot_be_written_is_named() -> None:
    assert (
        text_of(OSError(errno.ENOSPC, "No space left on device", "/x/y")) == "/x/y: No space left on device"
    )
