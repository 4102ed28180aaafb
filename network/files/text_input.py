"""Text of a file that a person wrote: UTF-8, with or without a mark at its front, and of a size that can be read.

Another encoding is named as what it is with how to convert it, not guessed at: names would come out wrong. What the
parsers of TOML and JSON share of limits stands here too.
"""

from __future__ import annotations

import codecs
import stat
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, Final

from network.errors import InputError
from network.raw import is_list, is_table

TOML_BYTES_MAX: Final = 1 << 20  # fifty times the largest shipped file; read in about a second
JSON_BYTES_MAX: Final = 16 << 20  # a hundred times the largest public timetable of a line
NESTING_MAX: Final = 16  # the deepest place of any schema is eight levels down

# The longer mark first: that of UTF-16 is its beginning.
_MARKS: Final = (
    (codecs.BOM_UTF32_LE, "UTF-32"),
    (codecs.BOM_UTF32_BE, "UTF-32"),
    (codecs.BOM_UTF16_LE, "UTF-16"),
    (codecs.BOM_UTF16_BE, "UTF-16"),
)
# Name, codec, and what `iconv` calls it.
_JAPANESE: Final = (("Shift-JIS", "cp932", "CP932"), ("EUC-JP", "euc_jp", "EUC-JP"))
_SHOWN_BEYOND: Final = "\ufffd"


def existing_file(path: Path) -> bool:
    """Whether a path is that of a file; one that the system cannot even look for is not."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def read_text(path: Path, bytes_max: int = TOML_BYTES_MAX) -> str:
    """Text of a UTF-8 file, without its mark. Raises InputError when it cannot be read."""
    return _decoded(str(path), read_bytes(path, bytes_max))


def read_bytes(path: Path, bytes_max: int) -> bytes:
    """What a file holds. Raises InputError for what is no file, cannot be read or is larger than `bytes_max`."""
    with opened(path) as stream:
        data = stream.read(bytes_max + 1)
    if len(data) > bytes_max:
        raise InputError(str(path), "", None, f"a file of at most {bytes_max >> 20} MiB")
    return data


@contextmanager
def opened(path: Path) -> Generator[BinaryIO]:
    """A file to read. Raises InputError for what is no file, and when it cannot be read."""
    file = str(path)
    try:
        if not stat.S_ISREG(path.stat().st_mode) and not path.is_dir():
            raise InputError(file, "", None, "a file, and no pipe or device")
        with path.open("rb") as stream:
            yield stream
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise InputError(file, "", None, f"a readable file ({why})") from error


def _decoded(file: str, data: bytes) -> str:
    other = wide_encoding(data)
    if other:
        raise InputError(file, "", None, _converted(other, other))
    data = data.removeprefix(codecs.BOM_UTF8)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        found = japanese_encoding(data)
        if found is None:
            where = f"byte 0x{data[error.start]:02x} in line {line} is none"
            raise InputError(file, "", None, f"text in UTF-8 ({where})") from error
        raise InputError(file, "", None, _converted(*found)) from error


def _converted(name: str, codec: str) -> str:
    return f"text in UTF-8, but it is in {name}; convert it: iconv -f {codec} -t UTF-8 OLD > NEW"


def wide_encoding(data: bytes) -> str:
    """The wide encoding of a text, by its mark or by the zeros between its letters; empty if it has none."""
    for mark, name in _MARKS:
        if data.startswith(mark):
            return name
    for byte, name in ((1, "UTF-16LE"), (0, "UTF-16BE")):
        if data[byte::2].count(0) > len(data) // 4 > 0 and data[1 - byte :: 2].count(0) == 0:
            return name
    return ""


def japanese_encoding(data: bytes) -> tuple[str, str] | None:
    """The Japanese encoding of a text that is no UTF-8, and what iconv calls it; None for any other."""
    shown = data.decode("utf-8", errors="replace")
    beyond = shown.count(_SHOWN_BEYOND)
    if sum(not c.isascii() for c in shown) - beyond > beyond:
        return None
    scores: list[tuple[int, tuple[str, str]]] = []
    for name, codec, word in _JAPANESE:
        try:
            text = data.decode(codec)
        except UnicodeDecodeError:
            continue
        # What is read in the wrong one of the two shows half-width katakana, which nobody writes.
        full = sum("\u3040" <= c <= "\u30ff" or "\u4e00" <= c <= "\u9fff" for c in text)
        half = sum("\uff61" <= c <= "\uff9f" for c in text)
        scores.append((full - 4 * half, (name, word)))
    score, found = max(scores, default=(0, None))
    return found if score > 0 else None


def check_nesting(file: str, data: object, form: str) -> None:
    """Tables and lists in one another no deeper than NESTING_MAX; looks without recursion. Raises InputError."""
    waiting: list[tuple[object, int, str]] = [(data, 0, "")]
    while waiting:
        node, depth, key = waiting.pop()
        if depth > NESTING_MAX:
            raise too_deep(file, key, form)
        if is_table(node):
            waiting += [(value, depth + 1, key or str(name)) for name, value in node.items()]
        elif is_list(node):
            waiting += [(value, depth + 1, key) for value in node]


def too_deep(file: str, key: str, form: str) -> InputError:
    """The error of a file whose tables and lists lie too deep in one another."""
    return InputError(file, key, None, f"{form} with at most {NESTING_MAX} levels of tables and lists")
