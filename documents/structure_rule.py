"""A rule of the structure as it was found, and the packages that rules are about."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

PRODUCT: Final = (
    "network",
    "exchange",
    "sumo_cfg",
    "vehicle",
    "radio",
    "onboard",
    "wayside",
    "host",
    "simulation",
    "scenario",
    "study",
    "papers",
    "documents",
    "branchline",
)
TESTS: Final = "tests"


@dataclass(frozen=True, slots=True)
class StructureRule:
    """One rule as found: `broken` names what breaks it, and says what to do instead."""

    text: str
    found: str
    broken: tuple[str, ...]
