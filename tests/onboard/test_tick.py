from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from onboard.driving.stop_keeper import StopKeeper
from onboard.driving.stopping import WaveRow
from onboard.driving.tasc import DesignRow, TascRow
from onboard.records import EVENT_MOVING, EVENT_POSITION, EVENT_STOPPED
from onboard.rows import BehaviourRow, UnitRow
from onboard.tick import tick
from vehicle.rows import TrainRow

Rows = NDArray[np.void]


def rows(kept: StopKeeper) -> tuple[TascRow, DesignRow, WaveRow]:
    return kept.tasc, kept.design, kept.wave


@pytest.mark.parametrize(
    ("before_mps", "now_mps", "event"),
    [(0.0, 0.1, EVENT_MOVING), (0.1, 0.0, EVENT_STOPPED), (0.0, 0.0, 0), (5.0, 5.1, 0)],
)
def test_starting_and_stopping_are_reported_once(
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    keeper: Callable[[], StopKeeper],
    track: Callable[..., Rows],
    before_mps: float,
    now_mps: float,
    event: int,
) -> None:
    path = track(np.zeros(1000))
    unit.path_rows, unit.speed_mps = path.size, before_mps
    assert tick(unit, train, behaviour, path, 0.01, now_mps, 0.0, *rows(keeper())) == event


def test_the_position_trigger_fires_once(
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    keeper: Callable[[], StopKeeper],
    track: Callable[..., Rows],
) -> None:
    path = track(np.zeros(1000))
    unit.path_rows, unit.position_trigger_m, unit.speed_mps = path.size, 101.0, 5.0
    stop = rows(keeper())
    odometers_m = (0.5, 0.99, 1.0, 1.5)
    events = [tick(unit, train, behaviour, path, metres, 5.0, 0.0, *stop) for metres in odometers_m]
    assert events == [0, 0, EVENT_POSITION, 0]
    assert unit.position_trigger_m == np.inf


def test_two_trains_use_their_own_rows_of_one_path_database(
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    keeper: Callable[[], StopKeeper],
    track: Callable[..., Rows],
) -> None:
    both = np.concatenate([track(np.zeros(500), 10.0), track(np.zeros(500), 20.0)]).view(np.recarray)
    permitted = []
    for offset in (0, 500):
        unit.path_offset, unit.path_rows = offset, 500
        tick(unit, train, behaviour, both, 0.0, 1.0, 0.0, *rows(keeper()))
        permitted.append(float(unit.permitted_mps))
    assert permitted == pytest.approx([10.0, 20.0])
