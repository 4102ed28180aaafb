"""The shortest way to a state, in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from verify.composition import Cell, Composition, LineState
from verify.expansion import Expansion, Keys
from verify.parties import Parties
from verify.search import parts


class StoryTeller:
    """Tells how the search came to a state."""

    def __init__(self, parties: Parties, expansion: Expansion) -> None:
        self.composition: Final = Composition(parties)
        self._expansion: Final = expansion

    def line_state(self, key: int) -> LineState:
        """A state of the search as the composition has it."""
        columns = self._expansion.columns(np.array([key], np.uint64))
        cells = tuple(
            Cell(*self._expansion.cells[unit].keys.things[int(numbers[0])])
            for unit, numbers in enumerate(columns.cells)
        )
        left = self._expansion.lefts.things[int(columns.left[0])]
        terminals = tuple(int(numbers[0]) for numbers in columns.terminals)
        return LineState(int(columns.manager[0]), terminals, left, cells)

    def way_to(self, levels: Sequence[Keys], key: int) -> list[int]:
        """The states on a shortest way to one, the first and itself among them."""
        depth = next(d for d, level in enumerate(levels) if key in level)
        way = [key]
        for level in reversed(levels[:depth]):
            way.append(self._before(level, way[-1]))
        return way[::-1]

    def _before(self, level: Keys, key: int) -> int:
        for part in parts(level):
            source, after, _ = self._expansion.following(part)
            found = np.flatnonzero(after == np.uint64(key))
            if len(found):
                return int(part[source[found[0]]])
        raise LookupError(f"nothing leads to {key}")

    def story(self, levels: Sequence[Keys], key: int) -> tuple[str, ...]:
        """What happens on a shortest way to a state: who, and what, a line for each event."""
        way = [self.line_state(k) for k in self.way_to(levels, key)]
        lines: list[str] = []
        for before, after in zip(way, way[1:], strict=False):
            found = next(f for f in self.composition.following(before) if f.state == after)
            lines.append(f"{found.who} {found.what}")
        return tuple(lines)
