"""Hops from a stand to a stand on the bench: what is ordered comes out, whatever law drives, and nothing leaks over."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from onboard.driving.laws.cue import PLAN, PLAN_COAST, PLAN_HOLD
from onboard.records import NO_INTERVENTION
from study.papers.single_hop import (
    HopBench,
    Rows,
    Way,
    new_hops,
    one_gradient,
)
from study.papers.yasunobu_train import HOP_M, ORDERS_S, paper_bench, paper_hops
from vehicle.mass import GRAVITY_MPS2, mass_kg


@pytest.fixture(scope="module")
def course() -> HopBench:
    return paper_hops("hold_speed")


def test_the_running_time_asked_for_comes_out_by_the_same_loop_for_every_law(course: HopBench) -> None:
    for gradient_permille in (10.0, 0.0, -10.0):
        for law in ("hold_speed", "follow_plan"):
            for order_s in ORDERS_S:
                found = paper_hops(law, gradient_permille).timed(order_s)
                assert abs(found.off_s) <= 1.0
                assert abs(found.outcome["error_m"]) < 0.5
                assert found.outcome["intervention"] == NO_INTERVENTION
    assert course.timed(60.0).off_s > 10.0  # nobody makes it: the nearest is far


def test_many_hops_are_each_as_if_made_alone(course: HopBench) -> None:
    hops = new_hops([80.0, 100.0, 90.0])
    hops["gradient_off_permille"] = (3.0, 0.0, -3.0)
    hops["brake_factor"] = (0.95, 1.0, 1.05)
    together, _ = course.run(hops)
    for i in range(3):
        alone, _ = course.run(hops[i : i + 1])
        assert alone[0] == together[i]
    assert len({float(s) for s in together["time_s"]}) == 3


def test_the_trace_is_the_run(course: HopBench) -> None:
    found = course.timed(90.0)
    trace = course.traced(found)
    assert trace.size * 0.1 == pytest.approx(float(found.outcome["time_s"]))
    assert trace["position_m"][-1] == pytest.approx(HOP_M + float(found.outcome["error_m"]))
    moving = trace[:-1]
    changes = np.diff(moving["notch"], prepend=0.0) != 0.0
    assert changes[moving["speed_mps"] > 0.0].sum() == found.notch_changes
    assert trace["speed_mps"].max() == found.outcome["speed_max_mps"]


@settings(max_examples=20)
@given(st.floats(-10.0, 10.0), st.floats(76.0, 110.0))
def test_what_is_drawn_pays_for_the_climb_and_more(gradient_permille: float, order_s: float) -> None:
    """Energy at the wire is at least that of the climb over the efficiency, and a slower order costs no more speed."""
    course = paper_hops("hold_speed", gradient_permille)
    outcomes, _ = course.run(new_hops([order_s, order_s + 5.0]))
    weight_n = mass_kg(course.train, 0.0) * GRAVITY_MPS2
    climb_j = weight_n * gradient_permille / 1000.0 * (HOP_M + float(outcomes["error_m"][0]))
    assert outcomes["energy_traction_j"][0] * course.train.efficiency_traction > climb_j
    assert outcomes["speed_max_mps"][1] <= outcomes["speed_max_mps"][0] + 0.1


def test_the_unit_goes_by_its_own_map() -> None:
    """A drop that the map does not show lies under the train: the cruising speed is that of the level."""
    flat = one_gradient(HOP_M)
    hidden = Way(HOP_M, ((0.0, 0.0), (HOP_M - 60.0, -20.0)), believed_permille=((0.0, 0.0),))
    known = Way(HOP_M, ((0.0, 0.0), (HOP_M - 60.0, -20.0)))
    by_way = {way: paper_hops("hold_speed", way=way) for way in (flat, hidden, known)}
    cruise = [course.cruise_mps(90.0) for course in by_way.values()]
    assert cruise[0] == cruise[1]
    ends = [float(course.run(new_hops([90.0]))[0]["error_m"][0]) for course in by_way.values()]
    assert ends[1] > ends[0] + 0.05  # unknown, it carries the train on
    assert abs(ends[2]) < abs(ends[1])


def test_limits_on_the_way_are_kept() -> None:
    way = Way(HOP_M, limits_mps=((0.0, 20.0), (400.0, 12.0), (600.0, 20.0)))
    course = paper_hops("hold_speed", way=way)
    outcomes, trace = course.run(new_hops([95.0]), 3000)
    slow = (trace["position_m"] >= 400.0) & (trace["position_m"] <= 600.0)
    assert trace["speed_mps"][slow].max() <= 12.0
    assert trace["speed_mps"].max() > 13.0
    assert outcomes["intervention"][0] == NO_INTERVENTION


def test_a_planner_lays_a_plan_for_every_hop() -> None:
    """Each hop has its own: coasting from where its order says."""

    def planner(course: HopBench, order_s: float, _load_share: float) -> Rows:
        plan = np.zeros(course.pattern.size, dtype=PLAN)
        plan["speed_mps"], plan["mode"] = 16.0, PLAN_HOLD
        plan["mode"][int(course.begin_m + 4.0 * order_s) :] = PLAN_COAST
        plan["time_left_s"] = -1000.0  # never late
        return plan

    course = HopBench(paper_bench("follow_plan"), one_gradient(HOP_M), planner)
    outcomes, _ = course.run(new_hops([100.0, 150.0]))
    assert outcomes["coasting_s"][0] > outcomes["coasting_s"][1] + 5.0
    assert outcomes["energy_traction_j"][0] < outcomes["energy_traction_j"][1]
