"""The run that shuts off once: within its time, under the fastest run, no dearer than any of its kind."""

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle.optimum import Course, TooShort, least_energy, least_time
from vehicle.optimum.coast import coast_down, coast_run, cruise_run, cruising_run, time_and_energy
from vehicle.optimum.mesh import laid_course
from vehicle.train_file import load_train, shipped_train

TRAIN: Any = load_train(shipped_train("ev_e301")).row[0]


def course(*gradients_permille: float, limits_mps: tuple[float, ...] = (20.0,), metres: int = 2000) -> Course:
    """A run of equal parts with these gradients, and of equal parts with these limits."""
    at = np.arange(metres + 2)
    slopes = np.array(gradients_permille)[
        np.minimum(at * len(gradients_permille) // metres, len(gradients_permille) - 1)
    ]
    limits = np.array(limits_mps)[np.minimum(at * len(limits_mps) // metres, len(limits_mps) - 1)]
    climb_m = np.concatenate(([0.0], np.cumsum(slopes[:-1]) * 1e-3))
    return Course(TRAIN, 0.2, climb_m, limits.astype(np.float64), 0.5, metres - 0.25, 0.6)


COURSES = {
    "level": course(0.0),
    "over a hill": course(10.0, -10.0),
    "through a dip": course(-15.0, 15.0),
    "down": course(-20.0),
    "a slow part": course(0.0, limits_mps=(22.0, 12.0, 22.0)),
}


@pytest.mark.parametrize("name", COURSES)
@pytest.mark.parametrize("stretch", [1.0, 1.05, 1.2, 1.6])
def test_it_keeps_its_time_and_costs_no_less_than_the_optimum_nor_more_than_a_held_speed(
    name: str, stretch: float
) -> None:
    asked = COURSES[name]
    least_s = float(least_time(asked).time_s[-1])
    run, plain = coast_run(asked, stretch * least_s), cruise_run(asked, stretch * least_s)
    assert run.time_s <= stretch * least_s * (1.0 + 1e-9)
    assert np.all(run.profile.speed_mps <= np.sqrt(2.0 * laid_course(asked).fastest) + 1e-9)
    assert run.profile.speed_mps[-1] == pytest.approx(0.0, abs=1e-6)
    assert run.energy_j <= plain.energy_j + 1e-6 * abs(plain.energy_j)
    if stretch > 1.0:
        assert run.energy_j >= least_energy(asked, stretch * least_s).energy_j - 5e-3 * abs(run.energy_j)
        assert plain.time_s == pytest.approx(stretch * least_s, rel=1e-4)


def test_beyond_the_place_of_shutting_off_nothing_pulls() -> None:
    run = coast_run(COURSES["level"], 160.0)
    beyond = run.profile.position_m[:-1] >= run.coast_from_m
    assert 300.0 < run.coast_from_m < 1900.0
    assert np.all(run.rim_mps2[beyond] <= 0.0)
    assert np.count_nonzero(run.rim_mps2[beyond] == 0.0) > 100
    assert run.cruise_mps == pytest.approx(run.profile.speed_mps.max())


@pytest.mark.parametrize("name", ["level", "over a hill", "through a dip"])
def test_no_other_speed_and_place_is_cheaper(name: str) -> None:
    asked = COURSES[name]
    found = laid_course(asked)
    time_s = 1.15 * found.least_s
    best_j = math.inf
    laws = (TRAIN, found.inertia_kg, 1.0, found.table, found.way)
    for speed, place in itertools.product(np.linspace(8.0, 20.0, 25), range(0, 2000, 50)):
        z = cruising_run(found.table, found.way, found.fastest, 0.5 * float(speed) ** 2)
        coast_down(found.table, found.way, found.fastest, z, place)
        if np.all(z[1:-1] > 0.0):
            taken_s, energy_j, _ = time_and_energy(*laws, z)
            if taken_s[-1] <= time_s:
                best_j = min(best_j, float(energy_j[-1]))
    assert coast_run(asked, time_s).energy_j <= best_j * 1.01


@given(st.lists(st.floats(-20.0, 20.0), min_size=1, max_size=4), st.floats(1.01, 2.0))
def test_more_time_never_costs_more(gradients: list[float], stretch: float) -> None:
    asked = course(*gradients, metres=1200)
    least_s = float(least_time(asked).time_s[-1])
    sooner, later = (coast_run(asked, factor * least_s) for factor in (stretch, stretch * 1.05))
    scale_j = sum(abs(part) for part in (sooner.energy_j, later.energy_j)) + 1e5
    assert later.energy_j <= sooner.energy_j + 0.01 * scale_j
    assert later.time_s <= stretch * 1.05 * least_s


def test_a_time_too_short_names_the_least() -> None:
    least_s = float(least_time(COURSES["level"]).time_s[-1])
    with pytest.raises(TooShort) as short:
        coast_run(COURSES["level"], least_s - 1.0)
    assert short.value.least_s == pytest.approx(least_s)
