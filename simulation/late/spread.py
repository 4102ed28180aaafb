"""A time that is drawn from a named distribution: data, and the draw.

Exponential, lognormal, Weibull and gamma are given by their mean and one shape, so that a sweep over the mean changes
nothing else. `max_s` is a lid: what is drawn above it counts as it, so the mean of what happens is a little smaller.
"""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Annotated, Final, Self

import numpy as np
from pydantic import Field, model_validator

from network.files.chances import LogSigma, Shape
from network.files.kinds import about
from network.files.quantities import DrillTime, Duration
from network.files.toml_input import Record


class Distribution(StrEnum):
    """Distributions, by name."""

    EXPONENTIAL = "exponential"
    LOGNORMAL = "lognormal"
    WEIBULL = "weibull"
    GAMMA = "gamma"
    UNIFORM = "uniform"
    FIXED = "fixed"


NEEDS: Final = {
    Distribution.EXPONENTIAL: ("mean_s",),
    Distribution.LOGNORMAL: ("mean_s", "sigma"),
    Distribution.WEIBULL: ("mean_s", "shape"),
    Distribution.GAMMA: ("mean_s", "shape"),
    Distribution.UNIFORM: ("low_s", "high_s"),
    Distribution.FIXED: ("mean_s",),
}
_FIGURES: Final = ("mean_s", "sigma", "shape", "low_s", "high_s")


class DrawnTime(Record):
    """A time that is drawn: a distribution with its figures, and a lid."""

    distribution: Annotated[Distribution, Field(strict=False), about("name of the distribution")]
    mean_s: Annotated[Duration | None, about("mean, without the upper limit; for fixed, the time itself")] = (
        None
    )
    sigma: Annotated[LogSigma | None, about("lognormal: standard deviation of the logarithm")] = None
    shape: Annotated[
        Shape | None, about("Weibull and gamma: 1 is exponential, above it times cluster, below they scatter")
    ] = None
    low_s: Annotated[DrillTime | None, about("uniform: least")] = None
    high_s: Annotated[Duration | None, about("uniform: greatest")] = None
    max_s: Annotated[Duration | None, about("upper limit: greater draws count as this")] = None

    @model_validator(mode="after")
    def _figures_of_it(self) -> Self:
        needed = NEEDS[self.distribution]
        given = tuple(name for name in _FIGURES if getattr(self, name) is not None)
        if given != needed:
            raise ValueError(f"{' and '.join(needed)}, and no other figure, for {self.distribution.value}")
        if self.low_s is not None and self.high_s is not None and self.high_s < self.low_s:
            raise ValueError(f"high_s at least low_s = {self.low_s:g}")
        return self

    def draw_s(self, chance: np.random.Generator) -> float:
        """One time, s, rounded to a step."""
        drawn_s = self._drawn_s(chance)
        return round(min(drawn_s, math.inf if self.max_s is None else self.max_s), 1)

    def _drawn_s(self, chance: np.random.Generator) -> float:
        mean_s, shape = self.mean_s or 0.0, self.shape or 1.0
        match self.distribution:
            case Distribution.EXPONENTIAL:
                return float(chance.exponential(mean_s))
            case Distribution.LOGNORMAL:
                sigma = self.sigma or 0.0
                return float(chance.lognormal(math.log(mean_s) - 0.5 * sigma**2, sigma))
            case Distribution.WEIBULL:
                return float(chance.weibull(shape)) * mean_s / math.gamma(1.0 + 1.0 / shape)
            case Distribution.GAMMA:
                return float(chance.gamma(shape, mean_s / shape))
            case Distribution.UNIFORM:
                return float(chance.uniform(self.low_s or 0.0, self.high_s or 0.0))
            case Distribution.FIXED:
                return mean_s

    @property
    def words(self) -> str:
        """The distribution with its figures, in words."""
        told = [f"{self.distribution.value}"]
        told += [
            f"{name.removesuffix('_s').removesuffix('_')} {value:g}{' s' if name.endswith('_s') else ''}"
            for name in (*_FIGURES, "max_s")
            if (value := getattr(self, name)) is not None
        ]
        return ", ".join(told)
