"""The one error that bad input raises; the command line prints it as one line and exits with 2."""

from __future__ import annotations

from typing import Final

SHOWN_MAX: Final = 80  # characters of a value, or of a key, that a message shows
EXPECTED_MAX: Final = 600  # of what was expected: it may name what a file calls its own things


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
        where = f"{one_line(self.file)}: {cut(one_line(self.key))}" if self.key else one_line(self.file)
        value = "" if self.value is None else f" is {shown(self.value)}"
        return f"{where}{value}; expected {cut(one_line(self.expected), EXPECTED_MAX)}"


def shown(value: object) -> str:
    """A value as a file spells it, cut at SHOWN_MAX characters."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        # A longer text is cut before its quotes and escapes are made: it may be as large as a file.
        return cut(repr(value[: SHOWN_MAX + 1]))
    if isinstance(value, list | tuple):
        return cut(
            f"[{', '.join(shown(item) for item in value[:SHOWN_MAX])}{', …' if len(value) > SHOWN_MAX else ''}]"
        )
    if isinstance(value, dict):
        return "a table"
    try:
        return cut(str(value))
    except ValueError:  # Python writes no whole number of more than 4300 digits
        return "a number of thousands of digits"


def cut(text: str, most: int = SHOWN_MAX) -> str:
    """A text with what goes beyond `most` characters left out."""
    return text if len(text) <= most else text[: most - 1] + "…"


def one_line(text: str) -> str:
    """A text with everything escaped that does not show as itself on a line."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
