"""Energy of one hop over its running time, from a few solutions: convex, falling, with its price -dE/dT at each.

Between two solutions the truth lies above both tangents and below the chord. The curve used for planning lies
between them: its price goes straight from a solution's to the chord's, which it has where the tangents meet, and from
there straight to the next one's. So it is convex, has the energies and prices of all solutions, and can be inverted.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle.optimum.price_graph import FOREVER_S, PRICE_MAX_W, PriceGraph, graph_of

SAME_TIME_S: Final = 1e-6  # solutions nearer than this count as one


@dataclass(frozen=True, slots=True)
class ParetoPoint:
    """One solution of a hop. `price_w`: what one more second would save, W; nan: as its neighbours tell.

    `bound_j`: no run in `time_s` needs less, proven, such that `bound_j - price_w * (T - time_s)` is a bound for any
    other time T too; minus infinity: nothing is proven.
    """

    time_s: float
    energy_j: float
    price_w: float
    bound_j: float = -math.inf


@dataclass(frozen=True, slots=True)
class HopCurve:
    """Energy over running time of one hop, from the least time on; made by `curve_of`.

    `may_wait`: the train may be there earlier and stand, so more time than the longest costs nothing and saves nothing;
    else the longest is the most that the hop may take.
    """

    points: tuple[ParetoPoint, ...]
    may_wait: bool = True
    graph: PriceGraph = field(init=False, repr=False, compare=False)
    _falls_j: NDArray[np.float64] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        graph = _graph(self.points, self.may_wait)
        falls = 0.5 * (graph.price_w[1:] + graph.price_w[:-1]) * np.diff(graph.time_s)
        object.__setattr__(self, "graph", graph)
        object.__setattr__(self, "_falls_j", np.concatenate(([0.0], np.cumsum(falls))))

    @property
    def least_s(self) -> float:
        """The shortest running time."""
        return self.points[0].time_s

    @property
    def longest_s(self) -> float:
        """The running time beyond which nothing is known to be saved."""
        return self.points[-1].time_s

    def energy_j(self, time_s: float) -> float:
        """Energy, J; infinite below the least running time, and above the longest where the train may not wait."""
        if time_s < self.least_s - SAME_TIME_S or (
            time_s > self.longest_s + SAME_TIME_S and not self.may_wait
        ):
            return math.inf
        time_s = min(max(time_s, self.least_s), self.longest_s)
        at = int(np.searchsorted(self.graph.time_s, time_s, side="right")) - 1
        at = min(at, len(self.graph.time_s) - 2)
        begin, end = self.graph.time_s[at], self.graph.time_s[at + 1]
        high, low = self.graph.price_w[at], self.graph.price_w[at + 1]
        along = time_s - begin
        mean = high + 0.5 * (low - high) * (along / (end - begin) if end > begin else 0.0)
        return float(self.points[0].energy_j - self._falls_j[at] - mean * along)

    def price_w(self, time_s: float) -> float:
        """What one more second saves, W; at a kink the least that it saves."""
        return max(self.graph.prices_w(time_s)[0], 0.0)


def curve_of(points: Iterable[ParetoPoint], *, may_wait: bool = True) -> HopCurve:
    """The curve through solutions of one hop, in any order, without those that are no better than a mean of others.

    Prices that do not lie between the neighbouring chords (solutions are exact to their gap alone) are brought there.
    ValueError without a solution.
    """
    hull: list[ParetoPoint] = []
    for point in sorted(points, key=lambda p: (p.time_s, p.energy_j)):
        if hull and (point.time_s - hull[-1].time_s < SAME_TIME_S or point.energy_j >= hull[-1].energy_j):
            continue
        while len(hull) > 1 and _saving_w(hull[-2], hull[-1]) <= _saving_w(hull[-1], point):
            hull.pop()
        hull.append(point)
    if not hull:
        raise ValueError("a hop has at least one solution")
    chords = [_saving_w(*pair) for pair in pairwise(hull)]
    made = (
        ParetoPoint(p.time_s, p.energy_j, price_w, p.bound_j)
        for p, price_w in zip(hull, _prices_w(hull, chords), strict=True)
    )
    return HopCurve(tuple(made), may_wait)


def _prices_w(hull: Sequence[ParetoPoint], chords: Sequence[float]) -> Iterator[float]:
    """Each solution's price, between those of the chords beside it.

    Where it is not known, the chords' mean; at the least time, where prices rise without end, as far above the chord
    as twice what the next price is below it.
    """
    for i, point in enumerate(hull):
        high = chords[i - 1] if i > 0 else PRICE_MAX_W
        low = chords[i] if i < len(chords) else 0.0
        price_w = point.price_w
        if math.isnan(price_w) and i > 0:
            price_w = 0.5 * (high + low)
        elif math.isnan(price_w):
            beyond = hull[1].price_w if len(hull) > 1 else low
            price_w = low if math.isnan(beyond) else 3.0 * low - 2.0 * min(beyond, low)
        yield min(max(price_w, low), high)


def proportional_curve(least_s: float) -> HopCurve:
    """A cost of which the least sum stretches all running times alike: least_s^2 / T, at ratios that all hops share."""
    ratios = np.geomspace(1.0, 20.0, 60)
    return curve_of(ParetoPoint(least_s * r, least_s / r, 1.0 / (r * r)) for r in ratios.tolist())


def _saving_w(before: ParetoPoint, after: ParetoPoint) -> float:
    """Mean price between two solutions, W."""
    return (before.energy_j - after.energy_j) / (after.time_s - before.time_s)


def _graph(points: Sequence[ParetoPoint], may_wait: bool) -> PriceGraph:
    """The price over the running time: straight from solution to chord to solution (module's docstring)."""
    first, last = points[0], points[-1]
    line = [(first.time_s, PRICE_MAX_W), (first.time_s, first.price_w)]
    for here, there in pairwise(points):
        chord = min(max(_saving_w(here, there), there.price_w), here.price_w)
        spread = here.price_w - there.price_w
        share = (chord - there.price_w) / spread if spread > 0.0 else 1.0
        meet_s = min(here.time_s + share * (there.time_s - here.time_s), there.time_s)
        line += [(meet_s, chord), (there.time_s, there.price_w)]
    if may_wait:
        line += [(last.time_s, 0.0), (max(FOREVER_S, last.time_s), 0.0)]
    return graph_of([*line, (line[-1][0], -PRICE_MAX_W)])
