"""How real trains differ from their files, and the day from a fine one: data, and the draws from it (ばらつき).

What belongs to a train stays with it for ever: drawn by seed and stock. What passes is drawn anew for every leg
and day. The on-board units know nothing of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from radio.chance import generator
from vehicle.records import TRAIN

SIGMAS_MAX: Final = 3.0  # normal draws are cut here


@dataclass(frozen=True, slots=True)
class Weather:
    """Adhesion of a part of the day: factor of the dry rail, evenly between `low` and `high`, leg by leg."""

    from_s: float
    to_s: float
    adhesion_low: float
    adhesion_high: float


@dataclass(frozen=True, slots=True)
class Individual:
    """What is known of one stock's real brakes; None: drawn."""

    brake_factor: float | None = None  # real over designed deceleration of the service brake
    dead_time_offset_s: float | None = None  # real less believed
    lag_offset_s: float | None = None


@dataclass(frozen=True, slots=True)
class Scatter:
    """Spread of trains and days; all zero: every train is as its file says, on dry rail."""

    brake_sigma: float = 0.0  # of the brake factor, train to train
    brake_leg_sigma: float = 0.0  # and of the same train from leg to leg: friction, temperature
    dead_time_spread_s: float = 0.0  # real less believed dead time, evenly within +-
    lag_spread_s: float = 0.0
    weather: tuple[Weather, ...] = ()
    stock: Mapping[str, Individual] = field(default_factory=dict)

    def body(self, seed: int, stock_id: str, believed: NDArray[np.void]) -> tuple[NDArray[np.void], float]:
        """The real TRAIN row of a stock, shape (1,), and its brake factor."""
        rng = generator(seed, "scatter", stock_id)
        drawn = (
            1.0 + self.brake_sigma * _cut_normal(rng),
            self.dead_time_spread_s * float(rng.uniform(-1.0, 1.0)),
            self.lag_spread_s * float(rng.uniform(-1.0, 1.0)),
        )
        own = self.stock.get(stock_id, Individual())
        given = (own.brake_factor, own.dead_time_offset_s, own.lag_offset_s)
        factor, dead_time_s, lag_s = (
            chance if known is None else known for chance, known in zip(drawn, given, strict=True)
        )
        row = np.array(believed, dtype=TRAIN).reshape(1)
        row["brake_dead_time_s"] = max(0.0, float(row["brake_dead_time_s"][0]) + dead_time_s)
        row["brake_lag_s"] = max(0.0, float(row["brake_lag_s"][0]) + lag_s)
        return row, factor

    def brake_of_leg(self, rng: np.random.Generator) -> float:
        """Factor of one leg on top of the train's own."""
        return 1.0 + self.brake_leg_sigma * _cut_normal(rng)

    def adhesion_of_leg(self, rng: np.random.Generator, now_s: float) -> float:
        """Adhesion factor of a leg that begins now; 1 outside every kind of weather."""
        share = float(rng.uniform())
        for part in self.weather:
            if part.from_s <= now_s < part.to_s:
                return part.adhesion_low + share * (part.adhesion_high - part.adhesion_low)
        return 1.0


def _cut_normal(rng: np.random.Generator) -> float:
    return float(np.clip(rng.standard_normal(), -SIGMAS_MAX, SIGMAS_MAX))
