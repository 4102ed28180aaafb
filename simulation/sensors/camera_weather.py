"""The compiled pixels of the open air: a yard, grass and sky by ray, then sun, wet pane and falling drops.

Image arrays are those of `camera_pixels`; 1.0 is what a white face towards the train gives.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from simulation.sensors.camera_pixels import RAY_MAX_M, sample
from vehicle.compiled import compiled

Singles = NDArray[np.float32]
Floats = NDArray[np.float64]

TREES_M: Final = 400.0  # how far off they stand
GRASS_COARSER: Final = 3.0  # its texture is laid out this much larger
SKYLINE_PER_RAD: Final = 100.0
TREE_GREY: Final = 0.13
SUN_RAD: Final = 0.0047  # half of its diameter
SUN_WHITE: Final = 100.0  # far beyond what any exposure holds
DEG: Final = 180.0 / math.pi
DISC_PX: Final = 2.5  # width of a drop's soft rim


@compiled
def draw_open(
    image: Singles,
    left_px: int,
    top_px: int,
    lens_m: Floats,
    focal_px: float,
    axis_row: float,
    axis_column: float,
    lens_height_m: float,
    half_width_m: float,
    floor: Singles,
    grass: Singles,
    cell_m: float,
    ground_share: float,
    sky_low: float,
    sky_high: float,
    skyline_rad: Floats,
    extinction_per_m: float,
) -> None:
    """Fill the image with the yard, grass beside it, trees at the horizon and the sky, fading into the air."""
    columns: int = image.shape[1]
    side = (left_px + np.arange(columns) + 0.5 - axis_column) / focal_px
    per_cell = 1.0 / cell_m
    fade = per_cell / (8.0 * focal_px * lens_height_m)
    share = np.float32(ground_share)
    far_clear = math.exp(-extinction_per_m * TREES_M)
    place = (np.arctan(side) + 1.0) * SKYLINE_PER_RAD
    for r in range(image.shape[0]):
        rise = (axis_row - (top_px + r + 0.5)) / focal_px
        ray_m = min(lens_height_m / max(-rise, lens_height_m / RAY_MAX_M), RAY_MAX_M)
        along = (lens_m[r] * per_cell) % (floor.shape[0] - 1) + ray_m * per_cell
        clear = math.exp(-extinction_per_m * ray_m)
        height = min(max(rise, 0.0) / 0.5, 1.0)
        sky = sky_low + (sky_high - sky_low) * height
        for k in range(columns):
            if ray_m > TREES_M:
                near = min(max(int(place[k]), 0), skyline_rad.shape[0] - 2)
                part = min(max(place[k] - near, 0.0), 1.0)
                tall = skyline_rad[near] + part * (skyline_rad[near + 1] - skyline_rad[near])
                for c in range(3):
                    if rise < tall:
                        image[r, k, c] = TREE_GREY * far_clear + sky_low * (1.0 - far_clear)
                    else:
                        image[r, k, c] = sky * (1.0 - 0.03 * c)
                continue
            across_m = side[k] * ray_m
            if abs(across_m) <= half_width_m:
                blur = ray_m * ray_m * fade - 0.5
                sample(floor, along, (half_width_m + across_m) * per_cell, blur, image, r, k)
            else:
                far = min(abs(across_m) / GRASS_COARSER * per_cell, 1.0e6) % (grass.shape[1] - 2)
                sample(grass, along / GRASS_COARSER, far, ray_m * ray_m * fade - 0.5, image, r, k)
            for c in range(3):
                image[r, k, c] = image[r, k, c] * share * clear + sky_low * (1.0 - clear)


@compiled
def add_glare(
    image: Singles,
    left_px: int,
    top_px: int,
    focal_px: float,
    axis_row: float,
    axis_column: float,
    elevation_rad: float,
    azimuth_rad: float,
    glare_deg2: float,
) -> None:
    """The sun's disc and its veil, which falls with the square of the angle from it (Holladay, Stiles)."""
    sun_x, sun_y = math.tan(azimuth_rad), math.tan(elevation_rad)
    sun_long = math.sqrt(sun_x * sun_x + sun_y * sun_y + 1.0)
    for r in range(image.shape[0]):
        y = (axis_row - (top_px + r + 0.5)) / focal_px
        for k in range(image.shape[1]):
            x = (left_px + k + 0.5 - axis_column) / focal_px
            cosine = (x * sun_x + y * sun_y + 1.0) / (math.sqrt(x * x + y * y + 1.0) * sun_long)
            angle_rad = math.acos(min(cosine, 1.0))
            angle_deg = max(angle_rad, SUN_RAD) * DEG
            veil = glare_deg2 / (angle_deg * angle_deg)
            if angle_rad < SUN_RAD:
                veil += SUN_WHITE
            for c in range(3):
                image[r, k, c] += veil


@compiled
def add_drops(image: Singles, drops: Floats, sky: float) -> None:
    """Drops on the pane, rows of (row, column, radius) px: each a picture upside down, out of focus."""
    rows, columns = image.shape[0], image.shape[1]
    for i in range(drops.shape[0]):
        row, column, radius = drops[i, 0], drops[i, 1], drops[i, 2]
        reach = radius + DISC_PX
        for r in range(max(int(row - reach), 0), min(int(row + reach) + 2, rows)):
            for k in range(max(int(column - reach), 0), min(int(column + reach) + 2, columns)):
                away = math.sqrt((r - row) ** 2 + (k - column) ** 2)
                cover = 0.85 * min(max((radius - away) / DISC_PX + 0.5, 0.0), 1.0)
                shown = sky * (0.55 + 0.35 * (r - row) / max(radius, 1.0))
                for c in range(3):
                    image[r, k, c] = image[r, k, c] * (1.0 - cover) + shown * cover


@compiled
def add_streaks(image: Singles, streaks: Floats, sky: float) -> None:
    """Falling drops as lines, rows of (row, column, length px, columns a row, share of the sky's light)."""
    rows, columns = image.shape[0], image.shape[1]
    for i in range(streaks.shape[0]):
        for step in range(int(streaks[i, 2])):
            r = int(streaks[i, 0]) + step
            at = streaks[i, 1] + streaks[i, 3] * step
            k = math.floor(at)
            if r < 0 or r >= rows:
                continue
            for side in range(2):  # shared by two columns, as the line lies between them
                cover = streaks[i, 4] * (at - k if side == 1 else 1.0 - at + k)
                if 0 <= k + side < columns:
                    for c in range(3):
                        image[r, k + side, c] += cover * (sky - image[r, k + side, c])
