"""Figures of one run in a process of its own, which do not depend on what ran before it, and what they may be."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
from collections.abc import Callable, Mapping
from typing import Any

Figures = dict[str, list[dict[str, Any]]]  # of each way, round by round


def figures_afresh(module: str, called: str, *words: str) -> dict[str, Any]:
    """The JSON object that `python -m module words` prints. RuntimeError, `called` so, where it fails."""
    command = [sys.executable, "-m", module, *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{called} failed: {done.stderr.strip()[-500:]}")
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def in_rounds(
    module: str, ways: Mapping[str, str], rounds: int, tell: Callable[[str], None], scenario: str, *words: str
) -> Figures:
    """What `module WAY SCENARIO words` finds for all ways in turn, round after round; `tell` gets which is next."""
    figures: Figures = {way: [] for way in ways}
    for number in range(rounds):
        for way, called in ways.items():
            tell(f"{scenario}, round {number + 1} of {rounds}: {called}")
            figures[way].append(figures_afresh(module, called, way, scenario, *words))
    return figures


def walls_of(figures: Figures, way: str, ratio: str) -> dict[str, Any]:
    """A row each, by the key `way`, of wall times in s and, by the key `ratio`, how many times that of the first the
    median is; and whether every way ended each round alike.
    """
    median = {name: statistics.median(f["wall_s"] for f in found) for name, found in figures.items()}
    rows = [
        {
            way: name,
            "wall_s": round(median[name], 3),
            "wall_s_min": round(min(f["wall_s"] for f in found), 3),
            "wall_s_max": round(max(f["wall_s"] for f in found), 3),
            ratio: round(median[name] / next(iter(median.values())), 3),
        }
        for name, found in figures.items()
    ]
    same = all(len({f["digest"] for f in found}) == 1 for found in figures.values())
    return {"rows": rows, "same_digest": same}


def budget_of(what: str, limit: float, found: float | None) -> dict[str, Any]:
    """A budget, with whether it is kept; None: nothing was there to be measured, which is not."""
    return {"what": what, "limit": limit, "found": found, "kept": found is not None and found <= limit}
