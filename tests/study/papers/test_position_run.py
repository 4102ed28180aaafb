"""The bench of one train along a line: what is to happen at a place happens there."""

from __future__ import annotations

from simulation.setup import STEP_S
from simulation.world.trains import Trains
from study.papers.position_run import Moment, PositionRun
from study.scenario.scenario import load_scenario

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
