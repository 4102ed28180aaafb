import numpy as np
import pytest

from network.model import Direction
from network.path import path_of
from onboard.driving.laws.cue import PLAN, PLAN_HOLD
from onboard.records import UNIT, UnitRow
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


def plan_of(rows: int, speed_mps: float) -> np.ndarray:
    plan = np.zeros(rows, dtype=PLAN)
    plan["speed_mps"], plan["mode"] = speed_mps, PLAN_HOLD
    return plan


def unit_on(rows: int) -> UnitRow:
    unit: UnitRow = np.zeros(1, dtype=UNIT).view(np.recarray)[0]
    unit.path_rows = rows
    return unit


def lay(pool: PathPool, slot: int, unit: UnitRow, plan: np.ndarray) -> None:
    """Lay it, and tell the unit where."""
    unit.plan_offset, unit.plan_rows = pool.lay_plan(slot, unit.path_rows, plan), plan.size


def speeds_of(pool: PathPool, unit: UnitRow) -> list[float]:
    """What compiled code finds where the unit's row says that its plan lies."""
    speeds: list[float] = pool.track.plan["speed_mps"][unit.plan_offset :][: unit.plan_rows].tolist()
    return speeds


def test_each_stock_has_a_plan_of_its_own_where_its_unit_says(pool: PathPool) -> None:
    first, second = unit_on(40), unit_on(30)
    lay(pool, 0, first, plan_of(40, 9.0))
    lay(pool, 1, second, plan_of(30, 12.0))
    assert speeds_of(pool, first) == [9.0] * 40
    assert speeds_of(pool, second) == [12.0] * 30


def test_a_new_plan_takes_the_old_ones_room_and_a_longer_one_new_room(pool: PathPool) -> None:
    first, second = unit_on(40), unit_on(30)
    lay(pool, 0, first, plan_of(40, 9.0))
    lay(pool, 1, second, plan_of(30, 12.0))
    first.path_rows = 20
    lay(pool, 0, first, plan_of(20, 7.0))
    assert (pool.plan.size, speeds_of(pool, first)) == (70, [7.0] * 20)
    first.path_rows = 50
    lay(pool, 0, first, plan_of(50, 5.0))
    assert (pool.plan.size, speeds_of(pool, first)) == (120, [5.0] * 50)
    assert speeds_of(pool, second) == [12.0] * 30


def test_no_rows_take_the_plan_away_and_a_plan_of_another_length_is_refused(pool: PathPool) -> None:
    unit = unit_on(40)
    lay(pool, 0, unit, plan_of(40, 9.0))
    with pytest.raises(ValueError, match="39 rows for a path of 40"):
        lay(pool, 0, unit, plan_of(39, 3.0))
    assert speeds_of(pool, unit) == [9.0] * 40
    lay(pool, 0, unit, plan_of(0, 0.0))
    assert unit.plan_rows == 0
