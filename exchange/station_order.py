"""The stations of a timetable in one order, where the source gives them train by train only."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise


def ordered_stations(runs: Iterable[tuple[Sequence[str], bool]]) -> tuple[str, ...]:
    """Stations in the order in which down trains come to them.

    `runs` are the stations of each train in order of travel, none twice, with whether the source calls it down. The
    longest run is the backbone; a train counts as down where it goes along what is known, whatever the source calls it.
    Stations between two known ones come before the second, those of a branch at the end.
    """
    known: list[str] = []
    ordered = sorted(dict.fromkeys((tuple(run), down) for run, down in runs), key=lambda run: -len(run[0]))
    for run, down in ordered:
        steps = _steps(run, {station: i for i, station in enumerate(known)})
        with_order = steps > 0 or (steps == 0 and down)
        _insert(known, run if with_order else run[::-1])
    return tuple(known)


def runs_down(run: Sequence[str], order: Mapping[str, int], says_down: bool) -> bool:
    """Whether a train goes along an order of stations, given as their places in it."""
    steps = _steps(run, order)
    return steps > 0 or (steps == 0 and says_down)


def _steps(run: Sequence[str], order: Mapping[str, int]) -> int:
    """How many more steps of a run go along the order than against it."""
    places = [order[station] for station in run if station in order]
    return sum(1 if after > before else -1 for before, after in pairwise(places))


def _insert(known: list[str], run: Sequence[str]) -> None:
    """Put the stations of a run that are new before the next known one, or at the end."""
    places = set(known)
    new: list[str] = []
    for station in run:
        if station not in places:
            new.append(station)
            continue
        at = known.index(station)
        known[at:at] = new
        new = []
    known += new
