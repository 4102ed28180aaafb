"""The compiled pixels of the rendered camera: a box tunnel by ray, flat boards and discs over it, then the sensor.

Image arrays have the shape (rows, columns, 3), BGR, 1.0 for full white. `lens_m[row]` is the lens's place along
the track when the row's exposure begins (rolling shutter), so every row sees its own picture.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled

Singles = NDArray[np.float32]
Floats = NDArray[np.float64]

INSTANTS: Final = 4  # a row's exposure is sampled this often, for motion blur
RAY_MAX_M: Final = 1e6

# columns of a board: distance along the track, centre right and up, half width and height, blue, green, red, round
ALONG, RIGHT, UP, HALF_WIDTH, HALF_HEIGHT, BLUE, GREEN, RED, ROUND = range(9)


@compiled
def sample(
    texture: Singles, along: float, across: float, blur: float, image: Singles, r: int, k: int
) -> None:
    """Bilinear sample of a texture (along, across, BGR) into a pixel; coordinates (>= 0) in cells, the first wraps.

    The texture's last row holds the mean along the track; `blur` (0 to 1) fades to it where detail is too fine.
    """
    rows = texture.shape[0] - 1
    q = min(max(across, 0.0), texture.shape[1] - 1.001)
    j = int(q)
    right = np.float32(q - j)
    left = np.float32(1.0) - right
    if blur >= 1.0:
        for c in range(3):
            image[r, k, c] = texture[rows, j, c] * left + texture[rows, j + 1, c] * right
        return
    i0 = int(along)
    far = np.float32(along - i0)
    near = np.float32(1.0) - far
    while i0 >= rows:  # few times: what lies farther is blurred; a division would cost more
        i0 -= rows
    i1 = i0 + 1 if i0 + 1 < rows else 0
    fade = np.float32(blur)
    for c in range(3):
        low = texture[i0, j, c] * left + texture[i0, j + 1, c] * right
        high = texture[i1, j, c] * left + texture[i1, j + 1, c] * right
        fine = low * near + high * far
        if blur > 0.0:
            fine += (texture[rows, j, c] * left + texture[rows, j + 1, c] * right - fine) * fade
        image[r, k, c] = fine


@compiled
def draw_tunnel(
    image: Singles,
    left_px: int,
    top_px: int,
    lens_m: Floats,
    focal_px: float,
    axis_row: float,
    axis_column: float,
    lens_height_m: float,
    half_width_m: float,
    ceiling_m: float,
    floor: Singles,
    wall: Singles,
    ceiling: Singles,
    cell_m: float,
    extinction_per_m: float,
    air: float,
) -> None:
    """Fill the image with floor, walls and ceiling of a straight box around the track, fading into the air."""
    columns: int = image.shape[1]
    side = (left_px + np.arange(columns) + 0.5 - axis_column) / focal_px
    to_wall_m = half_width_m / np.maximum(np.abs(side), half_width_m / RAY_MAX_M)
    per_cell = 1.0 / cell_m
    # what one pixel covers along the track, against the finest pattern: blur = ray^2 * fade - 1/2
    wall_fade = per_cell / (8.0 * focal_px * half_width_m)
    for r in range(image.shape[0]):
        rise = (axis_row - (top_px + r + 0.5)) / focal_px
        start = (lens_m[r] * per_cell) % (floor.shape[0] - 1)
        level_m = lens_height_m if rise < 0.0 else ceiling_m - lens_height_m
        to_level_m = level_m / max(abs(rise), level_m / RAY_MAX_M)
        level_fade = per_cell / (8.0 * focal_px * level_m)
        for k in range(columns):
            ray_m = min(to_wall_m[k], to_level_m)
            along = start + ray_m * per_cell
            if to_wall_m[k] < to_level_m:
                blur = ray_m * ray_m * wall_fade - 0.5
                sample(wall, along, (lens_height_m + rise * ray_m) * per_cell, blur, image, r, k)
            else:
                blur = ray_m * ray_m * level_fade - 0.5
                across = (half_width_m + side[k] * ray_m) * per_cell
                if rise < 0.0:
                    sample(floor, along, across, blur, image, r, k)
                else:
                    sample(ceiling, along, across, blur, image, r, k)
            if extinction_per_m > 0.0:
                clear = math.exp(-extinction_per_m * ray_m)
                for c in range(3):
                    image[r, k, c] = image[r, k, c] * clear + air * (1.0 - clear)


@compiled
def board_cover(board: Floats, x_px: float, y_px: float, scale: float, edge_px: float) -> float:
    """Share (0 to 1) of a pixel that a board covers; `x_px`, `y_px` from its centre, `scale` pixels a metre."""
    half_width = board[HALF_WIDTH] * scale
    half_height = board[HALF_HEIGHT] * scale
    if board[ROUND] > 0.0:
        inside = half_width - math.sqrt(x_px * x_px + y_px * y_px)
        return float(min(max(inside / edge_px + 0.5, 0.0), 1.0))
    across = min(max((half_width - abs(x_px)) / edge_px + 0.5, 0.0), min(2.0 * half_width / edge_px, 1.0))
    upright = min(max((half_height - abs(y_px)) / edge_px + 0.5, 0.0), min(2.0 * half_height / edge_px, 1.0))
    return float(across * upright)


@compiled
def draw_board(
    image: Singles,
    left_px: int,
    top_px: int,
    lens_m: Floats,
    way_in_exposure_m: float,
    focal_px: float,
    axis_row: float,
    axis_column: float,
    lens_height_m: float,
    board: Floats,
    edge_px: float,
    extinction_per_m: float,
    air: float,
) -> None:
    """Draw one board or disc that faces the camera, blurred by the lens and by the way run while exposing."""
    rows, columns = image.shape[0], image.shape[1]
    nearest_m = board[ALONG] - lens_m[rows - 1] - way_in_exposure_m
    if nearest_m <= 0.01:
        return
    scale = focal_px / nearest_m
    reach = board[HALF_WIDTH] * scale + edge_px + 2.0
    centre = axis_column + board[RIGHT] * scale
    far_centre = axis_column + board[RIGHT] * focal_px / (board[ALONG] - lens_m[0])
    first = max(int(min(centre, far_centre) - reach) - left_px, 0)
    last = min(int(max(centre, far_centre) + reach) + 1 - left_px, columns)
    for r in range(rows):
        v_px = top_px + r + 0.5 - axis_row
        near_v = (lens_height_m - board[UP]) * focal_px / nearest_m
        far_v = (lens_height_m - board[UP]) * focal_px / (board[ALONG] - lens_m[0])
        tall = board[HALF_HEIGHT] * scale + edge_px + 2.0
        if v_px < min(near_v, far_v) - tall or v_px > max(near_v, far_v) + tall:
            continue
        for k in range(first, last):
            u_px = left_px + k + 0.5 - axis_column
            cover = 0.0
            for instant in range(INSTANTS):
                distance = board[ALONG] - lens_m[r] - way_in_exposure_m * (instant + 0.5) / INSTANTS
                now = focal_px / distance
                x_px = u_px - board[RIGHT] * now
                y_px = v_px - (lens_height_m - board[UP]) * now
                cover += board_cover(board, x_px, y_px, now, edge_px) / INSTANTS
            if cover <= 0.0:
                continue
            clear = math.exp(-extinction_per_m * (board[ALONG] - lens_m[r]))
            for c in range(3):
                colour = board[BLUE + c] * clear + air * (1.0 - clear)
                image[r, k, c] = image[r, k, c] * (1.0 - cover) + colour * cover


@compiled
def expose_image(
    image: Singles,
    light: Floats,
    noise: Singles,
    noise_from: int,
    read_grey: float,
    shot_grey: float,
    out: NDArray[np.uint8],
) -> None:
    """Light (one factor a row), sensor noise and 8 bits, into `out`.

    The variance of a pixel (grey levels, squared) is `read_grey`^2 and `shot_grey` times its grey.
    """
    used = noise_from
    last = noise.size - 1  # a power of two less one
    for r in range(image.shape[0]):
        for k in range(image.shape[1]):
            for c in range(3):
                grey = 255.0 * image[r, k, c] * light[r]
                sigma = read_grey
                if shot_grey > 0.0:
                    sigma = math.sqrt(read_grey * read_grey + shot_grey * max(grey, 0.0))
                grey += sigma * noise[used & last]
                used += 1
                out[r, k, c] = np.uint8(min(max(grey + 0.5, 0.0), 255.0))
