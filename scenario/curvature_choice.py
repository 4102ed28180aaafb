"""The map of curvature that a scenario names: the line's own design, or a file beside the scenario."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from network.errors import InputError
from network.files.text_input import existing_file
from network.model import Line
from onboard.localisation.curvature_map import DESIGN, CurvatureMap
from onboard.localisation.curvature_map_file import read_map
from simulation.sensor_settings import Curvature


def curvature_map_of(
    folders: Sequence[Path], scenario: Path, curvature: Curvature, line: Line
) -> CurvatureMap | None:
    """The map read, None for the design's. InputError for a file that is not there or not of this line.

    A file is read, and refused, whether any stock carries a gyro or not.
    """
    name = curvature.map
    if name == DESIGN:
        return None
    for folder in folders:
        if existing_file(folder / name):
            return read_map(folder / name, line)
    raise InputError(
        str(scenario),
        "curvature.map",
        name,
        f"{DESIGN!r}, or a file beside the scenario (branchline new curvature-map)",
    )
