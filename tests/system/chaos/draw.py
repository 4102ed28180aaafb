"""Chance of one case: by its family and seed and the name of what is drawn, so that a new draw disturbs no other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from radio.chance import generator

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Draw:
    """Draws of one name."""

    seed: int
    names: tuple[str, ...]
    _chance: np.random.Generator = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_chance", generator(self.seed, "chaos", *self.names))

    def of(self, *names: str) -> Draw:
        """The draws of something else of the same case."""
        return Draw(self.seed, (*self.names, *names))

    def one_of(self, items: Sequence[T]) -> T:
        """One of the items, each as likely."""
        return items[int(self._chance.integers(len(items)))]

    def chance(self, p: float) -> bool:
        """True with this probability."""
        return bool(self._chance.random() < p)

    def whole(self, low: int, high: int) -> int:
        """A whole number from `low` to `high`, both included."""
        return int(self._chance.integers(low, high + 1))

    def between(self, low: float, high: float, digits: int = 3) -> float:
        """A number between two, rounded so that a file has it as it is."""
        return round(float(self._chance.uniform(low, high)), digits)

    def by_size(self, low: float, high: float, digits: int = 1) -> float:
        """A positive number of which each order of size is as likely."""
        return round(math.exp(self._chance.uniform(math.log(low), math.log(high))), digits)
