"""What the LiDARs of line runs make of markers, by speed and distance: figures fitted to the scan, read from a file.

`python -m documents.scans` scans and writes `line_scans.toml` anew; a test holds it against fresh scans. The figures
are of cycles: the mean distance of the points of the last 0.1 s, and what is read of the pattern from 6 to 5 m.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, fields
from functools import cache
from importlib.resources import files
from typing import Annotated, Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FILE: Final = "line_scans.toml"
SPEEDS_MPS: Final = (1.4, 3.0, 6.0, 10.0, 15.0, 20.0, 28.0, 36.0)
PLACES_M: Final = (5.0, 7.0, 10.0, 14.0, 19.0, 24.0, 30.0)  # from the LiDAR to the markers' middle
# by how much points of 0.1 s may stay spread by a wrong speed; what is read of them then
SMEARS_M: Final = (0.0, 0.03, 0.06, 0.09, 0.12, 0.15, 0.18, 0.21, 0.24)
PLACES: Final = len(PLACES_M)
SPEEDS: Final = len(SPEEDS_MPS)
SMEARS: Final = len(SMEARS_M)


@dataclass(frozen=True, slots=True, eq=False)
class Scans:
    """The error model; rows are speeds. `none_share` to `sigma_m` by PLACES_M, `read_share` by SMEARS_M."""

    none_share: Annotated[Floats, SPEEDS * PLACES, "of cycles in which there is no point at all"]
    bias_m: Annotated[Floats, SPEEDS * PLACES, "of the mean distance over the middle half of the time ago"]
    sigma_m: Annotated[Floats, SPEEDS * PLACES]
    read_share: Annotated[Floats, SPEEDS * SMEARS, "of readings that give the pattern; the others give none"]
    row_bias_m: Annotated[Floats, SPEEDS, "of the first row's distance, where it is read"]
    row_sigma_m: Annotated[Floats, SPEEDS]


COLUMNS: Final = tuple(column.name for column in fields(Scans))


@cache
def line_scans() -> Scans:
    """The figures as committed."""
    table = tomllib.loads((files("simulation.sensors") / FILE).read_text("utf-8"))
    return Scans(*(np.array(table[column], dtype=np.float64) for column in COLUMNS))
