from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from onboard.driving.tasc import Verdict
from study.papers.oda_table4 import controller, oda_train, plain_stop
from study.papers.single_stop import (
    OUTCOME,
    STOP,
    TRACE,
    OutcomeRow,
    StopRow,
    TraceRow,
    one_stop,
)

GAIN_PER_S = 0.6


def test_the_rows_have_the_fields_that_the_laws_see() -> None:
    assert tuple(StopRow.__annotations__) == STOP.names
    assert tuple(OutcomeRow.__annotations__) == OUTCOME.names
    assert tuple(TraceRow.__annotations__) == TRACE.names


@pytest.mark.parametrize("speed_kmh", [20.0, 40.0, 60.0, 80.0])
@pytest.mark.parametrize("gradient_permille", [-10.0, 0.0, 10.0])
def test_without_errors_the_train_stops_at_the_mark(speed_kmh: float, gradient_permille: float) -> None:
    stop = plain_stop(speed_kmh)
    stop["start_m"] = 40.0 + (speed_kmh / 3.6) ** 2 / (2.0 * 0.79)  # uphill a long run up would end before it
    stop["gradient_permille"] = gradient_permille
    stop["gradient_believed_permille"] = gradient_permille
    result, _ = one_stop(stop, oda_train(), controller(GAIN_PER_S))
    assert abs(result.error_m) < 0.05
    assert result.verdict is Verdict.POSSIBLE
    assert not result.emergency


def test_the_final_stop_is_soft() -> None:
    result, trace = one_stop(plain_stop(70.0), oda_train(), controller(GAIN_PER_S), 2000)
    # at rest little more ends than the 0.3 m/s^2 and running resistance that the pattern leaves
    assert result.rest_mps2 < 0.5
    assert result.deceleration_max_mps2 < 0.93 + 0.1
    moving = trace[trace["speed_mps"] > 0.1]
    jerk = np.diff(moving["deceleration_mps2"][-40:]) / 0.1
    assert np.abs(jerk).max() < 1.0


def test_a_weak_brake_leaves_proportional_following_past_the_mark_and_pid_nearer() -> None:
    stop = plain_stop(60.0)
    stop["brake_factor"] = 0.93
    proportional = controller(GAIN_PER_S, 0.7)
    pid = controller(GAIN_PER_S, 0.7)
    pid["integral_gain_per_s2"] = 0.1
    pid["derivative_gain"] = 0.02
    by_proportional, _ = one_stop(stop, oda_train(), proportional)
    by_pid, _ = one_stop(stop, oda_train(), pid)
    assert 0.1 < by_proportional.error_m < 1.0
    assert abs(by_pid.error_m) < by_proportional.error_m / 2.0


def test_a_beacon_takes_the_odometer_error_off() -> None:
    stop = plain_stop(60.0)
    stop["since_fix_m"] = 550.0
    stop["odometer_error"] = 0.01
    without, _ = one_stop(stop, oda_train(), controller(GAIN_PER_S))
    # 1 % of 1000 m
    assert without.error_m == pytest.approx(-10.0, abs=0.2)
    stop["beacons"] = 1
    stop["beacon_m"][0, 0] = 100.0
    with_beacon, _ = one_stop(stop, oda_train(), controller(GAIN_PER_S))
    assert with_beacon.error_m == pytest.approx(-1.0, abs=0.1)


def test_the_trace_is_the_run() -> None:
    stop = plain_stop(60.0)
    result, trace = one_stop(stop, oda_train(), controller(GAIN_PER_S), 2000)
    assert trace.size * 0.1 == pytest.approx(result.time_s)
    assert trace["position_m"][0] == -450.0
    assert trace["estimate_m"] == pytest.approx(trace["position_m"], abs=1e-9)
    assert (np.diff(trace["position_m"]) >= 0.0).all()


@settings(max_examples=60, deadline=None)
@given(
    brake_factor=st.floats(0.3, 1.2),
    odometer_error=st.floats(-0.01, 0.01),
    speed_kmh=st.floats(20.0, 75.0),
    limit_m=st.floats(-50.0, 30.0),
    seen=st.booleans(),
)
def test_the_train_stops_within_its_authority_whatever_the_brake_and_the_sign(
    brake_factor: float, odometer_error: float, speed_kmh: float, limit_m: float, seen: bool
) -> None:
    stop = plain_stop(speed_kmh)
    stop["since_fix_m"] = 550.0
    stop["odometer_error"] = odometer_error
    stop["bound_growth"] = 0.01
    stop["brake_factor"] = brake_factor
    stop["stop_limit_m"] = limit_m
    if seen:
        stop["signs"] = 1
        stop["detection_m"] = 60.0
        stop["frame_s"] = -1.0 / 52.0
    result, _ = one_stop(stop, oda_train(), controller(GAIN_PER_S))
    assert result.within_limit
    assert result.error_m <= limit_m
    if limit_m < 0.0:
        assert result.verdict is not Verdict.POSSIBLE
