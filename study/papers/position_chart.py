"""The picture of `position-operations`: a row a case; bounds, releases, stops and lateness beside one another."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.report.style import AUXILIARY, INK, RED, REGENERATED, RULE, TRACTION, WIDTH_IN, drawing

NAME: Final = "position_operations"
LEAST_M: Final = 0.05  # shown where a spread is nothing on a logarithmic axis
_PANELS: Final = (
    ("half-width of the bounds, m", (("on the way", "half_width_m"), ("at ①", "half_width_at_release_m"))),
    ("at the mark, m", (("half-width", "half_width_at_marks_m"), ("stop error", "stop_error_m"))),
)
_COLOURS: Final = (TRACTION, REGENERATED)


def draw_cases(days: Mapping[str, Mapping[str, Any]]) -> Figure:
    """`days`: the figures of each case by its name, as the reproduction tells them."""
    names = list(days)
    figure = Figure(figsize=(WIDTH_IN, 1.4 + 0.42 * len(names)), layout="constrained")
    panels = figure.subplots(1, 4, sharey=True, gridspec_kw={"width_ratios": [1.3, 1.3, 1.3, 1.0]})
    for axes, (title, series) in zip(panels, _PANELS, strict=False):
        _spreads(axes, title, [(label, [days[n][key] for n in names]) for label, key in series])
    later = [days[n].get("release_later_s") or days[n]["release_s"] for n in names]
    _spreads(panels[2], "release later than with tags, s", [("by section", later)], logarithmic=False)
    _lateness(panels[3], [days[n] for n in names])
    panels[0].set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
    panels[0].set_ylim(len(names) - 0.4, -0.6)
    for axes in panels:
        axes.spines[:].set_color(RULE)
        axes.tick_params(axis="y", length=0)
        for row in range(len(names)):
            axes.axhline(row + 0.5, color=RULE, lw=0.4, zorder=0.4)
    return figure


def _spreads(
    axes: Axes, title: str, series: list[tuple[str, list[Mapping[str, Any]]]], *, logarithmic: bool = True
) -> None:
    """A dot at the median, a line to 95 %, a tick at the largest."""
    for index, (label, spreads) in enumerate(series):
        aside = 0.16 * (2 * index - len(series) + 1)
        for row, spread in enumerate(spreads):
            if spread["median"] is None:
                continue
            least = LEAST_M if logarithmic else float("-inf")
            median, p95, most = (max(spread[key], least) for key in ("median", "p95", "most"))
            colour = _COLOURS[index]
            axes.plot([median, p95], [row + aside] * 2, color=colour, lw=2.2)
            axes.plot(median, row + aside, "o", color=colour, ms=4, label=label if row == 0 else None)
            axes.plot(most, row + aside, "|", color=colour, ms=7)
    if logarithmic:
        axes.set_xscale("log")
        axes.set_xticks([0.1, 1.0, 10.0, 100.0], ["0.1", "1", "10", "100"])
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)
    else:
        axes.set_xscale("symlog", linthresh=10.0)
        axes.set_xticks([0.0, 10.0, 100.0, 1000.0], ["0", "10", "100", "1000"])
    axes.set_xlabel(title)
    axes.grid(axis="x")


def _lateness(axes: Axes, days: list[Mapping[str, Any]]) -> None:
    """The latest arrival or departure of the day, and how many positions were lost and drivers asked."""
    for row, day in enumerate(days):
        late_min = day["late_s_max"] / 60.0
        axes.barh(row, late_min, 0.5, color=RED if late_min > 1.0 else AUXILIARY)
        words = f" {late_min:.1f}"
        if day["positions_lost"]:
            words += f", {day['positions_lost']} lost"
        axes.annotate(words, (late_min, row), va="center", fontsize=6.5, color=INK)
    axes.set_xlim(0.0, 1.5 * max(1.0, *(day["late_s_max"] / 60.0 for day in days)))
    axes.set_xlabel("latest call, min; positions lost")
    axes.grid(axis="x")


def write_chart(days: Mapping[str, Mapping[str, Any]], folder: Path) -> tuple[Path, ...]:
    """Write the picture as SVG and PNG below `folder`, which is made; the files written."""
    folder.mkdir(parents=True, exist_ok=True)
    with drawing():
        figure = draw_cases(days)
        paths = tuple(folder / f"{NAME}.{kind}" for kind in ("svg", "png"))
        figure.savefig(paths[0], metadata={"Date": None, "Creator": None})
        figure.savefig(paths[1], dpi=130, metadata={"Software": None})
    return paths
