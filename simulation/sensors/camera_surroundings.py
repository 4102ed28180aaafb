"""What surrounds the camera: textures of a tunnel, of a station's yard and of what grows beside a line, by seed.

A texture has the shape (along, across, BGR), reflectances of 0 to 1, and its mean along the track as an extra last
row; it is `TEXTURE_CELLS` cells square.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

TEXTURE_CELLS: Final = 600


def _with_mean(texture: Floats) -> Singles:
    """A texture with its mean along the track as an extra last row."""
    return np.concatenate([texture, texture.mean(axis=0, keepdims=True)]).clip(0.0, 1.0).astype(np.float32)


def floor_texture(rng: np.random.Generator, cell_m: float) -> Singles:
    """Ballast, sleepers each 0.6 m, rails of 1067 mm gauge on the middle, concrete beside (full-size metres)."""
    n = TEXTURE_CELLS
    along = (np.arange(n) * cell_m)[:, None]
    across = np.abs((np.arange(n) + 0.5) * cell_m - n * cell_m / 2.0)[None, :]
    grain = rng.normal(0.0, 0.07, (n, n))
    texture = 0.36 + np.stack([grain * 0.9, grain, grain * 1.1], axis=-1)
    concrete = np.broadcast_to(across > 1.7, (n, n))
    texture[concrete] = (0.47, 0.49, 0.50) + 0.15 * grain[concrete][:, None]
    sleeper = (along % 0.6 < 0.22) & (across < 1.0)
    texture[sleeper] = (0.20, 0.25, 0.30) + 0.3 * grain[sleeper][:, None]
    rail = np.broadcast_to(np.abs(across - 1.067 / 2.0) < 0.04, (n, n))
    texture[rail] = (0.62, 0.62, 0.61)
    return _with_mean(texture)


def wall_texture(rng: np.random.Generator) -> Singles:
    """Concrete panels with seams and a dark cable duct."""
    n = TEXTURE_CELLS
    texture = np.full((n, n, 3), (0.50, 0.54, 0.57)) + rng.normal(0.0, 0.015, (n, n, 1))
    texture[:: n // 4] *= 0.7
    texture[:, n // 8 : n // 8 + 6] = (0.22, 0.22, 0.24)
    return _with_mean(texture)


def ceiling_texture(rng: np.random.Generator) -> Singles:
    """Concrete with two rows of tube lamps."""
    n = TEXTURE_CELLS
    texture = np.full((n, n, 3), (0.40, 0.42, 0.44)) + rng.normal(0.0, 0.015, (n, n, 1))
    for side in (n // 3, 2 * n // 3):
        texture[: n // 4, side - 8 : side + 8] = 1.0
        texture[n // 2 : 3 * n // 4, side - 8 : side + 8] = 1.0
    return _with_mean(texture)


def grass_texture(rng: np.random.Generator) -> Singles:
    """Grass and low growth: green, of a hue just short of what the paper's threshold takes for the sign's (90 deg)."""
    n = TEXTURE_CELLS
    coarse = np.kron(rng.normal(0.0, 1.0, (n // 20, n // 20)), np.ones((20, 20)))
    light = 1.0 + 0.15 * coarse + rng.normal(0.0, 0.25, (n, n))
    yellow = rng.normal(0.0, 0.012, (n, n))
    texture = np.empty((n, n, 3))
    texture[..., 0], texture[..., 1], texture[..., 2] = 0.065, 0.150, 0.105
    texture[..., 2] += yellow
    return _with_mean(texture * light[..., None])


def skyline(rng: np.random.Generator) -> Floats:
    """Height (rad) of trees and hills over the horizon, one a hundredth of a radian from -1 rad of azimuth to 1."""
    steps = rng.normal(0.0, 0.004, 201)
    hills = np.convolve(rng.normal(0.0, 0.02, 240), np.ones(40) / 6.0, mode="valid")
    height: Floats = (0.045 + hills + steps).clip(0.01, 0.12)
    return height
