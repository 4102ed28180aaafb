"""A rule of the structure as it was found, and the packages that rules are about."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Final

_PROJECT: Final = Path(__file__).resolve().parent.parent / "pyproject.toml"
PRODUCT: Final[tuple[str, ...]] = tuple(
    tomllib.loads(_PROJECT.read_text("utf-8"))["tool"]["importlinter"]["root_packages"]
)
TESTS: Final = "tests"


@dataclass(frozen=True, slots=True)
class StructureRule:
    """One rule as found: `broken` names what breaks it, and says what to do instead."""

    text: str
    found: str
    broken: tuple[str, ...]
