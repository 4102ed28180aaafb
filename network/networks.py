"""Two radio networks of one line: where any of them reaches, and the line as one of them alone reaches it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

from network.model import Coverage, Line


def reached(stretches: Sequence[Coverage]) -> tuple[Coverage, ...]:
    """Stretches that may overlap, as sorted ones that do not; those that only touch stay apart."""
    found: list[Coverage] = []
    for stretch in sorted(stretches, key=lambda one: (one.from_m, one.to_m)):
        if found and stretch.from_m < found[-1].to_m:
            found[-1] = Coverage(found[-1].from_m, max(found[-1].to_m, stretch.to_m))
        else:
            found.append(stretch)
    return tuple(found)


def has_second(line: Line) -> bool:
    """Whether a line says where a second network reaches."""
    return any(alignment.of_networks for alignment in line.alignments.values())


def with_first_alone(line: Line) -> Line:
    """The line for trains that have a radio of its first network alone."""
    return _with_first_alone(line) if has_second(line) else line


@lru_cache(maxsize=16)
def _with_first_alone(line: Line) -> Line:
    alone = {
        name: replace(a, coverage=a.of_networks[0] if a.of_networks else a.coverage, of_networks=())
        for name, a in line.alignments.items()
    }
    return replace(line, alignments=alone)
