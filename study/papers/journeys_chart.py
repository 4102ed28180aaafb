"""Where the seconds of a journey go: each hop's least time, its share in proportion, and the time allocated to it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.measures.driving import JOULE_PER_KWH
from study.measures.journeys import JourneyEnergies
from study.report.style import INK, PALE, RED, RULE, TRACTION, drawing

if TYPE_CHECKING:
    from study.papers.journeys import Case

NAME: Final = "journeys"
WIDTH: Final = 0.38


def draw_seconds(cases: Sequence[tuple[str, Sequence[str], JourneyEnergies]]) -> Figure:
    """A panel a case (name, names of hops, energies): bars over the least time, and what each hop saves."""
    figure = Figure(figsize=(9.0, 2.6 * len(cases)), layout="constrained")
    panels = figure.subplots(len(cases), 1, squeeze=False)[:, 0]
    for axes, (name, hops, found) in zip(panels, cases, strict=True):
        _panel(axes, name, hops, found)
    panels[0].legend(loc="upper right", fontsize=7.5)
    return figure


def _panel(axes: Axes, name: str, hops: Sequence[str], found: JourneyEnergies) -> None:
    at = np.arange(len(hops), dtype=np.float64)
    least = np.array(found.least_s)
    shares = [np.array(shared.journey.running_s) for shared in (found.proportional, found.optimal)]
    saved = (np.array(found.proportional.hops_j) - np.array(found.optimal.hops_j)) / JOULE_PER_KWH
    for offset, running, color, label in zip(
        (-0.5, 0.5), shares, (PALE, TRACTION), ("in proportion", "where it saves most"), strict=True
    ):
        axes.bar(at + offset * WIDTH, least, WIDTH, color=RULE, label="least" if offset < 0 else None)
        axes.bar(at + offset * WIDTH, running - least, WIDTH, bottom=least, color=color, label=label)
    tops = np.maximum(*shares)
    for x, top, kwh in zip(at, tops, saved, strict=True):
        axes.annotate(
            f"{kwh:+.2f}", (x, top), ha="center", va="bottom", fontsize=7, color=INK if kwh >= 0 else RED
        )
    axes.set_xticks(at, hops, fontsize=7.5)
    axes.set_ylim(0.0, float(tops.max()) * 1.15)
    axes.set_ylabel("running time, s")
    axes.set_title(
        f"{name}: {found.saving_percent:.2f} % saved; figures are kWh saved", fontsize=8.5, loc="left"
    )


def write_seconds(cases: Sequence[Case], folder: Path) -> tuple[Path, ...]:
    """Write the figure of all possible cases as SVG and PNG below `folder`, which is made; the files written."""
    shown = [
        (case.name, [hop.name for hop in case.hops], case.energies)
        for case in cases
        if case.energies is not None
    ]
    folder.mkdir(parents=True, exist_ok=True)
    with drawing():
        figure = draw_seconds(shown)
        paths = tuple(folder / f"{NAME}.{kind}" for kind in ("svg", "png"))
        figure.savefig(paths[0], metadata={"Date": None, "Creator": None})
        figure.savefig(paths[1], dpi=130, metadata={"Software": None})
    return paths
