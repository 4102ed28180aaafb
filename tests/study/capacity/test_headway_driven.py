"""Least headways driven: two trains of one kind as near to each other as the headways say, and a second nearer.

Both run as fast as units drive and stand no longer than they must. Then the second can follow the first as soon as the
greatest of its headways to it is kept, and a second less makes it late.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, replace

import pytest

from radio.air import DelayShape
from simulation.result import RunResult
from simulation.setup import STEP_S, Setup
from study.capacity import headway as module
from study.capacity.headway import HeadwayKind, line_cases
from study.capacity.observed import observed
from study.capacity.standard import StandardPath, added, extended, standard_paths
from study.run.run import CarrierKind, Link, execute
from study.scenario.scenario import Scenario, load_scenario

LEAD_S = 0.5  # a unit that asks no sooner than it must has no time to ask again
FAR_S = 14_400
NEAR_S = 0.5  # who is later than that by another train is late
FOLLOWS = frozenset({HeadwayKind.FOLLOWING})


@dataclass(frozen=True)
class Pair:
    """Two trains of one standard path, the second so much later."""

    scenario: Scenario
    path: StandardPath

    def setup(self, apart_s: int) -> Setup:
        setup, legs = self.scenario.setup, 100
        both = [added(setup, self.path, n, [apart_s if n == 2 else 0] * legs) for n in (1, 2)]
        bare = replace(setup, timetable=replace(setup.timetable, trains={}, diagrams=()))
        return extended(bare, [(one, self.path) for one in both])

    def run(self, apart_s: int) -> tuple[Setup, RunResult]:
        setup = self.setup(apart_s)
        scenario = replace(self.scenario, setup=setup)
        return setup, execute(scenario, Link.SIMULATED, carrier=CarrierKind.PLAIN).result

    def times_s(self, result: RunResult, apart_s: int) -> list[float]:
        """Arrivals and departures of the second train, against its plan."""
        own = [s for s in result.stops if s.stock_id == "X2"]
        times = [t for s in own for t in (s.arrival_s, s.departure_s) if t is not None]
        return [t - apart_s for t in times]


def pair_of(name: str, path: int) -> Pair:
    scenario = load_scenario(name)
    setup = scenario.setup
    air = setup.air.model_copy(
        update={
            "delay_min_s": 0.2,
            "delay_mean_s": 0.2,
            "delay_shape": DelayShape.CONSTANT,
            "loss_good_p": 0.0,
        }
    )
    unit = setup.unit.model_copy(update={"request_lead_s": LEAD_S})
    load = setup.load.model_copy(update={"load_share_spread": 0.0})
    setup = replace(setup, air=air, unit=unit, load=load)
    return Pair(replace(scenario, setup=setup), standard_paths(setup)[path])


def greatest_s(
    setup: Setup, result: RunResult, apart_s: int, kinds: Collection[HeadwayKind] = FOLLOWS
) -> float:
    """How near the second may be by all headways of some kinds, the first before the second wherever they go."""
    cases = line_cases(setup.line, observed(result, setup), setup.unit.dwell_min_s)
    found = [c.closest.buffer_s for c in cases if c.closest is not None and c.headway.kind in kinds]
    return apart_s - min(found)


def late_s(pair: Pair, apart_s: int, alone_s: list[float]) -> float:
    """By how much the first train makes the second late at most, s; infinite where that does not come."""
    _, result = pair.run(apart_s)
    times_s = pair.times_s(result, apart_s)
    if len(times_s) < len(alone_s):
        return math.inf
    return max(b - a for a, b in zip(alone_s, times_s, strict=True))


@dataclass(frozen=True)
class Driven:
    """How late the second train is at the greatest of the least headways, in whole seconds, and a second nearer, s.

    What frees a section and who asks for it come in any order within a step, so that one is added.
    """

    least_s: int
    kept_s: float
    nearer_s: float


def driven(pair: Pair, kinds: Collection[HeadwayKind] = FOLLOWS) -> Driven:
    setup, far = pair.run(FAR_S)
    least_s = math.ceil(greatest_s(setup, far, FAR_S, kinds) + STEP_S)
    alone_s = pair.times_s(far, FAR_S)
    return Driven(least_s, late_s(pair, least_s, alone_s), late_s(pair, least_s - 1, alone_s))


@pytest.mark.parametrize("path", [0, 1])
def test_a_least_headway_can_be_driven_and_a_second_less_is_late(path: int) -> None:
    """Down and up the busy line, from portal to portal."""
    found = driven(pair_of("busy_line", path))
    assert found.kept_s <= NEAR_S
    assert found.nearer_s > NEAR_S


def test_without_the_way_in_the_second_train_is_late(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "WAY_IN_COUNTS", False)
    assert driven(pair_of("busy_line", 0)).kept_s > NEAR_S


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["busy_line", "karasuyama_weekday"])
def test_no_least_headway_is_below_what_a_run_needs(name: str) -> None:
    """All kinds, on all standard paths: on the Karasuyama line to the one track of its terminus and back."""
    paths = standard_paths(load_scenario(name).setup)
    assert paths
    for path in range(len(paths)):
        assert driven(pair_of(name, path), tuple(HeadwayKind)).kept_s <= NEAR_S
