"""The one way this project compiles a law: numba, deterministic, kept on disk without going stale.

Every function that Python calls becomes machine code of its own, with all that it calls inside it (`vehicle.linking`).
What is kept is found again by what it depends on (`vehicle.code_key`), wherever it was compiled (`network.code_store`).
Fastmath stays off: same input, same bits.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial, wraps
from pathlib import Path
from types import FunctionType
from typing import Any, Final, ParamSpec, TypeVar, cast

import numpy as np

from network.code_store import CodeStore, kept_folder
from vehicle.uncompiled import LATE, Uncompiled

INTERPRETED: Final = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")
SHIPPED: Final = Path(__file__).parent / "machine_code"  # compiled for any processor; a wheel has it
STORE: Final = CodeStore(kept_folder() / SHIPPED.name, [SHIPPED])
OPTIONS: Final = {"nopython": True, "error_model": "numpy"}

P = ParamSpec("P")
R = TypeVar("R")


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` at its first call; division by zero gives inf or nan instead of raising.

    With NUMBA_DISABLE_JIT=1 it runs as it is written, for coverage and for looking into; much slower.
    """
    if INTERPRETED:
        return _interpreted(function)
    return cast(
        "Callable[P, R]", Uncompiled(cast("FunctionType", function), partial(_made, STORE, late=False))
    )


def compiled_when_called(function: Callable[P, R]) -> Callable[P, R]:
    """As `compiled`, for what few runs use: compiled code that calls it does not contain it, and it waits for a call.

    It returns a float, an int or nothing, and says so. A call costs some nanoseconds more.
    """
    if INTERPRETED:
        return _interpreted(function)
    uncompiled = Uncompiled(cast("FunctionType", function), partial(_made, STORE, late=True))
    LATE[f"{uncompiled.py_func.__module__}.{uncompiled.py_func.__qualname__}"] = uncompiled
    return cast("Callable[P, R]", uncompiled)


def _made(store: CodeStore, function: FunctionType, *, late: bool) -> object:
    """The function as the compiler calls it; numba is loaded by the first."""
    from vehicle.entries import Entry, LateEntry

    return (LateEntry if late else Entry)(function, OPTIONS, store)


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
