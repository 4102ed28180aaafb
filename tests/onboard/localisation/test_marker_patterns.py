"""The catalogue of patterns: how far any two are apart, and that what is not exactly one of them is refused."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.localisation import marker_patterns as module
from onboard.localisation.marker_patterns import (
    CELLS,
    COLUMN_M,
    COLUMNS,
    MARKERS,
    PATTERNS,
    ROWS,
    UNREAD,
    WORDS,
    is_marked,
    pattern_of,
    recognised_pattern,
)


def cells_of(pattern: int) -> list[int]:
    return [cell for cell in range(CELLS) if WORDS[pattern - 1] >> cell & 1]


def points_on(
    cells: list[int], counts: list[int], spacing_m: float, first_m: float, seed: int, spread_m: float
) -> tuple[np.ndarray, np.ndarray]:
    """So many points on each cell, evenly within `spread_m` of its middle either way."""
    rng = np.random.default_rng(seed)
    x = [
        first_m + cell // COLUMNS * spacing_m
        for cell, count in zip(cells, counts, strict=True)
        for _ in range(count)
    ]
    y = [
        (cell % COLUMNS - (COLUMNS - 1) / 2.0) * COLUMN_M
        for cell, count in zip(cells, counts, strict=True)
        for _ in range(count)
    ]
    return (
        np.array(x) + rng.uniform(-spread_m, spread_m, len(x)),
        np.array(y) + rng.uniform(-0.05, 0.05, len(y)),
    )


def test_any_two_patterns_differ_in_eight_cells_or_more() -> None:
    assert PATTERNS == 24
    assert min((a ^ b).bit_count() for a, b in combinations(WORDS, 2)) == 8
    for pattern in range(1, PATTERNS + 1):
        rows = [sum(is_marked(pattern, row, column) for column in range(COLUMNS)) for row in range(ROWS)]
        assert rows == [MARKERS // ROWS] * ROWS
        assert pattern_of(WORDS[pattern - 1]) == pattern


@given(
    pattern=st.integers(1, PATTERNS),
    counts=st.lists(st.integers(4, 20), min_size=MARKERS, max_size=MARKERS),
    spacing_m=st.sampled_from([0.25, 0.5, 1.0]),
    first_m=st.floats(3.0, 8.0),
    seed=st.integers(0, 1000),
)
def test_points_about_the_markers_give_the_pattern_and_its_first_row(
    pattern: int, counts: list[int], spacing_m: float, first_m: float, seed: int
) -> None:
    x_m, y_m = points_on(cells_of(pattern), counts, spacing_m, first_m, seed, 0.2 * spacing_m)
    number, row_m = recognised_pattern(x_m, y_m, spacing_m)
    assert number == pattern
    assert row_m == pytest.approx(first_m, abs=0.2 * spacing_m)


@given(
    pattern=st.integers(1, PATTERNS),
    moves=st.lists(st.tuples(st.integers(0, MARKERS - 1), st.integers(0, CELLS - 1)), min_size=0, max_size=3),
    lost=st.integers(0, 3),
    points=st.integers(2, 9),
)
def test_up_to_three_markers_in_wrong_places_or_gone_never_give_another_pattern(
    pattern: int, moves: list[tuple[int, int]], lost: int, points: int
) -> None:
    cells = cells_of(pattern)
    for index, cell in moves:
        cells[index] = cell
    cells = sorted(set(cells))[lost:] if lost else sorted(set(cells))
    x_m, y_m = points_on(cells, [points] * len(cells), 0.25, 5.0, 1, 0.05)
    assert recognised_pattern(x_m, y_m, 0.25)[0] in (UNREAD, pattern)


@pytest.mark.parametrize("lost", range(MARKERS))
def test_a_marker_that_is_missing_hides_the_pattern(lost: int) -> None:
    cells = cells_of(7)
    del cells[lost]
    x_m, y_m = points_on(cells, [8] * len(cells), 0.25, 5.0, 1, 0.05)
    assert recognised_pattern(x_m, y_m, 0.25)[0] == UNREAD


def test_points_spread_over_half_a_row_more_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """They fill cells between; without the demand that others show clearly less, something is told."""
    x_m, y_m = points_on(cells_of(3), [30] * MARKERS, 0.25, 5.0, 2, 0.2)
    assert recognised_pattern(x_m, y_m, 0.25)[0] == UNREAD
    counts = np.zeros(module.ROWS_LOOKED * COLUMNS, dtype=np.int64)
    module.count_cells(x_m, y_m, 0.25, counts)
    assert np.count_nonzero(counts >= 5) > MARKERS


def test_too_few_points_show_nothing() -> None:
    assert recognised_pattern(np.zeros(0), np.zeros(0), 0.25)[0] == UNREAD
    x_m, y_m = points_on(cells_of(3), [1] * MARKERS, 0.25, 5.0, 2, 0.0)
    assert recognised_pattern(x_m, y_m, 0.25)[0] == UNREAD
