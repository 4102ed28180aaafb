"""Units at the edge: people read and write kilometres and km/h, everything inside is metres and m/s."""

from __future__ import annotations

from typing import Final

J_PER_KWH: Final = 3.6e6


def metres(kilometrage_km: float) -> float:
    """Kilometrage in m, to the micrometre: 1.001 km is 1001 m, not 1000.9999999999999."""
    return round(kilometrage_km * 1000.0, 6)


def mps(speed_kmh: float) -> float:
    """Speed in m/s."""
    return speed_kmh / 3.6
