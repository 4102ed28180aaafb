"""What days say together: means, quantiles and shares with intervals that hold the truth as often as they say.

Means by Student's t; quantiles by order statistics, which need no shape; shares of days by Wilson (1927), which stays
within 0 and 1. Differences of points are taken seed by seed: what the seed does to both drops out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import stats

QUANTILES: Final = (0.05, 0.25, 0.5, 0.75, 0.95)
DIGITS: Final = 6


@dataclass(frozen=True, slots=True)
class Estimate:
    """A figure with its confidence interval; of `days` days. None where there are too few."""

    days: int
    value: float | None
    low: float | None = None
    high: float | None = None

    @property
    def width(self) -> float | None:
        """Of the interval; None where there is none."""
        return None if self.low is None or self.high is None else self.high - self.low

    @property
    def apart_from_0(self) -> bool:
        """Whether the interval lies on one side of 0: a difference that chance alone hardly makes."""
        return self.low is not None and self.high is not None and (self.low > 0.0 or self.high < 0.0)

    @property
    def text(self) -> str:
        """For a person: the value, and half its interval."""
        if self.value is None:
            return "-"
        return f"{self.value:.4g}" + ("" if self.width is None else f" ± {self.width / 2.0:.2g}")

    def as_dict(self) -> dict[str, float | int | None]:
        """For JSON."""
        return {"days": self.days, "value": self.value, "low": self.low, "high": self.high}


class Running:
    """Mean and scatter of figures as they come, one at a time (Welford 1962)."""

    def __init__(self) -> None:
        self.count = 0
        self.mean = 0.0
        self._squares = 0.0

    def add(self, value: float) -> None:
        """One more."""
        self.count += 1
        step = value - self.mean
        self.mean += step / self.count
        self._squares += step * (value - self.mean)

    def estimate(self, confidence: float) -> Estimate:
        """The mean so far."""
        return _mean(self.count, self.mean, self._squares, confidence)


def mean_of(values: Sequence[float], confidence: float) -> Estimate:
    """The mean, by Student's t."""
    running = Running()
    for value in values:
        running.add(value)
    return running.estimate(confidence)


def quantile_of(values: Sequence[float], share: float, confidence: float) -> Estimate:
    """A quantile between order statistics, and the two between which the true one lies; none of few days.

    The number of values below the true quantile is binomial: Conover, Practical Nonparametric Statistics, 3.2.
    """
    ordered: NDArray[np.float64] = np.sort(np.asarray(values, dtype=np.float64))
    count = len(ordered)
    if not count:
        return Estimate(0, None)
    value = _rounded(float(np.quantile(ordered, share)))
    tail = (1.0 - confidence) / 2.0
    below = int(stats.binom.ppf(tail, count, share))
    above = int(stats.binom.ppf(1.0 - tail, count, share)) + 1
    # P(X(below) <= quantile) needs one step down where the binomial has already more than the tail below it.
    if below and stats.binom.cdf(below - 1, count, share) > tail:
        below -= 1
    if below < 1 or above > count:
        return Estimate(count, value)
    return Estimate(count, value, _rounded(float(ordered[below - 1])), _rounded(float(ordered[above - 1])))


def share_of(hits: int, days: int, confidence: float) -> Estimate:
    """A share of days, by Wilson."""
    if not days:
        return Estimate(0, None)
    interval = stats.binomtest(hits, days).proportion_ci(confidence, method="wilson")
    return Estimate(
        days, _rounded(hits / days), _rounded(float(interval.low)), _rounded(float(interval.high))
    )


def difference_of(pairs: Sequence[tuple[float, float]], confidence: float) -> Estimate:
    """The mean of second less first, pair by pair."""
    return mean_of([second - first for first, second in pairs], confidence)


def _mean(count: int, mean: float, squares: float, confidence: float) -> Estimate:
    if not count:
        return Estimate(0, None)
    value = _rounded(mean)
    if count < 2:
        return Estimate(count, value)
    error = math.sqrt(squares / (count - 1) / count)
    reach = float(stats.t.ppf(0.5 + confidence / 2.0, count - 1)) * error
    return Estimate(count, value, _rounded(mean - reach), _rounded(mean + reach))


def _rounded(value: float) -> float:
    return round(value, DIGITS)
