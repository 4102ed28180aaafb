import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle.response import approach, dead_time_steps


@pytest.mark.parametrize(
    ("dead_s", "dt_s", "steps"),
    [
        (0.0, 0.1, 0),
        (0.2, 0.1, 2),
        (0.5, 0.1, 5),
        (1.0, 0.02, 50),
        (0.3, 0.1, 3),
        (0.26, 0.1, 3),
        (9.0, 0.1, 63),
    ],
)
def test_dead_time_in_whole_steps(dead_s: float, dt_s: float, steps: int) -> None:
    assert dead_time_steps(dead_s, dt_s) == steps


@given(dt_s=st.floats(0.01, 0.5))
def test_the_lag_is_exact_at_any_step(dt_s: float) -> None:
    value = 0.0
    for _ in range(20):
        value = approach(value, 1.0, 0.6, 0.0, dt_s)
    assert value == pytest.approx(1.0 - math.exp(-20 * dt_s / 0.6))


def test_no_lag_and_no_limit_is_at_once() -> None:
    assert approach(0.0, 5.0, 0.0, 0.0, 0.1) == 5.0


@given(st.floats(-100, 100), st.floats(-100, 100), st.floats(0, 2), st.floats(0.1, 50))
def test_the_rate_limit_holds_and_the_target_is_not_passed(
    value: float, target: float, lag_s: float, rate: float
) -> None:
    after = approach(value, target, lag_s, rate, 0.1)
    assert abs(after - value) <= rate * 0.1 + 1e-9
    assert min(value, target) - 1e-9 <= after <= max(value, target) + 1e-9
