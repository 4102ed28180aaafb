"""The camera's part of localisation: find the stop sign (停止位置目標), measure the distance, fix the position.

Oda, chapter 3: HSV threshold, opening by two erosions and two dilations, the largest cluster, its centroid, and
a measured table from image row to distance (sections 3.2.2 and 3.3.3). The sign that should come next is looked
up in the station database; its kilometrage less (increasing) or plus (decreasing) the distance is the train's
front (section 3.1, figure 10). Pixel rows count down from the top, pixel i covers i to i + 1. Needs the extra
[vision].
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from network.model import Direction

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]

EROSIONS: Final = 2  # Oda, 3.2.2
DILATIONS: Final = 2
# Oda leaves open how many neighbours count. With four a disc of 5 pixels survives, as the paper's table to 2.8 m
# before the mark needs; with eight the rendered sign is lost some 2.2 m before it.
NEIGHBOURS: Final = cast("Image", cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)))
ROW_SCATTER_PX: Final = 2.0  # largest 3 sigma of the centroid's row in Oda's table 2
COLUMN_TOLERANCE_PX: Final = 6.0
AREA_RATIO_MAX: Final = 2.0


class ImageWindow(NamedTuple):
    """A part of the image in pixels, right and bottom edges excluded."""

    left: int
    top: int
    right: int
    bottom: int


@dataclass(frozen=True, slots=True)
class SignColour:
    """Bounds of the sign's colour, both included: hue in degrees, saturation and value in percent."""

    hue_deg: tuple[float, float] = (90.0, 224.0)  # Oda, 3.2.2
    saturation_percent: tuple[float, float] = (14.0, 100.0)
    value_percent: tuple[float, float] = (27.0, 79.0)

    def bounds(self) -> tuple[Image, Image]:
        """Lower and upper bound as OpenCV counts: hue in steps of 2 degrees, the others to 255."""
        spans = (self.hue_deg, self.saturation_percent, self.value_percent)
        scales = (0.5, 2.55, 2.55)
        lower = [math.ceil(span[0] * scale - 1e-9) for span, scale in zip(spans, scales, strict=True)]
        upper = [math.floor(span[1] * scale + 1e-9) for span, scale in zip(spans, scales, strict=True)]
        return np.array(lower, dtype=np.uint8), np.array(upper, dtype=np.uint8)


PAPER_COLOUR: Final = SignColour()
_BOUNDS: Final = {PAPER_COLOUR: PAPER_COLOUR.bounds()}


@dataclass(frozen=True, slots=True)
class Cluster:
    """The largest connected patch of the sign's colour; its centroid in pixels of the whole image."""

    row_px: float
    column_px: float
    area_px: float


@dataclass(frozen=True, slots=True)
class TargetSighting:
    """The sign seen in one image: distance from the train's front at the start of the frame, m.

    `offset_px` is the centroid's distance below the optical axis (dy of the paper), `column_px` to the right.
    """

    distance_m: float
    offset_px: float
    column_px: float
    area_px: float


@dataclass(frozen=True, slots=True, eq=False)
class SightTable:
    """What was measured once from known places (Oda, 3.3.3 (3), figure 20): distance rising, offset falling.

    `column_px` and `area_px` tell how far to the right the sign then lay and how many pixels it had.
    """

    distance_m: Floats
    offset_px: Floats
    column_px: Floats
    area_px: Floats

    def __post_init__(self) -> None:
        if self.distance_m.size < 2 or np.any(np.diff(self.distance_m) <= 0.0):
            raise ValueError("a sight table needs two or more rising distances")
        if np.any(np.diff(self.offset_px) >= 0.0) or self.offset_px[-1] <= 0.0:
            raise ValueError("the offset below the axis must fall as the distance grows, and stay above 0")

    def distance_at(self, offset_px: float) -> float | None:
        """Distance (m) for a centroid this far below the axis; None outside what was measured.

        Between entries the inverse of the offset is interpolated: for a level camera it is linear in distance.
        """
        if not self.offset_px[-1] <= offset_px <= self.offset_px[0]:
            return None
        return float(np.interp(1.0 / offset_px, 1.0 / self.offset_px, self.distance_m))

    def expected_at(self, distance_m: float) -> tuple[float, float, float]:
        """Offset and column (px) and area (px) at a distance (m), held at the ends of the table."""
        offset = 1.0 / float(np.interp(distance_m, self.distance_m, 1.0 / self.offset_px))
        column = float(np.interp(distance_m, self.distance_m, self.column_px / self.offset_px)) * offset
        area = float(np.interp(distance_m, self.distance_m, self.area_px / self.offset_px**2)) * offset**2
        return offset, column, area

    def slope_m_per_px(self, distance_m: float) -> float:
        """Distance per pixel of row (m/px, positive) around a distance: the quotient of the paper's equation 2."""
        after = int(np.clip(np.searchsorted(self.distance_m, distance_m), 1, self.distance_m.size - 1))
        rise_m = self.distance_m[after] - self.distance_m[after - 1]
        return float(rise_m / (self.offset_px[after - 1] - self.offset_px[after]))


@dataclass(frozen=True, slots=True)
class StationSign:
    """One entry of the station database: where a sign stands and where it tells a train to stop (m, kilometrage)."""

    station_id: str
    track: str
    direction: Direction
    position_m: float
    stop_m: float


@dataclass(frozen=True, slots=True)
class PositionFix:
    """The front's kilometrage (m) at the start of a frame; bounds (m) lie ahead and behind in running direction."""

    kilometrage_m: float
    bound_ahead_m: float
    bound_behind_m: float

    @property
    def accuracy_m(self) -> float:
        """The larger bound, as `onboard.localisation.tachometer.fix` takes it."""
        return max(self.bound_ahead_m, self.bound_behind_m)


def sign_mask(image: Image, colour: SignColour = PAPER_COLOUR) -> Image:
    """Binary image (0 or 255) of what has the sign's colour, after the opening; `image` is BGR, shape (h, w, 3)."""
    lower, upper = _BOUNDS.get(colour) or colour.bounds()
    mask = cv2.inRange(cv2.cvtColor(image, cv2.COLOR_BGR2HSV), lower, upper)
    mask = cv2.erode(mask, NEIGHBOURS, iterations=EROSIONS)
    return cast("Image", cv2.dilate(mask, NEIGHBOURS, iterations=DILATIONS))


def largest_cluster(
    image: Image, left_px: int = 0, top_px: int = 0, colour: SignColour = PAPER_COLOUR
) -> Cluster | None:
    """The largest patch of the sign's colour in a BGR image whose first pixel lies at `left_px`, `top_px`.

    None where there is none, or where it is cut off by the edge and its centroid would be wrong.
    """
    mask = sign_mask(image, colour)
    if not mask.any():
        return None
    count, _labels, stats, centroids = cast(
        "tuple[int, Any, NDArray[np.int32], Floats]", cv2.connectedComponentsWithStats(mask, connectivity=8)
    )
    best = max(range(1, count), key=lambda label: int(stats[label, cv2.CC_STAT_AREA]))
    left, top, width, height, area = (int(value) for value in stats[best])
    if left == 0 or top == 0 or left + width == mask.shape[1] or top + height == mask.shape[0]:
        return None
    column, row = (float(value) for value in centroids[best])
    return Cluster(top_px + row + 0.5, left_px + column + 0.5, float(area))


def is_plausible(
    table: SightTable, offset_px: float, column_px: float, area_px: float, distance_m: float
) -> bool:
    """Whether a cluster lies in the column, and has about the size, that the sign has at that distance.

    Not in the paper, whose colour occurs nowhere else; refuses most things that do share the sign's colour.
    """
    _offset, column, area = table.expected_at(distance_m)
    small = min(area, area_px) * AREA_RATIO_MAX >= max(area, area_px)
    return small and abs(column_px - column) <= COLUMN_TOLERANCE_PX + 0.02 * offset_px


def sight(
    image: Image,
    table: SightTable,
    axis_px: tuple[float, float],
    left_px: int = 0,
    top_px: int = 0,
    colour: SignColour = PAPER_COLOUR,
    plausible_only: bool = True,
) -> TargetSighting | None:
    """The paper's pipeline on one BGR image (or a window of it); None says that no sign was found.

    `axis_px` is the (row, column) of the optical axis in the whole image. `plausible_only=False` is the
    pipeline as the paper has it, without the check of column and size.
    """
    cluster = largest_cluster(image, left_px, top_px, colour)
    if cluster is None:
        return None
    offset = cluster.row_px - axis_px[0]
    column = cluster.column_px - axis_px[1]
    distance = table.distance_at(offset)
    if distance is None:
        return None
    if plausible_only and not is_plausible(table, offset, column, cluster.area_px, distance):
        return None
    return TargetSighting(distance, offset, column, cluster.area_px)


def search_window(
    table: SightTable,
    distance_m: float,
    bound_m: float,
    axis_px: tuple[float, float],
    size_px: tuple[int, int],
    margin_px: int = 8,
) -> ImageWindow | None:
    """Where in the image (`size_px`: rows, columns) the sign can be if it is `distance_m` +- `bound_m` away.

    None while all of that lies beyond the table: there is nothing to look for yet.
    """
    nearest, farthest = distance_m - bound_m, distance_m + bound_m
    if nearest > table.distance_m[-1] or farthest < table.distance_m[0]:
        return None
    near_row, near_column, near_area = table.expected_at(max(nearest, float(table.distance_m[0])))
    far_row, far_column, _area = table.expected_at(min(farthest, float(table.distance_m[-1])))
    around = margin_px + ROW_SCATTER_PX + math.sqrt(near_area / math.pi)
    window = ImageWindow(
        max(math.floor(axis_px[1] + min(near_column, far_column) - around), 0),
        max(math.floor(axis_px[0] + far_row - around), 0),
        min(math.ceil(axis_px[1] + max(near_column, far_column) + around), size_px[1]),
        min(math.ceil(axis_px[0] + near_row + around), size_px[0]),
    )
    return window if window.right > window.left and window.bottom > window.top else None


def frame_rate_error_m(speed_mps: float, frame_rate_hz: float) -> float:
    """Equation 1: the way run in one frame, m. A row is exposed up to this far beyond where the frame began."""
    return speed_mps / frame_rate_hz


def next_target(
    signs: Iterable[StationSign],
    kilometrage_m: float,
    direction: Direction,
    route: Sequence[tuple[str, str]] | None = None,
) -> StationSign | None:
    """The sign for this direction that comes next ahead of a kilometrage (m); None past the last one.

    `route` names the (station, track) pairs that the train will call at or pass; without it any track counts.
    """
    ahead = [
        sign
        for sign in signs
        if sign.direction is direction
        and direction * (sign.position_m - kilometrage_m) > 0.0
        and (route is None or (sign.station_id, sign.track) in route)
    ]
    return min(ahead, key=lambda sign: direction * sign.position_m, default=None)


def position_fix(
    sighting: TargetSighting,
    sign: StationSign,
    table: SightTable,
    speed_mps: float,
    frame_rate_hz: float,
    metres_per_metre: float = 1.0,
    row_scatter_px: float = ROW_SCATTER_PX,
) -> PositionFix:
    """The front's place at the start of the frame, from a sighting of a known sign (Oda, 3.1 and 3.2.1).

    The distance is taken as that at the start of the frame, so the estimate can only run ahead of the train by
    equation 1; the centroid's scatter (3 sigma, px) counts both ways through the table's slope. On a scale
    track `metres_per_metre` turns distance and speed (m, m/s on the track) into those of the kilometrage.
    """
    scatter_m = row_scatter_px * table.slope_m_per_px(sighting.distance_m)
    return PositionFix(
        sign.position_m - sign.direction * sighting.distance_m * metres_per_metre,
        scatter_m * metres_per_metre,
        (scatter_m + frame_rate_error_m(speed_mps, frame_rate_hz)) * metres_per_metre,
    )
