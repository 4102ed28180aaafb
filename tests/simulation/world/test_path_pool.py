from __future__ import annotations

import numpy as np
import pytest

from network.model import Direction
from network.path import path_of
from simulation.setup import Setup, behaviour_rows
from simulation.world.path_pool import PathPool

PIECES_DOWN = ("3", "P5.normal", "P5.stem", "6")


@pytest.fixture
def pool(rtri_setup: Setup) -> PathPool:
    return PathPool(rtri_setup.line)


def test_rows_lie_where_the_pool_says_and_never_move(rtri_setup: Setup, pool: PathPool) -> None:
    line = rtri_setup.line
    behaviour = behaviour_rows(rtri_setup, ("K1",)).view(np.recarray)[0]
    train = rtri_setup.trains["K1"].row.view(np.recarray)[0]
    down = path_of(line, PIECES_DOWN, Direction.DOWN)
    up = path_of(line, PIECES_DOWN[::-1], Direction.UP)
    first = pool.rows_for(down, "ev_e301", train, behaviour)
    before = pool.pattern_of(first).copy()
    second = pool.rows_for(up, "ev_e301", train, behaviour)
    assert pool.rows_for(down, "ev_e301", train, behaviour) == first
    assert (first.offset, second.offset) == (0, first.rows)
    assert first.rows == int(np.ceil(down.length_m)) + 1
    assert np.array_equal(pool.pattern_of(first), before)
    assert pool.profile.size == pool.pattern.size == first.rows + second.rows
    other = pool.rows_for(down, "another kind", train, behaviour)
    assert other.offset == first.rows + second.rows


def test_tags_are_those_a_train_of_this_direction_reads_in_order(rtri_setup: Setup, pool: PathPool) -> None:
    behaviour = behaviour_rows(rtri_setup, ("K1",)).view(np.recarray)[0]
    train = rtri_setup.trains["K1"].row.view(np.recarray)[0]
    down = path_of(rtri_setup.line, PIECES_DOWN, Direction.DOWN)
    rows = pool.rows_for(down, "ev_e301", train, behaviour)
    assert pool.tag_ids[rows.tag_first : rows.tag_end] == [301, 302, 303, 601, 602, 603]
    positions_m = pool.tag_positions_m[rows.tag_first : rows.tag_end]
    # km 0.412, 0.425, 0.438, 0.535, 0.67 and 0.72 on a path that begins at km 0.36
    assert positions_m == pytest.approx([52.0, 65.0, 78.0, 175.0, 310.0, 360.0])
