from collections.abc import Callable

import numpy as np
import pytest

from onboard.board import SENSED, BoardRow, SensedRow
from onboard.driving.laws.cue import PLAN
from onboard.records import (
    EMERGENCY_INTERVENTION,
    EVENT_IDLE,
    EVENT_MOVING,
    EVENT_POSITION,
    EVENT_STOPPED,
    MODE_DRIVE,
    NO_PLACES,
    Chart,
    UnitRow,
)
from onboard.tick import IDLE_S, stands_idle, tick
from tests.rows import Rows

NO_PLAN = np.zeros(0, dtype=PLAN)


@pytest.fixture
def board(unit: UnitRow, new_board: Callable[[UnitRow], BoardRow]) -> BoardRow:
    return new_board(unit)


def sensed(odometer_m: float, speed_mps: float) -> SensedRow:
    row: SensedRow = np.zeros(1, dtype=SENSED).view(np.recarray)[0]
    row.odometer_m, row.speed_mps = odometer_m, speed_mps
    return row


@pytest.mark.parametrize(
    ("before_mps", "now_mps", "event"),
    [(0.0, 0.1, EVENT_MOVING), (0.1, 0.0, EVENT_STOPPED), (0.0, 0.0, 0), (5.0, 5.1, 0)],
)
def test_starting_and_stopping_are_reported_once(
    board: BoardRow, track: Callable[..., Rows], before_mps: float, now_mps: float, event: int
) -> None:
    path = track(np.zeros(1000))
    board.unit.path_rows, board.unit.speed_mps = path.size, before_mps
    assert tick(board, sensed(0.01, now_mps), Chart(path, NO_PLACES), NO_PLAN) == event


def test_the_position_trigger_fires_once(board: BoardRow, track: Callable[..., Rows]) -> None:
    path, unit = track(np.zeros(1000)), board.unit
    unit.path_rows, unit.position_trigger_m, unit.speed_mps = path.size, 101.0, 5.0
    events = [
        tick(board, sensed(metres, 5.0), Chart(path, NO_PLACES), NO_PLAN) for metres in (0.5, 0.99, 1.0, 1.5)
    ]
    assert events == [0, 0, EVENT_POSITION, 0]
    assert unit.position_trigger_m == np.inf


@pytest.mark.parametrize(("behind_m", "events"), [(0.2, [0, 0, 0]), (0.6, [0, EVENT_POSITION, 0])])
def test_it_looks_again_in_time_unless_its_front_is_surely_on_the_road(
    board: BoardRow, track: Callable[..., Rows], behind_m: float, events: list[int]
) -> None:
    """The road begins at 101 m. At 5 s its front is at 101.5 m, by a bound of 0.2 m surely on it, of 0.6 m not."""
    path, unit = track(np.zeros(1000)), board.unit
    unit.path_rows, unit.look_s, unit.look_before_m, unit.speed_mps = path.size, 5.0, 101.0, 5.0
    unit.bound_behind_m, unit.bound_growth = behind_m, 0.0
    seen = []
    for metres, now_s in ((1.0, 4.9), (1.5, 5.0), (1.6, 5.1)):
        shown = sensed(metres, 5.0)
        shown.now_s = now_s
        seen.append(tick(board, shown, Chart(path, NO_PLACES), NO_PLAN))
    assert seen == events


def test_two_trains_use_their_own_rows_of_one_path_database(
    board: BoardRow, track: Callable[..., Rows]
) -> None:
    both = np.concatenate([track(np.zeros(500), 10.0), track(np.zeros(500), 20.0)]).view(np.recarray)
    permitted = []
    for offset in (0, 500):
        board.unit.path_offset, board.unit.path_rows = offset, 500
        tick(board, sensed(0.0, 1.0), Chart(both, NO_PLACES), NO_PLAN)
        permitted.append(float(board.unit.permitted_mps))
    assert permitted == pytest.approx([10.0, 20.0])


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({}, 2),
        ({"mode": 0}, 0),
        ({"notch": 1.0}, 0),
        ({"intervention": EMERGENCY_INTERVENTION}, 0),
        ({"mark_m": np.inf}, 0),  # on sight
        ({"mark_m": 700.0}, 0),  # it waits for what lies ahead
    ],
)
def test_a_train_that_may_drive_on_and_stands_is_reported(
    unit: UnitRow, changes: dict[str, float], told: int
) -> None:
    unit.mode, unit.notch, unit.mark_m, unit.stop_limit_m = MODE_DRIVE, -3.0, 500.0, 600.0
    for name, value in changes.items():
        setattr(unit, name, value)
    events = [stands_idle(unit, 0.0, 0.5) for _ in range(int(2.0 * IDLE_S / 0.5))]
    assert events.count(EVENT_IDLE) == told
    assert stands_idle(unit, 0.1, 0.5) == 0
    assert unit.idle_s == 0.0
