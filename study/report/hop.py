"""One hop as several laws or runs drove it: speed over distance, and the notches of each on a strip of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from network.model import Direction
from study.record.driving import DrivenHop
from study.record.figure import rows_in
from study.report.curve import KMH_PER_MPS, alignment_of, draw_gradients, draw_notches, in_km, mark_stations
from study.report.data import ReportedRun, limits_mps
from study.report.style import INK, RULE, UNIT_COLOURS, WIDTH_IN, beside, write_figure

PICTURE: Final = "laws"
SPEED_IN: Final = 3.4
STRIP_IN: Final = 0.55
_DASHES: Final = ("-", (0, (6, 1.5)), (0, (3, 1)), (0, (6, 1.5, 1, 1.5)))


@dataclass(frozen=True, slots=True)
class DrivenHopShown:
    """A hop as it was driven once: what to call it, its figures, and its samples of the trajectory."""

    label: str
    hop: DrivenHop
    samples: pl.DataFrame

    @property
    def text(self) -> str:
        """For the legend: name, energy and time."""
        hop = self.hop
        kwh = f"{hop.running_kwh:.2f}".replace("-", "−")
        return f"{self.label}: {kwh} kWh, {hop.run_s:.0f} s"

    def called(self, label: str) -> DrivenHopShown:
        """The same under another name."""
        return replace(self, label=label)


def driving_of(run: ReportedRun, train: str, from_station: str | None) -> DrivenHopShown | None:
    """The hop of a train that begins at a station, its first one if none is named; None where it did not run it."""
    hops = [hop for hop in rows_in(DrivenHop, run.tables.driving) if hop.train == train]
    known = [hop for hop in hops if hop.from_station in run.line.stations]
    hop = next((hop for hop in known if from_station in (None, hop.from_station)), None)
    if hop is None or (hop.unit, train) not in run.courses:
        return None
    arrived = run.tables.stops.filter(pl.col("train") == train, pl.col("station") == hop.to_station)
    arrival_s = arrived["arrival_s"][0] if arrived.height else None
    end_s = hop.begin_s + hop.run_s if arrival_s is None else float(arrival_s)
    course = run.courses[hop.unit, train]
    samples = course.filter(pl.col("t_s").is_between(hop.begin_s - 1.0, end_s + 0.05))
    return DrivenHopShown(hop.law, hop, samples)


def draw_hop(run: ReportedRun, driven: Sequence[DrivenHopShown]) -> Figure:
    """All of them over one axis of distance, in the direction of travel: speed, gradient, notches. Km and km/h."""
    first = driven[0]
    alignment = alignment_of(run.line, first.samples)
    direction = run.directions[first.hop.train]
    heights = [SPEED_IN, 0.7, *(STRIP_IN for _ in driven)]
    figure = Figure(figsize=(WIDTH_IN, sum(heights) + 1.3), layout="constrained")
    panels: tuple[Axes, ...] = tuple(
        figure.subplots(len(heights), 1, sharex=True, gridspec_kw={"height_ratios": heights})
    )
    speed, gradient, *strips = panels
    low_m, high_m = _extent_m(driven)
    speed.set_xlim(*((low_m, high_m) if direction is Direction.DOWN else (high_m, low_m)))
    breaks_m, limit_mps = limits_mps(run.line, alignment, direction)
    speed.step(
        breaks_m, limit_mps * KMH_PER_MPS, where="post", color=INK, lw=0.9, label="speed limit of the line"
    )
    for index, (one, strip) in enumerate(zip(driven, strips, strict=True)):
        colour = UNIT_COLOURS[index % len(UNIT_COLOURS)]
        at_m = one.samples["kilometrage_m"].to_numpy()
        kmh = one.samples["speed_mps"].to_numpy() * KMH_PER_MPS
        dashes = _DASHES[index % len(_DASHES)]
        speed.plot(at_m, kmh, color=colour, ls=dashes, lw=1.4, label=one.text)
        _draw_notches(strip, one, colour)
    speed.set_ylim(0, float(limit_mps.max()) * KMH_PER_MPS * 1.12)
    speed.set_ylabel("speed, km/h")
    speed.grid(axis="y")
    draw_gradients(gradient, alignment, direction, high_m - low_m)
    mark_stations(run, panels, low_m, high_m)
    strips[-1].xaxis.set_major_locator(MaxNLocator(24, steps=[1, 2, 5, 10]))
    strips[-1].xaxis.set_major_formatter(FuncFormatter(in_km))
    strips[-1].set_xlabel("kilometrage, km")
    figure.legend(*speed.get_legend_handles_labels(), loc="outside lower center", ncols=4, handlelength=3.2)
    figure.align_ylabels()
    return figure


def _extent_m(driven: Sequence[DrivenHopShown]) -> tuple[float, float]:
    """Lowest and highest kilometrage, with a little room at both ends."""
    ends_m = np.concatenate([one.samples["kilometrage_m"].to_numpy() for one in driven])
    low_m, high_m = float(ends_m.min()), float(ends_m.max())
    room_m = max(0.015 * (high_m - low_m), 1.0)
    return low_m - room_m, high_m + room_m


def _draw_notches(axes: Axes, one: DrivenHopShown, colour: str) -> None:
    """Power up, brake down, with the name of the law at the left and how often each changed at the right."""
    draw_notches(axes, one.samples, (colour, colour), 0.45, 3)
    axes.tick_params(axis="y", labelsize=6)
    axes.spines[:].set_color(RULE)
    hop = one.hop
    changes = f"{hop.power_changes} power,\n{hop.brake_changes} brake"
    for text, at, aside_pt, colour_of, size_pt in (
        (one.label, (0.0, 0.5), -24, colour, 7.0),
        (changes, (1.0, 0.5), 4, INK, 6.5),
    ):
        beside(
            axes,
            text,
            at,
            (aside_pt, 0),
            size_pt,
            xycoords="axes fraction",
            color=colour_of,
            annotation_clip=False,
        )


def write_hop(runs: Sequence[ReportedRun], which: tuple[str, str], folder: Path) -> tuple[Path, ...]:
    """Write the picture of one hop (train, station where it begins) below `folder`, which is made; the files written.

    Runs in which the train did not run the hop are left out; nothing is written where it did in none.
    """
    found = [driving for run in runs if (driving := driving_of(run, *which)) is not None]
    if not found:
        return ()
    return write_figure(f"{PICTURE}-{'-'.join(which)}", lambda: draw_hop(runs[0], found), folder)
