"""Where the seconds of a journey go: what each hop gets over its least time, in proportion and where it saves most."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from network.units import J_PER_KWH
from study.measures.journeys import JourneyEnergies
from study.report.style import INK, PALE, RED, TRACTION, drawing

Shown = tuple[str, Sequence[str], JourneyEnergies]
NAME: Final = "journeys"
WIDTH: Final = 0.38
MOVED_S: Final = 0.1


def draw_seconds(cases: Sequence[Shown]) -> Figure:
    """A panel a case (name, names of hops, energies): seconds over the least time, and what each hop saves."""
    figure = Figure(figsize=(9.0, 2.6 * len(cases)), layout="constrained")
    panels = figure.subplots(len(cases), 1, squeeze=False)[:, 0]
    for axes, (name, hops, found) in zip(panels, cases, strict=True):
        _panel(axes, name, hops, found)
    panels[0].legend(loc="upper right", fontsize=7.5)
    return figure


def _panel(axes: Axes, name: str, hops: Sequence[str], found: JourneyEnergies) -> None:
    at = np.arange(len(hops), dtype=np.float64)
    over = [
        np.array(shared.journey.running_s) - np.array(found.least_s)
        for shared in (found.proportional, found.optimal)
    ]
    saved = (np.array(found.proportional.hops_j) - np.array(found.optimal.hops_j)) / J_PER_KWH
    axes.bar(at - 0.5 * WIDTH, over[0], WIDTH, color=PALE, label="in proportion")
    axes.bar(at + 0.5 * WIDTH, over[1], WIDTH, color=TRACTION, label="where it saves most")
    tops = np.maximum(*over)
    for x, top, kwh in zip(at, tops, saved, strict=True):
        axes.annotate(
            f"{kwh:+.2f}", (x, top), ha="center", va="bottom", fontsize=7, color=INK if kwh >= 0 else RED
        )
    axes.set_xticks(at, hops, fontsize=7.5)
    axes.set_ylim(0.0, float(tops.max()) * 1.2)
    axes.set_ylabel("over the least time, s")
    axes.set_title(
        f"{name}: {found.saving_percent:.2f} % saved; figures are kWh saved", fontsize=8.5, loc="left"
    )


def write_seconds(cases: Sequence[Shown], folder: Path) -> tuple[Path, ...]:
    """Write the cases in which there was anything to share as SVG and PNG below `folder`; the files written."""
    shown = [case for case in cases if _moved_s(case[2]) > MOVED_S]
    if not shown:
        return ()
    folder.mkdir(parents=True, exist_ok=True)
    with drawing():
        figure = draw_seconds(shown)
        paths = tuple(folder / f"{NAME}.{kind}" for kind in ("svg", "png"))
        figure.savefig(paths[0], metadata={"Date": None, "Creator": None})
        figure.savefig(paths[1], dpi=130, metadata={"Software": None})
    return paths


def _moved_s(found: JourneyEnergies) -> float:
    """The most that a hop's time differs between the two."""
    times = zip(found.proportional.journey.running_s, found.optimal.journey.running_s, strict=True)
    return max(abs(one - other) for one, other in times)
