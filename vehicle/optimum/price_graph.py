"""Decreasing graphs of a price over a time: what a convex cost looks like by its slope, and how such costs are joined.

A convex cost f of a time x is kept as the graph of its price p = -f'(x), W: a line of points from the earliest time to
the latest in which the price never rises. Where the price jumps the graph is upright (f has a kink, or ends), where it
stays it is level (f is straight). Everything here is exact on such lines; nothing is iterated.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

PRICE_MAX_W: Final = 1e12  # no train saves so much: stands for a price without bound
FOREVER_S: Final = 1e7  # later than any plan: stands for a time without bound


class NoTimeLeft(Exception):  # noqa: N818 - a planner's finding, not a program error
    """No time is left; by how much, s: positive, the earliest is too late; negative, the latest is too early."""

    def __init__(self, late_s: float) -> None:
        super().__init__(late_s)
        self.late_s = late_s


@dataclass(frozen=True, slots=True)
class PriceGraph:
    """Points (time, price): times never fall, prices never rise, from `PRICE_MAX_W` down to minus that."""

    time_s: NDArray[np.float64]
    price_w: NDArray[np.float64]

    def first_s(self, price_w: NDArray[np.float64]) -> NDArray[np.float64]:
        """The earliest time that has each price."""
        at = np.searchsorted(-self.price_w, -price_w, side="left")
        at = np.clip(at, 1, len(self.time_s) - 1)
        return self._between(at, price_w)

    def last_s(self, price_w: NDArray[np.float64]) -> NDArray[np.float64]:
        """The latest time that has each price."""
        at = np.searchsorted(-self.price_w, -price_w, side="right")
        at = np.clip(at, 1, len(self.time_s) - 1)
        return self._between(at, price_w)

    def _between(self, at: NDArray[np.intp], price_w: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where the part of the graph that ends in point `at` has a price."""
        high, low = self.price_w[at - 1], self.price_w[at]
        drop = high - low
        share = np.where(drop > 0.0, (high - price_w) / np.where(drop > 0.0, drop, 1.0), 1.0)
        begin, end = self.time_s[at - 1], self.time_s[at]
        share = np.clip(share, 0.0, 1.0)
        return np.where(share >= 1.0, end, begin + (end - begin) * share)

    def prices_w(self, time_s: float) -> tuple[float, float]:
        """The least and the greatest price at a time, W; that of the nearest end outside of the graph."""
        first, last = self.time_s[0], self.time_s[-1]
        time_s = min(max(time_s, first), last)
        return self._price_w(time_s, "right"), self._price_w(time_s, "left")

    def _price_w(self, time_s: float, side: str) -> float:
        at = int(np.searchsorted(self.time_s, time_s, side="left" if side == "left" else "right"))
        if side == "left":
            if self.time_s[at] == time_s:
                return float(self.price_w[at])
        elif self.time_s[at - 1] == time_s:
            return float(self.price_w[at - 1])
        begin, end = self.time_s[at - 1], self.time_s[at]
        share = (time_s - begin) / (end - begin)
        return float(self.price_w[at - 1] + (self.price_w[at] - self.price_w[at - 1]) * share)

    def joined_with(self, other: PriceGraph) -> PriceGraph:
        """The least sum of both costs over all ways to part a time between them: times add at equal prices."""
        prices = np.unique(np.concatenate((self.price_w, other.price_w)))[::-1]
        first = self.first_s(prices) + other.first_s(prices)
        last = self.last_s(prices) + other.last_s(prices)
        times = np.empty(2 * len(prices))
        times[0::2], times[1::2] = first, np.maximum(first, last)
        return PriceGraph(np.maximum.accumulate(times), np.repeat(prices, 2))

    def in_window(self, earliest_s: float, latest_s: float, tolerance_s: float) -> PriceGraph:
        """The same cost for times in a window alone. `NoTimeLeft` where no time is left by more than the tolerance."""
        first, last = float(self.time_s[0]), float(self.time_s[-1])
        if first > latest_s + tolerance_s:
            raise NoTimeLeft(first - latest_s)
        if last < earliest_s - tolerance_s:
            raise NoTimeLeft(last - earliest_s)
        low = min(max(earliest_s, first), last)
        high = max(min(latest_s, last), low)
        if high <= low:
            return PriceGraph(np.array([low, low]), np.array([PRICE_MAX_W, -PRICE_MAX_W]))
        inside = (self.time_s > low) & (self.time_s < high)
        below, above = self.prices_w(low)[0], self.prices_w(high)[1]
        return PriceGraph(
            np.concatenate(([low, low], self.time_s[inside], [high, high])),
            np.concatenate(([PRICE_MAX_W, below], self.price_w[inside], [above, -PRICE_MAX_W])),
        )


def graph_of(points: list[tuple[float, float]]) -> PriceGraph:
    """The graph through points (time, price) in order. ValueError where a time falls or a price rises."""
    time_s, price_w = (np.array(column, dtype=np.float64) for column in zip(*points, strict=True))
    if bool(np.any(np.diff(time_s) < 0.0)) or bool(np.any(np.diff(price_w) > 0.0)):
        raise ValueError("times that never fall and prices that never rise")
    return PriceGraph(time_s, price_w)


def free_between(least_s: float, most_s: float) -> PriceGraph:
    """A time that costs nothing from `least_s` to `most_s` and may not be another."""
    return graph_of([(least_s, PRICE_MAX_W), (least_s, 0.0), (most_s, 0.0), (most_s, -PRICE_MAX_W)])
