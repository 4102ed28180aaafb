"""All states that can be come to, breadth first, level by level."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from verify.tables import Numbers

Keys = NDArray[np.uint64]
_INDEX_BITS: Final = np.uint64(32)
_INDEX: Final = np.uint64((1 << 32) - 1)
TOLD_EVERY: Final = 10  # levels, to people
AT_ONCE: Final = 200_000  # states expanded at once: what a table of successors of them takes


class Explorable(Protocol):
    """What can be searched: states are numbers of 64 bits."""

    def start(self) -> Keys:
        """The one state in which all begins."""
        ...

    def following(self, keys: Keys) -> tuple[Numbers, Keys, Numbers]:
        """Successors: from which of the states (by index), what, and with what trouble, 0 for none."""
        ...

    def finished(self, keys: Keys) -> NDArray[np.bool_]:
        """In which all is done."""
        ...


class Level(NamedTuple):
    """A level of the search, for whoever watches."""

    depth: int
    new: int
    distinct: int
    generated: int


class SearchedSpace(NamedTuple):
    """What was found: all states in order, those of each level, and states that break a rule."""

    states: Keys
    levels: tuple[Keys, ...]
    generated: int
    broken: Keys
    complete: bool


def search(
    expansion: Explorable,
    states_max: int,
    watch: Callable[[Level], None],
    breaks: Callable[[Keys], NDArray[np.bool_]],
) -> SearchedSpace:
    """Every state, until a level has one that breaks a rule by `breaks`, or `states_max` are found."""
    frontier = expansion.start()
    levels, seen, generated = [frontier], SeenStates(), 0
    seen.add(frontier)
    broken = frontier[breaks(frontier)]
    while len(frontier) and not len(broken) and seen.count < states_max:
        found: list[Keys] = []
        for part in parts(frontier):
            _, after, _ = expansion.following(part)
            generated += len(after)
            found.append(seen.new(np.unique(after)))
        frontier = np.unique(np.concatenate(found))
        seen.add(frontier)
        levels.append(frontier)
        broken = frontier[breaks(frontier)]
        watch(Level(len(levels) - 1, len(frontier), seen.count, generated))
    return SearchedSpace(seen.all(), tuple(levels), generated, broken, complete=not len(frontier))


def parts(keys: Keys) -> Iterator[Keys]:
    """The states, some at a time."""
    return (keys[first : first + AT_ONCE] for first in range(0, len(keys), AT_ONCE))


def way_to(expansion: Explorable, levels: Sequence[Keys], key: int) -> list[int]:
    """The states on a shortest way to one, the first and itself among them."""
    depth = next(d for d, level in enumerate(levels) if key in level)
    way = [key]
    for level in reversed(levels[:depth]):
        way.append(_before(expansion, level, way[-1]))
    return way[::-1]


def _before(expansion: Explorable, level: Keys, key: int) -> int:
    for part in parts(level):
        source, after, _ = expansion.following(part)
        found = np.flatnonzero(after == np.uint64(key))
        if len(found):
            return int(part[source[found[0]]])
    raise LookupError(f"nothing leads to {key}")


class SeenStates:
    """States that have been found: a few sorted arrays, the greater at least twice as great as the next."""

    def __init__(self) -> None:
        self._runs: list[Keys] = []

    @property
    def count(self) -> int:
        """How many."""
        return sum(len(run) for run in self._runs)

    def add(self, keys: Keys) -> None:
        """More of them: sorted, each once, none of them known."""
        self._runs.append(keys)
        while len(self._runs) > 1 and 2 * len(self._runs[-1]) > len(self._runs[-2]):
            last = self._runs.pop()
            self._runs[-1] = np.sort(np.concatenate((self._runs[-1], last)), kind="stable")

    def new(self, keys: Keys) -> Keys:
        """Those that are not known."""
        for run in self._runs:
            keys = keys[~among(run, keys)]
        return keys

    def all(self) -> Keys:
        """All of them, sorted."""
        return np.sort(np.concatenate(self._runs))


def among(run: Keys, keys: Keys) -> NDArray[np.bool_]:
    """Which keys are in a sorted array."""
    if not len(run):
        return np.zeros(len(keys), bool)
    at = np.searchsorted(run, keys)
    there: NDArray[np.bool_] = run[np.minimum(at, len(run) - 1)] == keys
    return there


def ranks(expansion: Explorable, space: SearchedSpace) -> Numbers:
    """By state: how many steps without trouble are enough for all trains to finish; -1: no number is."""
    states, filled = space.states, 0
    edges = np.empty(space.generated, np.uint64)  # to and from where, as one number: they sort in place
    for number, part in enumerate(parts(states)):
        source, after, trouble = expansion.following(part)
        helpful = trouble == 0
        target = np.searchsorted(states, after[helpful]).astype(np.uint64)
        source = (source[helpful] + number * AT_ONCE).astype(np.uint64)
        edges[filled : filled + len(target)] = target << _INDEX_BITS | source
        filled += len(target)
    edges = edges[:filled]
    edges.sort()
    bounds = np.searchsorted(edges, np.arange(len(states) + 1, dtype=np.uint64) << _INDEX_BITS)
    rank = np.full(len(states), -1, np.int64)
    done = np.concatenate([expansion.finished(part) for part in parts(states)])
    here, depth = np.flatnonzero(done), 0
    while len(here):
        rank[here] = depth
        count = bounds[here + 1] - bounds[here]
        at = np.repeat(bounds[here] - np.cumsum(count) + count, count) + np.arange(int(count.sum()))
        before = np.unique(edges[at] & _INDEX).astype(np.int64)
        here, depth = before[rank[before] < 0], depth + 1
    return rank


class JudgedSpace(NamedTuple):
    """A space that was searched; `ranks`: of its states, None unless it was found whole and breaks no rule.

    `dead`: how many states lead to no end. `wrong`: the first state that breaks a rule, or else a dead one that is
    nearest; None: neither.
    """

    space: SearchedSpace
    ranks: Numbers | None = None
    dead: int = 0
    wrong: int | None = None


def judged_space(
    expansion: Explorable,
    states_max: int,
    watch: Callable[[Level], None],
    breaks: Callable[[Keys], NDArray[np.bool_]],
) -> JudgedSpace:
    """What `search` finds, and which of it no way leads to an end from."""
    space = search(expansion, states_max, watch, breaks)
    if len(space.broken):
        return JudgedSpace(space, wrong=int(space.broken[0]))
    if not space.complete:
        return JudgedSpace(space)
    rank = ranks(expansion, space)
    dead = space.states[rank < 0]
    if not len(dead):
        return JudgedSpace(space, rank)
    first = next(found for level in space.levels if len(found := np.intersect1d(level, dead)))
    return JudgedSpace(space, rank, len(dead), int(first[0]))
