"""Mass of a train, with and without what turns."""

from __future__ import annotations

from typing import Final

from vehicle.compiled import compiled
from vehicle.records import TrainRow

GRAVITY_MPS2: Final = (
    9.81  # the value papers on running resistance in Japan print, Oda's equation 3 among them
)


@compiled
def mass_kg(train: TrainRow, load_share: float) -> float:
    """Mass with the load on board, kg; `load_share` 0 empty, 1 full."""
    return train.mass_empty_kg + load_share * train.mass_load_full_kg


@compiled
def equivalent_mass_kg(train: TrainRow, load_share: float) -> float:
    """Mass that resists acceleration (等価質量), kg: mass * (1 + rotating mass factor)."""
    return mass_kg(train, load_share) * (1.0 + train.rotating_mass_factor)
