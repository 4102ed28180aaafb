import math
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.rows import Change, Rows
from vehicle.dynamics import step
from vehicle.mass import equivalent_mass_kg, mass_kg
from vehicle.resistance import climb_m, resistance_n
from vehicle.running_time import predicted_course, predicted_run
from vehicle.traction import full_force_n
from vehicle.train_file import new_plant

TRAIN_RUNS = Path(__file__).resolve().parents[2] / "../shared/data/trainruns"
SPEED_MAX_MPS = 120 / 3.6
DECELERATION_MPS2 = 0.4253  # a_braking of local.yaml
LENGTH_M = 41.7


def flat(limit_mps: float = 50.0, length_m: int = 5000) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return np.zeros(length_m + 1), np.full(length_m + 1, limit_mps)


def loaded_br642(br642: Rows, changed: Change) -> Rows:
    """TrainRuns accelerates the loaded mass (88 t) but lets only the empty one (68 t) roll; so do we here."""
    rows = changed(br642)
    resistance = rows["resistance"]
    for name in resistance.dtype.names or ():
        if name.startswith(("motored", "trailer")):
            resistance[name] *= 68.0 / 88.0
    return rows


def read_path(name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Elevation and limit by the metre; a limit holds until the rear has left it."""
    file = TRAIN_RUNS / "paths" / f"{name}.yaml"
    if not file.exists():
        pytest.skip(f"{file.name} of the TrainRuns validation data is not here")
    text = file.read_text(encoding="utf-8").partition("characteristic_sections")[2]
    sections = [
        [float(x) for x in m] for m in re.findall(r"\[\s*([\d.]+),\s*([\d.]+),\s*(-?[\d.]+)\s*\]", text)
    ]
    elevation, limit = np.zeros(10_001), np.full(10_001, SPEED_MAX_MPS)
    for (start, speed_kmh, permille), (end, _, _) in pairwise(sections):
        first, last = int(start), int(end)
        elevation[first + 1 :] += np.clip(np.arange(1, 10_001 - first), 0, last - first) * permille * 1e-3
        cleared = last + math.ceil(LENGTH_M)
        limit[first:cleared] = np.minimum(limit[first:cleared], speed_kmh / 3.6)
    return elevation, limit


@pytest.mark.parametrize(("path", "time_s"), [("const", 391.615), ("slope", 395.515), ("speed", 523.315)])
def test_running_times_of_trainruns_within_1_percent(
    br642: Rows, changed: Change, path: str, time_s: float
) -> None:
    # Ours converge about 0.5 % above: TrainRuns' steps of 20 m hold the start's force too long (next test).
    elevation, limit = read_path(path)
    row = loaded_br642(br642, changed)[0]
    ours_s, _ = predicted_run(row, 1.0, elevation, limit, 0.0, 10_000.0, 50.0, DECELERATION_MPS2, 0.1)
    assert ours_s == pytest.approx(time_s, rel=0.01)


def test_our_laws_with_trainruns_steps_of_20_m_give_its_time_to_a_hundredth(
    br642: Rows, changed: Change
) -> None:
    row = loaded_br642(br642, changed)[0]
    mass, inertia = mass_kg(row, 1.0), equivalent_mass_kg(row, 1.0)
    speed = position = time_s = 0.0
    while speed < SPEED_MAX_MPS:
        net_n = full_force_n(row, 1.0, speed) - resistance_n(row, mass, speed)
        after = math.sqrt(speed**2 + 2 * net_n / inertia * 20.0)
        time_s += 40.0 / (speed + after)
        speed, position = min(after, SPEED_MAX_MPS), position + 20.0
    braking_m = speed**2 / (2 * DECELERATION_MPS2)
    time_s += (10_000.0 - position - braking_m) / speed + speed / DECELERATION_MPS2
    assert time_s == pytest.approx(391.615, abs=0.02)


def test_a_run_without_resistance_in_closed_form(ev_e301: Rows, changed: Change) -> None:
    row = changed(
        ev_e301,
        free=True,
        traction_power_max_w=1e9,
        regenerative_force_max_n=0.0,
        auxiliary_power_w=0.0,
    )[0]
    time_s, energy_j = predicted_run(row, 0.0, *flat(), 0.0, 5000.0, 15.0, 0.7, 0.1)
    acceleration = 48_000.0 / 84_132.0
    assert time_s == pytest.approx(5000 / 15 + 15 / (2 * acceleration) + 15 / (2 * 0.7), abs=0.02)
    assert energy_j == pytest.approx(0.5 * 84_132 * 15.0**2 / 0.85, rel=1e-6)


def test_auxiliaries_and_regeneration_are_in_the_energy(ev_e301: Rows, changed: Change) -> None:
    plain = changed(ev_e301, auxiliary_power_w=0.0, regenerative_force_max_n=0.0)[0]
    with_auxiliaries = changed(ev_e301, regenerative_force_max_n=0.0)[0]
    time_s, bare_j = predicted_run(plain, 0.5, *flat(), 0.0, 3000.0, 18.0, 0.7, 0.5)
    _, more_j = predicted_run(with_auxiliaries, 0.5, *flat(), 0.0, 3000.0, 18.0, 0.7, 0.5)
    assert more_j - bare_j == pytest.approx(30_000.0 * time_s)
    _, net_j = predicted_run(ev_e301[0], 0.5, *flat(), 0.0, 3000.0, 18.0, 0.7, 0.5)
    kinetic_j = 0.5 * equivalent_mass_kg(ev_e301[0], 0.5) * 18.0**2
    assert more_j - 0.75 * kinetic_j < net_j < more_j - 0.3 * 0.75 * kinetic_j


def test_a_lower_limit_is_braked_for_by_the_constant_deceleration(ev_e301: Rows, changed: Change) -> None:
    row = changed(ev_e301, free=True, traction_power_max_w=1e9)[0]
    elevation, limit = flat(15.0)
    limit[2000:2500] = 10.0
    time_s, _ = predicted_run(row, 0.0, elevation, limit, 0.0, 5000.0, 50.0, 0.5, 0.1)
    up, down = 48_000.0 / 84_132.0, 0.5
    expected = 15 / up / 2 + 15 / down / 2 + 4500 / 15 + 500 / 10
    for a in (up, down):  # each change between 10 and 15 m/s, against having run it at 15 m/s
        expected += 5 / a - (15**2 - 10**2) / (2 * a) / 15
    assert time_s == pytest.approx(expected, abs=0.1)


def test_a_gradient_too_steep_gives_an_infinite_time(ev_e301: Rows) -> None:
    elevation = np.linspace(0.0, 1000.0, 5001)
    assert predicted_run(ev_e301[0], 1.0, elevation, flat()[1], 100.0, 5000.0, 15.0, 0.7, 0.5)[0] == math.inf


def test_nothing_to_run_takes_no_time(ev_e301: Rows) -> None:
    assert predicted_run(ev_e301[0], 0.0, *flat(), 100.0, 100.0, 15.0, 0.7, 0.5)[0] == 0.0


@given(
    start=st.floats(0.0, 2000.0),
    leg=st.floats(1.0, 2900.0),
    cruise=st.floats(5.0, 24.0),
    deceleration=st.floats(0.3, 1.0),
    dt_s=st.sampled_from([0.1, 0.5, 1.0]),
    limits=st.lists(st.floats(5.0, 27.0), min_size=10, max_size=10),
    permille=st.lists(st.floats(-25.0, 25.0), min_size=10, max_size=10),
)
def test_every_leg_ends_and_no_faster_than_its_limits(
    ev_e301: Rows,
    start: float,
    leg: float,
    cruise: float,
    deceleration: float,
    dt_s: float,
    limits: list[float],
    permille: list[float],
) -> None:
    limit = np.append(np.repeat(limits, 500), limits[-1])
    elevation = np.append(0.0, np.cumsum(np.repeat(permille, 500) * 1e-3))
    run = (ev_e301[0], 0.5, elevation, limit, start, start + leg)
    time_s, energy_j = predicted_run(*run, cruise, deceleration, dt_s)
    assert math.isfinite(time_s) and math.isfinite(energy_j)
    assert time_s >= leg / min(cruise, max(limits)) - dt_s
    slower_s, _ = predicted_run(*run, 0.8 * cruise, deceleration, dt_s)
    assert slower_s >= time_s - dt_s


def test_a_run_from_speed(ev_e301: Rows) -> None:
    rolling_s, _ = predicted_run(ev_e301[0], 0.0, *flat(), 0.0, 3000.0, 15.0, 0.7, 0.1, 15.0)
    assert rolling_s == pytest.approx(3000 / 15 + 15 / (2 * 0.7), abs=0.1)


@pytest.mark.parametrize("radius_m", [200.0, 400.0])
def test_curves_count_as_the_plant_feels_them(ev_e301: Rows, radius_m: float) -> None:
    """600 / R permille (R = 200 m: 3.0): time and energy as on that gradient, and as the plant in the curve."""
    train = ev_e301[0]
    level, limit = flat(60 / 3.6)
    turn_rad = np.arange(level.size) / radius_m
    run = (limit, 100.0, 3100.0, 50.0, 0.6, 0.5)
    in_curve = predicted_run(train, 0.0, climb_m(ev_e301.view(np.recarray)[0], level, turn_rad), *run)
    uphill = predicted_run(train, 0.0, np.arange(level.size) * 0.6 / radius_m, *run)
    straight = predicted_run(train, 0.0, level, *run)
    assert in_curve == pytest.approx(uphill, rel=1e-9)
    assert in_curve[0] > straight[0]
    # work against it: 600 / R permille of the weight over 3 km, at the wire; a little comes back in braking
    work_j = 77_900 * 9.81 * 0.6 / radius_m * 3000.0 / 0.85
    assert in_curve[1] - straight[1] == pytest.approx(work_j, rel=0.1)
    plant = new_plant(1, 10.0)[0]
    step(plant, train, 0.0, False, 0.0, 1.0 / radius_m, 0.1)
    curved_mps2 = float(plant["acceleration_mps2"])
    plant = new_plant(1, 10.0)[0]
    step(plant, train, 0.0, False, 600.0 / radius_m, 0.0, 0.1)
    assert curved_mps2 == pytest.approx(float(plant["acceleration_mps2"]))


def test_no_train_is_predicted_to_pull_more_than_its_driven_axles_hold(
    ev_e301: Rows, changed: Change
) -> None:
    """Half of the weight at 0.245: 1.11 m/s2 at rest, however strong the motors are."""
    strong = changed(ev_e301, traction_force_max_n=1e6, traction_power_max_w=1e8)[0]
    time_s, _ = predicted_run(strong, 0.0, *flat(100 / 3.6), 100.0, 1100.0, 50.0, 1.0, 0.1)
    # a triangle of speeds, if it reaches the limit
    best_s = math.sqrt(2.0 * 1000.0 * (1.0 / 1.11 + 1.0 / 1.0))
    assert time_s > best_s


@pytest.mark.parametrize("until_m", [300.0, 1480.5, 1700.0, 1999.5, 2600.0])
def test_a_place_on_the_way_is_passed_as_on_the_whole_run(br642: Rows, until_m: float) -> None:
    """Slow track from 2000 m on: before it the train brakes for what lies beyond the place."""
    elevation, limit = flat(30.0, 6000)
    limit[2000:2400] = 8.0
    run = br642[0], 0.5, elevation, limit, 10.0, 5500.5, 25.0, 0.6, 0.5
    times_s, fronts_m, _ = predicted_course(*run).T
    k = int(np.searchsorted(fronts_m, until_m)) - 1
    share = (until_m - fronts_m[k]) / (fronts_m[k + 1] - fronts_m[k])
    assert predicted_run(*run, until_m=until_m)[0] == pytest.approx(times_s[k] + 0.5 * share, abs=1e-9)


@pytest.mark.parametrize(
    ("permille", "loses_mps2"), [(0.0, 0.0), (-10.0, 0.0), (10.0, 0.0981 * 77_900 / 84_132)]
)
def test_who_is_faster_than_meant_rolls(
    ev_e301: Rows, changed: Change, permille: float, loses_mps2: float
) -> None:
    """Without resistance from 15 m/s, where 10 are meant: kept on the level and downhill, lost uphill by the climb."""
    _, limit = flat()
    row = changed(ev_e301, free=True)[0]
    run = (
        row,
        0.0,
        np.arange(limit.size) * permille * 1e-3,
        limit,
        100.0,
        4000.0,
        10.0,
        0.7,
        0.1,
        15.0,
        1600.0,
    )
    rolled_m = min((15.0**2 - 10.0**2) / (2.0 * loses_mps2), 1500.0) if loses_mps2 else 1500.0
    mean_mps = 0.5 * (15.0 + (10.0 if loses_mps2 else 15.0))
    assert predicted_run(*run, rolls=True)[0] == pytest.approx(
        rolled_m / mean_mps + (1500.0 - rolled_m) / 10.0, abs=0.1
    )
    braked_m = (15.0**2 - 10.0**2) / (2.0 * 0.7)
    assert predicted_run(*run)[0] == pytest.approx(braked_m / 12.5 + (1500.0 - braked_m) / 10.0, abs=0.1)
