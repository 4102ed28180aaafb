"""The one error that bad input raises; the command line prints it as one line and exits with 2."""

from __future__ import annotations


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
