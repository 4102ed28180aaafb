"""The one way this project compiles a law: numba, deterministic, cached on disk without going stale.

numba keeps the machine code of a function beside its file and asks only whether *that* file changed; a
compiled caller in another file would keep the old code of what it calls. The cache therefore lies in a folder
named by a digest of every source file that holds compiled code. Fastmath stays off: same input, same bits.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from hashlib import blake2b
from pathlib import Path
from typing import Final, ParamSpec, TypeVar, cast

import numpy as np
from numba import njit
from numba.core import config
from numpy.typing import NDArray

PACKAGES: Final = ("vehicle", "onboard", "simulation", "study")  # below them too
MARKS: Final = (b"@compiled", b"dtype_of")  # the second takes in the records and their sizes

P = ParamSpec("P")
R = TypeVar("R")


def sources_digest(root: Path, packages: tuple[str, ...] = PACKAGES) -> str:
    """Digest (16 hex digits) of the files below `root`'s `packages` that hold compiled code."""
    digest = blake2b(digest_size=8)
    for package in packages:
        for file in sorted((root / package).rglob("*.py")):
            text = file.read_bytes()
            if any(mark in text for mark in MARKS):
                digest.update(file.relative_to(root).as_posix().encode() + b"\0" + text)
    return digest.hexdigest()


def _place_cache() -> None:
    """Point numba's cache at the folder of this version of the sources, inside the user's own if set."""
    root = Path(__file__).resolve().parent.parent
    settings = config.__dict__  # numba fills this module at run time, so type checkers do not know its names
    base = Path(settings["CACHE_DIR"] or Path(__file__).parent / "__pycache__")
    settings["CACHE_DIR"] = str(base / f"numba-{sources_digest(root)}")


class _Record:
    """A record as compiled code sees it: fields as attributes, of the very memory."""

    __slots__ = ("_void",)
    _void: np.void

    def __init__(self, void: np.void) -> None:
        object.__setattr__(self, "_void", void)

    def __getattr__(self, name: str) -> object:
        return _seen(self._void[name])

    def __setattr__(self, name: str, value: float) -> None:
        self._void[name] = value


def _seen(value: object) -> object:
    """An argument with its fields as attributes, if it has any."""
    if type(value) is np.void:
        return _Record(value)
    if isinstance(value, np.ndarray):
        array = cast("NDArray[np.void]", value)
        return array if array.dtype.names is None else array.view(np.recarray)
    return value


def interpreted(function: Callable[P, R]) -> Callable[P, R]:
    """`function` as Python runs it, on the records that compiled code takes."""

    @wraps(function)
    def run(*args: P.args, **keywords: P.kwargs) -> R:
        with np.errstate(all="ignore"):
            return function(*map(_seen, args), **keywords)  # type: ignore[arg-type]

    return run


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` at its first call; division by zero gives inf or nan instead of raising.

    With NUMBA_DISABLE_JIT=1 it is interpreted, on the same records: slow, for coverage and for stepping through.
    """
    if config.__dict__["DISABLE_JIT"]:
        return interpreted(function)
    return cast("Callable[P, R]", njit(cache=True, error_model="numpy")(function))


_place_cache()
