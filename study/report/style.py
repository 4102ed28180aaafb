"""How the report's figures look: fonts, colours, clock axes, and SVG that can stand inside one HTML page."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from html import escape
from io import StringIO
from itertools import accumulate
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from network.clock import clock as whole_clock
from network.model import Direction
from study.report.face import japanese_font

if TYPE_CHECKING:  # the page of a run has these colours and draws nothing with Matplotlib
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Text
    from matplotlib.typing import RcKeyType

DIGIT_EM: Final = 0.66  # width of a character, share of its size, at most
WIDTH_IN: Final = 13.0  # 936 pt, 1248 px at 100 %: fits a page of 1280 px and A4 across
INK: Final = "#222222"
PALE: Final = "#8a8a8a"
RULE: Final = "#d9d9d9"
RED: Final = "#b3261e"
DIRECTION_COLOUR: Final[Mapping[int, str]] = {Direction.DOWN: "#1f4e79", Direction.UP: "#b4531a"}
PLAN_COLOUR: Final[Mapping[int, str]] = {Direction.DOWN: "#0b2540", Direction.UP: "#5c2605"}
TRACTION, REGENERATED, AUXILIARY, STANDING = "#3b6ea5", "#5b8c5a", "#b5b5b5", "#dedede"
# Unit colours that stay apart in print and for colour-blind readers (after Okabe and Ito).
UNIT_COLOURS: Final = ("#0072b2", "#d55e00", "#009e73", "#a0568a", "#8c6d1f", "#4b4b4b", "#56b4e9", "#c48a00")

_TYPE: Final[dict[RcKeyType, Any]] = {
    "font.size": 8.0,
    "axes.edgecolor": PALE,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.6,
    "axes.titlesize": 8.5,
    "axes.titlelocation": "left",
    "axes.axisbelow": True,
    "grid.color": RULE,
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.solid_capstyle": "round",
    "lines.solid_joinstyle": "round",
    "svg.fonttype": "path",
    "text.parse_math": False,
    "axes.unicode_minus": True,
}


@cache
def _font_family() -> tuple[str, ...]:
    """DejaVu Sans, then the IPA font for Japanese where it is installed.

    The package that carries the font is located, not imported: its import changes the global font.
    """
    from matplotlib import font_manager

    path = japanese_font()
    if path is None:
        return ("DejaVu Sans",)
    font_manager.fontManager.addfont(path)
    return ("DejaVu Sans", "IPAexGothic")


def can_write_japanese() -> bool:
    """Whether the figures have a font with Japanese characters."""
    return len(_font_family()) > 1


@contextmanager
def drawing() -> Generator[None]:
    """Matplotlib settings for making and saving the report's figures; the caller's come back afterwards."""
    import matplotlib as mpl

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update({**_TYPE, "font.family": list(_font_family())})
        yield


def write_figure(name: str, draw: Callable[[], Figure], folder: Path) -> tuple[Path, ...]:
    """Draw a figure and write it as SVG and PNG below `folder`, which is made; the files written."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = tuple(folder / f"{name}.{kind}" for kind in ("svg", "png"))
    with drawing():
        figure = draw()
        figure.savefig(paths[0], metadata={"Date": None, "Creator": None})
        figure.savefig(paths[1], dpi=130, metadata={"Software": None})
    return paths


def svg_of(figure: Figure, name: str, tips: Mapping[str, str] | None = None) -> str:
    """The figure as an <svg> element: no prologue, no namespaces, no metadata, ids of its own.

    `name` sets the ids apart from those of other figures on the page; `tips` maps gid of an artist to the
    text shown when pointed at. Call within `drawing()`. The same figure gives the same text.
    """
    import matplotlib as mpl

    buffer = StringIO()
    with mpl.rc_context({"svg.hashsalt": name}):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None, "Format": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\s+xmlns(:\w+)?="[^"]*"', "", text)
    text = text.replace("xlink:href=", "href=")
    for gid, tip in (tips or {}).items():
        text = text.replace(f'<g id="{gid}">', f'<g id="{gid}"><title>{escape(tip)}</title>', 1)
    text = re.sub(r'\bid="([^"]+)"', rf'id="{name}-\1"', text)
    text = re.sub(r'href="#([^"]+)"', rf'href="#{name}-\1"', text)
    return re.sub(r"url\(#([^)]+)\)", rf"url(#{name}-\1)", text)


def beside(
    axes: Axes,
    text: str,
    place: tuple[float, float],
    aside_pt: tuple[float, float],
    size_pt: float,
    **how: Any,  # noqa: ANN401 - matplotlib's
) -> None:
    """A text that stands `aside_pt` to the right of a place and above it, and goes on away from it."""
    right_pt, up_pt = aside_pt
    across = "center" if right_pt == 0 else "left" if right_pt > 0 else "right"
    upright = "center" if up_pt == 0 else "bottom" if up_pt > 0 else "top"
    how |= {"textcoords": "offset points", "ha": across, "va": upright, "fontsize": size_pt}
    axes.annotate(text, place, xytext=aside_pt, **how)


def centred(axes: Axes, x: float, y: float, text: str, size_pt: float, **how: Any) -> Text:  # noqa: ANN401
    """A text whose middle stands at a place."""
    where: dict[str, Any] = {"ha": "center", "va": "center"}
    return axes.text(x, y, text, fontsize=size_pt, **where | how)


def dots(axes: Axes, x: Any, y: Any, marker: str, size_pt: float, colour: str, **how: Any) -> None:  # noqa: ANN401
    """Marks at places, with no line through them."""
    axes.plot(x, y, ls="", marker=marker, ms=size_pt, color=colour, **how)


def unit_colours(units: list[str]) -> dict[str, str]:
    """A colour for each unit, in the order given; colours repeat beyond eight units."""
    return {unit: UNIT_COLOURS[i % len(UNIT_COLOURS)] for i, unit in enumerate(units)}


def clock(time_s: float, *, seconds: bool = False) -> str:
    """HH:MM, or HH:MM:SS, of seconds since midnight; hours go on after 23 as in a Japanese timetable."""
    text = whole_clock(time_s)
    return text if seconds else text[: -len(":00")]


@dataclass(frozen=True, slots=True)
class TimeGrid:
    """Spacing of a clock axis, s: labelled lines, dashed lines between, fine lines."""

    label_s: int
    middle_s: int
    fine_s: int


@dataclass(frozen=True, slots=True)
class TimeBand:
    """A stretch of the day that makes one panel, s since midnight."""

    from_s: float
    to_s: float

    def meets(self, from_s: float, to_s: float) -> bool:
        """Whether from_s..to_s shows on the panel."""
        return from_s < self.to_s and to_s > self.from_s


BAND_S_MAX: Final = 6.5 * 3600
# Longest span for which each grid serves.
_GRIDS: Final = (
    (120, TimeGrid(10, 5, 1)),
    (600, TimeGrid(60, 30, 10)),
    (2400, TimeGrid(300, 60, 30)),
    (7200, TimeGrid(600, 300, 60)),
)
_DAY_GRID: Final = TimeGrid(3600, 1800, 600)


def time_grid(span_s: float) -> TimeGrid:
    """The grid for a span: hours, half hours and ten minutes (十分目) for a day, finer for short runs."""
    return next((grid for span_s_max, grid in _GRIDS if span_s <= span_s_max), _DAY_GRID)


def time_bands(from_s: float, to_s: float) -> tuple[tuple[TimeBand, ...], TimeGrid]:
    """Cut from_s..to_s into equal panels of at most 6.5 h that begin and end on the grid."""
    grid = time_grid(to_s - from_s)
    snap_s = grid.middle_s
    start_s = np.floor(from_s / snap_s) * snap_s
    end_s = max(np.ceil(to_s / snap_s) * snap_s, start_s + snap_s)
    count = int(np.ceil((end_s - start_s) / BAND_S_MAX))
    each_s = np.ceil((end_s - start_s) / count / snap_s) * snap_s
    return tuple(TimeBand(start_s + i * each_s, start_s + (i + 1) * each_s) for i in range(count)), grid


def draw_clock_axis(axes: Axes, band: TimeBand, grid: TimeGrid) -> None:
    """Clock labels and the three kinds of vertical lines on the time axis of `axes`."""
    from matplotlib.ticker import FuncFormatter, MultipleLocator

    axes.set_xlim(band.from_s, band.to_s)
    seconds = grid.label_s % 60 != 0
    axes.xaxis.set_major_locator(MultipleLocator(grid.label_s))

    def label(time_s: float, _place: int | None) -> str:
        return clock(time_s, seconds=seconds)

    axes.xaxis.set_major_formatter(FuncFormatter(label))
    axes.tick_params(axis="x", length=0, labeltop=True, labelbottom=True)
    styles = ((grid.fine_s, "-", 0.3), (grid.middle_s, (0, (4, 3)), 0.6), (grid.label_s, "-", 0.8))
    drawn: set[int] = set()
    for step_s, style, width_pt in reversed(styles):
        first = int(np.ceil(band.from_s / step_s))
        for i in range(first, int(np.floor(band.to_s / step_s)) + 1):
            if i * step_s not in drawn:
                drawn.add(i * step_s)
                axes.axvline(i * step_s, color=RULE, lw=width_pt, ls=style, zorder=0.5)


def text_pt(text: str, size_pt: float) -> float:
    """How wide a text stands, pt, at most; Japanese characters are as wide as high."""
    return size_pt * sum(1.0 if ord(c) > 0x2E7F else DIGIT_EM for c in text)


def spread(
    positions: Sequence[float],
    gap_min: float | Sequence[float],
    within: tuple[float, float] = (-math.inf, math.inf),
) -> list[float]:
    """Positions moved apart in their order to at least gap_min, or one for each two; what is too close keeps a mean."""
    gaps = [gap_min] * (len(positions) - 1) if isinstance(gap_min, float | int) else gap_min
    before = list(accumulate(gaps[: len(positions) - 1], initial=0.0))
    close: list[list[float]] = []
    for position, gap in zip(positions, before, strict=False):
        close.append([position - gap])
        while len(close) > 1 and fmean(close[-2]) > fmean(close[-1]):
            close[-2:] = [close[-2] + close[-1]]
    least, most = within[0], within[1] - before[-1]
    means = [min(max(fmean(own), least), most) for own in close for _ in own]
    return [mean + gap for mean, gap in zip(means, before, strict=False)]
