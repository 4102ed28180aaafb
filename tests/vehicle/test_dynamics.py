import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.rows import Change, Rows
from vehicle.adhesion import adhesion_coefficient
from vehicle.dynamics import equivalent_mass_kg, step
from vehicle.mass import mass_kg
from vehicle.resistance import curve_resistance_n, gradient_force_n, resistance_n
from vehicle.train_file import new_plant

DT_S = 0.1
commands = st.lists(st.tuples(st.integers(-7, 5), st.integers(1, 20)), min_size=1, max_size=8)


def test_equivalent_mass(ev_e301: Rows) -> None:
    assert equivalent_mass_kg(ev_e301[0], 0.0) == pytest.approx(77_900 * 1.08)
    assert equivalent_mass_kg(ev_e301[0], 1.0) == pytest.approx(92_500 * 1.08)


def test_coasting_on_the_level_decelerates_by_resistance_over_mass(ev_e301: Rows) -> None:
    plant = new_plant(1, 20.0)[0]
    step(plant, ev_e301[0], 0.0, False, 0.0, 0.0, DT_S)
    # equation 3 at 72 km/h: 3.45 N/kN of 764.2 kN + 0.35316 * 72^2 = 4467.3 N; over 84,132 kg
    assert plant["acceleration_mps2"] == pytest.approx(-4467.27 / 84_132, rel=1e-5)


def test_a_gradient_accelerates_by_g_over_the_mass_factor(ev_e301: Rows, changed: Change) -> None:
    plant = new_plant(1, 20.0)[0]
    step(plant, changed(ev_e301, free=True)[0], 0.0, False, -25.0, 0.0, DT_S)
    assert plant["acceleration_mps2"] == pytest.approx(9.81 * 0.025 / 1.08)


@given(
    commands=commands,
    speed=st.floats(5.0, 25.0),
    gradient=st.floats(-25.0, 25.0),
    curvature=st.floats(-1 / 250, 1 / 250),
    load_share=st.floats(0.0, 1.0),
)
def test_energy_balance(
    ev_e301: Rows,
    commands: list[tuple[int, int]],
    speed: float,
    gradient: float,
    curvature: float,
    load_share: float,
) -> None:
    train, plant = ev_e301[0], new_plant(1, speed)[0]
    plant["load_share"] = load_share
    mass = mass_kg(train, load_share)
    work_j = traction_j = regenerated_j = 0.0
    time_s = 0.0
    for notch in (float(notch) for notch, steps in commands for _ in range(steps)):
        before_mps, before_m = plant["speed_mps"], plant["travelled_m"]
        kinetic_j = 0.5 * equivalent_mass_kg(train, load_share) * (before_mps**2 - speed**2)
        assert kinetic_j == pytest.approx(work_j, rel=1e-6, abs=1.0)
        step(plant, train, notch, False, gradient, curvature, DT_S)
        time_s += DT_S
        distance = plant["travelled_m"] - before_m
        traction_j += plant["traction_force_n"] * distance
        regenerated_j += plant["regenerative_force_n"] * distance
        if plant["speed_mps"] == 0.0:
            break  # in the step that stops, the brakes do less work than their force could
        resisting_n = resistance_n(train, mass, before_mps) + curve_resistance_n(train, mass, curvature)
        braking_n = plant["air_force_n"] + plant["regenerative_force_n"]
        net_n = plant["traction_force_n"] - braking_n - resisting_n - gradient_force_n(mass, gradient)
        work_j += net_n * distance
    assert plant["energy_traction_j"] * 0.85 == pytest.approx(traction_j, abs=1e-3)
    assert plant["energy_regenerated_j"] == pytest.approx(regenerated_j * 0.75, abs=1e-3)
    assert plant["energy_auxiliary_j"] == pytest.approx(30_000.0 * time_s)


@given(commands=commands, speed=st.floats(0.0, 25.0), gradient=st.floats(-30.0, 30.0))
def test_distance_is_the_trapezoid_to_the_bit_and_speed_never_negative(
    ev_e301: Rows, commands: list[tuple[int, int]], speed: float, gradient: float
) -> None:
    plant = new_plant(1, speed)[0]
    travelled = 0.0
    for notch in (float(notch) for notch, steps in commands for _ in range(steps)):
        before = float(plant["speed_mps"])
        step(plant, ev_e301[0], notch, False, gradient, 0.0, DT_S)
        after = float(plant["speed_mps"])
        assert after >= 0.0
        travelled += 0.5 * (before + after) * DT_S
        assert plant["travelled_m"] == travelled
        if plant["sliding"] == 0 and plant["wheel_speed_mps"] == after:
            assert plant["wheel_travelled_m"] == pytest.approx(travelled, abs=1e-9)


def test_dead_times_are_counted_in_steps_and_differ(ev_e301: Rows, changed: Change) -> None:
    train = changed(ev_e301, traction_dead_time_s=0.7, brake_dead_time_s=0.3)[0]
    pulling = new_plant(1, 10.0)[0]
    braking = new_plant(1, 10.0)[0]
    pulled, braked = [], []
    for _ in range(10):
        step(pulling, train, 5.0, False, 0.0, 0.0, DT_S)
        step(braking, train, -7.0, False, 0.0, 0.0, DT_S)
        pulled.append(pulling["traction_force_n"] > 0.0)
        braked.append(braking["air_force_n"] + braking["regenerative_force_n"] > 0.0)
    assert pulled == [False] * 7 + [True] * 3
    assert braked == [False] * 3 + [True] * 7


def test_the_first_order_lag_of_hitachis_brake(hitachi: Rows) -> None:
    plant = new_plant(1, 20.0)[0]
    for _ in range(2 + 6):  # 0.2 s dead, then one time constant of 0.6 s
        step(plant, hitachi[0], -9.0, False, 0.0, 0.0, DT_S)
    assert plant["service_deceleration_mps2"] == pytest.approx(5.14 / 3.6 * (1 - math.exp(-1)))


@given(commands=commands)
def test_jerk_limits_hold(ev_e301: Rows, commands: list[tuple[int, int]]) -> None:
    train, plant = ev_e301[0], new_plant(1, 15.0)[0]
    for notch in (float(notch) for notch, steps in commands for _ in range(steps)):
        braking, pulling = plant["service_deceleration_mps2"], plant["traction_built_n"]
        step(plant, train, notch, False, 0.0, 0.0, DT_S)
        assert abs(plant["service_deceleration_mps2"] - braking) <= 2.0 * DT_S + 1e-9
        pull_jerk = abs(plant["traction_built_n"] - pulling) / equivalent_mass_kg(train, 0.0) / DT_S
        assert pull_jerk <= 0.8 + 1e-9


@pytest.mark.parametrize("notch", [-1.0, -4.0, -7.0])
def test_a_notch_brakes_alike_at_any_load(ev_e301: Rows, changed: Change, notch: float) -> None:
    train = changed(ev_e301, free=True)[0]
    decelerations = []
    for load_share in (0.0, 1.0):
        plant = new_plant(1, 25.0)[0]
        plant["load_share"] = load_share
        for _ in range(60):
            step(plant, train, notch, False, 0.0, 0.0, DT_S)
        decelerations.append(-plant["acceleration_mps2"])
    assert decelerations[0] == pytest.approx(decelerations[1], rel=1e-9)
    assert decelerations[0] == pytest.approx(-notch / 7, rel=2e-3)


def test_a_weak_brake_brakes_less(ev_e301: Rows, changed: Change) -> None:
    plant = new_plant(1, 25.0)[0]
    plant["brake_factor"] = 0.9
    for _ in range(60):
        step(plant, changed(ev_e301, free=True)[0], -7.0, False, 0.0, 0.0, DT_S)
    assert plant["acceleration_mps2"] == pytest.approx(-0.9, rel=1e-3)


def test_stopping_distance_from_odas_0_93_mps2(oda: Rows, changed: Change) -> None:
    train, plant, dt_s, speed = changed(oda, free=True)[0], new_plant(1, 20.0)[0], 0.02, 20.0
    for _ in range(3000):
        step(plant, train, -1.0, False, 0.0, 0.0, dt_s)
    ramp_s = 0.93 / 4.65
    expected = speed * 1.0 + speed * ramp_s / 2 - 0.93 * ramp_s**2 / 24 + speed**2 / (2 * 0.93)
    assert plant["speed_mps"] == 0.0
    assert plant["travelled_m"] == pytest.approx(expected, abs=speed * dt_s)


def test_the_emergency_brake_cuts_power_and_is_air_alone(ev_e301: Rows, changed: Change) -> None:
    train, plant = changed(ev_e301, free=True)[0], new_plant(1, 15.0)[0]
    for _ in range(30):
        step(plant, train, 5.0, False, 0.0, 0.0, DT_S)
    for _ in range(40):
        step(plant, train, 5.0, True, 0.0, 0.0, DT_S)
    assert plant["traction_force_n"] < 20.0
    assert plant["regenerative_force_n"] == 0.0
    assert plant["acceleration_mps2"] == pytest.approx(-1.25, rel=2e-3)


@pytest.mark.parametrize("factor", [1.0, 0.8])
def test_an_emergency_brake_that_has_lost_force_brakes_by_what_is_left(
    ev_e301: Rows, changed: Change, factor: float
) -> None:
    train, plant = changed(ev_e301, free=True)[0], new_plant(1, 15.0)[0]
    plant["emergency_factor"] = factor
    for _ in range(70):
        step(plant, train, 0.0, True, 0.0, 0.0, DT_S)
    assert plant["acceleration_mps2"] == pytest.approx(-1.25 * factor, rel=2e-3)


def test_air_supplies_what_the_motors_cannot(ev_e301: Rows) -> None:
    plant = new_plant(1, 25.0)[0]
    for _ in range(400):
        before = float(plant["speed_mps"])
        step(plant, ev_e301[0], -7.0, False, 0.0, 0.0, DT_S)
        asked_n = plant["service_deceleration_mps2"] * 77_900 * 1.08
        assert plant["regenerative_force_n"] + plant["air_force_n"] == pytest.approx(asked_n)
        if before <= 5 / 3.6:
            assert plant["regenerative_force_n"] == 0.0
        if before > 0.0:
            assert plant["regenerative_force_n"] * before <= 380_000.0 * (1 + 1e-9)
    assert plant["speed_mps"] == 0.0
    assert plant["energy_regenerated_j"] > 0.0


@pytest.mark.parametrize("gradient", [-35.0, -25.0, 25.0, 35.0])
def test_a_braked_train_stands_on_a_gradient(ev_e301: Rows, gradient: float) -> None:
    plant = new_plant(1)[0]
    for _ in range(100):
        step(plant, ev_e301[0], -3.0, False, gradient, 0.0, DT_S)
    assert plant["travelled_m"] == 0.0
    assert plant["wheel_travelled_m"] == 0.0


def test_without_brakes_it_rolls_forward_downhill_and_is_held_uphill(ev_e301: Rows) -> None:
    down, up, level = new_plant(3)
    for _ in range(200):
        step(down, ev_e301[0], 0.0, False, -10.0, 0.0, DT_S)
        step(up, ev_e301[0], 0.0, False, 10.0, 0.0, DT_S)
        step(level, ev_e301[0], 0.0, False, -2.0, 0.0, DT_S)
    assert down["speed_mps"] > 0.5
    assert up["travelled_m"] == 0.0
    assert level["travelled_m"] == 0.0  # starting resistance of 3.06 permille holds it


@pytest.mark.parametrize("kind", ["ev_e301", "oda", "br642"])
@pytest.mark.parametrize("gradient", [-20.0, 0.0, 20.0])
@pytest.mark.parametrize("hold", [-1.0, -3.0, -7.0])
def test_a_start_is_no_rougher_than_the_limits_of_jerk(
    request: pytest.FixtureRequest, kind: str, gradient: float, hold: float
) -> None:
    """Brakes let go and motors build up at once; beside them only the falling starting resistance counts (2 %)."""
    train, plant = request.getfixturevalue(kind)[0], new_plant(1)[0]
    for _ in range(30):
        step(plant, train, hold, False, gradient, 0.0, DT_S)
    limit_mps3, before_mps2, worst = float(train["traction_jerk_max_mps3"]), 0.0, 0.0
    released = float(plant["service_deceleration_mps2"])
    for _ in range(80):
        step(plant, train, float(train["power_notches"]), False, gradient, 0.0, DT_S)
        jerk = (plant["acceleration_mps2"] - before_mps2) / DT_S
        letting_go = (released - plant["service_deceleration_mps2"]) / DT_S
        worst = max(worst, jerk - max(limit_mps3, letting_go))
        before_mps2, released = plant["acceleration_mps2"], float(plant["service_deceleration_mps2"])
    assert plant["speed_mps"] > 0.0
    assert worst <= 0.02 * limit_mps3


def _stop_from(train: np.void, speed_mps: float, adhesion: float) -> tuple[float, bool]:
    """Energy regenerated (J) in a stop by full service brake, and whether motors ever braked in a slide."""
    plant = new_plant(1, speed_mps)[0]
    plant["adhesion_factor"] = adhesion
    in_slide = False
    while plant["speed_mps"] > 0.0:
        slides = plant["wheel_speed_mps"] < plant["speed_mps"]
        step(plant, train, -float(train["brake_notches"]), False, 0.0, 0.0, DT_S)
        in_slide |= bool(plant["regenerative_force_n"] > 0.0 and (plant["sliding"] == 1 or slides))
    return float(plant["energy_regenerated_j"]), in_slide


def test_worse_rail_never_gives_more_energy_back(ev_e301: Rows) -> None:
    """Motors do not brake in a slide, so a longer stop on slippery rail regenerates less."""
    results = [_stop_from(ev_e301[0], 65 / 3.6, adhesion) for adhesion in (1.0, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2)]
    energies_j = [energy_j for energy_j, _ in results]
    assert not any(in_slide for _, in_slide in results)
    assert energies_j[0] == energies_j[1]  # nothing slides
    assert all(worse <= better for better, worse in pairwise(energies_j))
    # 0.75 of the kinetic energy at most: 84,132 kg at 18.06 m/s
    assert energies_j[0] < 0.75 * 0.5 * 84_132 * (65 / 3.6) ** 2


@given(speed=st.floats(0.5, 27.0), adhesion=st.floats(0.2, 1.0), notch=st.floats(-7.0, -0.5))
def test_motors_brake_no_more_than_their_axles_hold(
    ev_e301: Rows, changed: Change, speed: float, adhesion: float, notch: float
) -> None:
    """One bogie of two is driven: half of the weight, or a quarter with half of the motors cut out."""
    train = changed(ev_e301, regenerative_force_max_n=1e6, regenerative_power_max_w=1e8)[0]
    for motors_share in (1.0, 0.5):
        plant = new_plant(1, speed)[0]
        plant["adhesion_factor"], plant["motors_share"] = adhesion, motors_share
        for _ in range(20):
            grip = adhesion_coefficient(train, adhesion, plant["speed_mps"])
            step(plant, train, notch, False, 0.0, 0.0, DT_S)
            limit_n = 0.5 * motors_share * 77_900 * 9.81 * grip
            assert plant["regenerative_force_n"] <= limit_n * (1 + 1e-12)


def test_half_of_the_motors_pull_half_as_much_and_take_half_of_the_brake(ev_e301: Rows) -> None:
    forces = []
    for share in (1.0, 0.5):
        pulling, braking = new_plant(1, 15.0)[0], new_plant(1, 15.0)[0]
        pulling["motors_share"] = braking["motors_share"] = share
        for _ in range(40):
            step(pulling, ev_e301[0], 1.0, False, 0.0, 0.0, DT_S)
        for _ in range(12):
            step(braking, ev_e301[0], -7.0, False, 0.0, 0.0, DT_S)
        forces.append((pulling["traction_built_n"], braking["regenerative_force_n"]))
    # 0.2 of 380 kW at about 15 m/s, less as it gains speed; the limit of the electric brake is 380 kW too
    assert forces[1][0] == pytest.approx(0.5 * forces[0][0], rel=0.02)
    assert forces[1][1] == pytest.approx(0.5 * forces[0][1], rel=0.02)
