"""What `branchline bench` measures, part by part: a module each with `bench(scenario, rounds, tell)`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, Final

from network.errors import InputError
from network.files.toml_input import one_of

Part = Callable[[str, int, Callable[[str], None]], dict[str, Any]]

PARTS: Final[Mapping[str, str]] = {
    "links": "study.evaluate.bench",
    "laws": "study.evaluate.laws",
    "collation": "study.evaluate.collation",
    "sweep": "study.evaluate.sweep_bench",
    "certificate": "study.evaluate.certificate",
    "crossings": "study.evaluate.crossings_bench",
    "road": "study.evaluate.road_queueing",
    "start": "study.evaluate.start_bench",
    "serve": "console.serve_bench",
}
ROUNDS: Final = 5
ROUNDS_OF: Final[Mapping[str, int]] = {"crossings": 3, "road": 3}  # five minutes, and half a minute
DEFAULT: Final = "links"  # of minutes; the others are asked for by name


def part_of(name: str) -> Part:
    """The function that measures a part: rows, and budgets with whether they are kept. InputError for another name."""
    if name not in PARTS:
        raise InputError("command line", "--part", name, one_of(PARTS, name))
    function: Part = import_module(PARTS[name]).bench
    return function
