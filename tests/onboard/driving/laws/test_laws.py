"""Driving laws in the tick, on plain track: what they ask for, and what lies outside them."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from onboard.board import BOARD, SENSED, BoardRow, SensedRow
from onboard.driving.laws.cue import PLAN, PLAN_COAST, PLAN_HOLD
from onboard.driving.laws.settings import fit_law
from onboard.driving.laws.table import LAW_NAMES, LAWS
from onboard.records import NO_PLACES, Chart, UnitRow
from onboard.tick import tick
from tests.rows import Rows
from vehicle.dynamics import step
from vehicle.train_file import new_plant

TRACK_M = 3000
STEP_S = 0.1


class Ride:
    """One train on level plain track under one law."""

    def __init__(self, board: BoardRow, path: Rows, speed_mps: float = 0.0) -> None:
        self.board, self.path = board, path
        self.plan: Rows = np.zeros(0, dtype=PLAN)
        self.sensed: SensedRow = np.zeros(1, dtype=SENSED).view(np.recarray)[0]
        self.plant: Any = new_plant(1, speed_mps).view(np.recarray)[0]
        board.unit.speed_mps, board.unit.path_rows = speed_mps, path.size

    def follow(self, plan: Rows) -> None:
        self.plan = plan
        self.board.unit.plan_rows = plan.size

    def run(self, steps: int) -> tuple[list[float], list[float]]:
        """Speeds shown and notches given."""
        unit, speeds, notches = self.board.unit, [], []
        for _ in range(steps):
            step(self.plant, self.board.kind, unit.notch, unit.emergency != 0, 0.0, 0.0, STEP_S)
            self.sensed.now_s += STEP_S
            self.sensed.odometer_m, self.sensed.speed_mps = self.plant.wheel_travelled_m, self.plant.speed_mps
            tick(self.board, self.sensed, Chart(self.path, NO_PLACES), self.plan)
            speeds.append(float(self.plant.speed_mps))
            notches.append(float(unit.notch))
        return speeds, notches


@pytest.fixture
def ride(
    unit: UnitRow, new_board: Callable[[UnitRow], BoardRow], track: Callable[..., Rows]
) -> Callable[..., Ride]:
    def make(law: str, limit_mps: float = 18.0, **of_ride: float) -> Ride:
        board = new_board(unit)
        fit_law(board.laws, law)
        board.unit.due_s = board.unit.replan_s = np.inf
        return Ride(board, track(np.zeros(TRACK_M), limit_mps), **of_ride)

    return make


def plan_of(speed_mps: float, mode: int = PLAN_HOLD, time_left_s: float = 0.0) -> Rows:
    plan = np.zeros(TRACK_M, dtype=PLAN)
    plan["speed_mps"], plan["mode"], plan["time_left_s"] = speed_mps, mode, time_left_s
    return plan


def test_every_law_of_the_table_has_its_own_row_and_name() -> None:
    assert len({law.name for law in LAWS}) == len(LAWS)
    for law in LAWS:
        assert BOARD["laws"][law.name].names == tuple(law.row.__annotations__)


@pytest.mark.parametrize("law", LAW_NAMES)
def test_no_law_passes_the_limit_or_the_target(ride: Callable[..., Ride], law: str) -> None:
    """A limit of 12 m/s and a stop 1200 m on, whatever the law would like."""
    course = ride(law, limit_mps=12.0)
    course.board.unit.target_stop_m, course.board.unit.stop_limit_m = 1300.0, 1400.0
    course.follow(plan_of(30.0))
    speeds, _ = course.run(2500)
    assert max(speeds) <= 12.0
    assert speeds[-1] == 0.0
    assert course.board.unit.position_m == pytest.approx(1300.0, abs=1.0)


@pytest.mark.parametrize("law", LAW_NAMES)
def test_an_intervention_overrules_every_law(ride: Callable[..., Ride], law: str) -> None:
    course = ride(law, speed_mps=10.0)
    course.board.unit.stop_limit_m = 110.0
    _, notches = course.run(2)
    assert notches[-1] == -course.board.kind.brake_notches
    assert course.board.unit.emergency == 1


def test_a_number_that_is_no_law_brakes(ride: Callable[..., Ride]) -> None:
    course = ride("hold_speed", speed_mps=10.0)
    course.board.laws.number = len(LAWS)
    _, notches = course.run(1)
    assert notches == [-course.board.kind.brake_notches]


def test_the_plan_gives_the_speed_and_without_one_the_cruise_does(ride: Callable[..., Ride]) -> None:
    for plan, held_mps in ((plan_of(9.0), 9.0), (np.zeros(0, dtype=PLAN), 6.0)):
        course = ride("follow_plan")
        course.board.unit.cruise_mps = 6.0
        course.follow(plan)
        speeds, _ = course.run(1200)
        assert max(speeds) <= held_mps + 0.5
        assert min(speeds[-300:]) >= held_mps - 1.0


def test_a_train_coasts_where_the_plan_says_so(ride: Callable[..., Ride]) -> None:
    """On the level only running resistance slows it: no notch at all, and the speed falls all the time."""
    course = ride("follow_plan", speed_mps=12.0)
    course.follow(plan_of(12.0, PLAN_COAST))
    speeds, notches = course.run(300)
    assert set(notches) == {0.0}
    assert all(after < before for before, after in pairwise(speeds))


def test_a_late_train_gives_up_coasting_until_it_has_caught_up(ride: Callable[..., Ride]) -> None:
    """The plan leaves 100 s from anywhere: due in 95 s the train is 5 s late; due in 100 s and more it is not."""
    course = ride("follow_plan", speed_mps=12.0)
    course.follow(plan_of(12.0, PLAN_COAST, time_left_s=100.0))
    course.board.unit.due_s = 95.0
    _, notches = course.run(30)
    assert max(notches) > 0.0
    course.board.unit.due_s = 102.0  # at 3 s: 1 s late by now
    course.run(1)
    assert course.board.laws.follow_plan.catching_up == 1  # type: ignore[attr-defined]
    course.board.unit.due_s = 105.0
    _, notches = course.run(30)  # a notch is kept for a while
    assert notches[-1] == 0.0
    assert course.board.laws.follow_plan.catching_up == 0  # type: ignore[attr-defined]
