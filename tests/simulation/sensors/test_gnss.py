"""The satellite receiver: errors that last, reflections by place and hour, tunnels, latency and faults."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from network.profile import NO_SKY, OPEN_SKY, PART_OF_SKY
from onboard.board import SENSED
from simulation.faults.gnss import GnssAntenna, GnssJump, GnssReflections, GnssTimeTag, Reception
from simulation.gnss_settings import AIM, FAIL_SAFE, Correction, Gnss, GnssReceiver
from simulation.sensors.gnss import (
    HOURS,
    SIDEREAL_DAY_S,
    GnssReceiverRow,
    fit,
    gnss_receiver,
    put_reception,
    reflection_sigmas,
)
from simulation.sensors.scene import SCENE
from simulation.sensors.table import SENSORS_ROW
from simulation.settings import PositionSensor
from simulation.setup import Setup

SPEED_MPS = 20.0
STEP_S = 0.1


def receiver_of(setup: Setup, gnss: Gnss | None = None, day: int = 1) -> GnssReceiverRow:
    row: GnssReceiverRow = np.zeros(1, SENSORS_ROW["gnss_receiver"]).view(np.recarray)[0]
    sensors = setup.sensors.model_copy(update={"carries": (PositionSensor.GNSS,)})
    fit(row, replace(setup, sensors=sensors, gnss=gnss or Gnss(), day=day), "K1")
    return row


class Ride:
    """A train at 20 m/s, or another speed, under a sky; what its receiver shows."""

    def __init__(self, receiver: GnssReceiverRow, step: int = 0, speed_mps: float = SPEED_MPS) -> None:
        self.receiver, self.step, self.speed_mps = receiver, step, speed_mps
        self.scene: Any = np.zeros(1, SCENE).view(np.recarray)[0]
        self.sensed: Any = np.zeros(1, SENSED).view(np.recarray)[0]
        self.scene.step_s, self.scene.sky, self.scene.down = STEP_S, OPEN_SKY, 1.0
        self.scene.front_m = 100.0

    def next(self) -> float | None:
        """A step later: the error of the fix that is handed over, by the age that it states; None without one."""
        scene, self.step = self.scene, self.step + 1
        scene.step, scene.now_s = self.step, self.step * STEP_S
        scene.run_m = self.speed_mps * STEP_S
        scene.front_m += scene.run_m
        scene.kilometrage_m = scene.front_m
        gnss_receiver(self.receiver, None, scene, self.sensed)
        shown = self.sensed.readings.gnss
        if not shown.taken:
            return None
        return float(shown.position_m + self.speed_mps * shown.age_s - scene.front_m)

    def errors(self, seconds: float) -> list[float]:
        """Of all fixes in so long."""
        found = [self.next() for _ in range(round(seconds / STEP_S))]
        return [error_m for error_m in found if error_m is not None]


def test_a_fix_a_second_as_old_as_it_says(rtri_setup: Setup) -> None:
    ride = Ride(receiver_of(rtri_setup))
    when = [step for step in range(1, 60) if ride.next() is not None]
    assert when == [12, 22, 32, 42, 52]
    assert ride.sensed.readings.gnss.age_s == pytest.approx(0.2)
    assert ride.sensed.readings.gnss.protection_m == FAIL_SAFE.protection_m


def test_stock_without_a_receiver_has_no_fix(rtri_setup: Setup) -> None:
    row: GnssReceiverRow = np.zeros(1, SENSORS_ROW["gnss_receiver"]).view(np.recarray)[0]
    fit(row, rtri_setup, "K1")
    put_reception(row, Reception(bias_m=30.0))
    assert Ride(row).errors(60.0) == []


def test_errors_last_and_have_the_stated_deviation(rtri_setup: Setup) -> None:
    gnss = Gnss(rate_hz=1.0, time_constant_s=20.0)
    errors = np.array(Ride(receiver_of(rtri_setup, gnss)).errors(6000.0))
    assert np.std(errors) == pytest.approx(math.hypot(FAIL_SAFE.sigma_m, FAIL_SAFE.noise_sigma_m), rel=0.15)
    apart = [float(np.corrcoef(errors[:-k], errors[k:])[0, 1]) for k in (1, 20, 100)]
    assert apart[0] > 0.8
    assert apart[1] == pytest.approx(math.exp(-1.0), abs=0.15)
    assert abs(apart[2]) < 0.2


def test_the_same_errors_whatever_stretches_a_run_is_cut_into(rtri_setup: Setup) -> None:
    assert Ride(receiver_of(rtri_setup)).errors(30.0) == Ride(receiver_of(rtri_setup)).errors(30.0)


def test_no_fix_in_a_tunnel_and_for_a_time_after(rtri_setup: Setup) -> None:
    ride = Ride(receiver_of(rtri_setup))
    assert ride.errors(10.0)
    ride.scene.sky = NO_SKY
    ride.errors(1.0)  # what was under way
    assert ride.errors(20.0) == []
    ride.scene.sky = OPEN_SKY
    assert ride.errors(Gnss().reacquisition_s) == []
    assert ride.errors(2.0)


def test_reflections_come_again_where_the_satellites_do(rtri_setup: Setup) -> None:
    own = receiver_of(rtri_setup)
    places = np.arange(0.0, 40_000.0, 40.0)
    now = np.array([reflection_sigmas(own, place, 36_000.0) for place in places])
    assert np.std(now) == pytest.approx(1.0, abs=0.12)
    soon = np.array([reflection_sigmas(own, place, 36_060.0) for place in places])
    later = np.array(
        [reflection_sigmas(own, place, 36_000.0 + 2.0 * SIDEREAL_DAY_S / HOURS) for place in places]
    )
    assert np.corrcoef(now, soon)[0, 1] > 0.95
    assert abs(np.corrcoef(now, later)[0, 1]) < 0.15
    tomorrow = receiver_of(rtri_setup, day=2)
    earlier_s = 86_400.0 - SIDEREAL_DAY_S
    again = np.array([reflection_sigmas(tomorrow, place, 36_000.0 - earlier_s) for place in places])
    assert np.allclose(now, again)
    near = np.array([reflection_sigmas(own, place + 4.0, 36_000.0) for place in places])
    assert np.corrcoef(now, near)[0, 1] > 0.95


def test_a_hidden_sky_is_told_and_adds_to_the_error(rtri_setup: Setup) -> None:
    spread: list[float] = []
    for sky in (OPEN_SKY, PART_OF_SKY):
        ride = Ride(receiver_of(rtri_setup))
        ride.scene.sky = sky
        errors = ride.errors(1500.0)
        spread.append(float(np.std(errors)))
        assert ride.sensed.readings.gnss.open_sky == (1 if sky == OPEN_SKY else 0)
        assert max(abs(error_m) for error_m in errors) < FAIL_SAFE.protection_m
    assert spread[1] > 1.8 * spread[0]


def test_the_error_is_of_the_place_and_not_of_the_way_of_travel(rtri_setup: Setup) -> None:
    down, up = Ride(receiver_of(rtri_setup)), Ride(receiver_of(rtri_setup))
    up.scene.down = -1.0
    assert down.errors(20.0) == pytest.approx([-error_m for error_m in up.errors(20.0)])


def test_what_faults_do(rtri_setup: Setup) -> None:
    plain = Ride(receiver_of(rtri_setup)).errors(30.0)

    def faulty(reception: Reception) -> list[float]:
        receiver = receiver_of(rtri_setup)
        put_reception(receiver, reception)
        return Ride(receiver).errors(30.0)

    assert faulty(Reception(no_signals=True)) == []
    jumped = faulty(GnssJump(target="K1", bias_m=30.0).applied_to(Reception()))
    assert np.subtract(jumped, plain) == pytest.approx(30.0)
    crept = np.subtract(
        faulty(GnssReflections(target="K1", bias_m=30.0, over_m=300.0).applied_to(Reception())), plain
    )
    assert crept[0] < 5.0
    assert np.diff(crept).max() == pytest.approx(2.0, abs=0.2)  # 20 m/s, 0.1 m a metre
    assert crept[-1] == pytest.approx(30.0)
    late = faulty(GnssTimeTag(target="K1", late_s=1.0).applied_to(Reception()))
    assert np.mean(late) == pytest.approx(np.mean(plain) - SPEED_MPS, abs=0.3)


def test_a_frozen_receiver_shows_one_place_for_ever(rtri_setup: Setup) -> None:
    ride = Ride(receiver_of(rtri_setup))
    ride.errors(10.0)
    ride.next()
    put_reception(ride.receiver, Reception(frozen=True))
    ride.errors(2.0)
    places_m = {round(ride.sensed.readings.gnss.position_m, 6) for _ in range(60) if ride.next() is not None}
    assert len(places_m) == 1
    put_reception(ride.receiver, Reception())
    ride.errors(2.0)
    assert all(abs(error_m) < FAIL_SAFE.protection_m for error_m in ride.errors(10.0))


def test_faults_that_overlap_are_folded_and_a_bias_goes_as_it_came(rtri_setup: Setup) -> None:
    both = GnssJump(target="K1", bias_m=5.0).applied_to(GnssAntenna(target="K1").applied_to(Reception()))
    assert both == Reception(no_signals=True, bias_m=5.0)
    receiver = receiver_of(rtri_setup)
    put_reception(receiver, Reception(bias_m=30.0, over_m=300.0))
    ride = Ride(receiver)
    ride.errors(30.0)
    put_reception(receiver, Reception())
    leaving = ride.errors(5.0)
    assert 10.0 < leaving[-1] < 28.0
    assert abs(ride.errors(20.0)[-1]) < 10.0


def test_a_receiver_that_states_less_than_it_errs_by_is_refused() -> None:
    with pytest.raises(ValidationError, match=r"at least 19\.79"):
        GnssReceiver(sigma_m=1.2, noise_sigma_m=0.3, multipath_sigma_m=3.0, protection_m=10.0)
    assert Gnss().receiver is FAIL_SAFE
    assert Gnss(correction=Correction.AIM).receiver is AIM
