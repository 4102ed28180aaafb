"""From which distance and speed every brake of a stated range stops inside the window: computed, not sampled.

A state is a distance to the mark and a speed, the train coasting, its position known. Against it stands every brake
whose dead time, lag, deceleration and adhesion lie in RANGES; the unit believes the middle. What holds exactly:

- adhesion: the rail only ever caps what the wheel passes on, so a stop in which no wheel slides is the same, to the
  bit, at any higher adhesion. Adhesions are tried from the least on, and only where the last one made wheels slide.
- dead time: the brake's counts whole steps of 0.1 s, so its range is five values, all of them tried.
- coasting: until the brake is asked for, a start is a later moment of any start further back on the same coasting
  curve. States from where braking begins down to the mark are all that must be computed.
- any law: no service brake stops sooner than the weakest one, fully asked for at once within the greatest jerk (3.2.3).
  What overruns the window even so (`outer_m`) is beyond every law.

What is numerical: between the points of the grid of speed, distance, lag, deceleration and adhesion a stop may end
outside what its neighbours span. MARGIN_M of the window is kept for that, and the edge is drawn one step further out;
`beyond_the_grid_m` measures how much of the margin is used, and stops drawn anew try the set.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from papers.parameter_sets import LINE
from papers.single_run import Rows, new_stops
from papers.single_train import Bench
from papers.specification import Evenly
from papers.stop_statistics import FACTORS, statistics_bench

Floats = NDArray[np.float64]

WINDOW_M: Final = 1.0  # Oda, 2.2
MARGIN_M: Final = 0.1
SPEED_LEAST_MPS: Final = (
    2.0  # of the set; the grid begins lower, since coasting trains slow down on their way
)
GRID_FROM_MPS: Final = 1.0
GRID_TO_MPS: Final = 25.0
BEYOND_M: Final = 50.0  # coasting before the brake, at most
STRIP_STEPS: Final = 4
TOP_SHARE: Final = 0.9  # coasting trains enter the grid above this


@dataclass(frozen=True, slots=True)
class BrakeRange(Evenly):
    """What a quantity of the brake may be; `tried` are the values of the grid."""

    tried: tuple[float, ...] = ()


RANGES: Final[Mapping[str, BrakeRange]] = {
    each.name: each
    for each in (
        BrakeRange(
            "dead_time",
            0.8,
            1.2,
            "s",
            "assumed: two steps of the learner's grid either way",
            (0.8, 0.9, 1.0, 1.1, 1.2),
        ),
        BrakeRange("lag", 0.2, 0.4, "s", "as in stop-statistics, its sigma as the range", (0.2, 0.3, 0.4)),
        BrakeRange(
            "brake",
            0.9,
            1.1,
            "of its design",
            "stop-statistics: 3 sigma of 2 %, 3 % by load, rounded up",
            (0.9, 1.0, 1.1),
        ),
        BrakeRange(
            "adhesion",
            0.4,
            1.0,
            "of the dry one",
            "the least in rain of oda-tuning",
            (0.4, 0.45, 0.5, 0.6, 0.8),
        ),
    )
}
BRAKES: Final = tuple(product(*(RANGES[name].tried for name in ("dead_time", "lag", "brake"))))


@dataclass(frozen=True, slots=True)
class StopGrid:
    """How finely it is computed."""

    speed_step_mps: float = 0.5
    shares: int = 41
    to_mps: float = GRID_TO_MPS

    @property
    def speeds_mps(self) -> Floats:
        """Columns of the grid."""
        return np.arange(GRID_FROM_MPS, self.to_mps + 1e-9, self.speed_step_mps)


WHOLE_GRID: Final = StopGrid()
QUICK_GRID: Final = StopGrid(1.0, 21)


@dataclass(frozen=True, slots=True)
class StopSet:
    """The set, by columns of speed, shape (n,); `share` 0 is the least distance any law needs, 1 where braking begins.

    `least_m` and `most_m`, shape (n, m): where the stops of all brakes end, m past the mark.
    """

    speeds_mps: Floats
    outer_m: Floats
    begin_m: Floats
    shares: Floats
    least_m: Floats
    most_m: Floats
    lowest: Floats  # least share from which on up everything is in the window; inf: none

    @property
    def top_mps(self) -> float:
        """The speed up to which the set reaches without a gap."""
        holds = self.lowest <= TOP_SHARE
        first_out = int(np.argmin(holds)) if not holds.all() else holds.size
        return float(self.speeds_mps[first_out - 1]) if first_out > 0 else 0.0

    @property
    def is_empty(self) -> bool:
        """Whether it does not even reach one column above SPEED_LEAST_MPS."""
        return self.top_mps <= SPEED_LEAST_MPS

    def _column(self, speeds_mps: Floats) -> tuple[NDArray[np.int64], Floats]:
        step_mps = self.speeds_mps[1] - self.speeds_mps[0]
        at = (speeds_mps - self.speeds_mps[0]) / step_mps
        column = np.clip(np.floor(at).astype(np.int64), 0, self.speeds_mps.size - 2)
        return column, at - column

    def distance_m(self, shares: Floats, speeds_mps: Floats) -> Floats:
        """Distances to the mark at these shares and speeds, m."""
        outer_m = np.interp(speeds_mps, self.speeds_mps, self.outer_m)
        return outer_m + shares * (np.interp(speeds_mps, self.speeds_mps, self.begin_m) - outer_m)

    def least_share(self, speeds_mps: Floats) -> Floats:
        """Share from which on the set begins at these speeds: what both columns beside them ask for."""
        column, _ = self._column(speeds_mps)
        return np.maximum(self.lowest[column], self.lowest[column + 1])

    def spanned_m(self, shares: Floats, speeds_mps: Floats) -> tuple[Floats, Floats]:
        """Least and greatest end of a stop at the four points of the grid about each state, m."""
        column, _ = self._column(speeds_mps)
        row = np.clip((shares * (self.shares.size - 1)).astype(np.int64), 0, self.shares.size - 2)
        corners = [(column + i, row + j) for i in (0, 1) for j in (0, 1)]
        least = np.min([self.least_m[corner] for corner in corners], axis=0)
        most = np.max([self.most_m[corner] for corner in corners], axis=0)
        return least, most

    @property
    def strip(self) -> float:
        """Share of the way that counts as just outside: STRIP_STEPS of the grid."""
        return STRIP_STEPS / (self.shares.size - 1)

    def holds_share(self) -> float:
        """Of what any law could hold short of the beginning of the brake, the share that is in the set."""
        inside = (self.speeds_mps >= SPEED_LEAST_MPS) & (self.speeds_mps <= self.top_mps)
        room_m = (self.begin_m - self.outer_m)[inside]
        kept_m = np.clip(1.0 - self.lowest[inside], 0.0, 1.0) * room_m
        return float(kept_m.sum() / room_m.sum())


def stop_bench() -> Bench:
    """The train of stop-statistics; its controller believes in the middle of each range."""
    return statistics_bench(FACTORS["brake_lag"].mean)


def stops_from(distances_m: Floats, speeds_mps: Floats, brakes: Floats, adhesions: Floats) -> Rows:
    """Stops, shape (n,): distance, speed, brakes (n, 3: dead time s, lag s, factor) and adhesion of each."""
    train = stop_bench().prepared["board"]["kind"][0]
    stops = new_stops(distances_m.size)
    stops["start_m"], stops["speed_mps"] = distances_m, speeds_mps
    stops["brake_dead_time_off_s"] = brakes[:, 0] - float(train["brake_dead_time_s"])
    stops["brake_lag_off_s"] = brakes[:, 1] - float(train["brake_lag_s"])
    stops["brake_factor"] = brakes[:, 2]
    stops["adhesion_factor"] = adhesions
    return stops


def spanned_by_brakes_m(distances_m: Floats, speeds_mps: Floats) -> tuple[Floats, Floats]:
    """Least and greatest end of the stops of all brakes of the grid from each state, shape (n,), m past the mark."""
    least, most = np.full(distances_m.size, np.inf), np.full(distances_m.size, -np.inf)
    state = np.repeat(np.arange(distances_m.size), len(BRAKES))
    brakes = np.tile(np.array(BRAKES), (distances_m.size, 1))
    for adhesion in RANGES["adhesion"].tried:
        adhesions = np.full(state.size, adhesion)
        outcomes, _ = stop_bench().run(stops_from(distances_m[state], speeds_mps[state], brakes, adhesions))
        np.minimum.at(least, state, outcomes["error_m"])
        np.maximum.at(most, state, outcomes["error_m"])
        slid = outcomes["slid_steps"] > 0
        state, brakes = state[slid], brakes[slid]
        if state.size == 0:
            break
    return least, most


def outer_distances_m(speeds_mps: Floats) -> Floats:
    """Least distance from which the weakest brake, asked for fully and at once, stops inside the window, m."""
    weakest = (RANGES["dead_time"].high, RANGES["lag"].high, RANGES["brake"].low)
    brakes = np.tile(np.array(weakest), (speeds_mps.size, 1))
    near = np.full(speeds_mps.size, 0.01)  # a mark just ahead: the law asks for all there is
    adhesions = np.full(speeds_mps.size, RANGES["adhesion"].low)
    hardest = stop_bench()
    hardest.design.pattern_mps2 = hardest.design.end_mps2 = hardest.design.brake_max_mps2
    outcomes, _ = hardest.run(stops_from(near, speeds_mps, brakes, adhesions))
    return np.array(outcomes["error_m"] + near - WINDOW_M, dtype=np.float64)


def begin_distances_m(speeds_mps: Floats) -> Floats:
    """Distances at which no train brakes yet, and soon will, m: the pattern's, its reaction, and some 0.3 s more."""
    pattern_mps2 = LINE.driving.stop_deceleration_mps2
    return np.asarray(speeds_mps**2 / (2.0 * pattern_mps2) + 1.7 * speeds_mps + 2.0)


def stop_set(grid: StopGrid = WHOLE_GRID) -> StopSet:
    """Compute the set on a grid of speeds and distances."""
    speeds = grid.speeds_mps
    shares = np.linspace(0.0, 1.0, grid.shares)
    outer, begin = outer_distances_m(speeds), begin_distances_m(speeds)
    distances = outer[:, None] + shares[None, :] * (begin - outer)[:, None]
    least, most = spanned_by_brakes_m(distances.ravel(), np.repeat(speeds, shares.size))
    least, most = least.reshape(distances.shape), most.reshape(distances.shape)
    return StopSet(speeds, outer, begin, shares, least, most, lowest_shares(shares, least, most))


def lowest_shares(shares: Floats, least_m: Floats, most_m: Floats) -> Floats:
    """Least share of each column from which on up every stop ends in the window less MARGIN_M; inf: none.

    One step of the grid further out than that: where wheels slide, stops change abruptly, and the edge is no place to
    trust neighbours on one side alone.
    """
    room_m = WINDOW_M - MARGIN_M
    held = (least_m >= -room_m) & (most_m <= room_m)
    above = np.flip(np.logical_and.accumulate(np.flip(held, axis=1), axis=1), axis=1)
    first = np.argmax(above, axis=1) + 1
    some = above.any(axis=1) & (first < shares.size)
    return np.where(some, shares[np.minimum(first, shares.size - 1)], np.inf)


def random_brakes(rng: np.random.Generator, n: int) -> tuple[Floats, Floats]:
    """Brakes (n, 3) and adhesions (n,) anywhere in their ranges, a tenth of the values at their ends."""
    columns = [within.at(np.clip(rng.uniform(-0.05, 1.05, n), 0.0, 1.0)) for within in RANGES.values()]
    return np.stack(columns[:3], axis=1), columns[3]


def corner_brakes(rng: np.random.Generator, n: int) -> tuple[Floats, Floats]:
    """Brakes (n, 3) and adhesions (n,) at either end of their ranges."""
    columns = [
        np.where(rng.uniform(0.0, 1.0, n) < 0.5, within.low, within.high) for within in RANGES.values()
    ]
    return np.stack(columns[:3], axis=1), columns[3]


def random_states(found: StopSet, rng: np.random.Generator, n: int, *, beyond: bool) -> tuple[Floats, Floats]:
    """Shares and speeds of states in the set; half of them `beyond` the grid, coasting first, if asked for."""
    speeds = rng.uniform(SPEED_LEAST_MPS, found.top_mps, n)
    lowest = found.least_share(speeds)
    shares = lowest + rng.uniform(0.0, 1.0, n) * (1.0 - lowest)
    if beyond:
        at_one, at_zero = found.distance_m(np.ones(n), speeds), found.distance_m(np.zeros(n), speeds)
        further = 1.0 + rng.uniform(0.0, BEYOND_M, n) / (at_one - at_zero)
        shares = np.where(rng.uniform(0.0, 1.0, n) < 0.5, shares, further)
    return shares, speeds


def ends_m(found: StopSet, shares: Floats, speeds: Floats, brakes: Floats, adhesions: Floats) -> Floats:
    """Where stops from these states end by these brakes, m past the mark."""
    outcomes, _ = stop_bench().run(stops_from(found.distance_m(shares, speeds), speeds, brakes, adhesions))
    return np.array(outcomes["error_m"], dtype=np.float64)


def beyond_the_grid_m(found: StopSet, rng: np.random.Generator, n: int) -> float:
    """By how much `n` random stops from between the points of the grid leave what those points span, at most, m."""
    shares, speeds = random_states(found, rng, n, beyond=False)
    ends = ends_m(found, shares, speeds, *random_brakes(rng, n))
    least, most = found.spanned_m(shares, speeds)
    return float(np.maximum(ends - most, least - ends).max())
