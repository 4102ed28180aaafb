"""Energy of a whole journey by how its time is shared among the hops, beside a proven bound below every journey.

Hops are run by the optimum in whatever time they get, so that nothing but the sharing differs.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final

from vehicle.optimum import Course, TooShort
from vehicle.optimum.coast import fastest_j
from vehicle.optimum.journey import (
    JourneyStop,
    ProvenHop,
    TimedJourney,
    earliest_times,
    journey_bound_j,
    journey_times,
)
from vehicle.optimum.least import least_time_bound_s
from vehicle.optimum.mesh import laid_course
from vehicle.optimum.pareto import HopCurve, ParetoPoint, curve_of, proportional_curve
from vehicle.optimum.proof import proven_run
from vehicle.optimum.samples import STRETCHES
from vehicle.running_time import laid_down_s

ROUNDS: Final = 6  # of solving at the times found and sharing anew; the bound says whether they suffice
NEAR_LEAST: Final = (1.002, 1.005)  # multiples of the least time that are solved beside STRETCHES
GAP_ENOUGH: Final = 1e-4
JUST_POSSIBLE: Final = 1.001  # of the least time: a hop that gets less is run as fast as it can be


@dataclass(slots=True)
class SampledHop:
    """A hop, its least time, and all that was solved of it so far."""

    name: str
    course: Course
    least_s: float = field(init=False)
    points: dict[float, ParetoPoint] = field(init=False, default_factory=dict[float, ParetoPoint])
    _fastest_j: float = field(init=False)

    def __post_init__(self) -> None:
        found = laid_course(self.course)
        self.least_s, self._fastest_j = found.least_s, fastest_j(found)
        for stretch in (*NEAR_LEAST, *STRETCHES):
            self.energy_j(stretch * self.least_s)

    def energy_j(self, time_s: float) -> float:
        """Energy of the best run known in a running time, solved once, J: near the least time, of the fastest."""
        if time_s < JUST_POSSIBLE * self.least_s:
            return self._fastest_j
        if time_s not in self.points:
            try:
                found = proven_run(self.course, time_s)
            except TooShort:
                return self._fastest_j
            price_w = max(float(found.optimum.price_w), 0.0)  # the one of the bound's line, too
            self.points[time_s] = ParetoPoint(time_s, float(found.energy_j), price_w, float(found.bound_j))
        return self.points[time_s].energy_j

    def proven(self) -> ProvenHop:
        """What is proven of it so far."""
        return ProvenHop(tuple(self.points.values()), least_time_bound_s(self.course))

    def curve(self) -> HopCurve:
        """The curve through all that was solved."""
        return curve_of((ParetoPoint(self.least_s, self._fastest_j, math.nan), *self.points.values()))


@dataclass(frozen=True, slots=True)
class SharedTime:
    """One way to share the time of a journey: when, and what each hop costs, J."""

    journey: TimedJourney
    hops_j: tuple[float, ...]

    @property
    def energy_j(self) -> float:
        """Of the whole journey."""
        return sum(self.hops_j)


@dataclass(frozen=True, slots=True)
class JourneyEnergies:
    """The same journey in standard times, with its reserve in proportion, and with it where it saves most.

    `bound_j`: below which no journey within these windows can be, proven.
    """

    least_s: tuple[float, ...]
    standard: SharedTime
    proportional: SharedTime
    optimal: SharedTime
    bound_j: float

    @property
    def saving_percent(self) -> float:
        """What sharing by energy saves of the energy in proportion."""
        return 100.0 * (self.proportional.energy_j - self.optimal.energy_j) / abs(self.proportional.energy_j)

    @property
    def gap_percent(self) -> float:
        """How far the plan lies above the bound."""
        return 100.0 * (self.optimal.energy_j - self.bound_j) / abs(self.bound_j)


def journey_energies(hops: Sequence[SampledHop], stops: Sequence[JourneyStop]) -> JourneyEnergies:
    """All three ways to share a journey's time. `WindowMissed` where no journey keeps the windows."""
    least_s = [hop.least_s for hop in hops]
    standard_s = [float(laid_down_s(time_s)) for time_s in least_s]
    standard = _costed(hops, earliest_times(standard_s, least_s, stops))
    proportional = _costed(hops, journey_times([proportional_curve(time_s) for time_s in least_s], stops))
    best: SharedTime | None = None
    bound_j = -math.inf
    for _ in range(ROUNDS):
        found = _costed(hops, journey_times([hop.curve() for hop in hops], stops))
        best = found if best is None or found.energy_j < best.energy_j else best
        prices = [max(price, 0.0) for price in found.journey.prices_w]
        bound_j = max(bound_j, journey_bound_j([hop.proven() for hop in hops], stops, prices))
        if best.energy_j - bound_j <= GAP_ENOUGH * abs(bound_j):
            break
    return JourneyEnergies(tuple(least_s), standard, proportional, best or proportional, bound_j)


def _costed(hops: Iterable[SampledHop], journey: TimedJourney) -> SharedTime:
    """A journey with what its hops cost in the times that they get; time beyond what saves is stood off."""
    times = zip(hops, journey.running_s, strict=True)
    return SharedTime(journey, tuple(hop.energy_j(time_s) for hop, time_s in times))
