"""How real trains differ from their files, and the day from a fine one: data, and the draws from it (ばらつき).

What belongs to a train stays with it for ever: drawn by seed and stock. What passes is drawn anew for every leg
and day. The on-board units know nothing of it.
"""

from __future__ import annotations

from typing import Annotated, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationInfo, field_validator

from network.files.kinds import TEXTS_MAX, about
from network.files.part_of_day import PartOfDay
from network.files.quantities import BrakeFactor, ShareAbove0, Sigma, TimeOffset, TimeSpread, WheelFactor
from network.files.toml_input import Record
from radio.chance import generator
from vehicle.records import TRAIN

SIGMAS_MAX: Final = 3.0  # normal draws are cut here


class Weather(PartOfDay):
    """`scatter.weather`: adhesion of a part of the day, evenly between two factors, leg by leg."""

    adhesion_low: Annotated[ShareAbove0, about("least factor of the dry rail's adhesion")]
    adhesion_high: Annotated[ShareAbove0, about("greatest factor")]

    @field_validator("adhesion_high")
    @classmethod
    def _not_lower(cls, high: float, info: ValidationInfo) -> float:
        if high < (low := info.data.get("adhesion_low", 0.0)):
            raise ValueError(f"at least adhesion_low = {low:g}")
        return high


class Individual(Record):
    """`[scatter.stock.<id>]`: what is known of one stock's real brakes and wheels; what is left out is drawn."""

    brake_factor: Annotated[
        BrakeFactor | None,
        about("real over designed deceleration of the service brake"),
    ] = None
    dead_time_offset_s: Annotated[TimeOffset | None, about("real less believed dead time")] = None
    lag_offset_s: Annotated[TimeOffset | None, about("real less believed lag")] = None
    wheel_factor: Annotated[
        WheelFactor | None,
        about("real over assumed circumference of the wheel that the tachometer counts"),
    ] = None


class ScatterSettings(Record):
    """`[scatter]`: spread of trains and days; all zero: every train is as its file says, on dry rail."""

    brake_sigma: Annotated[
        Sigma, about("standard deviation of the brake factor, among trains", "assumed: no spread")
    ] = 0.0
    brake_leg_sigma: Annotated[
        Sigma,
        about(
            "standard deviation for one train from leg to leg: friction, temperature", "assumed: no spread"
        ),
    ] = 0.0
    dead_time_spread_s: Annotated[
        TimeSpread, about("real less believed dead time, evenly within +-", "assumed: no spread")
    ] = 0.0
    lag_spread_s: Annotated[
        TimeSpread, about("real less believed lag, evenly within +-", "assumed: no spread")
    ] = 0.0
    weather: Annotated[
        tuple[Weather, ...],
        Field(strict=False, max_length=TEXTS_MAX),
        about("parts of the day with slippery rails"),
    ] = ()
    stock: Annotated[dict[str, Individual], about("what is known of single trains, by stock id")] = Field(
        default_factory=dict
    )

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

    def adhesion_least(self, now_s: float) -> float:
        """The least adhesion factor of a leg that begins now; 1 outside every kind of weather."""
        low = (part.adhesion_low for part in self.weather if part.from_s <= now_s < part.to_s)
        return next(low, 1.0)


def _cut_normal(rng: np.random.Generator) -> float:
    return float(np.clip(rng.standard_normal(), -SIGMAS_MAX, SIGMAS_MAX))
