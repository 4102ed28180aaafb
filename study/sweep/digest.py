"""What a day is made of, and by what code, each in one number: days of two sweeps are the same day if these are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import fields, is_dataclass, replace
from enum import Enum
from functools import cache
from hashlib import blake2b
from importlib.resources import files
from itertools import chain
from pathlib import Path
from typing import Final, cast

import numpy as np
from pydantic import BaseModel

from network.raw import is_row
from simulation.setup import Setup
from study.sweep.records import HASH_BYTES

# What decides how a day goes; pages, pictures and the command line do not.
CODE: Final = (
    "network",
    "sumo_cfg",
    "vehicle",
    "radio",
    "onboard",
    "wayside",
    "host",
    "simulation",
    "scenario",
    "study/outcome.py",
    "study/feasibility",
    "study/measures",
    "study/record",
    "study/collect",
    "study/runner",
    "study/sweep/day.py",
    "study/sweep/point.py",
)


def inputs_digest(setup: Setup) -> str:
    """Digest of all that a run is made of, its name and seed apart."""
    plain = replace(setup, name="", seed=0)
    found = blake2b(digest_size=HASH_BYTES)
    for part in _parts(plain):
        found.update(part)
    return found.hexdigest()


@cache
def code_digest(*beside: str) -> str:
    """Digest of the code that decides how a day goes, and of what else decides a result."""
    return digest_of(*CODE, *beside)


def digest_of(*places: str) -> str:
    """Digest of the code in some packages and files, by their paths in the project."""
    root = Path(str(files("study"))).parent
    found = blake2b(digest_size=HASH_BYTES)
    for name in places:
        place = root / name
        for path in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            if path.is_file():
                found.update(f"{path.relative_to(root).as_posix()}\0".encode())
                found.update(path.read_bytes())
    return found.hexdigest()


def _parts(value: object) -> Iterator[bytes]:
    """The bytes of a value with its type before it; a type that is not known is a bug."""
    yield f"<{type(value).__name__}".encode()
    if isinstance(value, AbstractSet):
        some = cast("AbstractSet[object]", value)
        yield from sorted(b"".join(_parts(item)) for item in some)
    elif (children := _children(value)) is not None:
        for child in children:
            yield from _parts(child)
    else:
        yield _plain(value)
    yield b">"


def _children(value: object) -> Iterable[object] | None:
    """What a value is made of, in its own order; None for one that is whole."""
    if isinstance(value, Mapping):
        return chain.from_iterable(cast("Mapping[object, object]", value).items())
    if is_dataclass(value) and not isinstance(value, type):
        return [part for field in fields(value) for part in (field.name, getattr(value, field.name))]
    if isinstance(value, BaseModel):
        return [part for name in type(value).model_fields for part in (name, getattr(value, name))]
    return value if is_row(value) else None


def _plain(value: object) -> bytes:
    if isinstance(value, np.ndarray | np.void):
        return f"{value.dtype}{value.shape}".encode() + value.tobytes()
    if isinstance(value, np.generic):
        return value.tobytes()
    if isinstance(value, Enum):
        return value.name.encode()
    if isinstance(value, type):  # of an event that is waited for
        return value.__qualname__.encode()
    if value is None or isinstance(value, str | int | float | bytes | Path):
        return repr(value).encode()
    raise TypeError(f"{type(value)} has no digest")
