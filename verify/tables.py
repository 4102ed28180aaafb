"""Tables over numbers: rows that grow, and functions computed once for each argument, for whole arrays at a time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.int64]
_FEW: Final = 64


class GrowingRows:
    """A table of numbers whose rows are added one by one."""

    def __init__(self, width: int) -> None:
        self._rows: Numbers = np.zeros((_FEW, width), np.int64)
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add(self, row: Sequence[int]) -> None:
        """One more row."""
        if self._count == len(self._rows):
            self._rows = np.concatenate((self._rows, np.zeros_like(self._rows)))
        self._rows[self._count] = row
        self._count += 1

    def set(self, row: int, column: int, value: int) -> None:
        """Change one number."""
        self._rows[row, column] = value

    def column(self, index: int) -> Numbers:
        """A column of all rows."""
        return self._rows[: self._count, index]


class NumbersInUse:
    """Numbers of those numbers alone that are asked for, in the order in which they first are."""

    def __init__(self) -> None:
        self._of: Numbers = np.full(_FEW, -1, np.int64)
        self.things: Numbers = np.zeros(0, np.int64)

    def of(self, numbers: Numbers) -> Numbers:
        """The number of each."""
        while len(numbers) and len(self._of) <= int(numbers.max()):
            self._of = np.concatenate((self._of, np.full_like(self._of, -1)))
        fresh = np.unique(numbers[self._of[numbers] < 0])
        if len(fresh):
            self._of[fresh] = np.arange(len(self.things), len(self.things) + len(fresh))
            self.things = np.concatenate((self.things, fresh))
        return self._of[numbers]


class Choices:
    """For each number a list of rows, found once, and laid out one behind another."""

    def __init__(self, width: int, find: Callable[[int], Sequence[Sequence[int]]]) -> None:
        self._find: Final = find
        self._rows: Final = GrowingRows(width)
        self._first: Final = GrowingRows(2)

    def of(self, numbers: Numbers) -> tuple[Numbers, Callable[[int], Numbers]]:
        """Which of the numbers each choice belongs to (by index), and the columns of these choices."""
        self._find_all(numbers)
        first, count = self._first.column(0)[numbers], self._first.column(1)[numbers]
        whose = np.repeat(np.arange(len(numbers)), count)
        within = np.arange(len(whose)) - np.repeat(np.cumsum(count) - count, count)
        at = np.repeat(first, count) + within
        return whose, lambda column: self._rows.column(column)[at]

    def _find_all(self, numbers: Numbers) -> None:
        wanted = np.unique(numbers)
        while len(self._first) <= int(wanted[-1] if len(wanted) else -1):
            self._first.add((-1, 0))
        for number in wanted[self._first.column(0)[wanted] < 0].tolist():
            rows = self._find(number)
            self._first.set(number, 0, len(self._rows))
            self._first.set(number, 1, len(rows))
            for row in rows:
                self._rows.add(row)


class Once:
    """A function of several numbers, each below 2 ** `bits`, computed once for each that comes."""

    def __init__(self, compute: Callable[..., Sequence[int]], width: int, *bits: int) -> None:
        self._compute: Final = compute
        self._width: Final = width
        self._bits: Final = bits
        self._found: Final[dict[int, Sequence[int]]] = {}
        if sum(bits) > 63:
            raise ValueError(f"{sum(bits)} bits of arguments; expected 63 or fewer")

    def __call__(self, *of: Numbers) -> Numbers:
        """The results, one row each."""
        key = of[0]
        for numbers, bits in zip(of[1:], self._bits[1:], strict=True):
            if len(numbers) and int(numbers.max()) >> bits:
                raise OverflowError(f"a table is full: {int(numbers.max())} is not below 2 ** {bits}")
            key = key << bits | numbers
        different, inverse = np.unique(key, return_inverse=True)
        rows = [self._row(number) for number in different.tolist()]
        return np.array(rows, np.int64).reshape(len(different), self._width)[inverse]

    def _row(self, key: int) -> Sequence[int]:
        found = self._found.get(key)
        if found is None:
            arguments, rest = list[int](), key
            for bits in reversed(self._bits[1:]):
                arguments.append(rest & (1 << bits) - 1)
                rest >>= bits
            found = self._found[key] = self._compute(rest, *reversed(arguments))
        return found
