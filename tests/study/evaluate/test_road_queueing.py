"""Queueing by hand, and the road in real SUMO beside it."""

import math
from pathlib import Path

import pytest

from study.evaluate.road_queueing import (
    CLOSURES,
    DIFFERENCE_MAX,
    REPEATED,
    SATURATED,
    SATURATED_PER_H,
    Discharge,
    alike,
    delay_of,
    discharge_of,
    queueing_s,
    road_run,
)
from tests.simulation.carriers.roads import LINE, road_at, road_of

PLACE = road_at(road_of())


def test_a_queue_by_hand() -> None:
    """Shut from 10 s to 30 s, two seconds a vehicle: those of 12 s, 20 s and 29 s go at 30, 32 and 34 s, that of 35 s
    at 36 s; that of 40 s, and that of 5 s before the closure, wait for nobody.
    """
    assert queueing_s((5.0, 12.0, 20.0, 29.0, 35.0, 40.0), ((10.0, 30.0),), 0.5) == 18.0 + 12.0 + 5.0 + 1.0


def test_even_arrivals_wait_as_the_formula_has_it() -> None:
    """q r^2 / (2 (1 - q/s)) = 0.1 * 60^2 / (2 * 0.8) = 225 s; in whole vehicles half of one more or less in each."""
    arrivals_s = [10.0 * k + 5.0 for k in range(60)]
    assert queueing_s(arrivals_s, ((100.0, 160.0),), 0.5) == pytest.approx(225.0, rel=0.10)


def test_delay_under_closures_is_that_of_deterministic_queueing(tmp_path: Path) -> None:
    """Undersaturated by far, with the flow of discharge measured in the same net."""
    with road_run(LINE, alike(PLACE, SATURATED_PER_H), tmp_path, SATURATED, seed=1) as run:
        discharge: Discharge = discharge_of(run)
    assert 0.35 < discharge.flow_per_s < 0.65  # 1260 to 2340 vehicles an hour and lane
    assert 0.0 < discharge.lost_s < 5.0
    with road_run(LINE, alike(PLACE, 600.0), tmp_path, REPEATED, seed=1) as run:
        delay = delay_of(run, discharge)
    assert delay.arrival_per_s < discharge.flow_per_s / 3.0
    assert abs(delay.difference) < DIFFERENCE_MAX
    # Of some 270 vehicles that come to a closure; the waiting of each is even between nothing and all.
    assert delay.sumo_s == pytest.approx(delay.even_s, rel=3.0 * math.sqrt(4.0 / 3.0 / (2 * CLOSURES * 5.6)))
    deepest = delay.arrival_per_s * delay.shut_s  # of vehicles, on average, as the barriers open
    assert deepest < delay.queue < deepest + 4.0 * math.sqrt(deepest)
