"""What days say together: means, quantiles and shares with intervals that hold the truth as often as they say.

Means by Student's t corrected for skewness (Hall 1992): figures of late days are mostly small and now and then large,
and of such a figure Student's interval holds the truth too seldom. Quantiles by order statistics, which need no shape;
shares of days by Wilson (1927), which stays within 0 and 1. Differences of points are taken seed by seed: what the seed
does to both drops out. Where days are looked at again and again until an interval is narrow, each look has its share of
what the interval may be wrong (Bonferroni), so that all of them hold together.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy  # it loads `stats`, which takes long, as that is asked for
from numpy.typing import NDArray

QUANTILES: Final = (0.05, 0.25, 0.5, 0.75, 0.95)
DIGITS: Final = 6
SKEW_MIN: Final = 1e-6  # less makes no difference
LATER: Final = 1.5  # assumed: so many times as many days at the next look


@dataclass(frozen=True, slots=True)
class FigureEstimate:
    """A figure with its confidence interval; of `days` days. None where there are too few, or all are alike.

    `wrong_max`: the chance that it may be wrong, of days that are all alike.
    """

    days: int
    value: float | None
    low: float | None = None
    high: float | None = None
    wrong_max: float = 0.0

    @property
    def width(self) -> float | None:
        """Of the interval; None where there is none."""
        return None if self.low is None or self.high is None else self.high - self.low

    @property
    def apart_from_0(self) -> bool:
        """Whether the interval lies on one side of 0: a difference that chance alone hardly makes.

        Of days that are all alike by the sign test: at 95 % six of them or more.
        """
        if self.low is None or self.high is None:
            return bool(self.value) and 0.5 ** (self.days - 1) < self.wrong_max
        return self.low > 0.0 or self.high < 0.0

    @property
    def text(self) -> str:
        """For a person: the value, and its interval."""
        if self.value is None:
            return "-"
        interval = "" if self.low is None or self.high is None else f" ({self.low:.4g} to {self.high:.4g})"
        return f"{self.value:.4g}{interval}"

    def as_dict(self) -> dict[str, float | int | None]:
        """For JSON."""
        return {"days": self.days, "value": self.value, "low": self.low, "high": self.high}


class RunningMoments:
    """Mean, scatter and skewness of figures as they come, one at a time (Welford 1962, Pébay 2008)."""

    def __init__(self) -> None:
        self.count = 0
        self.mean = 0.0
        self._squares = 0.0
        self._cubes = 0.0

    def add(self, value: float) -> None:
        """One more."""
        self.count += 1
        step = value - self.mean
        part = step / self.count
        self.mean += part
        square = step * (value - self.mean)
        self._cubes += square * part * (self.count - 2) - 3.0 * part * self._squares
        self._squares += square

    def estimate(self, confidence: float) -> FigureEstimate:
        """The mean so far; without an interval while none differs: how far others would, such days do not say."""
        if not self.count:
            return FigureEstimate(0, None)
        value = _rounded(self.mean)
        if self._squares <= 0.0:
            return FigureEstimate(self.count, value, wrong_max=1.0 - confidence)
        error = math.sqrt(self._squares / (self.count - 1) / self.count)
        reach = float(scipy.stats.t.ppf(0.5 + confidence / 2.0, self.count - 1))
        above, below = (_uncorrected(t, self._skewness / math.sqrt(self.count)) for t in (-reach, reach))
        low, high = self.mean - below * error, self.mean - above * error
        return FigureEstimate(self.count, value, _rounded(low), _rounded(high))

    @property
    def _skewness(self) -> float:
        """Of the figures so far; 0 where there are too few to see any."""
        if self.count < 3:
            return 0.0
        count = self.count
        biased = self._cubes / count / math.pow(self._squares / count, 1.5)
        return biased * math.sqrt(count * (count - 1)) / (count - 2)


def mean_of(values: Sequence[float], confidence: float) -> FigureEstimate:
    """The mean, by Student's t corrected for skewness."""
    running = RunningMoments()
    for value in values:
        running.add(value)
    return running.estimate(confidence)


def quantile_of(values: Sequence[float], share: float, confidence: float) -> FigureEstimate:
    """A quantile between order statistics, and the two between which the true one lies; none of few days.

    The number of values below the true quantile is binomial: Conover, Practical Nonparametric Statistics, 3.2.
    """
    ordered: NDArray[np.float64] = np.sort(np.asarray(values, dtype=np.float64))
    count = len(ordered)
    if not count:
        return FigureEstimate(0, None)
    value = _rounded(float(np.quantile(ordered, share)))
    tail = (1.0 - confidence) / 2.0
    below = int(scipy.stats.binom.ppf(tail, count, share))
    above = int(scipy.stats.binom.ppf(1.0 - tail, count, share)) + 1
    if below < 1 or above > count:
        return FigureEstimate(count, value)
    return FigureEstimate(
        count, value, _rounded(float(ordered[below - 1])), _rounded(float(ordered[above - 1]))
    )


def share_of(hits: int, days: int, confidence: float) -> FigureEstimate:
    """A share of days, by Wilson."""
    if not days:
        return FigureEstimate(0, None)
    interval = scipy.stats.binomtest(hits, days).proportion_ci(confidence, method="wilson")
    return FigureEstimate(
        days, _rounded(hits / days), _rounded(float(interval.low)), _rounded(float(interval.high))
    )


def difference_of(pairs: Sequence[tuple[float, float]], confidence: float) -> FigureEstimate:
    """The mean of second less first, pair by pair; what rounding alone makes differ is alike."""
    return mean_of([_rounded(second - first) for first, second in pairs], confidence)


def looks(least_days: int, days: int) -> tuple[int, ...]:
    """After how many days it is looked whether an interval is narrow enough: half as many again each time, and all."""
    found: list[int] = []
    at = min(least_days, days)
    while at < days:
        found.append(at)
        at = math.ceil(LATER * at)
    return (*found, days)


def of_each_look(confidence: float, count: int) -> float:
    """The confidence of one of so many intervals that are to hold together."""
    return 1.0 - (1.0 - confidence) / count


def _uncorrected(t: float, skew: float) -> float:
    """The t that Hall's transformation takes to this one (Annals of Statistics 20, 1992, equation 2.3), by its inverse.

    It takes the skewness out of the t of a mean and is monotone: g(t) = t + skew t^2/3 + skew^2 t^3/27 + skew/6, where
    `skew` is that of the figures by the root of their count.
    """
    if abs(skew) < SKEW_MIN:
        return t
    return 3.0 / skew * (math.cbrt(1.0 + skew * (t - skew / 6.0)) - 1.0)


def _rounded(value: float) -> float:
    return round(value, DIGITS)
