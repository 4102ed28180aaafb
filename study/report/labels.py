"""Where the numbers of trains stand on a crowded graph: beside their own line, on no other line, on no other number."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text
from numpy.typing import NDArray

Floats = NDArray[np.float64]

GAP_PX: Final = 2.0  # between a number and its line, and round every box
DENSITY_PX: Final = 1.5  # lines are looked at as points that far apart
PLACES: Final = (0.5, 0.35, 0.65, 0.2, 0.8)  # along a stretch, as shares
EQUAL_PX: Final = 8.0  # lengths are compared to so much
LEAST_PX: Final = 4.0  # a stretch shorter than this on the screen has no direction


def laid_out(figure: Figure) -> None:
    """Panels get their places, and nothing is drawn for it; what comes later, as a title, moves them once more."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle on the screen, px: centre, half of width and height, angle in rad."""

    x: float
    y: float
    half_width: float
    half_height: float
    angle: float

    def corners(self) -> Floats:
        """Its four corners, shape (4, 2)."""
        along = np.array([np.cos(self.angle), np.sin(self.angle)])
        up = np.array([-along[1], along[0]])
        signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=np.float64)
        reach = np.array([along * self.half_width, up * self.half_height])
        return np.asarray(np.array([self.x, self.y]) + signs @ reach, dtype=np.float64)

    def overlaps(self, other: Box) -> bool:
        """Whether two boxes have more than an edge in common (separating axes)."""
        mine, others = self.corners(), other.corners()
        for angle in (self.angle, self.angle + np.pi / 2, other.angle, other.angle + np.pi / 2):
            axis = np.array([np.cos(angle), np.sin(angle)])
            a, b = mine @ axis, others @ axis
            if a.max() <= b.min() + 1e-9 or b.max() <= a.min() + 1e-9:
                return False
        return True

    def covers(self, points: Floats) -> int:
        """How many of some points, shape (n, 2), lie in it."""
        if points.size == 0:
            return 0
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        dx, dy = points[:, 0] - self.x, points[:, 1] - self.y
        along, up = np.abs(dx * cos + dy * sin), np.abs(dy * cos - dx * sin)
        return int(np.count_nonzero((along < self.half_width) & (up < self.half_height)))


@dataclass(frozen=True, slots=True)
class Number:
    """A train's number, and the course beside which it may stand: times (s) and kilometrages (m) of its corners."""

    text: str
    colour: str
    t_s: Floats
    at_m: Floats


def dense(points_px: Floats) -> Floats:
    """Points at most `DENSITY_PX` apart along a polyline, shape (n, 2)."""
    steps = np.diff(points_px, axis=0)
    counts = np.maximum(np.ceil(np.hypot(steps[:, 0], steps[:, 1]) / DENSITY_PX), 1.0).astype(np.int64)
    ends = np.cumsum(counts)
    share = (np.arange(int(counts.sum())) - np.repeat(ends - counts, counts)) / np.repeat(counts, counts)
    along = np.repeat(points_px[:-1], counts, axis=0) + share[:, None] * np.repeat(steps, counts, axis=0)
    return np.concatenate((along, points_px[-1:]))


def place_numbers(
    axes: Axes, numbers: Sequence[Number], lines: Iterable[Floats], occupied: Sequence[Box], size_pt: float
) -> list[Text]:
    """Write the numbers; one for which no place is free of other numbers is left out.

    The figure must have been laid out. `lines` are polylines in data coordinates, shape (n, 2); `occupied` are boxes on
    the screen where something stands. Of the places without another number the one on the fewest lines is taken.
    """
    to_px = axes.transData.transform
    window = axes.bbox
    clouds = [dense(np.asarray(to_px(line), dtype=np.float64)) for line in lines if len(line)]
    # Samples of a second lie much closer than can be seen.
    cloud = np.unique(np.round(np.concatenate(clouds)), axis=0) if clouds else np.zeros((0, 2))
    cloud = cloud[(cloud[:, 0] >= window.x0) & (cloud[:, 0] <= window.x1)]
    boxes, texts = list(occupied), list[Text]()
    for number in numbers:
        text = axes.text(
            0.0,
            0.0,
            number.text,
            color=number.colour,
            fontsize=size_pt,
            clip_on=True,
            zorder=5,
            ha="center",
            va="center",
            rotation_mode="anchor",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.0},
        )
        text.set_in_layout(False)
        extent = text.get_window_extent()
        course_px = np.asarray(to_px(np.column_stack([number.t_s, number.at_m])), dtype=np.float64)
        best: tuple[int, Box] | None = None
        for box in _candidates(course_px, extent.width, extent.height):
            corners = box.corners()
            inside = bool(
                (corners >= (window.x0, window.y0)).all() and (corners <= (window.x1, window.y1)).all()
            )
            if not inside or any(box.overlaps(other) for other in boxes):
                continue
            covered = box.covers(cloud)
            if best is None or covered < best[0]:
                best = covered, box
            if covered == 0:
                break
        if best is None:
            text.remove()
            continue
        box = best[1]
        x, y = axes.transData.inverted().transform((box.x, box.y)).tolist()
        text.set_position((x, y))
        text.set_rotation(float(np.degrees(box.angle)))
        boxes.append(box)
        texts.append(text)
    return texts


def _candidates(course_px: Floats, width_px: float, height_px: float) -> Iterator[Box]:
    """Boxes beside the stretches of a course, the longest stretch first, above the line before below it."""
    steps = np.diff(course_px, axis=0)
    lengths_px = np.hypot(steps[:, 0], steps[:, 1])
    half_width, half_height = width_px / 2 + GAP_PX / 2, height_px / 2
    # Stretches as good as equal come in the order of the run, so that numbers of like trains stand in a row.
    for index in np.argsort(-np.round(lengths_px / EQUAL_PX), kind="stable"):
        step = steps[index]
        if lengths_px[index] < LEAST_PX or step[1] == 0.0:
            continue  # the train stands there
        angle = float(np.arctan2(step[1], step[0]))
        away = np.array([-np.sin(angle), np.cos(angle)]) * (half_height + GAP_PX)
        for share in PLACES:
            on_line = course_px[index] + share * step
            for side in (1.0, -1.0):
                x, y = on_line + side * away
                yield Box(float(x), float(y), half_width, half_height, angle)
