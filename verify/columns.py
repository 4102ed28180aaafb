"""States of the line as columns of numbers, a part each, and what follows from them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from verify.tables import Numbers

Which = NDArray[np.bool_]


class Columns(NamedTuple):
    """States as columns: the ground's parts, and the cells."""

    manager: Numbers
    terminals: tuple[Numbers, ...]
    left: Numbers
    cells: tuple[Numbers, ...]

    def at(self, which: Numbers | Which) -> Columns:
        """Some of the states."""
        return Columns(
            self.manager[which],
            tuple(t[which] for t in self.terminals),
            self.left[which],
            tuple(c[which] for c in self.cells),
        )


class Block(NamedTuple):
    """What follows: from which of the states (by index), what, and with what trouble."""

    source: Numbers
    after: Columns
    trouble: Numbers
