"""The one way this project compiles a law: numba, deterministic, cached on disk without going stale.

numba keeps the machine code of a function beside its file and asks only whether *that* file changed; a
compiled caller in another file would keep the old code of what it calls. The cache therefore lies in a folder
named by a digest of every source file that holds compiled code. Fastmath stays off: same input, same bits.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from hashlib import blake2b
from pathlib import Path
from typing import Any, Final, ParamSpec, TypeVar, cast

import numpy as np
from numba import njit
from numba.core import config

PACKAGES: Final = ("vehicle", "onboard", "simulation", "study")  # below them too
MARKS: Final = (b"@compiled", b"dtype_of")  # the second takes in the records and their sizes
INTERPRETED: Final = bool(config.__dict__["DISABLE_JIT"])

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


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` at its first call; division by zero gives inf or nan instead of raising.

    With NUMBA_DISABLE_JIT=1 it runs as it is written, for coverage and for looking into; much slower.
    """
    if INTERPRETED:
        return _interpreted(function)
    return cast("Callable[P, R]", njit(cache=True, error_model="numpy")(function))


def _interpreted(function: Callable[P, R]) -> Callable[P, R]:
    """Compiled code reads `row.speed_mps`; numpy does so for records alone."""

    @wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> R:
        with np.errstate(divide="ignore", invalid="ignore"):
            return function(*(_with_names(arg) for arg in args), **kwargs)  # type: ignore[arg-type]

    return run


def _with_names(value: object) -> object:
    """The same memory, its fields as attributes; rows in a named tuple too."""
    if type(value) is np.void and value.dtype.names is not None:
        return value.view((np.record, value.dtype))
    if type(value) is np.ndarray and value.dtype.names is not None:
        return value.view(np.recarray)
    if isinstance(value, tuple):
        parts = cast("tuple[object, ...]", value)
        made: Any = type(parts)  # a named tuple takes its parts one by one
        return made(*(_with_names(part) for part in parts)) if hasattr(parts, "_fields") else parts
    return value


def compiled_lines(lines: Sequence[str], names: Mapping[str, Callable[..., Any]], module: str) -> Any:  # noqa: ANN401
    """Compile a function written by a table of functions: compiled code cannot choose between them by value.

    `lines` define one function, `names` are the table's functions that it calls, `module` is the table's own.
    """
    written: dict[str, Any] = {"__name__": module, **names}  # numba keeps what it compiled under that name
    exec(compile("\n".join(lines), str(sys.modules[module].__file__), "exec"), written)
    return compiled(written[lines[0].split()[1].partition("(")[0]])


_place_cache()
