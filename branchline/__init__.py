"""branchline from Python: ten verbs, each imported when it is first used.

    import branchline
    run = branchline.run(branchline.load("karasuyama_weekday", seed=3))
    run.tables.stops, run.picture("train-graph")

Input that cannot be used raises `InputError`: file, key, value and what was expected, as the command line prints it.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Final

from branchline.hidden import hidden_package

if TYPE_CHECKING:
    from branchline.verbs import (
        capacity,
        check,
        compare,
        headway,
        line,
        load,
        open,  # noqa: A004
        reproduce,
        run,
        sweep,
    )
    from network.errors import InputError
    from study.outcome import CutShortError

__all__ = [
    "CutShortError",
    "InputError",
    "capacity",
    "check",
    "compare",
    "headway",
    "line",
    "load",
    "open",
    "reproduce",
    "run",
    "sweep",
]
_ERRORS: Final = {"CutShortError": "study.outcome", "InputError": "network.errors"}


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if (hidden := hidden_package()) is not None:
        raise ImportError(hidden)
    found: object = getattr(import_module(_ERRORS.get(name, "branchline.verbs")), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return __all__
