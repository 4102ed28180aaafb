"""Figures like 8 and 9 of Yasunobu and others: energy over running time, and speed and notch over distance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator
from numpy.typing import NDArray

from papers.single_stop import Rows
from study.report.style import INK, UNIT_COLOURS, drawing

KMH_PER_MPS: Final = 3.6
STYLES: Final = ("-", "-", "-", ":")


@dataclass(frozen=True, slots=True)
class EnergyCurve:
    """Running times, s, and traction energies, kWh."""

    times_s: NDArray[np.float64]
    energies_kwh: NDArray[np.float64]


def draw_energy(curves: Mapping[str, Mapping[str, EnergyCurve]]) -> Figure:
    """Energy over running time, one panel a gradient, one line a law."""
    figure = Figure(figsize=(10.0, 3.8), layout="constrained")
    panels = figure.subplots(1, len(curves), sharey=True, squeeze=False)[0]
    for panel, (gradient, lines) in zip(panels, curves.items(), strict=True):
        for number, (name, curve) in enumerate(lines.items()):
            colour = INK if name == "lower bound" else UNIT_COLOURS[number]
            mark = "" if name == "lower bound" else "o"
            panel.plot(
                curve.times_s,
                curve.energies_kwh,
                STYLES[number],
                marker=mark,
                ms=3.5,
                color=colour,
                label=name,
            )
        panel.set_title(gradient)
        panel.set_xlabel("running time, s")
        panel.xaxis.set_major_locator(MultipleLocator(5.0))
        panel.grid(visible=True)
    panels[0].set_ylabel("traction energy at the wire, kWh")
    panels[0].set_ylim(bottom=0.0)
    panels[-1].legend(loc="upper right")
    return figure


def draw_running_curves(traces: Mapping[str, Rows]) -> Figure:
    """Speed and notch over distance, one pair of panels a law."""
    figure = Figure(figsize=(10.0, 2.6 * len(traces)), layout="constrained")
    panels = figure.subplots(len(traces), 1, sharex=True, squeeze=False)[:, 0]
    for number, (panel, (name, trace)) in enumerate(zip(panels, traces.items(), strict=True)):
        at_m, colour = trace["position_m"], UNIT_COLOURS[number]
        panel.plot(at_m, trace["speed_mps"] * KMH_PER_MPS, color=colour, lw=1.4, label="speed, km/h")
        panel.set_ylabel("km/h")
        panel.set_ylim(0.0, 80.0)
        panel.grid(visible=True)
        panel.set_title(name)
        beside = panel.twinx()
        moving = trace["speed_mps"] > 0.0
        beside.step(at_m[moving], trace["notch"][moving], where="post", color=INK, lw=0.7)
        beside.set_ylabel("notch")
        beside.set_ylim(-9.5, 18.0)
        beside.set_yticks([-9, -6, -3, 0, 3, 7])
        beside.axhline(0.0, color=INK, lw=0.3)
    panels[-1].set_xlabel("distance from the start, m")
    return figure


def _write(figure: Figure, folder: Path, name: str) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.png"
    figure.savefig(path, dpi=130, metadata={"Software": None})
    return path


def write_energy(curves: Mapping[str, Mapping[str, EnergyCurve]], folder: Path) -> tuple[Path, ...]:
    """The like of figure 8 as PNG below `folder`, which is made."""
    with drawing():
        return (_write(draw_energy(curves), folder, "yasunobu_energy"),)


def write_running_curves(traces: Mapping[str, Rows], folder: Path) -> tuple[Path, ...]:
    """The like of figure 9."""
    with drawing():
        return (_write(draw_running_curves(traces), folder, "yasunobu_running_curves"),)
