"""What people call things: identifiers, which become names of files, of SUMO and of Zenoh, and text to be read.

An identifier (ID) begins with a Latin letter or a digit and goes on with these, `.`, `_` and `-`; it is no path, ends
in no dot, and is none of the names that Windows keeps for devices, with or without an ending. Japanese stands in the
`name` and `name_ja` beside it: SUMO's ids and Zenoh's keys take it nowhere reliably. Text has no control characters,
which neither XML nor a terminal shows, and none that a reader does not see: marks that turn the direction of what
follows (U+202E), separators of lines, characters of no width.
"""

from __future__ import annotations

import re
import unicodedata
from typing import Annotated, Final

from pydantic import AfterValidator, WithJsonSchema

IDENTIFIER_LENGTH_MAX: Final = (
    64  # assumed: longer than any shipped id, and short enough for names made of two
)
TITLE_LENGTH_MAX: Final = 200
PROSE_LENGTH_MAX: Final = 2000
_IDENTIFIER: Final = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9._-]*[A-Za-z0-9_-])?")
# Microsoft, "Naming Files, Paths, and Namespaces": not with an ending either.
_RESERVED: Final = re.compile(r"(?:con|prn|aux|nul|com[0-9]|lpt[0-9])(?:\..*)?", re.IGNORECASE)
IDENTIFIER_HELP: Final = (
    f"an identifier: at most {IDENTIFIER_LENGTH_MAX} of A-Z, a-z, 0-9, '.', '_' and '-', beginning with a letter or a"
    " digit, not ending in '.', and no name that Windows keeps for a device"
)

# Control, surrogate, format, line and paragraph separator (Unicode, General Category).
_UNSEEN: Final = frozenset({"Cc", "Cs", "Cf", "Zl", "Zp"})
_JOINERS: Final = "\u200c\u200d"  # of format too, but scripts of India and Persia are spelled with them
_SEEN_HELP: Final = "characters, none of them a control character or one that is not seen"
TITLE_HELP: Final = f"one line of at most {TITLE_LENGTH_MAX} {_SEEN_HELP}"


def is_identifier(text: str) -> bool:
    """Whether a text may be an id."""
    short = len(text) <= IDENTIFIER_LENGTH_MAX
    return short and _IDENTIFIER.fullmatch(text) is not None and _RESERVED.fullmatch(text) is None


def title_of(text: str) -> str:
    """A text as a title: one line, and no longer than a title may be."""
    line = "".join(c for c in " ".join(text.split()) if not _unseen(c))
    return line if len(line) <= TITLE_LENGTH_MAX else line[: TITLE_LENGTH_MAX - 1] + "…"


def _unseen(character: str) -> bool:
    return unicodedata.category(character) in _UNSEEN and character not in _JOINERS


def _has_unseen(text: str) -> bool:
    """What can all be printed, as nearly every text can, is looked through at once."""
    return not text.isprintable() and any(map(_unseen, text))


def _identifier(text: str) -> str:
    if not is_identifier(text):
        raise ValueError(IDENTIFIER_HELP)
    return text


def _title(text: str) -> str:
    if len(text) > TITLE_LENGTH_MAX or _has_unseen(text):
        raise ValueError(TITLE_HELP)
    return text


def _prose(text: str) -> str:
    if len(text) > PROSE_LENGTH_MAX or _has_unseen(text.replace("\n", "").replace("\t", "")):
        raise ValueError(f"text of at most {PROSE_LENGTH_MAX} {_SEEN_HELP}")
    return text


Identifier = Annotated[
    str,
    AfterValidator(_identifier),
    WithJsonSchema(
        {
            "type": "string",
            "format": "identifier",
            "pattern": f"^{_IDENTIFIER.pattern}$",
            "maxLength": IDENTIFIER_LENGTH_MAX,
        }
    ),
]
Title = Annotated[
    str, AfterValidator(_title), WithJsonSchema({"type": "string", "maxLength": TITLE_LENGTH_MAX})
]
Prose = Annotated[
    str, AfterValidator(_prose), WithJsonSchema({"type": "string", "maxLength": PROSE_LENGTH_MAX})
]
