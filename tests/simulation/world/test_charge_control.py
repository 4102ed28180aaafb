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
    most_w = 0.0
    while plant["speed_mps"][0] > 0.0:
        offer_power(own[0], plant[0], 0.1)
        traction_j, back_j = float(plant["energy_traction_j"][0]), float(plant["energy_regenerated_j"][0])
        taken_j = float(own["flows"]["taken_j"][0])
        step(plant[0], train.row[0], -7.0, False, 0.0, 0.0, 0.1)
        drain(own[0], plant[0], train.row[0], traction_j, back_j, 0.1)
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
    assert own["flows"]["spilled_j"][0] == pytest.approx(
        0.0, abs=1.0
    )  # the motors are held, nothing is given back in vain
