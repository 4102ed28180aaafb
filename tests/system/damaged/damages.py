"""What can go wrong with a file: each is a function of chance and a bundle that gives the files as they then are.

Plain `random` with the number of the case as its seed, and not hypothesis: a case is found again by its number, in the
slice of every change as in the two thousand of the night.
"""

import codecs
import random
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from typing import Any, Final

from network.files.names import IDENTIFIER_LENGTH_MAX
from tests.system.damaged.bundles import WEIGHTS, Bundle, text_of
from tests.system.damaged.places import Path, Place, leaves, places_of, value_at, with_value

IDS: Final = (
    "../..",
    "..",
    "/etc",
    "a/b",
    "a\\b",
    "a\x00b",
    "",
    ".",
    "con",
    "x" * (IDENTIFIER_LENGTH_MAX + 1),
    "烏山",
    "a b",
    "-a",
    "a\n",
)
ID_KEYS: Final = frozenset({"id", "number", "stock", "terminal", "n", "original_name", "name"})
VALUES: Final[tuple[Any, ...]] = (
    float("nan"), float("inf"), float("-inf"), 1e308, -1e308, 5e-324, 1e-9, -1e-9, -0.0, 0, -1, 10**18, 2**64, 10**400,
    True, False, "", "x", "1", "nan", "x" * 100_000, "\x00", "\x1b[2J", "ü", [], {}, [[]], [1, "a"], {"a": {"b": 1}},
    datetime(2024, 2, 29, 12, 0, tzinfo=UTC), "\ud7ff", "../../etc/passwd", "/dev/zero", "x" * 300 + ".toml",
)  # fmt: skip
NOWHERE: Final = (
    "nowhere",
    "A9",
    "K9",
    "portal:nowhere",
    "from:nowhere",
    "train T9 departs Z",
    "25:99",
    "X <-> Y",
    "none.toml",
)


@dataclass(frozen=True, slots=True)
class Case:
    """Files as bytes; None is a folder, "" a pipe. `place`: the figure that was moved, and whether it is `inside`."""

    number: int
    bundle: Bundle
    file: str
    what: str
    files: dict[str, bytes | str | None]
    place: Place | None = None
    inside: bool = False


Damage = Callable[[random.Random, Bundle, str], tuple[object, str] | None]


def case_of(number: int) -> Case:
    """The case of that number; the same whenever it is asked for."""
    chance = random.Random(f"damaged {number}")
    while True:
        bundle, file, _ = chance.choices(WEIGHTS, [weight for *_, weight in WEIGHTS])[0]
        if chance.random() < RANGE_SHARE and file in bundle.models:
            return _at_range(chance, number, bundle, file)
        damage = chance.choice(DAMAGES)
        found = damage(chance, bundle, file)
        if found is not None:
            content, what = found
            return Case(number, bundle, file, what, {**dict(_whole_files(bundle.name)), file: content})  # type: ignore[dict-item]


RANGE_SHARE: Final = 0.3


def _at_range(chance: random.Random, number: int, bundle: Bundle, file: str) -> Case:
    """A figure at the end of its range: just inside or just outside."""
    places = _places(bundle.name, file)
    # By kind first, so that those with few keys come as often.
    name = chance.choice(sorted({place.quantity.name for place in places}))
    place = chance.choice([place for place in places if place.quantity.name == name])
    within, beyond = place.edges()
    inside = chance.random() < 0.5 or not beyond
    value = chance.choice(within if inside else beyond)
    data = with_value(bundle.files[file], place.path, value)
    what = f"{place.key} {'just inside' if inside else 'just outside'}: {value!r}"
    files: dict[str, bytes | str | None] = {
        **dict(_whole_files(bundle.name)),
        file: text_of(file, data).encode(),
    }
    return Case(number, bundle, file, what, files, place, inside)


@cache
def _places(name: str, file: str) -> tuple[Place, ...]:
    bundle = next(bundle for bundle, *_ in WEIGHTS if bundle.name == name)
    return tuple(places_of(bundle.models[file], bundle.files[file]))  # type: ignore[type-var]


@cache
def _whole_files(name: str) -> tuple[tuple[str, bytes], ...]:
    bundle = next(bundle for bundle, *_ in WEIGHTS if bundle.name == name)
    return tuple(bundle.written().items())


def _encoded(file: str, data: object) -> bytes:
    return text_of(file, data).encode("utf-8", errors="surrogatepass")


def _value(chance: random.Random, bundle: Bundle, file: str) -> tuple[object, str] | None:
    data = bundle.files[file]
    path = chance.choice(list(leaves(data)))
    value = chance.choice(VALUES)
    if file.endswith(".json") and isinstance(value, datetime):
        return None
    return _encoded(file, with_value(data, path, value)), f"{path} = {value!r:.60}"


def _scaled(chance: random.Random, bundle: Bundle, file: str) -> tuple[object, str] | None:
    data = bundle.files[file]
    numbers = [p for p in leaves(data) if type(value_at(data, p)) in (int, float)]
    if not numbers:
        return None
    path = chance.choice(numbers)
    factor = chance.choice((-1, 1e-6, 0.01, 0.5, 2, 10, 1000, 1e9))
    value = value_at(data, path) * factor
    return _encoded(file, with_value(data, path, value)), f"{path} times {factor}"


def _id(chance: random.Random, bundle: Bundle, file: str) -> tuple[object, str] | None:
    data = bundle.files[file]
    paths = [p for p in leaves(data) if p[-1] in ID_KEYS and isinstance(value_at(data, p), str)]
    if not paths:
        return None
    path, value = chance.choice(paths), chance.choice(IDS)
    return _encoded(file, with_value(data, path, value)), f"{path} = {value!r:.60}"


def _reference(chance: random.Random, bundle: Bundle, file: str) -> tuple[object, str] | None:
    data = bundle.files[file]
    texts = [p for p in leaves(data) if isinstance(value_at(data, p), str)]
    path, value = chance.choice(texts), chance.choice(NOWHERE)
    return _encoded(file, with_value(data, path, value)), f"{path} = {value!r}"


def _key(chance: random.Random, bundle: Bundle, file: str) -> tuple[object, str] | None:
    data = bundle.files[file]
    path = chance.choice(list(_keys(data)))
    copy = with_value(data, path, value_at(data, path))
    table = value_at(copy, path[:-1])
    key = str(path[-1])
    kept = table.pop(path[-1])
    how = chance.choice(("dropped", "misspelt", "a line of its own", "doubled"))
    if how == "misspelt":
        place = chance.randrange(len(key) + 1)
        table[key[:place] + chance.choice("aeiounrst_") + key[place + 1 :]] = kept
    elif how == "a line of its own":
        table[f"{key}\n\x07"] = kept
    elif how == "doubled":
        text = text_of(file, data)
        return (text + text).encode(), "every key doubled"
    return _encoded(file, copy), f"{path} {how}"


def _keys(data: object, path: Path = ()) -> list[Path]:
    if isinstance(data, dict):
        return [p for key, inner in data.items() for p in ((*path, key), *_keys(inner, (*path, key)))]
    if isinstance(data, list):
        return [p for i, inner in enumerate(data) for p in _keys(inner, (*path, i))]
    return []


def _list(chance: random.Random, bundle: Bundle, file: str) -> tuple[object, str] | None:
    data = bundle.files[file]
    lists = [p for p in _keys(data) if isinstance(value_at(data, p), list) and value_at(data, p)]
    if not lists:
        return None
    path = chance.choice(lists)
    old = list(value_at(data, path))
    how = chance.choice(("emptied", "shuffled", "one twice", "thousands", "one missing"))
    new = {
        "emptied": [],
        "shuffled": chance.sample(old, len(old)),
        "one twice": [*old, chance.choice(old)],
        "thousands": old * (6000 // len(old)),
        "one missing": old[1:],
    }[how]
    return _encoded(file, with_value(data, path, new)), f"{path} {how}"


def _deep(chance: random.Random, bundle: Bundle, file: str) -> tuple[object, str] | None:
    data = bundle.files[file]
    path = chance.choice(list(leaves(data)))
    depth = chance.choice((3, 20, 400, 5000))
    opening, closing = chance.choice(
        (("[", "]"), ('{"a": ', "}") if file.endswith(".json") else ("{ a = ", " }"))
    )
    text = text_of(file, with_value(data, path, "HERE")).replace(
        '"HERE"', opening * depth + "1" + closing * depth
    )
    return text.encode(), f"{path} {depth} deep"


def _bytes(chance: random.Random, bundle: Bundle, file: str) -> tuple[object, str] | None:
    data = bytearray(_encoded(file, bundle.files[file]))
    how = chance.choice(("flipped", "cut", "dropped", "zero", "noise", "repeated"))
    at = chance.randrange(len(data))
    if how == "flipped":
        for _ in range(chance.choice((1, 1, 3, 30))):
            data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    elif how == "cut":
        del data[at:]
    elif how == "dropped":
        del data[at : at + chance.choice((1, 5, 200))]
    elif how == "zero":
        data[at:at] = b"\0" * chance.choice((1, 100))
    elif how == "noise":
        data[at:at] = chance.randbytes(20)
    else:
        data[at:at] = data[at : at + 300]
    return bytes(data), f"bytes {how} at {at}"


def _encoding(chance: random.Random, bundle: Bundle, file: str) -> tuple[object, str] | None:
    text = text_of(file, bundle.files[file])
    name = chance.choice(
        ("utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "cp932", "euc_jp", "latin-1", "twice")
    )
    if name == "twice":
        return codecs.BOM_UTF8 * 2 + text.encode(), "two marks"
    return text.encode(name, errors="replace"), f"in {name}"


def _whole(chance: random.Random, bundle: Bundle, file: str) -> tuple[object, str] | None:
    found: dict[str, object] = {
        "empty": b"",
        "blank": b" \n\t\n",
        "a folder": None,
        "a pipe": "",
        "a link to itself": "loop",
        "zeros without end": "/dev/zero",
        "cannot be read": "unreadable",
        "missing": "missing",
        "large": b"#" + b" " * (3 << 20) if not file.endswith(".json") else b"[" + b" " * (17 << 20) + b"]",
        "another kind": chance.choice([c for n, c in _whole_files(bundle.name) if n != file] or [b"{}"]),
        "a list": b"[]",
        "null": b"null",
        "a number": b"7",
    }
    what = chance.choice(list(found))
    return found[what], what


DAMAGES: Final[tuple[Damage, ...]] = (
    *(_value,) * 4,
    *(_scaled,) * 2,
    *(_id,) * 2,
    _reference,
    *(_key,) * 2,
    _list,
    _deep,
    *(_bytes,) * 2,
    _encoding,
    _whole,
)
