"""The patterns in which reflective markers (ターゲットマーカ) lie, and which one a set of points shows.

Invariant: a pattern is told only if exactly its cells have shown themselves, none other nearly as much as any of them;
whatever else is seen is refused. A marker lost or one too many can therefore hide a pattern and not feign another.

The paper's patterns are lost with its figures; these are ours. Four columns of the 250 mm grid fit between rails
1,067 mm apart, with four rows a pattern has 16 cells. Its markers are the words of the first-order Reed-Muller code of
length 16 in which every row has markers: 24 patterns of 8 markers, two in each row, any two of which differ in 8 cells
or more. A wrong pattern thus takes four markers in other places at once. Rows are counted from the one that the train
meets first, so no pattern can be taken for another one a row further on.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled

COLUMN_M: Final = 0.25  # across; the paper's grid, 4.2
ROW_M: Final = 0.25  # along, unless they are laid further apart
COLUMNS: Final = 4
ROWS: Final = 4
CELLS: Final = COLUMNS * ROWS
MARKERS: Final = 8
HALF_M: Final = 0.5 * (ROWS - 1) * ROW_M  # from the first row to the middle
LEAST_POINTS: Final = 2  # a cell with fewer shows nothing
CLEARLY: Final = 2  # the weakest marker has more than this many times the points of any other cell
UNREAD: Final = 0  # no pattern
ROWS_LOOKED: Final = 48  # along, about the first point

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def _words() -> tuple[int, ...]:
    """The code's words as bits by cell (row * COLUMNS + column), in the order of pattern numbers from 1 on."""
    found: list[int] = []
    for across in (1, 2, 3):  # which bits of the column count: with none every row would be full or empty
        for along in range(8):  # bits of the row that count, and the constant
            word = 0
            for cell in range(CELLS):
                row, column = divmod(cell, COLUMNS)
                ones = (column & across).bit_count() + (row & along).bit_count() + (along >> 2)
                word |= (ones & 1) << cell
            found.append(word)
    return tuple(found)


WORDS: Final = _words()
PATTERNS: Final = len(WORDS)
WORDS_AT: Final[Ints] = np.array(WORDS, dtype=np.int64)


def is_marked(pattern: int, row: int, column: int) -> bool:
    """Whether a marker lies there; patterns count from 1. Raises ValueError where there is no such pattern."""
    if not 1 <= pattern <= PATTERNS:
        raise ValueError(f"pattern {pattern}: there are 1 to {PATTERNS}")
    return bool(WORDS[pattern - 1] >> (row * COLUMNS + column) & 1)


@compiled
def pattern_of(word: int) -> int:
    """The pattern of exactly these cells, UNREAD if none."""
    for number in range(len(WORDS_AT)):
        if WORDS_AT[number] == word:
            return number + 1
    return UNREAD


@compiled
def phase_m(x_m: Floats, spacing_m: float) -> float:
    """Where rows lie: the mean of places by their remainder in the spacing, on the circle; 0 to spacing."""
    turn = 2.0 * np.pi / spacing_m
    cosine = sine = 0.0
    for at_m in x_m:
        cosine += math.cos(turn * at_m)
        sine += math.sin(turn * at_m)
    return math.atan2(sine, cosine) / turn % spacing_m


@compiled
def count_cells(x_m: Floats, y_m: Floats, spacing_m: float, counts: Ints) -> float:
    """Fill `counts` (ROWS_LOOKED * COLUMNS) with the points of each cell; returns where row 0 lies, m."""
    counts[:] = 0
    phase = phase_m(x_m, spacing_m)
    least = math.floor((np.min(x_m) - phase) / spacing_m + 0.5)
    for i in range(len(x_m)):
        row = int(math.floor((x_m[i] - phase) / spacing_m + 0.5) - least)
        column = math.floor(y_m[i] / COLUMN_M + 0.5 * COLUMNS)
        if row < ROWS_LOOKED and 0 <= column < COLUMNS:
            counts[row * COLUMNS + column] += 1
    return phase + least * spacing_m


@compiled
def recognised_pattern(x_m: Floats, y_m: Floats, spacing_m: float) -> tuple[int, float]:
    """The pattern that points on markers show (places along the track and left of its middle, m), and its first row.

    UNREAD where it is not exactly one of the catalogue.
    """
    if len(x_m) < MARKERS * LEAST_POINTS:
        return UNREAD, 0.0
    counts = np.zeros(ROWS_LOOKED * COLUMNS, dtype=np.int64)
    first_m = count_cells(x_m, y_m, spacing_m, counts)
    order = np.argsort(-counts, kind="mergesort")
    weakest, other = counts[order[MARKERS - 1]], counts[order[MARKERS]]
    if weakest < LEAST_POINTS or weakest <= CLEARLY * other:
        return UNREAD, 0.0
    top = np.min(order[:MARKERS]) // COLUMNS
    word = 0
    for k in range(MARKERS):
        cell = order[k] - top * COLUMNS
        if cell >= CELLS:
            return UNREAD, 0.0
        word |= 1 << cell
    return pattern_of(word), first_m + top * spacing_m
