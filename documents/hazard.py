"""A hazard as data: cause, what prevents it and where, who watches, what shows it."""

from __future__ import annotations

from dataclasses import dataclass

from simulation.judge.checkers import Checker


@dataclass(frozen=True, slots=True)
class Hazard:
    """One hazard. `drills` are shipped ones, `defects` names in tests/system/test_defects.py."""

    hazard: str
    cause: str
    prevention: str
    modules: tuple[str, ...]
    watched_by: tuple[Checker, ...]
    drills: tuple[str, ...] = ()
    defects: tuple[str, ...] = ()
