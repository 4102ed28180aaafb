"""Files of others that hide a top-level package: a `network.py` beside a notebook is imported in place of `network`."""

from __future__ import annotations

import sys
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from pathlib import Path
from typing import Final

PACKAGES: Final = (
    "network", "exchange", "sumo_cfg", "vehicle", "radio", "onboard", "wayside", "host", "simulation", "scenario",
    "study", "plan", "papers", "verify", "console",
)  # fmt: skip
HOME: Final = Path(__file__).resolve().parent.parent


def hidden_package() -> str | None:
    """Which file hides which package, and what to do; None if all are those beside `branchline`."""
    for name in PACKAGES:
        found = _place(_spec(name))
        if found is not None and found != HOME / name / "__init__.py":
            mend = "rename it, or start Python where it is not on the path"
            return f"{found} hides the package {name!r} of branchline: {mend}"
    return None


def _spec(name: str) -> ModuleSpec | None:
    """What an import of that name gives, or has given."""
    there = sys.modules.get(name)
    return find_spec(name) if there is None else there.__spec__


def _place(spec: ModuleSpec | None) -> Path | None:
    if spec is None:
        return None
    if spec.origin is not None:
        return Path(spec.origin).resolve()
    return Path(next(iter(spec.submodule_search_locations or ()), "")).resolve()
