"""The pictures of docs/studies/accidents.md: where the trains were, a panel for each way of working the line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MultipleLocator

from network.clock import clock
from study.report.style import RED, UNIT_COLOURS, WIDTH_IN, drawing

DPI: Final = 110
_PANEL_IN: Final = 2.3
_MARKS: Final = ("-", "--")  # colour is never the only sign
MINUTE_S: Final = 60.0
APART: Final = 0.06  # of the height


@dataclass(frozen=True, slots=True)
class TrainPath:
    """Times (s) and places (km) of one train."""

    train: str
    at_s: tuple[float, ...]
    km: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Panel:
    """One run: its trains, and where two of them collided, if they did."""

    label: str
    trains: Sequence[TrainPath]
    collision: tuple[float, float] | None


def draw_panels(
    file: Path,
    panels: Sequence[Panel],
    places_km: Mapping[str, float],
    published: tuple[float, float],
    window_s: tuple[float, float],
) -> None:
    """Time to the right, the line's places upwards; a cross where trains collide, a circle where they did in truth."""
    with drawing():
        figure = Figure(figsize=(WIDTH_IN, _PANEL_IN * len(panels) + 0.3), layout="constrained")
        axes_of = figure.subplots(len(panels), 1, squeeze=False, sharex=True)[:, 0]
        for axes, panel in zip(axes_of, panels, strict=True):
            for i, train in enumerate(panel.trains):
                colour, style = UNIT_COLOURS[i % len(UNIT_COLOURS)], _MARKS[i % len(_MARKS)]
                axes.plot(train.at_s, train.km, style, color=colour, label=train.train)
            axes.plot(*published, "o", color=RED, fillstyle="none", markersize=9, label="as published")
            if panel.collision is not None:
                axes.plot(*panel.collision, "x", color=RED, markersize=9, label="collision")
            axes.set_title(panel.label, loc="left")
            axes.set_xlim(*window_s)
            axes.set_yticks(list(places_km.values()), _apart(places_km))
            axes.xaxis.set_major_locator(MultipleLocator(_every_s(window_s)))
            axes.xaxis.set_major_formatter(FuncFormatter(lambda at_s, _: clock(round(at_s))[:5]))
            axes.grid(visible=True)
            axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
        figure.savefig(file, dpi=DPI)


def _apart(places_km: Mapping[str, float]) -> list[str]:
    """Names of places, none where it would lie over the one before."""
    least_km = APART * (max(places_km.values()) - min(places_km.values()))
    names: list[str] = []
    last_km = -least_km + min(places_km.values())
    for name, km in places_km.items():
        names.append(name if km - last_km >= least_km else "")
        last_km = km if names[-1] else last_km
    return names


def _every_s(window_s: tuple[float, float]) -> float:
    return MINUTE_S if window_s[1] - window_s[0] < 12 * MINUTE_S else 5 * MINUTE_S
