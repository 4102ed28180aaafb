"""What is not installed with the program itself, and is asked for by name where it is missing."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager

from network.errors import COMMAND_LINE, InputError


@contextmanager
def needing_extra(extra: str, command: str) -> Generator[None]:
    """As a context for imports: InputError where what the extra brings is not there."""
    try:
        yield
    except ModuleNotFoundError as error:
        expected = f"the extra: pip install 'branchline[{extra}]'"
        raise InputError(COMMAND_LINE, command, None, expected) from error
