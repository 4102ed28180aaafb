"""What is not installed with the program itself, and is asked for by name where it is missing."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager

from network.errors import COMMAND_LINE, InputError


@contextmanager
def planning_extra(command: str) -> Generator[None]:
    """As a context for imports: InputError where OR-Tools are not there."""
    try:
        yield
    except ModuleNotFoundError as error:
        raise InputError(COMMAND_LINE, command, None, "the extra: pip install 'branchline[plan]'") from error
