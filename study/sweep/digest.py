"""What a day is made of, and by what code, each in one number: days of two sweeps are the same day if these are."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import fields, is_dataclass, replace
from enum import Enum
from functools import cache
from hashlib import blake2b
from importlib.resources import files
from pathlib import Path
from typing import Final

import numpy as np
from pydantic import BaseModel

from network.files.raw import is_list, is_row
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
    "study/scenario",
    "study/measures",
    "study/run",
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
def code_digest() -> str:
    """Digest of the code that decides how a day goes."""
    root = Path(str(files("study"))).parent
    found = blake2b(digest_size=HASH_BYTES)
    for name in CODE:
        place = root / name
        for path in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            if path.is_file():
                found.update(f"{path.relative_to(root).as_posix()}\0".encode())
                found.update(path.read_bytes())
    return found.hexdigest()


def _parts(value: object) -> Iterator[bytes]:
    """The bytes of a value with its type before it; a type that is not known is a bug."""
    yield f"<{type(value).__name__}".encode()
    if isinstance(value, np.ndarray | np.void):
        yield f"{value.dtype}{value.shape}".encode()
        yield value.tobytes()
    elif isinstance(value, np.generic):
        yield value.tobytes()
    elif isinstance(value, Enum):
        yield value.name.encode()
    elif value is None or isinstance(value, str | int | float | bytes | Path):
        yield repr(value).encode()
    elif isinstance(value, Mapping):
        for key, item in value.items():
            yield from _parts(key)
            yield from _parts(item)
    elif is_dataclass(value) and not isinstance(value, type):
        for field in fields(value):
            yield field.name.encode()
            yield from _parts(getattr(value, field.name))
    elif isinstance(value, BaseModel):
        for name in type(value).model_fields:
            yield name.encode()
            yield from _parts(getattr(value, name))
    elif isinstance(value, AbstractSet):
        yield from sorted(b"".join(_parts(item)) for item in value)
    elif is_row(value) or is_list(value) or isinstance(value, tuple):
        for item in value:
            yield from _parts(item)
    else:
        raise TypeError(f"{type(value)} has no digest")
    yield b">"
