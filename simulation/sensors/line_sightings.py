"""What the cameras of line runs see, by light and distance: figures fitted to the renderer, read from a file.

`python -m documents.sightings` renders and writes `line_sightings.toml` anew; a test holds it against fresh images.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, fields
from functools import cache
from importlib.resources import files
from typing import Final

import numpy as np
from numpy.typing import NDArray

from simulation.settings import Light

Floats = NDArray[np.float64]

FILE: Final = "line_sightings.toml"
# Places of the model, m before the sign. At the last its picture has 4 px, and detection ends (two erosions need 5).
PLACES_M: Final = (9.0, 12.0, 15.0, 21.0, 30.0, 39.0, 48.0, 60.0, 69.0, 78.0, 87.0, 96.0)
LIGHTS: Final = tuple(Light)


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """The error model in one kind of light, a figure a place of `PLACES_M`."""

    seen_share: Floats
    false_share: Floats
    bias_m: Floats
    sigma_m: Floats
    moving_sigma_m: Floats
    exposed_after_s: Floats

    @property
    def reach_m(self) -> float:
        """The farthest place at which, and before which everywhere, every second picture shows the sign; 0: none."""
        blind = np.flatnonzero(self.seen_share < 0.5)
        count = int(blind[0]) if blind.size else len(PLACES_M)
        return PLACES_M[count - 1] if count else 0.0


COLUMNS: Final = tuple(column.name for column in fields(Sightings))


@cache
def line_sightings() -> dict[Light, Sightings]:
    """The figures as committed."""
    table = tomllib.loads((files("simulation.sensors") / FILE).read_text("utf-8"))
    return {
        light: Sightings(*(np.array(table[light.value][column], dtype=np.float64) for column in COLUMNS))
        for light in LIGHTS
    }
