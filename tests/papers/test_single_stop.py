import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.driving.tasc import StopVerdict
from onboard.driving_settings import Driving
from onboard.records import EMERGENCY_INTERVENTION
from onboard.unit_records import UnitParameters
from papers.carried_train import CarriedTrain
from papers.parameter_sets import coasting
from papers.single_train import Bench
from papers.table4_stops import PATTERN_MPS2, controller, oda_train, plain_stop

GAIN_PER_S = 0.6


@pytest.mark.parametrize("speed_kmh", [20.0, 40.0, 60.0, 80.0])
@pytest.mark.parametrize("gradient_permille", [-10.0, 0.0, 10.0])
def test_without_errors_the_train_stops_at_the_mark(speed_kmh: float, gradient_permille: float) -> None:
    stop = plain_stop(speed_kmh)
    # uphill a long run up would end before it
    stop["start_m"] = 40.0 + (speed_kmh / 3.6) ** 2 / (2.0 * PATTERN_MPS2)
    stop["gradient_permille"] = gradient_permille
    stop["gradient_believed_permille"] = gradient_permille
    result, _ = controller(GAIN_PER_S).single_stop(stop)
    assert abs(result.error_m) < 0.05
    assert result.verdict == StopVerdict.POSSIBLE
    assert result.intervention != EMERGENCY_INTERVENTION


def test_the_final_stop_is_soft() -> None:
    result, trace = controller(GAIN_PER_S).single_stop(plain_stop(70.0), 2000)
    # at rest little more ends than the 0.3 m/s^2 and running resistance that the pattern leaves
    assert result.rest_mps2 < 0.5
    assert result.deceleration_max_mps2 < 0.93 + 0.1
    moving = trace[trace["speed_mps"] > 0.1]
    jerk = np.diff(-moving["acceleration_mps2"][-40:]) / 0.1
    assert np.abs(jerk).max() < 1.0


def test_a_weak_brake_leaves_proportional_following_past_the_mark_and_pid_nearer() -> None:
    stop = plain_stop(60.0)
    stop["brake_factor"] = 0.93
    proportional = controller(GAIN_PER_S, 0.7)
    pid = controller(GAIN_PER_S, 0.7)
    pid.design.integral_gain_per_s2 = 0.1
    pid.design.derivative_gain = 0.02
    by_proportional, _ = proportional.single_stop(stop)
    by_pid, _ = pid.single_stop(stop)
    assert 0.1 < by_proportional.error_m < 1.0
    assert abs(by_pid.error_m) < by_proportional.error_m / 2.0


def test_a_beacon_takes_the_odometer_error_off() -> None:
    stop = plain_stop(60.0)
    stop["since_fix_m"] = 550.0
    stop["count_error"] = 0.01
    without, _ = controller(GAIN_PER_S).single_stop(stop)
    # 1 % of 1000 m
    assert without.error_m == pytest.approx(-10.0, abs=0.2)
    stop["beacons"] = 1
    stop["beacon_m"][0, 0] = 100.0
    with_beacon, _ = controller(GAIN_PER_S).single_stop(stop)
    assert with_beacon.error_m == pytest.approx(-1.0, abs=0.1)


def test_the_trace_is_the_run() -> None:
    stop = plain_stop(60.0)
    result, trace = controller(GAIN_PER_S).single_stop(stop, 2000)
    assert trace.size * 0.1 == pytest.approx(result.time_s)
    assert trace["position_m"][0] == pytest.approx(-450.0 + 60.0 / 3.6 * 0.1, abs=0.001)  # one step later
    assert trace["position_m"][-1] == pytest.approx(result.error_m)
    assert trace["estimate_error_m"] == pytest.approx(0.0, abs=1e-9)
    assert (np.diff(trace["position_m"]) >= 0.0).all()


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
    stop["count_error"] = odometer_error
    stop["brake_factor"] = brake_factor
    stop["stop_limit_m"] = limit_m
    if seen:
        stop["signs"] = 1
        stop["detection_m"] = 60.0
        stop["frame_s"] = -1.0 / 52.0
    result, _ = controller(GAIN_PER_S).single_stop(stop)
    assert result.within_limit
    assert result.error_m <= limit_m
    if limit_m < 0.0:
        assert result.verdict != StopVerdict.POSSIBLE


def test_step_by_step_on_the_plain_carrier_the_stop_is_the_same() -> None:
    stop = plain_stop(50.0)
    stop["gradient_permille"] = stop["gradient_believed_permille"] = -5.0
    bench = controller(GAIN_PER_S)
    at_once, trace = bench.single_stop(stop, 2000)
    train = CarriedTrain(bench, stop)
    speeds = []
    while not train.stands:
        train.step()
        speeds.append(float(train.row.plant.speed_mps))
    assert speeds == trace["speed_mps"].tolist()
    assert train.past_mark_m == at_once.error_m


def test_many_stops_are_each_as_if_made_alone() -> None:
    bench = controller(GAIN_PER_S)
    stops = np.concatenate([plain_stop(speed_kmh) for speed_kmh in (70.0, 30.0, 50.0)])
    stops["gradient_permille"] = (5.0, 0.0, -5.0)
    together, _ = bench.run(stops)
    alone = [bench.single_stop(stops[i : i + 1])[0].error_m for i in range(3)]
    assert together["error_m"].tolist() == alone


def test_a_beacon_that_cannot_be_where_it_is_read_is_refused() -> None:
    stop = plain_stop(60.0)
    stop["beacons"] = 1
    stop["beacon_m"][0, 0] = 100.0
    stop["beacon_error_m"][0, 0] = 50.0
    outcomes, _ = controller(GAIN_PER_S).run(stop)
    assert outcomes["refused"][0] == 1
    assert abs(outcomes["error_m"][0]) < 0.05


def test_a_tachometer_counts_whole_pulses() -> None:
    """860 mm and 60 pulses a turn: what is counted lies within a pulse (45.03 mm) behind what was run."""
    train = oda_train()
    bench = Bench(train, coasting(Driving()), UnitParameters(), pulses=True)
    result, trace = bench.single_stop(plain_stop(60.0), 2000)
    behind_m = -trace["estimate_error_m"]
    pulse_m = np.pi * 0.860 / 60
    assert behind_m.min() >= -1e-9
    assert 0.95 * pulse_m < behind_m.max() < pulse_m
    assert abs(result.error_m) < 0.05 + pulse_m
    assert bench.run(plain_stop(60.0))[0]["out_of_bounds_m"][0] <= 0.0


def test_on_any_rail_the_front_stays_within_bounds() -> None:
    """Dry to oily (adhesion 0.04 at rest), empty to full: wheels slide in a third of these stops."""
    rng = np.random.default_rng(1)
    stops = np.concatenate([plain_stop(float(speed_kmh)) for speed_kmh in rng.uniform(20.0, 85.0, 1000)])
    stops["adhesion_factor"] = rng.uniform(0.15, 1.0, stops.size)
    stops["load_share"] = rng.uniform(0.0, 1.0, stops.size)
    outcomes, _ = controller(GAIN_PER_S).run(stops)
    assert (outcomes["slid_steps"] > 0).sum() > 200
    assert (outcomes["out_of_bounds_m"] <= 0.0).all()


def test_wheels_that_slide_are_ridden_over() -> None:
    """Rails that carry less than the pattern: the unit's estimate stays within bounds that it widened itself."""
    stop = plain_stop(60.0)
    stop["adhesion_factor"] = 0.35
    outcomes, _ = controller(GAIN_PER_S).run(stop)
    assert outcomes["slid_steps"][0] > 0
    assert outcomes["out_of_bounds_m"][0] <= 0.0
