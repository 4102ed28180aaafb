"""The law that drives an optimal profile: what it asks for in each mode of its plan, and while TASC brakes."""

from collections.abc import Callable

import numpy as np
import pytest

from onboard.driving.laws.cue import CUE, PLAN, PLAN_COAST, PLAN_FOLLOW, PLAN_HOLD
from onboard.driving.laws.optimal import OptimalRow, optimal
from onboard.driving.laws.settings import fit_law
from onboard.driving.laws.table import LAWS_ROW
from onboard.records import BehaviourRow, UnitRow
from tests.rows import Rows
from vehicle.records import TrainRow

ROWS = 500
AT_M = 100.0


@pytest.fixture
def asked(
    unit: UnitRow, train: TrainRow, behaviour: BehaviourRow, track: Callable[..., Rows]
) -> Callable[..., float]:
    """The notch asked for on a plan whose speed squared falls or rises evenly from `at_mps` at AT_M."""
    path = track(np.zeros(ROWS), 30.0)

    def ask(mode: int, at_mps: float, slope_mps2: float, speed_mps: float, **of_unit: float) -> float:
        plan = np.zeros(ROWS, dtype=PLAN)
        energy = 0.5 * at_mps**2 + slope_mps2 * (np.arange(ROWS) - AT_M)
        plan["speed_mps"], plan["mode"] = np.sqrt(2.0 * np.maximum(energy, 0.0)), mode
        unit.position_m, unit.speed_mps, unit.plan_rows, unit.plan_offset = AT_M, speed_mps, ROWS, 0
        unit.acceleration_mps2, unit.notch, unit.braking_to_stop = 0.0, 0.0, 0
        for name, value in of_unit.items():
            setattr(unit, name, value)
        cue = np.zeros(1, dtype=CUE).view(np.recarray)[0]
        cue.limit_mps, cue.ceiling_mps = 30.0, np.inf
        cue.reaction_s = train.brake_dead_time_s + train.brake_lag_s
        laws = np.zeros(1, dtype=LAWS_ROW).view(np.recarray)[0]
        fit_law(laws, "optimal")
        own: OptimalRow = laws.optimal
        return float(optimal(own, cue, unit, train, behaviour, path, plan))

    return ask


def test_a_coast_asks_for_nothing_however_fast_the_train_is(asked: Callable[..., float]) -> None:
    assert asked(PLAN_COAST, 12.0, -0.05, 12.0) == 0.0
    assert asked(PLAN_COAST, 12.0, -0.05, 9.0) == 0.0
    assert asked(PLAN_COAST, 12.0, -0.05, 15.0) == 0.0


@pytest.mark.parametrize(("mode", "slope_mps2"), [(PLAN_COAST, -0.05), (PLAN_FOLLOW, -0.5)])
def test_who_stands_where_the_plan_only_rolls_pulls(
    asked: Callable[..., float], mode: int, slope_mps2: float
) -> None:
    assert asked(mode, 12.0, slope_mps2, 0.0) > 0.0


def test_who_stands_at_its_mark_with_tasc_braking_does_not(asked: Callable[..., float]) -> None:
    assert asked(PLAN_COAST, 1.0, -0.05, 0.0, braking_to_stop=1) == 0.0


def test_a_rising_plan_is_driven_with_the_notch_that_gives_it(
    asked: Callable[..., float], train: TrainRow
) -> None:
    assert asked(PLAN_FOLLOW, 3.0, 5.0, 3.0) == train.power_notches
    assert 0.0 < asked(PLAN_FOLLOW, 3.0, 0.05, 3.0) < train.power_notches


def test_a_falling_plan_is_braked_harder_by_who_is_too_fast(asked: Callable[..., float]) -> None:
    on_plan, above = asked(PLAN_FOLLOW, 12.0, -0.4, 12.0), asked(PLAN_FOLLOW, 12.0, -0.4, 13.0)
    assert above < on_plan < 0.0


def test_the_stop_is_tascs_alone(asked: Callable[..., float]) -> None:
    assert asked(PLAN_FOLLOW, 12.0, -0.4, 13.0, braking_to_stop=1) == 0.0


def test_a_level_plan_is_held(asked: Callable[..., float]) -> None:
    assert asked(PLAN_HOLD, 12.0, 0.0, 10.0) > 0.0
    assert asked(PLAN_HOLD, 12.0, 0.0, 13.0) <= 0.0
