"""The law `driver`: habits that are drawn, how they show on a hop, and how much drivers scatter."""

import numpy as np
import pytest

from onboard.driving.laws.driver import DRAWN, Driver
from onboard.driving.laws.settings import LawTables
from onboard.records import NO_INTERVENTION
from papers.driver_scatter import DEFAULT_FACTOR, SIGMAS, DriverScatter, scatter, widened_habits
from papers.single_hop import HopBench, one_gradient
from papers.single_run import STEPS_MAX, Rows, new_hops
from papers.yasunobu_train import HOP_M, paper_bench


def ridden(
    gradient_permille: float = 0.0,
    order_s: float = 90.0,
    habits: Driver | None = None,
    length_m: float = HOP_M,
    **drawn: float,
) -> tuple[np.void, Rows]:
    """A hop of a driver whose habits are that many deviations off the mean."""
    tables = LawTables.model_validate({"driver": habits or widened_habits(1.0)})
    bench = paper_bench("driver", tables, lambda _law, field: drawn.get(field, 0.0))
    outcomes, trace = HopBench(bench, one_gradient(length_m, gradient_permille)).run(
        new_hops([order_s]), STEPS_MAX
    )
    return outcomes[0], trace


@pytest.fixture(scope="module")
def forty() -> DriverScatter:
    return scatter(Driver(), 40)


def test_the_defaults_are_the_calibrated_ones() -> None:
    for name in SIGMAS:
        assert getattr(Driver(), name) == pytest.approx(
            getattr(widened_habits(DEFAULT_FACTOR), name), abs=1e-9
        )


def test_drivers_scatter_by_about_a_tenth_at_equal_punctuality_and_without_spread_not_at_all(
    forty: DriverScatter,
) -> None:
    assert 0.07 <= forty.sigma_share <= 0.13
    assert forty.late <= 2
    assert scatter(widened_habits(0.0), 3).sigma_share == 0.0


def test_the_same_seed_draws_the_same_drivers() -> None:
    first, again, other = (scatter(Driver(), 4, seed).energies_kwh.tolist() for seed in (1, 1, 2))
    assert first == again
    assert first != other


@pytest.mark.parametrize("gradient_permille", [-10.0, 0.0, 10.0])
@pytest.mark.parametrize("field", DRAWN)
@pytest.mark.parametrize("deviations", [-2.0, 2.0])
def test_whatever_the_habit_the_train_stops_at_the_mark(
    gradient_permille: float, field: str, deviations: float
) -> None:
    outcome, _ = ridden(gradient_permille, 95.0, **{field: deviations})
    assert abs(outcome["error_m"]) < 0.5
    assert outcome["intervention"] == NO_INTERVENTION


def test_habits_show() -> None:
    """Power taken hard, coasting begun early, a soft brake: each moves what it is about."""
    soft, hard = ridden(power_drawn=-2.0)[1], ridden(power_drawn=2.0)[1]
    assert soft["notch"].max() < hard["notch"].max()
    early, late = ridden(coast_drawn=1.0)[0], ridden(coast_drawn=-1.5)[0]
    assert early["energy_traction_j"] <= late["energy_traction_j"]
    gentle, firm = ridden(brake_drawn=-2.0)[1], ridden(brake_drawn=0.5)[1]
    begins = [float(trace["position_m"][trace["notch"] < 0.0][0]) for trace in (gentle, firm)]
    assert begins[0] < begins[1] - 30.0


def test_a_driver_who_is_late_takes_power_again() -> None:
    """His time passes while he runs on a climb with soft power: he hurries, unless he does not catch up at all."""
    hurried, trace = ridden(10.0, 85.0, power_drawn=-2.0)
    calm, _ = ridden(
        10.0, 85.0, Driver(**{**widened_habits(1.0).model_dump(), "catches_up": False}), power_drawn=-2.0
    )
    assert hurried["speed_max_mps"] > calm["speed_max_mps"] + 0.5
    assert hurried["power_changes"] > calm["power_changes"]
    assert hurried["time_s"] < calm["time_s"] - 1.0
    assert trace["speed_mps"].max() <= trace["permitted_mps"].max()


@pytest.mark.parametrize("gradient_permille", [-10.0, 0.0, 25.0])
@pytest.mark.parametrize("length_m", [25.0, 40.0])
def test_a_start_just_short_of_the_mark_is_one_move(gradient_permille: float, length_m: float) -> None:
    """TASC alone would have it pull a little, roll out and stand, again and again."""
    outcome, trace = ridden(gradient_permille, 60.0, length_m=length_m)
    moves = trace["speed_mps"][: int(outcome["steps"])] > 0.0
    assert int(np.count_nonzero(np.diff(moves.astype(int)) > 0)) <= 1
    assert outcome["time_s"] < 30.0
    assert outcome["speed_max_mps"] < 5.0
    assert abs(outcome["error_m"]) < 0.5


def test_a_driver_whose_wheels_slip_takes_less_power_and_a_notch_more_when_they_roll() -> None:
    """Full notch takes 0.74 of the dry rail's grip: on half of that grip wheels slip in the sixth of seven
    notches, which he takes at the start, and roll in the third.
    """
    bench = paper_bench("driver", LawTables.model_validate({"driver": widened_habits(0.0)}), lambda *_: 0.0)
    hops = new_hops([95.0])
    hops["adhesion_factor"] = 0.5
    outcomes, trace = HopBench(bench, one_gradient(HOP_M, 0.0)).run(hops, STEPS_MAX)
    start = trace["notch"][:300].tolist()
    assert start[0] == 6.0
    assert min(start) <= 3.0
    assert max(start[start.index(min(start)) :]) > min(start)
    assert outcomes[0]["slid_steps"] < 0.15 * outcomes[0]["steps"]
