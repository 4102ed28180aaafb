"""Numbers of trains that may stand in our files: published ones, in Latin letters and digits, each once a day."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from typing import Final

from network.files.names import IDENTIFIER_LENGTH_MAX, is_identifier

# Japanese that stands in numbers: empty (回), on trial (試), engines alone (単), extra (臨), delivery (配).
_LETTERS: Final = str.maketrans(
    {"回": "E", "試": "T", "単": "L", "臨": "X", "配": "H", "レ": None, "列": None}
)
_OTHERS: Final = re.compile(r"[^A-Za-z0-9._-]+")
_SUFFIX_MAX: Final = 4


def numbers_of(published: Iterable[tuple[str, bool]]) -> tuple[str, ...]:
    """A number for each train of a day, from the published one (or none) and whether it runs down, in order.

    A train without one is D001, D002, ... or U001, ...; of trains with the same one the second is ...-2.
    """
    found: list[str] = []
    numbers: set[str] = set()
    counts = {True: 0, False: 0}
    pairs = list(published)
    plain = [_plain(text) for text, _ in pairs]
    kept = set(plain)
    for number, (_, down) in zip(plain, pairs, strict=True):
        name = number
        while not name or (not number and name in kept):
            counts[down] += 1
            name = f"{'D' if down else 'U'}{counts[down]:03d}"
        again = 1
        while name in numbers:
            again += 1
            name = f"{number}-{again}"
        numbers.add(name)
        found.append(name)
    return tuple(found)


def _plain(text: str) -> str:
    """What is left of a number; nothing where that is no identifier."""
    latin = unicodedata.normalize("NFKC", text).translate(_LETTERS)
    number = _OTHERS.sub("-", latin).strip("._-")[: IDENTIFIER_LENGTH_MAX - _SUFFIX_MAX].rstrip(".")
    return number if is_identifier(number) else ""
