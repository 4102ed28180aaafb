"""The bench of one train along a line: what is to happen at a place happens there."""

import math

import numpy as np
import pytest

from onboard.records import EVENT_FOUND
from papers.position_run import SLOT, Moment, PositionRun
from scenario.scenario import load_scenario
from simulation.setup import STEP_S
from simulation.world.kernel import judge_bounds
from simulation.world.trains import Trains

PLACES_M = (500.0, 1234.5, 5000.0)


def test_moments_come_in_the_step_in_which_the_front_is_there() -> None:
    """Not at the end of the stretch that the kernel runs ahead, some 80 m further on."""
    setup = load_scenario("karasuyama_weekday").setup
    seen: list[tuple[float, float]] = []

    def at(place_m: float) -> Moment:
        def look(trains: Trains, slot: int) -> None:
            beyond_m = float(trains.truths[slot].position_m) - place_m
            seen.append((beyond_m, float(trains.plants[slot].speed_mps)))

        return Moment(place_m, look)

    result = PositionRun(setup, [at(place_m) for place_m in PLACES_M]).run()
    assert result.arrived
    assert result.out_m <= 0.0
    assert len(seen) == len(PLACES_M)
    assert all(0.0 <= beyond_m <= 2.0 * speed_mps * STEP_S for beyond_m, speed_mps in seen)


@pytest.mark.parametrize(("events", "judged"), [(0, True), (EVENT_FOUND, False)])
def test_what_a_sensor_finds_in_a_step_is_not_stated_in_it(events: int, judged: bool) -> None:
    """The unit has yet to believe it: who may be elsewhere does not, and then it was never stated."""
    trains = PositionRun(load_scenario("rtri_test_line").setup).trains
    trains.units[SLOT].position_m += 50.0
    worst = np.full(6, -np.inf)
    judge_bounds(trains.stock[SLOT], events, worst, 1)
    assert worst[0] > 40.0 if judged else worst[0] == -np.inf


@pytest.mark.parametrize("field", ["bound_behind_m", "bound_ahead_m", "position_m"])
def test_what_is_no_number_is_out_of_the_bounds_and_stays_it(field: str) -> None:
    """Whichever of them is none, and however far out the truth is later in the stretch."""
    trains = PositionRun(load_scenario("rtri_test_line").setup).trains
    worst = np.full(6, -np.inf)
    for value in (math.nan, 1.0):
        setattr(trains.units[SLOT], field, value)
        judge_bounds(trains.stock[SLOT], 0, worst, 1)
    assert math.isnan(worst[0])
    assert math.isnan(worst[2:].sum())


def test_a_trace_tells_where_the_position_is_unknown_and_nothing_stated() -> None:
    run = PositionRun(load_scenario("rtri_test_line").setup)

    def lose(_trains: Trains, _slot: int) -> None:
        run.motion._lose("a test")

    run.at([Moment(100.0, lose)])
    result = run.run()
    assert 0 < result.known_steps < result.steps
    assert result.stated.size == result.trace.size
    assert result.stated.mean() == pytest.approx(result.known_steps / result.steps, abs=0.1)
