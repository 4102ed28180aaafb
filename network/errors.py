"""The one error that bad input raises, which the command line prints as one line, and errors of the system that are no
bug.
"""

from __future__ import annotations

import errno
from pathlib import PurePath
from typing import Final

from network.raw import is_row

COMMAND_LINE: Final = "command line"  # the file of what is wrong there
SHOWN_MAX: Final = 80  # characters of a value, or of a key, that a message shows
EXPECTED_MAX: Final = 20_000  # of what was expected: it may name all that a file calls its own things

# What the system refuses for want of something, or of a right to it; any other error of its calls is a bug.
_WANTING: Final = frozenset(
    {
        errno.ENOSPC,
        errno.EDQUOT,
        errno.EFBIG,
        errno.EROFS,
        errno.EIO,
        errno.ENOMEM,
        errno.EMFILE,
        errno.ENFILE,
        errno.EACCES,
        errno.EPERM,
        errno.EPIPE,
    }
)


def is_want_of_resources(error: BaseException) -> bool:
    """Whether the machine lacks what the program needs: room, memory, a right, a reader."""
    return isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno in _WANTING)


class InputError(Exception):
    """Input that cannot be used: which file, which key, what value, what was expected."""

    def __init__(self, file: str, key: str, value: object, expected: str) -> None:
        super().__init__(file, key, value, expected)
        self.file = file
        self.key = key
        self.value = value
        self.expected = expected

    def __str__(self) -> str:
        """One line for the person who has to mend the file."""
        where = f"{one_line(self.file)}: {cut_text(one_line(self.key))}" if self.key else one_line(self.file)
        value = "" if self.value is None else f" is {self._value()}"
        return f"{where}{value}; expected {cut_text(one_line(self.expected), EXPECTED_MAX)}"

    def _value(self) -> str:
        """The value; what a person has just typed stays whole: a path is of no use without its end."""
        typed = self.file == COMMAND_LINE and isinstance(self.value, str | PurePath)
        return one_line(repr(str(self.value))) if typed else shown_value(self.value)


def shown_value(value: object) -> str:
    """A value as a file spells it, cut at SHOWN_MAX characters."""
    match value:
        case bool():
            text = str(value).lower()
        case str():
            # A longer text is cut before its quotes and escapes are made: it may be as large as a file.
            text = cut_text(repr(value[: SHOWN_MAX + 1]))
        case _ if is_row(value):
            items = ", ".join(shown_value(item) for item in value[:SHOWN_MAX])
            text = cut_text(f"[{items}{', …' if len(value) > SHOWN_MAX else ''}]")
        case dict():
            text = "a table"
        case _:
            text = cut_text(_plain(value))
    return text


def _plain(value: object) -> str:
    try:
        return str(value)
    except ValueError:  # Python writes no whole number of more than 4300 digits
        return "a number of thousands of digits"


def cut_text(text: str, most: int = SHOWN_MAX) -> str:
    """A text with what goes beyond `most` characters left out."""
    return text if len(text) <= most else text[: most - 1] + "…"


def one_line(text: str) -> str:
    """A text with everything escaped that does not show as itself on a line."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
