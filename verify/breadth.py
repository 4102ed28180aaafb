"""Breadth-first through the states of a machine, by its own step: what follows what, on which event."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

S = TypeVar("S", bound=Hashable)


@dataclass(frozen=True)
class Explored(Generic[S]):
    """What was found. `complete`: nothing was left when the bound was reached."""

    states: frozenset[S]
    steps: int
    edges: frozenset[tuple[str, str, str]]  # from, event, to: by name
    complete: bool


@dataclass(frozen=True)
class Keyed:
    """A state that has mappings in it, compared by what `key` says of it."""

    key: Hashable
    state: Any = field(compare=False)


def explore(
    initial: Iterable[S],
    following: Callable[[S], Iterable[tuple[str, S]]],
    name_of: Callable[[S], str],
    states_max: int,
) -> Explored[S]:
    """All states from the first ones on, at most `states_max`; `following` gives events by name and what they lead to.

    Those that change the name of the state are its edges.
    """
    queue = deque(initial)
    seen = set(queue)
    edges: set[tuple[str, str, str]] = set()
    count = 0
    while queue:
        state = queue.popleft()
        here = name_of(state)
        for event, after in following(state):
            count += 1
            there = name_of(after)
            if there != here:
                edges.add((here, event, there))
            if after not in seen and len(seen) < states_max:
                seen.add(after)
                queue.append(after)
    return Explored(frozenset(seen), count, frozenset(edges), complete=len(seen) < states_max)
