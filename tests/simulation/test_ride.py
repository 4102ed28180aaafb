"""What is counted of how a stock is driven: motions made by hand, with their figures by hand."""

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.records import MODE_DRIVE, MODE_HOLD, UNIT, UnitRow
from scenario.scenario import load_scenario
from simulation import ride as counted
from simulation.result import EnergyPhase
from simulation.ride import ACCELERATES, BRAKES, COASTS, CRUISES, Ride, RideRow, cut_ride, joined_rides
from simulation.world.energy_book import EnergyBook
from study.drilling.drill import find_drill
from study.runner.run import CarrierKind, simulation_of
from vehicle.record import dtype_of
from vehicle.records import PLANT, PlantRow

STEP_S: Final = 0.1
RIDE: Final = dtype_of(RideRow)
Step = tuple[float, float]  # notch, acceleration that it makes, m/s2


def new_ride() -> RideRow:
    row: RideRow = np.zeros(1, dtype=RIDE).view(np.recarray)[0]
    return row


def driven(
    steps: Sequence[Step], mode: int = MODE_DRIVE, ride: RideRow | None = None, speed_mps: float = 0.0
) -> RideRow:
    """The ride of a body moved by hand, in steps of 0.1 s."""
    ride = new_ride() if ride is None else ride
    unit: UnitRow = np.zeros(1, dtype=UNIT).view(np.recarray)[0]
    plant: PlantRow = np.zeros(1, dtype=PLANT).view(np.recarray)[0]
    unit.mode, plant.speed_mps = mode, speed_mps
    for notch, acceleration_mps2 in steps:
        before_mps, before_mps2 = plant.speed_mps, plant.acceleration_mps2
        counted.count_notches(ride, unit, plant, notch)
        plant.speed_mps = max(before_mps + acceleration_mps2 * STEP_S, 0.0)
        plant.acceleration_mps2 = (plant.speed_mps - before_mps) / STEP_S
        counted.count_motion(ride, plant, before_mps, before_mps2, False, STEP_S)
    return ride


def test_a_hop_worked_out_by_hand() -> None:
    # Power 1 and 2, even speed, coasting, brake 3 and 1, and a stand from 0.05 m/s.
    steps = [(1.0, 0.5), (2.0, 1.0), (1.0, 0.0), (0.0, -0.5), (-3.0, -0.5), (-1.0, -0.45), (-1.0, -0.5)]
    made = cut_ride(driven(steps))
    assert made.power_changes == 4  # 1, 2, 1, 0
    assert made.brake_changes == 2  # 3, 1
    # Jerks, m/s3: 5, 5, -10, -5, 0, 0.5; the step that ends in the stand is left out.
    assert made.jerk_max_mps3 == pytest.approx(10.0)
    assert made.jerk_squared_m2ps5 == pytest.approx((25.0 + 25.0 + 100.0 + 25.0 + 0.25) * 0.1)
    assert made.jolt_mps2 == pytest.approx(0.45)
    assert made.time_s[ACCELERATES] == pytest.approx(0.2)
    assert made.time_s[CRUISES] == made.time_s[COASTS] == pytest.approx(0.1)
    assert made.time_s[BRAKES] == pytest.approx(0.3)
    # Speeds at the ends of the steps, m/s: 0.05, 0.15, 0.15, 0.10, 0.05, 0.005, 0.
    assert made.way_m[ACCELERATES] == pytest.approx((0.025 + 0.1) * 0.1)
    assert made.way_m[CRUISES] == pytest.approx(0.15 * 0.1)
    assert made.way_m[COASTS] == pytest.approx(0.125 * 0.1)
    assert made.way_m[BRAKES] == pytest.approx((0.075 + 0.0275 + 0.0025) * 0.1)
    assert made.jerk_rms_mps3 == pytest.approx((17.525 / 0.7) ** 0.5)


def test_what_is_put_in_while_held_counts_for_nothing_and_the_start_counts_from_there() -> None:
    ride = driven([(-4.0, 0.0), (-2.0, 0.0), (-4.0, 0.0)], MODE_HOLD)
    assert (ride.power_changes, ride.brake_changes, sum(ride.time_s)) == (0, 0, 0.0)
    driven([(5.0, 0.0), (5.0, 0.3)], ride=ride)  # the brake goes and power comes before the train moves
    assert (ride.power_changes, ride.brake_changes) == (1, 1)


def test_a_notch_between_two_samples_of_the_trace_is_counted() -> None:
    within_a_second = [(3.0, 0.0)] * 4 + [(0.0, 0.0)] * 2 + [(3.0, 0.0)] * 4
    assert driven(within_a_second, speed_mps=10.0).power_changes == 3


def test_a_brake_without_steps_counts_by_the_notch() -> None:
    creeping = [(-0.1 * i, 0.0) for i in range(35)]  # put in, then 1.1, 2.1 and 3.1
    assert driven(creeping, speed_mps=10.0).brake_changes == 4
    assert driven([*creeping, (0.0, 0.0)], speed_mps=10.0).brake_changes == 5


@given(st.lists(st.integers(-7, 5), min_size=1, max_size=60))
def test_of_whole_notches_every_change_counts(notches: list[int]) -> None:
    ride = driven([(float(notch), 0.0) for notch in notches], speed_mps=10.0)
    both = [
        (max(a, 0) != max(b, 0), min(a, 0) != min(b, 0)) for a, b in zip([0, *notches], notches, strict=False)
    ]
    assert ride.power_changes == sum(power for power, _ in both)
    assert ride.brake_changes == sum(brake for _, brake in both)


def test_a_cut_begins_anew_and_keeps_the_notch() -> None:
    ride = driven([(2.0, 1.0)] * 3)
    assert cut_ride(ride).power_changes == 1
    assert cut_ride(ride) == Ride()
    assert driven([(2.0, 1.0)] * 3, ride=ride).power_changes == 0


def test_two_runs_of_one_hop_go_together() -> None:
    one = Ride(3, 1, 0.5, 2.0, 0.3, (1.0, 2.0, 3.0, 4.0), (10.0, 20.0, 30.0, 40.0))
    two = Ride(1, 4, 0.7, 1.0, 0.2, (1.0, 1.0, 1.0, 1.0), (1.0, 1.0, 1.0, 1.0))
    both = Ride(4, 5, 0.7, 3.0, 0.3, (2.0, 3.0, 4.0, 5.0), (11.0, 21.0, 31.0, 41.0))
    assert joined_rides((one, two)) == both
    assert joined_rides(()) == Ride()


def uncounted(drill: str) -> tuple[float, float]:
    """How far time (s) and way (m) that were counted are from what the records say; the worst of a drill's runs."""
    with simulation_of(load_scenario(drill).setup, carrier=CarrierKind.PLAIN) as simulation:
        records = simulation.run().energy
    runs = [r for r in records if r.phase is EnergyPhase.RUNNING]
    assert runs
    assert all(r.ride == Ride() for r in records if r.phase is not EnergyPhase.RUNNING)
    return (
        max(abs(r.ride.moving_s - (r.end_s - r.begin_s)) for r in runs),
        max(abs(r.ride.moved_m - r.distance_m) for r in runs),
    )


TURN_BACK: Final = find_drill("rtri/02_turn_back")


def test_every_second_and_metre_of_a_run_is_of_one_manner() -> None:
    time_s, way_m = uncounted(TURN_BACK)
    assert time_s < 1e-6
    assert way_m < 1e-6


@pytest.mark.parametrize(
    ("name", "instead"),
    [("stands", lambda *_: None), ("moves", lambda *_: None), ("begin", lambda *_: None)],
)
def test_a_cut_elsewhere_is_found_out(
    monkeypatch: pytest.MonkeyPatch, name: str, instead: Callable[..., object]
) -> None:
    monkeypatch.setattr(EnergyBook, name, instead)
    try:
        lost = max(uncounted(TURN_BACK)) > 1e-6
    except (AssertionError, KeyError):
        lost = True
    assert lost
