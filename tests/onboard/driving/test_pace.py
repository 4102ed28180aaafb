"""When a unit plans: at a departure, when it is off its plan, and not at all for a law that follows none."""

import math
from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from onboard.driving.laws.cue import PLAN_NONE
from onboard.driving.laws.settings import fit_law
from onboard.driving.laws.table import LAWS_ROW
from onboard.duty.records import DrivingCommand, DrivingOrder, Looked, StopLimit
from onboard.mission import Mission
from onboard.motion import UnitMotion
from onboard.records import EVENT_OFF_PLAN, EVENT_TAG_OVERDUE, MODE_DRIVE, PathData
from onboard.unit_records import UnitParameters
from tests.rows import Rows

DEPART = DrivingCommand(
    drive=True, target=1, limit=StopLimit(5, None, "end of the path"), rear=0, orders=(DrivingOrder.DEPART,)
)
ON = msgspec.structs.replace(DEPART, orders=())
Made = Callable[[str], UnitMotion]  # by the name of its law


@pytest.fixture
def made(at_start: Callable[..., UnitMotion]) -> Made:
    def make(law: str) -> UnitMotion:
        laws = np.zeros(1, dtype=LAWS_ROW).view(np.recarray)[0]
        fit_law(laws, law)
        return at_start(laws=laws)

    return make


def departed(motion: UnitMotion, mission: Mission) -> float:
    """It leaves as long before it is due as by the timetable; when that is."""
    due_s = mission.targets[1].arrival_s
    assert due_s is not None
    now_s = due_s - 120.0
    motion.obey(DEPART, now_s)
    return now_s


def test_a_law_that_follows_a_plan_has_one_from_its_departure(made: Made, mission: Mission) -> None:
    motion = made("optimal")
    now_s = departed(motion, mission)
    laid = motion.taken_plan()
    assert laid is not None
    assert laid.takes_s == pytest.approx(120.0 - UnitParameters().time_margin_s, abs=0.5)
    assert motion.row.plan_due_s == pytest.approx(now_s + laid.takes_s)
    assert laid.rows["mode"][int(motion.row.position_m) + 1] != PLAN_NONE
    assert motion.taken_plan() is None


def test_off_its_plan_it_plans_anew_for_the_time_that_is_left(made: Made, mission: Mission) -> None:
    motion = made("optimal")
    now_s = departed(motion, mission)
    motion.taken_plan()
    motion.obey(ON, now_s + 20.0)
    assert motion.taken_plan() is None
    motion.row.position_m += 100.0
    motion.row.speed_mps = 8.0
    assert motion.events(EVENT_OFF_PLAN) == [Looked()]
    motion.obey(ON, now_s + 20.0)
    laid = motion.taken_plan()
    assert laid is not None
    assert laid.takes_s == pytest.approx(100.0 - UnitParameters().time_margin_s, abs=0.5)
    assert laid.rows["speed_mps"][int(motion.row.position_m) + 1] == pytest.approx(8.0, abs=0.5)


def test_too_late_it_plans_for_little_more_than_the_least_time(made: Made, mission: Mission) -> None:
    motion = made("optimal")
    due_s = mission.targets[1].arrival_s
    assert due_s is not None
    motion.obey(DEPART, due_s + 300.0)
    fast = motion.taken_plan()
    motion.obey(DEPART, due_s + 600.0)
    faster = motion.taken_plan()
    assert fast is not None
    assert faster is not None
    assert fast.takes_s == pytest.approx(faster.takes_s)


def test_a_law_without_plans_has_none(made: Made, mission: Mission) -> None:
    motion = made("hold_speed")
    departed(motion, mission)
    assert motion.taken_plan() is None
    assert motion.row.replan_s == math.inf
    assert math.isfinite(motion.row.cruise_mps)


def test_a_train_that_would_stall_has_no_plan_and_tries_all_the_same(made: Made, mission: Mission) -> None:
    """The way is steeper than its motors are strong: there is no profile to its stop."""
    motion = made("optimal")
    motion._pace.climb_m = np.arange(motion._pace.climb_m.size) * 0.15
    departed(motion, mission)
    assert motion.taken_plan() is None
    assert motion.row.plan_rows == 0
    assert motion.row.mode == MODE_DRIVE


def test_on_sight_and_without_a_position_there_is_no_plan(made: Made, mission: Mission) -> None:
    """The plan was for a train that knows where it is; standing on a coast of it, it would never leave."""
    motion = made("optimal")
    now_s = departed(motion, mission)
    laid = motion.taken_plan()
    assert laid is not None
    motion.follow(0, laid.rows.size)
    motion.row.position_m += 300.0
    motion.events(EVENT_TAG_OVERDUE)
    assert motion.row.plan_rows == 0
    motion.follow(0, laid.rows.size)
    motion.obey(DrivingCommand(drive=True, on_sight=True, orders=(DrivingOrder.RELEASE,)), now_s + 60.0)
    assert motion.row.plan_rows == 0
    assert motion.row.replan_s == math.inf
    assert motion.taken_plan() is None


def test_under_a_restricted_speed_it_holds_a_speed(made: Made, mission: Mission) -> None:
    motion = made("optimal")
    due_s = mission.targets[1].arrival_s
    assert due_s is not None
    motion.obey(msgspec.structs.replace(DEPART, sweeps=True), due_s - 120.0)
    assert motion.row.restricted_mps < math.inf
    assert motion.taken_plan() is None


@pytest.mark.parametrize(("limit_kmh", "on_sight_kmh"), [(10.0, 10.0), (25.0, 15.0)])
def test_who_does_not_know_its_place_keeps_every_limit_of_its_path(
    at_start: Callable[..., UnitMotion], mission: Mission, path: Rows, limit_kmh: float, on_sight_kmh: float
) -> None:
    """On sight at 15 km/h, or under what lies anywhere on its way; who knows its place, under what is there."""
    motion, slow = at_start(), path.copy()
    slow["permitted_mps"][300:340] = limit_kmh / 3.6
    motion.go_on(mission, PathData(slow, 0))
    motion.obey(msgspec.structs.replace(ON, on_sight=True), 0.0)
    assert motion.row.restricted_mps == pytest.approx(15.0 / 3.6)
    motion.events(EVENT_TAG_OVERDUE)
    assert motion.row.position_known == 0
    assert motion.row.restricted_mps == pytest.approx(on_sight_kmh / 3.6)
    motion.obey(msgspec.structs.replace(ON, on_sight=True), 1.0)
    assert motion.row.restricted_mps == pytest.approx(on_sight_kmh / 3.6)
