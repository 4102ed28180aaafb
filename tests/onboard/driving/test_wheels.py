"""Supervision and driving by wheels that may be larger than the tachometer is set for, and so by a greater speed."""

from collections.abc import Callable

import numpy as np
import pytest

from onboard.driving.ahead import limit_mps
from onboard.driving.supervision import supervise
from onboard.records import NO_INTERVENTION, SERVICE_INTERVENTION, BehaviourRow, UnitRow
from tests.rows import Rows
from vehicle.records import TrainRow

TRACK_M = 2500


@pytest.mark.parametrize(("shown_mps", "brakes"), [(18.2, False), (18.3, True)])
def test_a_speed_counts_for_as_much_as_the_wheels_may_be_worth(
    train: TrainRow,
    behaviour: BehaviourRow,
    track: Callable[..., Rows],
    unit: UnitRow,
    shown_mps: float,
    brakes: bool,
) -> None:
    """Limit 18 m/s, service from 18.6: by wheels that may be larger by 2 % that is 18.24 m/s as they show it."""
    unit.path_rows = TRACK_M
    unit.speed_mps, unit.odometer_scale, unit.bound_growth = shown_mps, 1.005, 0.015
    supervise(unit, train, behaviour, track(np.zeros(TRACK_M)))
    assert bool(unit.intervention == SERVICE_INTERVENTION) is brakes


@pytest.mark.parametrize("growth", [0.0, 0.02, 0.2])
def test_driving_stays_below_where_supervision_brakes_however_little_the_wheels_are_known(
    train: TrainRow, behaviour: BehaviourRow, track: Callable[..., Rows], unit: UnitRow, growth: float
) -> None:
    """Of a limit of 27 m/s wheels that may be worth a fifth more leave 27.6 / 1.2 - 0.6 = 22.4 m/s, as they show it."""
    path = track(np.zeros(TRACK_M), 27.0)
    unit.path_rows = TRACK_M
    unit.bound_growth = growth
    unit.permitted_mps = unit.ceiling_mps = 27.0
    unit.speed_mps = limit_mps(unit, behaviour, path)
    assert supervise(unit, train, behaviour, path) == 0
    assert unit.intervention == NO_INTERVENTION
    assert unit.speed_mps == pytest.approx(min(27.0 - 1.2, 27.6 / (1.0 + growth) - 0.6))
