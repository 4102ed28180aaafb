import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.errors import InputError
from onboard.driving.tuning import (
    DEAD_TIMES,
    OFFSET_STEP_MPS2,
    OFFSET_ZERO,
    OFFSETS,
    SIX_POINTS,
    CharacteristicFit,
    Learned,
    Quadratic,
    StopDecelerations,
    approximate,
    disturbance,
    learned_after_stop,
    learned_from,
    minimum_of,
    quadratic_through,
    search,
    smoothed_wave,
    window,
)

STEPS = 300
coefficients = st.floats(-5.0, 5.0)


def record(
    delay_steps: int, offset_steps: int, slid: bool = False, load_share: float = 0.5
) -> StopDecelerations:
    """A stop of 30 s: a brake that grows within 1 s from second 8 on, answered late and with an offset."""
    designed = 0.7 * np.clip((np.arange(STEPS) - 80) / 10.0, 0.0, 1.0)
    asked = designed > 0.0
    actual = np.zeros(STEPS)
    late = designed + asked * offset_steps * OFFSET_STEP_MPS2
    actual[delay_steps:] = late[: STEPS - delay_steps]
    return StopDecelerations(designed, actual, slid, load_share)


@given(
    a=st.floats(0.1, 5.0), b=st.floats(0.1, 5.0), c=coefficients, d=coefficients, share=st.floats(-0.9, 0.9)
)
def test_equations_5_to_13_give_back_any_bowl(a: float, b: float, c: float, d: float, share: float) -> None:
    z = Quadratic(a, b, c, d, share * 2.0 * float(np.sqrt(a * b)), 1.0)
    points = np.array(SIX_POINTS, dtype=np.float64)
    x, y = points[:, 0], points[:, 1]
    found = quadratic_through(points, z.a * x * x + z.b * y * y + z.c * x + z.d * y + z.e * x * y + z.f)
    assert found == pytest.approx(z, abs=1e-8)
    lowest = minimum_of(z)
    assert lowest is not None
    p, q = lowest
    # equation 12: both slopes vanish
    assert 2.0 * z.a * p + z.c + z.e * q == pytest.approx(0.0, abs=1e-7)
    assert 2.0 * z.b * q + z.d + z.e * p == pytest.approx(0.0, abs=1e-7)


def test_the_six_points_make_the_matrix_regular() -> None:
    x, y = np.array(SIX_POINTS, dtype=np.float64).T
    matrix = np.stack((x * x, y * y, x, y, x * y, np.ones(6)), axis=1)
    assert np.linalg.matrix_rank(matrix) == 6


@pytest.mark.parametrize("z", [Quadratic(-1, -1, 0, 0, 0, 0), Quadratic(1, 1, 0, 0, 3, 0)])
def test_a_saddle_or_a_hill_has_no_minimum(z: Quadratic) -> None:
    assert minimum_of(z) is None


def test_the_grid_is_the_papers() -> None:
    assert DEAD_TIMES * OFFSETS == 441
    last = CharacteristicFit(DEAD_TIMES - 1, OFFSETS - 1, 0.0, 441)
    assert last.dead_time_s == pytest.approx(2.0)
    assert last.offset_mps2 * 3.6 == pytest.approx(1.0)
    assert CharacteristicFit(0, 0, 0.0, 441).offset_mps2 * 3.6 == pytest.approx(-1.0)


@given(delay=st.integers(1, 19), offset=st.integers(-9, 9))
def test_the_search_finds_a_shift_and_an_offset(delay: int, offset: int) -> None:
    fit = search(record(delay, offset))
    assert fit is not None
    assert (fit.dead_time_index, fit.offset_index) == (delay, OFFSET_ZERO + offset)
    assert fit.evaluations == 441


@given(delay=st.integers(4, 16), offset=st.integers(-9, 9), aside=st.integers(-1, 1))
def test_six_points_near_the_truth_find_it_too(delay: int, offset: int, aside: int) -> None:
    fit = approximate(record(delay, offset), (delay + aside, OFFSET_ZERO))
    assert fit is not None
    # J is not quite quadratic in dead time: from the side it may miss by one step of the grid
    assert abs(fit.dead_time_index - delay) <= abs(aside)
    assert fit.offset_index == OFFSET_ZERO + offset
    assert fit.evaluations == 6


def test_from_the_design_the_approximation_comes_to_the_truth_within_a_few_stops() -> None:
    learned = Learned("A", 1.0)
    for _ in range(6):
        stop = record(16, 4)
        learned = learned_after_stop(learned, stop, approximate(stop, learned.centre))
    assert learned.centre == (16, OFFSET_ZERO + 4)
    assert learned.offset_mps2 * 3.6 == pytest.approx(0.4)


def test_smoothing_keeps_a_level_and_a_length() -> None:
    assert smoothed_wave(np.full(50, 0.7)) == pytest.approx(np.full(50, 0.7))


def test_a_stop_without_brake_or_too_short_says_nothing() -> None:
    idle = StopDecelerations(np.zeros(STEPS), np.zeros(STEPS))
    short = StopDecelerations(np.ones(30), np.ones(30))
    for stop in (idle, short):
        assert window(stop) is None
        assert search(stop) is None
        assert approximate(stop, (10, 10)) is None
        assert disturbance(stop, None) == "no minimum"


@pytest.mark.parametrize(
    ("stop", "why"),
    [
        (record(10, 0), None),
        (record(10, 0, slid=True), "slide"),
        (record(10, 0, load_share=1.0), "load"),
        (StopDecelerations(record(10, 0).designed_mps2, record(10, 0).designed_mps2[::-1].copy()), "misfit"),
    ],
)
def test_disturbed_stops_are_left_out_and_counted(stop: StopDecelerations, why: str | None) -> None:
    fit = search(stop)
    assert disturbance(stop, fit) == why
    learned = learned_after_stop(Learned("A", 1.0), stop, fit)
    assert (learned.stops, learned.left_out) == ((1, 0) if why is None else (0, 1))


def test_the_mode_counts_not_the_mean() -> None:
    learned = Learned("A", 1.0)
    for delay in (8, 8, 8, 20, 20):
        learned = learned_after_stop(learned, record(10, 0), CharacteristicFit(delay, OFFSET_ZERO, 0.0, 441))
    assert learned.dead_time_s == pytest.approx(0.8)


def test_a_new_train_has_its_design() -> None:
    learned = Learned("A", 1.2)
    assert (learned.dead_time_s, learned.offset_mps2, learned.centre) == (1.2, 0.0, (12, OFFSET_ZERO))


def test_what_is_learned_is_kept_between_days() -> None:
    learned = learned_after_stop(Learned("A", 1.0), record(13, -3), search(record(13, -3)))
    kept = json.loads(json.dumps(learned.as_dict()))
    assert learned_from("A.json", kept) == learned
    assert learned_from("A.json", json.loads(json.dumps(Learned("B", 0.5).as_dict()))) == Learned("B", 0.5)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("train_id", 7),
        ("design_dead_time_s", 9.0),
        ("left_out", -1),
        ("dead_time_counts", [1, 2]),
        ("offset_counts", [1] + [0] * 20),
        ("last", [30, 1]),
    ],
)
def test_a_spoilt_file_is_named(key: str, value: object) -> None:
    kept = Learned("A", 1.0).as_dict() | {key: value}
    with pytest.raises(InputError, match=f"A.json: {key}"):
        learned_from("A.json", kept)
