"""The charts of the reproductions: panels of lines, bands, stretches and counts, written as SVG and PNG."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from study.report.style import INK, PALE, RULE, write_figure

BLUE: Final = "#2f7fb8"
BAND: Final = "#cfe2f0"
Values = NDArray[np.float64] | Sequence[float]
Corner = Literal["upper right", "upper left", "lower right", ""]


class Plottable(Protocol):
    """Anything that a panel shows."""

    def on(self, axes: Axes) -> None:
        """Draw it."""


@dataclass(frozen=True, slots=True)
class _Drawn:
    x: Values = ()
    y: Values = ()
    label: str = ""
    colour: str | None = INK
    style: str = "-"
    width: float = 0.9


@dataclass(frozen=True, slots=True)
class Plotted(_Drawn):
    """Values against others, by Matplotlib's marks of line and point; without a colour the next one of the cycle."""

    size: float = 3.0
    hollow: bool = False

    def on(self, axes: Axes) -> None:
        """Draw it."""
        drawn: Any = {"color": self.colour, "lw": self.width, "ms": self.size, "label": self.label or None}
        if self.hollow:
            drawn["mfc"] = "none"
        axes.plot(self.x, self.y, self.style, **drawn)


@dataclass(frozen=True, slots=True)
class Band:
    """What lies between two curves; `across`: between two values of x at each of y."""

    at: Values
    low: Values
    high: Values
    label: str
    colour: str = BAND
    across: bool = False

    def on(self, axes: Axes) -> None:
        """Draw it."""
        style: dict[str, Any] = {"color": self.colour, "lw": 0, "label": self.label}
        if self.across:
            axes.fill_betweenx(self.at, self.low, self.high, **style)
        else:
            axes.fill_between(self.at, self.low, self.high, **style)


@dataclass(frozen=True, slots=True)
class Shaded:
    """What lies between two values of x, over the whole height."""

    from_x: float
    to_x: float
    label: str = ""

    def on(self, axes: Axes) -> None:
        """Draw it."""
        axes.axvspan(self.from_x, self.to_x, color=RULE, lw=0, alpha=0.6, label=self.label or None)


@dataclass(frozen=True, slots=True)
class Ruled(_Drawn):
    """Straight lines at values of x, or of y, all through the panel."""

    colour: str | None = PALE
    style: str = "--"
    width: float = 0.8

    def on(self, axes: Axes) -> None:
        """Draw them."""
        style: dict[str, Any] = {"color": self.colour, "lw": self.width, "ls": self.style}
        for value in self.x:
            axes.axvline(float(value), label=self.label or None, **style)
        for value in self.y:
            axes.axhline(float(value), label=self.label or None, **style)


@dataclass(frozen=True, slots=True)
class Histogram:
    """A histogram: filled, or its outline."""

    values: Values
    edges: Values
    label: str = ""
    colour: str = INK
    filled: bool = False
    density: bool = False

    def on(self, axes: Axes) -> None:
        """Draw it."""
        kind: Literal["step", "stepfilled"] = "stepfilled" if self.filled else "step"
        face = BAND if self.filled and not self.density else self.colour
        drawn: Any = {"color": face, "edgecolor": self.colour, "lw": 0.9, "label": self.label or None}
        axes.hist(self.values, list(self.edges), histtype=kind, density=self.density, **drawn)


@dataclass(frozen=True, slots=True)
class Panel:
    """One pair of axes; `also` draws what is not of one of these kinds. `legend`: where it stands, empty: none."""

    x: str
    y: str
    shown: Sequence[Plottable]
    title: str = ""
    x_limits: tuple[float, float] | None = None
    y_limits: tuple[float, float] | None = None
    legend: Corner = "upper right"
    columns: int = 1  # of the legend
    grid: bool = True
    also: Callable[[Axes], object] | None = None

    def on(self, axes: Axes) -> None:
        """Draw it."""
        for each in self.shown:
            each.on(axes)
        if self.also is not None:
            self.also(axes)
        axes.set(xlabel=self.x, ylabel=self.y, title=self.title)
        if self.x_limits is not None:
            axes.set_xlim(*self.x_limits)
        if self.y_limits is not None:
            axes.set_ylim(*self.y_limits)
        if self.grid:
            axes.grid(visible=True)
        if self.legend:
            axes.legend(loc=self.legend, ncols=self.columns)


@dataclass(frozen=True, slots=True)
class ChartPage:
    """Rows of panels under a title; `size_in` wide and high."""

    name: str
    size_in: tuple[float, float]
    rows: Sequence[Sequence[Panel]]
    title: str = ""
    shared: bool = True  # the x of panels below one another

    def figure(self) -> Figure:
        """The drawing."""
        figure = Figure(figsize=self.size_in, layout="constrained")
        shared = self.shared and len(self.rows) > 1 and not any(panel.x for panel in self.rows[0])
        grid = figure.subplots(len(self.rows), len(self.rows[0]), squeeze=False, sharex=shared)
        for panels, line in zip(self.rows, grid, strict=True):
            for panel, axes in zip(panels, line, strict=True):
                panel.on(axes)
        if self.title:
            figure.suptitle(self.title)
        return figure

    def write(self, folder: Path) -> tuple[Path, ...]:
        """Write it below `folder`, which is made; the files written."""
        return write_figure(self.name, self.figure, folder)
