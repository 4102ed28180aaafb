from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from papers.reproduction import Options
from papers.stop_set import (
    BRAKES,
    MARGIN_M,
    QUICK_GRID,
    RANGES,
    SPEED_LEAST_MPS,
    WINDOW_M,
    StopSet,
    beyond_the_grid_m,
    lowest_shares,
    outer_distances_m,
    random_brakes,
    stop_bench,
    stop_set,
    stops_from,
)
from papers.stop_window import chart, reproduce
from radio.chance import generator

TO_MPS = 13.0  # of the set in every run; by night it is computed up to 25 m/s


@pytest.fixture(scope="module")
def found() -> StopSet:
    return stop_set(replace(QUICK_GRID, to_mps=TO_MPS))


@pytest.mark.nightly
def test_the_short_slice_passes_and_says_that_it_is_short() -> None:
    result = reproduce(Options(quick=True))
    assert [row.case for row in result.rows if not row.passed] == []
    assert "short slice" in result.remarks[-1]
    assert all(parameter.origin for parameter in result.parameters)


@pytest.mark.nightly
def test_of_100_000_stops_from_the_set_all_end_in_the_window() -> None:
    result = reproduce(Options(seed=2))
    assert [row.case for row in result.rows if not row.passed] == []
    assert result.rows[0].ours == "100,000 of 100,000"


def test_the_edge_is_one_step_beyond_where_from_on_up_everything_is_held() -> None:
    """With 0.1 m of the window kept for the grid: a miss at a share counts against all below it."""
    shares = np.linspace(0.0, 1.0, 5)
    held = [0.5] * 5
    most = np.array([[1.4, 0.91, 0.89, 0.7, 0.6], held, held, [0.5, 0.5, 0.5, 0.95, 0.5]])
    least = np.array([[0.0] * 5, [-0.5] * 5, [0.0, 0.0, 0.0, 0.0, -0.95], [0.0] * 5])
    assert pytest.approx(0.1) == MARGIN_M
    assert lowest_shares(shares, least, most).tolist() == [0.75, 0.25, np.inf, np.inf]


def test_what_any_law_needs_is_the_weakest_brake_fully_asked_for() -> None:
    """From v: v (dead time + lag) + v^2 / 2 b, less the window; faster, the rail gives less than the brake asks for."""
    speeds = np.array([5.0, 15.0])
    lost_m = speeds * (RANGES["dead_time"].high + RANGES["lag"].high) - WINDOW_M
    brake_mps2 = 0.93 * RANGES["brake"].low
    # oda_train: least at the beginning
    rail_mps2 = 0.245 / (1.0 + 0.030 * 15.0) * RANGES["adhesion"].low * 9.81
    slow_m, fast_m = outer_distances_m(speeds)
    assert slow_m == pytest.approx(lost_m[0] + 5.0**2 / (2.0 * brake_mps2), rel=0.03)
    assert lost_m[1] + 15.0**2 / (2.0 * brake_mps2) < fast_m < lost_m[1] + 15.0**2 / (2.0 * rail_mps2)


def test_nothing_nearer_than_what_any_law_needs_is_in_the_set(found: StopSet) -> None:
    assert (found.lowest[np.isfinite(found.lowest)] >= 0.0).all()
    assert (found.begin_m > found.outer_m).all()
    weakest = (RANGES["dead_time"].high, RANGES["lag"].high, RANGES["brake"].low)
    speeds = np.array([6.0, 9.0, 12.0])
    nearer = found.distance_m(np.zeros(3), speeds) - 0.5
    outcomes, _ = stop_bench().run(
        stops_from(nearer, speeds, np.tile(np.array(weakest), (3, 1)), np.full(3, RANGES["adhesion"].low))
    )
    assert (outcomes["error_m"] > WINDOW_M).all()


def test_states_and_their_shares_agree(found: StopSet) -> None:
    speeds = np.array([7.3, 12.0])
    assert found.distance_m(np.zeros(2), speeds)[1] == pytest.approx(found.outer_m[11])
    assert found.distance_m(np.ones(2), speeds)[1] == pytest.approx(found.begin_m[11])
    assert found.least_share(np.array([7.3]))[0] == max(found.lowest[6], found.lowest[7])
    least, most = found.spanned_m(np.array([0.52]), np.array([7.3]))
    assert least[0] == found.least_m[6:8, 10:12].min()
    assert most[0] == found.most_m[6:8, 10:12].max()


def test_between_the_points_of_the_grid_stops_stay_within_what_it_spans(found: StopSet) -> None:
    assert 2.0 * beyond_the_grid_m(found, generator(7, "test"), 1000) <= MARGIN_M


@given(
    speed_mps=st.floats(SPEED_LEAST_MPS, TO_MPS - 1.0),
    above=st.floats(0.0, 1.0),
    places=st.tuples(*(st.floats(0.0, 1.0) for _ in RANGES)),
)
def test_whatever_the_brake_a_stop_from_the_set_ends_in_the_window(
    found: StopSet, speed_mps: float, above: float, places: tuple[float, ...]
) -> None:
    speed = np.array([speed_mps])
    lowest = found.least_share(speed)
    distance = found.distance_m(lowest + above * (1.0 - lowest), speed)
    values = [
        within.low + place * (within.high - within.low)
        for within, place in zip(RANGES.values(), places, strict=True)
    ]
    outcomes, _ = stop_bench().run(stops_from(distance, speed, np.array([values[:3]]), np.array(values[3:])))
    assert abs(float(outcomes["error_m"][0])) <= WINDOW_M


def test_brakes_are_drawn_over_their_ranges_and_at_their_ends() -> None:
    brakes, adhesions = random_brakes(generator(1, "test"), 4000)
    for column, within in zip((*brakes.T, adhesions), RANGES.values(), strict=True):
        assert column.min() == within.low
        assert column.max() == within.high
        assert np.mean((column == within.low) | (column == within.high)) == pytest.approx(1 / 11, abs=0.02)
    assert len(BRAKES) == 5 * 3 * 3


def test_a_dead_time_is_the_whole_steps_nearest_to_it(found: StopSet) -> None:
    """So five values are all that there are of the range."""
    speed = np.full(3, 10.0)
    distance = found.distance_m(np.full(3, 0.8), speed)
    brakes = np.array([[0.96, 0.3, 1.0], [1.0, 0.3, 1.0], [1.04, 0.3, 1.0]])
    outcomes, _ = stop_bench().run(stops_from(distance, speed, brakes, np.ones(3)))
    assert len(set(outcomes["error_m"].tolist())) == 1


def test_the_figure_is_written_twice_and_says_what_it_shows(found: StopSet, tmp_path: Path) -> None:
    missed = np.array([100.0]), np.array([12.0])
    svg, png = chart(found, missed).write(tmp_path / "new")
    assert svg.read_text("utf-8").startswith("<?xml")
    assert png.read_bytes()[:4] == b"\x89PNG"
    assert chart(found, missed).write(tmp_path / "again")[1].read_bytes() == png.read_bytes()
