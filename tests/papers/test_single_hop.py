"""Hops from a stand to a stand on the bench: what is ordered comes out, whatever law drives, and nothing leaks over."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.driving.laws.cue import PLAN, PLAN_COAST, PLAN_HOLD
from onboard.driving.planner.plan import PlanOnPath
from onboard.records import NO_INTERVENTION
from papers.single_hop import HopBench, HopWay, one_gradient
from papers.single_run import new_hops
from papers.yasunobu_train import HOP_M, ORDERS_S, paper_bench, paper_hops
from tests.nightly import others_nightly
from vehicle.mass import GRAVITY_MPS2, mass_kg
from vehicle.optimum import TooShort


@pytest.fixture(scope="module")
def course() -> HopBench:
    return paper_hops("hold_speed")


@pytest.mark.parametrize("gradient_permille", others_nightly([10.0, 0.0, -10.0], [-10.0]))
def test_the_running_time_asked_for_comes_out_by_the_same_loop_for_every_law(
    course: HopBench, gradient_permille: float
) -> None:
    for law in ("hold_speed", "follow_plan"):
        for order_s in ORDERS_S:
            found = paper_hops(law, gradient_permille).timed(order_s)
            assert abs(found.off_s) <= 1.0
            assert abs(found.outcome["error_m"]) < 0.5
            assert found.outcome["intervention"] == NO_INTERVENTION
    assert course.timed(course.least_s() + 0.5).off_s > 0.0  # no law makes it: the nearest is what there is


def test_many_hops_are_each_as_if_made_alone(course: HopBench) -> None:
    hops = new_hops([80.0, 100.0, 90.0])
    hops["gradient_permille"] = (3.0, 0.0, -3.0)
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
    power = np.maximum(trace["notch"], 0.0)
    assert (np.diff(power, prepend=0.0) != 0.0).sum() == found.outcome["power_changes"]
    assert trace["speed_mps"].max() == found.outcome["speed_max_mps"]


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
    hidden = HopWay(HOP_M, ((0.0, 0.0), (HOP_M - 60.0, -20.0)), believed_permille=((0.0, 0.0),))
    known = HopWay(HOP_M, ((0.0, 0.0), (HOP_M - 60.0, -20.0)))
    by_way = {way: paper_hops("hold_speed", way=way) for way in (flat, hidden, known)}
    cruise = [course.cruise_mps(90.0) for course in by_way.values()]
    assert cruise[0] == cruise[1]
    ends = [float(course.run(new_hops([90.0]))[0]["error_m"][0]) for course in by_way.values()]
    assert ends[1] > ends[0] + 0.05  # unknown, it carries the train on
    assert abs(ends[2]) < abs(ends[1])


def test_limits_on_the_way_are_kept() -> None:
    way = HopWay(HOP_M, limits_mps=((0.0, 20.0), (400.0, 12.0), (600.0, 20.0)))
    course = paper_hops("hold_speed", way=way)
    outcomes, trace = course.run(new_hops([95.0]), 3000)
    slow = (trace["position_m"] >= 400.0) & (trace["position_m"] <= 600.0)
    assert trace["speed_mps"][slow].max() <= 12.0
    assert trace["speed_mps"].max() > 13.0
    assert outcomes["intervention"][0] == NO_INTERVENTION


def test_a_planner_lays_a_plan_for_every_hop() -> None:
    """Each hop has its own: coasting from where its order says."""

    def planner(course: HopBench, order_s: float, _load_share: float) -> PlanOnPath:
        plan = np.zeros(course.pattern.size, dtype=PLAN)
        plan["speed_mps"], plan["mode"] = 16.0, PLAN_HOLD
        plan["mode"][int(course.begin_m + 4.0 * order_s) :] = PLAN_COAST
        plan["time_left_s"] = -1000.0  # never late
        return PlanOnPath(plan, order_s + 7.0)

    course = HopBench(paper_bench("follow_plan"), one_gradient(HOP_M), planner)
    hops = new_hops([100.0, 150.0])
    outcomes, _ = course.run(hops)
    assert hops["plan_due_s"].tolist() == [107.0, 157.0]  # by when the plan is there, whatever was ordered
    assert outcomes["coasting_s"][0] > outcomes["coasting_s"][1] + 5.0
    assert outcomes["energy_traction_j"][0] < outcomes["energy_traction_j"][1]


@pytest.mark.parametrize("gradient_permille", [10.0, 0.0, -10.0])
def test_a_running_time_below_the_least_is_refused_with_the_least(gradient_permille: float) -> None:
    hops = paper_hops("hold_speed", gradient_permille)
    least_s = hops.least_s()
    with pytest.raises(TooShort, match=f"{least_s:.2f}") as refused:
        hops.timed(least_s - 0.1)
    assert refused.value.least_s == least_s
    fastest, _ = hops.run(new_hops([1.0]))
    assert float(fastest["time_s"][0]) > least_s  # no law is faster than that
    assert hops.timed(least_s + 0.1).off_s > 0.0


def test_switched_off_such_a_time_is_taken(course: HopBench, monkeypatch: pytest.MonkeyPatch) -> None:
    least_s = course.least_s()
    monkeypatch.setattr(HopBench, "least_s", lambda *_: 0.0)
    assert course.timed(least_s - 5.0).off_s > 0.0


def test_a_hop_that_is_too_steep_has_no_running_time() -> None:
    assert paper_hops("hold_speed", 140.0).least_s() == np.inf
