"""What is drawn for a day: by seed and name alone, so that neither the grid nor another draw changes it.

The value is that quantile of its distribution which the chance of the day says: with a wider distribution the same
chance gives a value further out, not another one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np
import scipy  # it loads `stats`, which takes long, as that is asked for

from network.errors import InputError
from radio.chance import generator
from scenario.sweep_file import DrawTable

SOURCE: Final = "sweep"
SIGNIFICANT: Final = 6
_NEEDED: Final[Mapping[str, tuple[str, ...]]] = {
    "uniform": ("low", "high"),
    "normal": ("mean", "sigma"),
    "lognormal": ("median", "sigma"),
    "exponential": ("mean",),
    "triangular": ("low", "high"),
    "choice": ("values",),
}
_ALLOWED: Final[Mapping[str, tuple[str, ...]]] = {
    "triangular": ("mode",),
    "choice": ("weights",),
    "normal": ("low", "high"),
    "lognormal": ("low", "high"),
    "exponential": ("low", "high"),
}
_SETTINGS: Final = ("low", "high", "mean", "median", "mode", "sigma", "values", "weights")
_NO: Final[tuple[object, ...]] = (None, [])


def check_draw(file: str, key: str, draw: DrawTable) -> None:
    """All that the distribution needs is there, nothing else, and it makes sense; InputError otherwise."""
    needed = _NEEDED[draw.distribution]
    for name in _SETTINGS:
        given = getattr(draw, name) not in _NO
        if name in needed and not given:
            raise InputError(file, f"{key}.{name}", None, f"this key, which {draw.distribution} needs")
        if given and name not in (*needed, *_ALLOWED.get(draw.distribution, ())):
            raise InputError(
                file, f"{key}.{name}", getattr(draw, name), f"no such key of {draw.distribution}"
            )
    low, high = draw.low, draw.high
    if low is not None and high is not None and high <= low:
        raise InputError(file, f"{key}.high", high, f"more than low = {low:g}")
    for name, end in (("low", low), ("high", high)):
        if draw.whole and end is not None and not end.is_integer():
            raise InputError(file, f"{key}.{name}", end, "a whole number, as the value is to be one")
    if draw.sigma is not None and draw.sigma <= 0.0:
        raise InputError(file, f"{key}.sigma", draw.sigma, "more than 0")
    if draw.mode is not None and low is not None and high is not None and not low <= draw.mode <= high:
        raise InputError(file, f"{key}.mode", draw.mode, "a value between low and high")
    for name in ("mean", "median"):
        value = getattr(draw, name)
        if value is not None and value <= 0.0 and draw.distribution in ("exponential", "lognormal"):
            raise InputError(file, f"{key}.{name}", value, "more than 0")
    if draw.weights and (
        len(draw.weights) != len(draw.values) or min(draw.weights) < 0.0 or not any(draw.weights)
    ):
        raise InputError(
            file, f"{key}.weights", draw.weights, "a share for each value, none below 0, not all 0"
        )


def drawn_value(draw: DrawTable, seed: int) -> Any:  # noqa: ANN401 - what a key says
    """The value of a day."""
    return value_at(draw, chance_of(draw, seed))


def chance_of(draw: DrawTable, seed: int) -> float:
    """The chance of a day, in [0, 1): a greater one never gives a smaller value."""
    return float(generator(seed, SOURCE, draw.name).random())


def value_at(draw: DrawTable, chance: float) -> Any:  # noqa: ANN401 - what a key says
    """The quantile of that share; SIGNIFICANT digits, so that another machine's last bit makes no other day."""
    if draw.distribution == "choice":
        weights = np.array(draw.weights or [1.0] * len(draw.values))
        edges = np.cumsum(weights) / weights.sum()
        return draw.values[int(np.searchsorted(edges, chance, side="right").clip(0, len(edges) - 1))]
    low, high = draw.low, draw.high
    value = _QUANTILES[draw.distribution](draw, chance)
    if draw.distribution not in ("uniform", "triangular"):
        value = max(value, -np.inf if low is None else low)
        value = min(value, np.inf if high is None else high)
    return round(value) if draw.whole else float(f"{value:.{SIGNIFICANT}g}")


def _uniform(draw: DrawTable, chance: float) -> float:
    low, high = draw.low or 0.0, draw.high or 0.0
    return math.floor(low + (high + 1.0 - low) * chance) if draw.whole else low + (high - low) * chance


def _normal(draw: DrawTable, chance: float) -> float:
    return float(scipy.stats.norm.ppf(chance, draw.mean or 0.0, draw.sigma or 1.0))


def _lognormal(draw: DrawTable, chance: float) -> float:
    return float(scipy.stats.lognorm.ppf(chance, draw.sigma or 1.0, scale=draw.median or 1.0))


def _exponential(draw: DrawTable, chance: float) -> float:
    return float(scipy.stats.expon.ppf(chance, scale=draw.mean or 1.0))


def _triangular(draw: DrawTable, chance: float) -> float:
    low, high = draw.low or 0.0, draw.high or 0.0
    mode = (low + high) / 2.0 if draw.mode is None else draw.mode
    return float(scipy.stats.triang.ppf(chance, (mode - low) / (high - low), low, high - low))


_QUANTILES: Final[Mapping[str, Callable[[DrawTable, float], float]]] = {
    "uniform": _uniform,
    "normal": _normal,
    "lognormal": _lognormal,
    "exponential": _exponential,
    "triangular": _triangular,
}
