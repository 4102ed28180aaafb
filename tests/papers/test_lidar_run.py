"""Trains that carry a LiDAR along the Karasuyama line with markers patched in: bounds hold, whatever goes wrong."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from network.model import Line, MarkerGroup
from onboard import notes
from papers.position_run import Moment, PositionResult, PositionRun
from scenario.scenario import load_scenario
from simulation.sensor_settings import Lidar
from simulation.settings import PositionSensor, Sensors
from simulation.setup import Belief, Setup
from simulation.world.roster import drawn_up
from simulation.world.trains import Trains
from vehicle.compiled import INTERPRETED

pytestmark = pytest.mark.skipif(INTERPRETED, reason="it runs along a whole line")

EVERY_M = 1000.0
BEFORE_MARK_M = 120.0
LIDAR = (PositionSensor.LIDAR,)
BOTH = (PositionSensor.TAGS, PositionSensor.LIDAR)


def with_markers(setup: Setup) -> Line:
    """A group each kilometre and one before each stop, for the trains of the first stock's first run."""
    path, targets = (
        (mission := drawn_up(setup, setup.line)[setup.timetable.diagrams[0].stock_id][0].mission).path,
        mission.targets,
    )
    places_m = [*np.arange(targets[0].mark_m + 400.0, path.length_m - 100.0, EVERY_M)]
    places_m += [target.mark_m - BEFORE_MARK_M for target in targets[1:]]
    apart = [m for k, m in enumerate(sorted(places_m)) if k == 0 or m - sorted(places_m)[k - 1] > 50.0]
    groups = {}
    for number, at_m in enumerate(apart):
        piece_id, kilometrage_m = path.locate(float(at_m))
        pattern = 1 + 5 * number % 24
        groups[9000 + number] = MarkerGroup(
            9000 + number, pattern, piece_id, kilometrage_m, (path.direction,)
        )
    return replace(setup.line, markers=groups)


@pytest.fixture(scope="module")
def setup() -> Setup:
    plain = load_scenario("karasuyama_weekday").setup
    return replace(plain, line=with_markers(plain))


def ride(
    setup: Setup, carries: tuple[PositionSensor, ...], *moments: Moment, **changed: object
) -> PositionResult:
    sensors = Sensors(carries=carries)
    return PositionRun(replace(setup, sensors=sensors, **changed), moments).run()  # type: ignore[arg-type]


def told(result: PositionResult) -> Counter[str]:
    return Counter(
        type(note).__name__ for _, _, note in result.notes if getattr(note, "reader", "lidar") == "lidar"
    )


def half_width_m(result: PositionResult) -> float:
    return float(np.median(result.trace["bound_ahead_m"] + result.trace["bound_behind_m"])) / 2.0


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("carries", [LIDAR, BOTH])
def test_bounds_hold_and_are_narrow(setup: Setup, carries: tuple[PositionSensor, ...], seed: int) -> None:
    result = ride(setup, carries, seed=seed)
    assert result.arrived
    assert result.out_m <= 0.0
    assert result.known_steps == result.steps
    assert half_width_m(result) < 12.0
    assert told(result)["FixTaken"] >= 1
    assert told(result)["FixRefused"] == 0


def test_without_any_lidar_bounds_are_wider(setup: Setup) -> None:
    tags = ride(setup, (PositionSensor.TAGS,))
    assert half_width_m(tags) > half_width_m(ride(setup, BOTH))


def blind(trains: Trains, slot: int) -> None:
    trains.lidars[slot].blind = 1


def test_a_lidar_that_goes_blind_misses_groups_and_breaks_no_bound(setup: Setup) -> None:
    result = ride(setup, BOTH, Moment(3000.0, blind))
    assert result.out_m <= 0.0
    assert told(result)["FixMissed"] >= 1


def test_fog_hides_all_groups(setup: Setup) -> None:
    result = ride(setup, BOTH, lidar=Lidar(visibility_m=5.0))
    assert result.out_m <= 0.0
    assert told(result)["FixTaken"] == 0


def test_a_group_that_has_lost_a_marker_is_missed(setup: Setup) -> None:
    group = sorted(setup.line.markers)[3]

    def lose(trains: Trains, _slot: int) -> None:
        trains.pool.lay_markers(group, whole=False)

    def mend(trains: Trains, _slot: int) -> None:
        trains.pool.lay_markers(group, whole=True)

    broken = ride(setup, LIDAR, Moment(100.0, lose))
    assert broken.out_m <= 0.0
    assert told(broken)["FixMissed"] == 1
    assert told(ride(setup, LIDAR, Moment(100.0, lose), Moment(150.0, mend)))["FixMissed"] == 0


def test_patterns_laid_in_each_others_place_are_refused(setup: Setup) -> None:
    """Units believe two neighbours to lie the other way round."""
    first, second = (setup.line.markers[key] for key in sorted(setup.line.markers)[3:5])
    swapped = dict(setup.line.markers)
    swapped[first.id] = replace(first, pattern=second.pattern)
    swapped[second.id] = replace(second, pattern=first.pattern)
    result = ride(setup, LIDAR, belief=Belief(replace(setup.line, markers=swapped)))
    assert result.out_m <= 0.0
    assert told(result)["FixRefused"] >= 1


def test_a_slippery_rail_breaks_no_bound(setup: Setup) -> None:
    moments = (
        Moment(700.0, lambda t, s: t.set_rail(s, 0.25)),
        Moment(9000.0, lambda t, s: t.set_rail(s, 1.0)),
    )
    result = ride(setup, LIDAR, *moments)
    assert result.out_m <= 0.0
    assert any(isinstance(note, notes.FixTaken) for _, _, note in result.notes)
