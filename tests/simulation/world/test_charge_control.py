"""The pantograph at a charger, step by step."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from simulation.world.charge_control import (
    CHARGING,
    DOWN,
    FALLING,
    MOVED,
    NOT_MOVED,
    RISING,
    UP,
    drain,
    offer_power,
    reset_charging,
    steer,
)
from vehicle.battery import available_j, stand
from vehicle.dynamics import step
from vehicle.train_file import load_train, new_plant, shipped_train

KWH = 3.6e6


class Stood:
    """A set that stands at a charger of 400 kW, which takes 20 s to connect and 15 s to disconnect."""

    def __init__(self, soc: float, leaves_s: float, needed_j: float = 0.0) -> None:
        row = load_train(shipped_train("ev_e301")).battery
        assert row is not None
        self.battery: NDArray[np.void] = row.copy()
        self.battery["charge_c"] = soc * self.battery["full_c"]
        self.charging = np.zeros(1, dtype=CHARGING)
        reset_charging(self.battery[0], self.charging[0])
        self.charging["power_w"], self.charging["connect_s"], self.charging["disconnect_s"] = 4e5, 20.0, 15.0
        self.charging["leaves_s"], self.charging["needed_j"] = leaves_s, needed_j
        self.charging["spare_j"] = 1.0 * KWH
        self.held, self.ahead_s = 1, 0.0

    def until(self, end_s: float, speed_mps: float = 0.0) -> list[tuple[float, int]]:
        """When the pantograph changed, and how it is then; a step a second."""
        seen: list[tuple[float, int]] = []
        for now_s in range(int(end_s) + 1):
            before = int(self.charging["pantograph"][0])
            steer(self.battery[0], self.charging[0], speed_mps, self.held, float(now_s), self.ahead_s)
            stand(self.battery[0], 30e3, float(self.battery["supply_w"][0]), 1.0, 1.0)
            if int(self.charging["pantograph"][0]) != before:
                seen.append((float(now_s), int(self.charging["pantograph"][0])))
        return seen


def test_up_after_its_time_and_down_before_it_leaves() -> None:
    assert Stood(0.5, 600.0).until(620.0) == [(0.0, RISING), (20.0, UP), (584.0, FALLING), (599.0, DOWN)]


def test_not_for_a_short_stop_with_enough() -> None:
    assert Stood(0.5, 60.0).until(100.0) == []


def test_for_a_short_stop_with_too_little_until_it_has_enough_and_some_more() -> None:
    stood = Stood(0.5, 60.0)
    stood.charging["needed_j"] = needed_j = available_j(stood.battery[0]) + 10.0 * KWH
    seen = stood.until(200.0)
    assert [state for _, state in seen] == [RISING, UP, FALLING, DOWN]
    falls_s = seen[2][0]
    # 11 kWh, and what the auxiliaries took while it rose, at 370 kW less the loss in the battery.
    assert falls_s - 20.0 == pytest.approx((11.0 * KWH + 20.0 * 30e3) / (370e3 - 0.03 * 570.0**2), rel=0.03)
    assert available_j(stood.battery[0]) > needed_j


def test_at_a_dead_charger_it_comes_down_and_stays_down() -> None:
    stood = Stood(0.5, math.inf)
    stood.until(30.0)
    stood.charging["power_w"] = 0.0
    assert [state for _, state in stood.until(60.0)] == [FALLING, DOWN]
    assert float(stood.battery["supply_w"][0]) == 0.0


def test_a_full_battery_does_not_wait_for_what_it_cannot_hold() -> None:
    stood = Stood(0.9, 60.0)
    stood.charging["needed_j"] = available_j(stood.battery[0]) - 0.1 * KWH
    stood.charging["pantograph"] = UP
    assert stood.until(80.0)[0] == (44.0, FALLING)


def test_who_moves_with_it_up_draws_nothing_more_and_lowers_it_in_its_time_and_that_is_told() -> None:
    stood = Stood(0.5, math.inf)
    stood.until(30.0)
    assert int(stood.charging["pantograph"][0]) == UP
    assert stood.until(20.0, speed_mps=1.0) == [(0.0, FALLING), (15.0, DOWN)]
    assert float(stood.charging["power_w"][0]) == 0.0 == float(stood.battery["supply_w"][0])
    assert int(stood.charging["moved"][0]) == MOVED


def test_who_moves_with_it_down_is_not_told_of() -> None:
    stood = Stood(0.5, 60.0)
    stood.until(20.0, speed_mps=1.0)
    assert int(stood.charging["moved"][0]) == NOT_MOVED


@pytest.mark.parametrize("ahead_s", [-100.0, 300.0])
def test_it_comes_down_by_the_clock_of_the_unit(ahead_s: float) -> None:
    stood = Stood(0.5, 600.0)
    stood.ahead_s = ahead_s
    assert (584.0 - ahead_s, FALLING) in stood.until(720.0)


def test_it_is_not_raised_on_a_train_that_its_unit_lets_run() -> None:
    stood = Stood(0.5, math.inf)
    stood.held = 0
    assert stood.until(60.0) == []


def test_where_the_plan_has_no_time_it_comes_down_with_enough() -> None:
    stood = Stood(0.5, -math.inf)
    stood.charging["needed_j"] = available_j(stood.battery[0]) + 10.0 * KWH
    assert [state for _, state in stood.until(300.0)][:4] == [RISING, UP, FALLING, DOWN]


# what the battery takes from the motors -----------------------------------------------------------------------------


def braked(limit_w: float) -> tuple[float, NDArray[np.void], NDArray[np.void]]:
    """A stop from 18 m/s: the greatest power that reached the battery (W), and battery and plant after it."""
    train = load_train(shipped_train("ev_e301"))
    assert train.battery is not None
    own, plant = train.battery.copy(), new_plant(1, 18.0)
    own["charge_c"] = 0.5 * own["full_c"]
    own["pack"]["regeneration_max_w"] = limit_w
    charging, most_w = np.zeros(1, dtype=CHARGING), 0.0
    while plant["speed_mps"][0] > 0.0:
        offer_power(own[0], charging[0], plant[0], 0.1)
        traction_j, back_j = float(plant["energy_traction_j"][0]), float(plant["energy_regenerated_j"][0])
        taken_j = float(own["flows"]["taken_j"][0])
        step(plant[0], train.row[0], -7.0, False, 0.0, 0.0, 0.1)
        drain(own[0], charging[0], plant[0], train.row[0], traction_j, back_j, 0.1)
        most_w = max(most_w, (float(own["flows"]["taken_j"][0]) - taken_j) / 0.1)
    return most_w, own, plant


def test_a_limit_on_regeneration_binds_and_the_air_brake_does_the_rest() -> None:
    """Motors of 380 kW never reach the shipped limit of 400 kW: 100 kW is one that binds."""
    free_w, _, free = braked(400e3)
    held_w, own, held = braked(100e3)
    assert free_w > 150e3
    assert free["energy_rejected_j"][0] == 0.0
    assert held_w == pytest.approx(100e3, rel=1e-6)
    assert held["energy_rejected_j"][0] > 0.2 * free["energy_regenerated_j"][0]
    assert held["energy_friction_j"][0] > free["energy_friction_j"][0]
    assert held["travelled_m"][0] == pytest.approx(free["travelled_m"][0], abs=1e-6)
    # the motors are held, nothing is given back in vain
    assert own["flows"]["spilled_j"][0] == pytest.approx(0.0, abs=1.0)


# a stand without a charger -------------------------------------------------------------------------------------------

KEEPS_KWH, RESERVE_KWH = 50.0, 12.0


class Waits:
    """A set held at a stop without a charger, that is to keep 50 kWh there; a step a second."""

    def __init__(self, available_kwh: float) -> None:
        self.train = load_train(shipped_train("ev_e301"))
        assert self.train.battery is not None
        self.battery = self.train.battery.copy()
        low, high = float(self.battery["pack"]["soc_low"][0]), float(self.battery["pack"]["soc_high"][0])
        for _ in range(40):  # halving: the charge above the window's low end grows with the state of charge
            middle = 0.5 * (low + high)
            self.battery["charge_c"] = middle * self.battery["full_c"]
            low, high = (middle, high) if self.available_kwh < available_kwh else (low, middle)
        self.charging, self.plant = np.zeros(1, dtype=CHARGING), new_plant(1, 0.0)
        reset_charging(self.battery[0], self.charging[0])
        self.charging["keeps_j"], self.charging["reserve_j"] = KEEPS_KWH * KWH, RESERVE_KWH * KWH
        self.charging["keeps_w"] = 5e3

    @property
    def available_kwh(self) -> float:
        return float(available_j(self.battery[0])) / KWH

    def stand(self, time_s: float, notch: float = -7.0) -> None:
        row, plant = self.train.row[0], self.plant[0]
        for now_s in range(int(time_s)):
            offer_power(self.battery[0], self.charging[0], plant, 1.0)
            traction_j, back_j = float(plant["energy_traction_j"]), float(plant["energy_regenerated_j"])
            step(plant, row, notch, False, 0.0, 0.0, 1.0)
            drain(self.battery[0], self.charging[0], plant, row, traction_j, back_j, 1.0)
            steer(self.battery[0], self.charging[0], float(plant["speed_mps"]), 0, float(now_s), 0.0)


def test_a_long_stand_leaves_what_the_way_takes() -> None:
    """30 kW take 10 kWh in 20 min; from then on 5 kW stay on, and 2 h more take 10 kWh."""
    waits = Waits(KEEPS_KWH + 10.0)
    waits.stand(1140.0)
    assert waits.charging["sheds"][0] == 0
    waits.stand(60.0)
    assert waits.available_kwh == pytest.approx(KEEPS_KWH, abs=0.1)
    waits.stand(7200.0)
    assert waits.charging["sheds"][0] == 1
    assert waits.available_kwh == pytest.approx(KEEPS_KWH - 10.0, abs=0.2)
    taken_kwh = float(waits.battery["flows"]["given_j"][0]) / KWH
    assert float(waits.plant["energy_auxiliary_j"][0]) / KWH == pytest.approx(taken_kwh, rel=1e-6)


def test_all_auxiliaries_are_on_as_it_runs_and_what_it_runs_by_is_kept_no_more() -> None:
    waits = Waits(KEEPS_KWH - 5.0)
    waits.stand(59.0)
    assert waits.charging["sheds"][0] == 0  # not at a stop of the timetable
    waits.stand(2.0)
    assert waits.charging["sheds"][0] == 1
    before_kwh = waits.available_kwh
    waits.stand(120.0, notch=5.0)
    assert waits.charging["sheds"][0] == 0
    lost_kwh = float(waits.battery["flows"]["lost_j"][0]) / KWH
    ran_kwh = before_kwh - waits.available_kwh - lost_kwh
    assert ran_kwh > 2.0
    assert KEEPS_KWH - float(waits.charging["keeps_j"][0]) / KWH == pytest.approx(ran_kwh, abs=0.1)


def test_at_the_least_the_reserve_is_kept() -> None:
    waits = Waits(RESERVE_KWH + 5.0)
    waits.charging["keeps_j"] = RESERVE_KWH * KWH
    waits.stand(60.0, notch=5.0)
    assert float(waits.charging["keeps_j"][0]) == RESERVE_KWH * KWH


def test_a_generator_charges_it_and_no_wheel_moves_meanwhile() -> None:
    """60 kW, 5 kW of them for what is on; it is taken away once there is what is to be kept."""
    waits = Waits(0.0)
    waits.charging["brought_w"] = 60e3
    waits.stand(1800.0, notch=5.0)
    assert float(waits.plant["travelled_m"][0]) == 0.0
    lost_kwh = float(waits.battery["flows"]["lost_j"][0]) / KWH
    assert waits.available_kwh == pytest.approx(55.0 * 0.5 - 25.0 / 60.0 - lost_kwh, abs=0.1)
    waits.stand(1600.0)
    assert waits.charging["brought_w"][0] == 0.0
    assert waits.available_kwh == pytest.approx(KEEPS_KWH, abs=0.3)
