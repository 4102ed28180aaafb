"""The one error that bad input raises, which the command line prints as one line, and errors of the system that are no
bug.
"""

from __future__ import annotations

import errno
from typing import Final

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


def wanting(error: BaseException) -> bool:
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
        where = f"{self.file}: {self.key}" if self.key else self.file
        value = "" if self.value is None else f" is {self.value!r}"
        return f"{where}{value}; expected {self.expected}"
