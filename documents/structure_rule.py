"""A rule of the structure as it was found, and the packages that rules are about."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Final

_PROJECT: Final = Path(__file__).resolve().parent.parent / "pyproject.toml"
_LINTER: Final = tomllib.loads(_PROJECT.read_text("utf-8"))["tool"]["importlinter"]
PRODUCT: Final[tuple[str, ...]] = tuple(_LINTER["root_packages"])
# Who may import whom, from the top down; those beside each other have a bar between them.
LAYERS: Final[tuple[str, ...]] = tuple(
    next(one["layers"] for one in _LINTER["contracts"] if "simulation" in one.get("layers", ()))
)
TESTS: Final = "tests"


@dataclass(frozen=True, slots=True)
class StructureRule:
    """One rule as found: `broken` names what breaks it, and says what to do instead."""

    text: str
    found: str
    broken: tuple[str, ...]
