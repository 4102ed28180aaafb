"""Writes what the cameras of line runs see: an error model for each kind of light, fitted to rendered images.

`python -m documents.sightings [file]` takes two to four minutes. The figures are samples: `make check` does not compare
them, `tests/simulation/sensors/test_line_sightings.py` holds them against fresh images within what samples differ by.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Final

import numpy as np

from documents.page import write_page
from onboard.localisation.sighting import accuracy_m
from onboard.localisation.vision import SightTable
from simulation.sensors.camera import LINE_CAMERA, LINE_SIGN, Renderer
from simulation.sensors.line_sightings import COLUMNS, FILE, LIGHTS, PLACES_M
from simulation.sensors.sighting_model import SightingModel, SignSearch, fit_sighting_model, record_table
from simulation.settings import Light

PLACE: Final = Path(__file__).resolve().parents[1] / "simulation" / "sensors" / FILE
SEED: Final = 7
IMAGES: Final = 100  # a place and light, at rest; as many at a creep
TABLE_IMAGES: Final = 30
TABLE_M: Final = (*(float(m) for m in range(8, 40, 2)), *(float(m) for m in range(40, 101, 4)))
# Sure of its place to a kilometre of wheels that are off by 2 %: so wide is what a unit looks through.
SEARCH: Final = SignSearch(25.0, lambda distance_m: float(accuracy_m(distance_m, 0.0)))
HEAD: Final = """# What the cameras of line runs see of a stop sign, by light (simulation.sensors.open_air) and place.
# Made by `python -m documents.sightings`: {images} rendered images a place at rest, as many with vibration.
"""


@cache
def recorded_rows(renderer: Renderer, fine: Light) -> SightTable:
    """The table from row to distance as recorded when the sign was put up, in good light."""
    return record_table(renderer, LINE_SIGN, TABLE_M, SEED, TABLE_IMAGES, light=fine, around=True)


def fitted_model(
    renderer: Renderer, light: Light, seed: int, count: int, places_m: tuple[float, ...]
) -> SightingModel:
    """The model of one kind of light; its table was recorded by lamps, or on a fine day."""
    table = recorded_rows(renderer, light if light is Light.LIT_TUNNEL else Light.DAYLIGHT)
    return fit_sighting_model(renderer, LINE_SIGN, table, seed, count, places_m, light, SEARCH)


def document() -> str:
    """The whole file."""
    renderer = Renderer(LINE_CAMERA, SEED)
    parts = [HEAD.format(images=IMAGES), f"places_m = {_listed(PLACES_M, 1)}\n"]
    for light in LIGHTS:
        model = fitted_model(renderer, light, SEED, IMAGES, PLACES_M)
        columns = {
            "seen_share": (model.probability, 3),
            "false_share": (model.false_share, 3),
            "bias_m": (model.bias_m, 3),
            "sigma_m": (model.sigma_m, 3),
            "moving_sigma_m": (model.moving_sigma_m, 3),
            "exposed_after_s": (model.exposed_after_s, 4),
        }
        lines = [f"{name} = {_listed(columns[name][0], columns[name][1])}" for name in COLUMNS]
        parts.append(f"[{light.value}]\n" + "\n".join(lines) + "\n")
    return "\n".join(parts)


def _listed(figures: np.ndarray | tuple[float, ...], digits: int) -> str:
    return "[" + ", ".join(f"{round(float(figure), digits) + 0.0}" for figure in figures) + "]"


if __name__ == "__main__":
    write_page(document, PLACE)
