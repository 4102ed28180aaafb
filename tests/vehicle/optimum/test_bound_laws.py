"""What the bound takes of the laws is above them: the electric brake on each cell, the ceiling of the speed."""

import math

import numpy as np
import pytest

from tests.rows import Change, Rows
from vehicle.brakes import regenerative_limit_n
from vehicle.mass import equivalent_mass_kg
from vehicle.optimum import Course
from vehicle.optimum.bound import ceilings
from vehicle.optimum.cells import cells_of, corners_mps
from vehicle.optimum.course import EndsNotKept
from vehicle.optimum.laws import law_table, laws_at
from vehicle.optimum.mesh import laid_course
from vehicle.optimum.proof import proven_run
from vehicle.optimum.way import WayTable

LOAD_SHARE = 0.3
PIECES = 400


@pytest.mark.parametrize("power_w", [380e3, 120e3, 60e3])
def test_the_electric_brake_is_nowhere_above_its_chords(
    ev_e301: Rows, changed: Change, power_w: float
) -> None:
    """With 60 kW it is held by its power where it begins to fade in, which bends it down over its chord."""
    train = changed(ev_e301, regenerative_power_max_w=power_w)[0]
    inertia_kg = equivalent_mass_kg(train, LOAD_SHARE)
    cells = cells_of(train, LOAD_SHARE, corners_mps(train, LOAD_SHARE, np.array([18.0])))
    for j in range(len(cells.speed) - 1):
        for share in np.linspace(0.0, 1.0, 11):
            v = float(cells.speed[j] + share * (cells.speed[j + 1] - cells.speed[j]))
            chord = (1.0 - share) * cells.electric[j, 0] + share * cells.electric[j, 1]
            assert regenerative_limit_n(train, v) / inertia_kg <= chord * (1.0 + 1e-12) + 1e-12


def metre_on(train: np.void, z: float, grade: float) -> float:
    """v^2/2 a metre on at full power, the true laws integrated in small pieces, each at its lesser speed."""
    inertia_kg = equivalent_mass_kg(train, LOAD_SHARE)
    for _ in range(PIECES):
        resist_n, pull_n, _ = laws_at(train, LOAD_SHARE, math.sqrt(2.0 * z))
        z = max(z + ((pull_n - resist_n) / inertia_kg - grade) / PIECES, 0.0)
    return z


def test_no_run_that_loses_speed_on_a_climb_is_above_the_ceiling(ev_e301: Rows, changed: Change) -> None:
    """Power-limited from 1 m/s on: what is lost within a metre is worth a good deal of pull."""
    train = changed(ev_e301, traction_power_max_w=60e3)[0]
    table = law_table(train, LOAD_SHARE, 1.0, 18.0)
    grade = 0.9
    least = math.inf
    for speed_mps in np.arange(1.6, 6.0, 0.013):
        z = 0.5 * float(speed_mps) ** 2
        way = WayTable(
            np.array([0.0, 1.0]),
            np.array([0.0, grade]),
            np.array([200.0]),
            np.zeros(1),
            50.0,
            50.0,
            50.0,
            z,
            200.0,
        )
        least = min(least, float(ceilings(way, table)[1]) - metre_on(train, z, grade))
    assert least >= 0.0


def test_a_run_that_would_be_slower_at_its_end_is_refused(ev_e301: Rows) -> None:
    """It has to end at full power, and on the mesh that is a little more than the worse end of a piece gives."""

    def run(final_mps: float) -> Course:
        limit_mps = np.full(402, 25.0)
        return Course(ev_e301[0], LOAD_SHARE, np.zeros(402), limit_mps, 0.0, 400.0, 0.7, 3.0, final_mps)

    slow, fast = run(5.0), run(0.9 * 16.5)
    assert proven_run(slow, 1.2 * laid_course(slow).least_s).gap < 0.02
    with pytest.raises(EndsNotKept, match="speeds asked for at its ends"):
        proven_run(fast, 1.2 * laid_course(fast).least_s)
