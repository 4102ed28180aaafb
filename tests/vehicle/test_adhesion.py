import pytest

from tests.rows import Change, Rows
from vehicle.adhesion import adhesion_coefficient, bounded_slip_mps, next_slip_mps, rotating_mass_kg
from vehicle.dynamics import step
from vehicle.train_file import new_plant

DT_S = 0.1


def test_adhesion_falls_with_speed_and_weather(ev_e301: Rows) -> None:
    train = ev_e301[0]
    assert adhesion_coefficient(train, 1.0, 0.0) == pytest.approx(0.245)
    # direct-current multiple units of the national railways: 0.245 (1 + 0.05 V) / (1 + 0.1 V) at 100 km/h
    assert adhesion_coefficient(train, 1.0, 100 / 3.6) == pytest.approx(0.245 * 6 / 11, rel=0.01)
    assert adhesion_coefficient(train, 0.4, 10.0) == pytest.approx(
        0.4 * adhesion_coefficient(train, 1.0, 10.0)
    )


def test_excess_spins_up_the_rotating_mass_and_spare_brings_it_back() -> None:
    assert next_slip_mps(0.0, 4000.0, 0.0, 8000.0, DT_S) == pytest.approx(0.05)
    assert next_slip_mps(0.0, -4000.0, 0.0, 8000.0, DT_S) == pytest.approx(-0.05)
    assert next_slip_mps(-1.0, 0.0, 16_000.0, 8000.0, DT_S) == pytest.approx(-0.8)
    assert next_slip_mps(-0.1, 0.0, 16_000.0, 8000.0, DT_S) == 0.0
    assert next_slip_mps(0.1, 0.0, 16_000.0, 8000.0, DT_S) == 0.0


def test_protection_bounds_the_slide_and_a_wheel_never_turns_backwards(
    ev_e301: Rows, changed: Change
) -> None:
    assert bounded_slip_mps(ev_e301[0], -15.0, 20.0) == pytest.approx(-6.0)
    unprotected = changed(ev_e301, wheel_slide_share_max=1.0)[0]
    assert bounded_slip_mps(unprotected, -15.0, 10.0) == -10.0
    assert rotating_mass_kg(changed(ev_e301, rotating_mass_factor=0.0)[0], 1000.0) > 0.0


def test_a_slide_caps_the_brake_cheats_the_tachometer_and_heals(ev_e301: Rows) -> None:
    plants = new_plant(1, 25.0)
    plant, train = plants[0], ev_e301[0]
    plant["adhesion_factor"] = 0.2
    slid = 0
    for _ in range(60):
        limit_n = 77_900 * 9.81 * adhesion_coefficient(train, 0.2, plant["speed_mps"])
        step(plant, train, -7.0, False, 0.0, 0.0, DT_S)
        assert plant["air_force_n"] + plant["regenerative_force_n"] <= limit_n * (1 + 1e-12)
        if plant["sliding"]:
            slid += 1
            assert plant["wheel_speed_mps"] < plant["speed_mps"]
    assert slid > 30
    assert plant["wheel_travelled_m"] < plant["travelled_m"] - 5.0
    lost_m = plant["travelled_m"] - plant["wheel_travelled_m"]
    plant["adhesion_factor"] = 1.0
    for _ in range(30):
        step(plant, train, -2.0, False, 0.0, 0.0, DT_S)
    assert plant["sliding"] == 0
    assert plant["wheel_speed_mps"] == plant["speed_mps"]
    recovered_m = plant["travelled_m"] - plant["wheel_travelled_m"]
    assert lost_m < recovered_m < lost_m + 5.0


def test_a_slip_caps_the_traction_by_the_motored_axles(ev_e301: Rows) -> None:
    plants = new_plant(1, 3.0)
    plant, train = plants[0], ev_e301[0]
    plant["adhesion_factor"] = 0.3
    for _ in range(40):
        limit_n = 0.5 * 77_900 * 9.81 * adhesion_coefficient(train, 0.3, plant["speed_mps"])
        step(plant, train, 5.0, False, 0.0, 0.0, DT_S)
        assert plant["traction_force_n"] <= limit_n * (1 + 1e-12)
    assert plant["sliding"] == 1
    assert plant["wheel_speed_mps"] > plant["speed_mps"]
    assert plant["wheel_travelled_m"] > plant["travelled_m"]


def test_no_slide_on_dry_rail_with_the_emergency_brake(ev_e301: Rows) -> None:
    plants = new_plant(1, 100 / 3.6)
    plant = plants[0]
    while plant["speed_mps"] > 0.0:
        step(plant, ev_e301[0], 0.0, True, 0.0, 0.0, DT_S)
        assert plant["sliding"] == 0
    assert plant["wheel_travelled_m"] == pytest.approx(plant["travelled_m"], abs=1e-9)
