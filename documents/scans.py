"""Writes what the LiDARs of line runs make of markers: an error model by speed and distance, fitted to scans.

`python -m documents.scans [file]` takes a minute. The figures are samples: `make check` does not compare them,
`tests/simulation/sensors/test_line_scans.py` holds them against fresh scans within what samples differ by.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

from documents.page import write_page
from simulation.sensors.lidar_model import fit_model
from simulation.sensors.line_scans import COLUMNS, FILE, PLACES_M, SMEARS_M, SPEEDS_MPS

PLACE: Final = Path(__file__).resolve().parents[1] / "simulation" / "sensors" / FILE
SEED: Final = 7
PASSAGES: Final = 48  # a speed; more where fast trains give few readings
READINGS: Final = 200
HEAD: Final = """# What the LiDARs of line runs make of markers: a row a speed (simulation.sensors.line_scans).
# Made by `python -m documents.scans`: {passages} scanned passages a speed or more, until there are {readings} readings.
"""


def document() -> str:
    """The whole file."""
    scans, _wrong = fit_model(SPEEDS_MPS, PASSAGES, SEED, READINGS)
    lines = [HEAD.format(passages=PASSAGES, readings=READINGS)]
    for name, values in (("speeds_mps", SPEEDS_MPS), ("places_m", PLACES_M), ("smears_m", SMEARS_M)):
        lines.append(f"{name} = {_listed(np.array(values))}\n")
    for name in COLUMNS:
        values = getattr(scans, name)
        if values.ndim == 1:
            lines.append(f"{name} = {_listed(values)}\n")
        else:
            lines.append(f"{name} = [\n" + "".join(f"    {_listed(row)},\n" for row in values) + "]\n")
    return "".join(lines)


def _listed(figures: np.ndarray) -> str:
    return "[" + ", ".join(f"{round(float(figure), 4) + 0.0}" for figure in figures) + "]"


if __name__ == "__main__":
    write_page(document, PLACE)
