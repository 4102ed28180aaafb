"""Figures 4 to 6 and 1 of Harada and others as ours come out, drawn as SVG and PNG."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.figure import Figure

from study.report.style import INK, PALE, RED, RULE, drawing

if TYPE_CHECKING:
    from study.papers.harada_accuracy import Runs
    from study.papers.harada_bench import Ride
    from study.papers.harada_watch import Watch

BLUE: Final = "#2f7fb8"
BAND: Final = "#cfe2f0"
COLOURS: Final = (BLUE, RED, "#c08a2b")
BIN_M: Final = 0.25
SHOWN_M: Final = 5.0


def write_errors(space: Runs, others: Sequence[Runs], folder: Path) -> tuple[Path, ...]:
    """Figure 5, with the other filters beside it, and the errors over the way."""
    with drawing():
        return _written(_errors(space, others), folder, "harada_errors")


def _errors(space: Runs, others: Sequence[Runs]) -> Figure:
    figure = Figure(figsize=(9.0, 7.0), layout="constrained")
    top, below = figure.subplots(2, 1)
    edges = np.arange(-SHOWN_M, SHOWN_M + BIN_M / 2.0, BIN_M)
    for runs, colour in zip((space, *others), COLOURS, strict=True):
        inside = np.clip(runs.errors_m, -SHOWN_M + 1e-3, SHOWN_M - 1e-3)
        filled = runs is space
        top.hist(
            inside,
            edges,
            histtype="stepfilled" if filled else "step",
            color=BAND if filled else colour,
            edgecolor=colour,
            lw=0.9,
            label=f"{runs.name}: sigma {runs.sigma_m:.2f} m",
        )
    for limit_m in (-2.0, 2.0):
        top.axvline(limit_m, color=PALE, lw=0.8, ls="--")
    top.set_xlabel(f"error at a check point, m (beyond {SHOWN_M:g} m in the last bins)")
    top.set_ylabel("check points")
    top.set_title(f"Errors at {space.errors_m.size} check points (the paper: sigma 0.65 m, all within 2 m)")
    top.legend(loc="upper right")
    for number, ride in enumerate(space.rides, start=1):
        at_km = [(point.true_m - ride.base_m) / 1000.0 for point in ride.check_points]
        below.plot(at_km, ride.errors_m, ".", ms=3.0, label=f"run {number}")
    for limit_m in (-2.0, 2.0):
        below.axhline(limit_m, color=PALE, lw=0.8, ls="--")
    below.set_xlabel("kilometrage, km")
    below.set_ylabel("error, m")
    below.grid(visible=True)
    below.legend(loc="upper right", ncols=len(space.rides))
    return figure


Marks = Sequence[tuple[float, float, str]]  # stretches (m) with words


def write_watched(watched: Watch, marks: Marks, title: str, folder: Path, name: str) -> tuple[Path, ...]:
    """Figures 4 and 6: speeds, curvature of map and run, mismatch, error."""
    with drawing():
        return _written(_watched(watched, marks, title), folder, name)


def _watched(watched: Watch, marks: Marks, title: str) -> Figure:
    rows = watched.rows
    at_km = rows["true_m"] / 1000.0
    figure = Figure(figsize=(9.0, 9.0), layout="constrained")
    speeds, bends, misfits, errors = figure.subplots(4, 1, sharex=True)
    speeds.plot(at_km, rows["wheel_mps"] * 3.6, color=RED, lw=0.9, label="shown by the wheels")
    speeds.plot(at_km, rows["speed_mps"] * 3.6, color=INK, lw=0.9, label="the train's")
    speeds.set_ylabel("speed, km/h")
    bends.plot(
        at_km, rows["map_per_m"] * 1000.0, color="#d98b2b", lw=1.0, label="map, where the unit believes to be"
    )
    bends.plot(at_km, rows["run_per_m"] * 1000.0, color=BLUE, lw=0.9, label="run")
    bends.set_ylabel("curvature, 1/km")
    misfits.plot(
        at_km, rows["mismatch_per_m"] * 1000.0, color=BLUE, lw=0.9, label="mismatch (root of the mean square)"
    )
    misfits.axhline(watched.threshold_per_m * 1000.0, color=RED, lw=0.8, ls="--", label="threshold")
    misfits.set_ylabel("1/km")
    errors.fill_between(
        at_km,
        -rows["behind_m"] + rows["error_m"],
        rows["ahead_m"] + rows["error_m"],
        color=BAND,
        lw=0,
        label="bounds",
    )
    errors.plot(at_km, rows["error_m"], color=INK, lw=0.9, label="estimate less truth")
    errors.axhline(0.0, color=PALE, lw=0.6)
    errors.set_ylabel("m")
    errors.set_xlabel("kilometrage, km")
    for axes in (speeds, bends, misfits, errors):
        axes.grid(visible=True)
        for from_m, to_m, words in marks:
            axes.axvspan(
                from_m / 1000.0,
                to_m / 1000.0,
                color=RULE,
                lw=0,
                alpha=0.6,
                label=words if axes is speeds else None,
            )
        axes.legend(loc="upper right")
    figure.suptitle(title)
    return figure


def write_beacons(rides: Sequence[tuple[str, Ride]], until_m: float, folder: Path) -> tuple[Path, ...]:
    """Figure 1 (3): the error over the way by beacons and by curvature, with the beacons and their windows."""
    with drawing():
        return _written(_beacons(rides, until_m), folder, "harada_beacons")


def _beacons(rides: Sequence[tuple[str, Ride]], until_m: float) -> Figure:
    figure = Figure(figsize=(9.0, 4.6), layout="constrained")
    axes: Any = figure.subplots()
    for (words, ride), colour in zip(rides, COLOURS, strict=False):
        at_m = ride.kilometrage_m
        shown = at_m <= until_m
        axes.plot(
            at_m[shown], ride.result.trace["estimate_error_m"][shown], color=colour, lw=1.0, label=words
        )
    line = rides[0][1].trip.place.line
    for beacon in line.beacons.values():
        if beacon.position_m > until_m:
            continue
        axes.axvline(
            beacon.position_m, color=INK if beacon.used else PALE, lw=0.8, ls="-" if beacon.used else ":"
        )
        if beacon.used and beacon.window_m:
            axes.axvspan(
                beacon.position_m - beacon.window_m,
                beacon.position_m + beacon.window_m,
                color=RULE,
                lw=0,
                alpha=0.6,
            )
    axes.set_xlabel("kilometrage, m (lines: beacons, dotted where no database goes by them; grey: windows)")
    axes.set_ylabel("estimate less truth, m")
    axes.grid(visible=True)
    axes.legend(loc="upper right")
    axes.set_title(
        "Wheels slip after the first beacon: another one is taken for the second, and the next two are missed"
    )
    return figure


def _written(figure: Figure, folder: Path, name: str) -> tuple[Path, ...]:
    folder.mkdir(parents=True, exist_ok=True)
    paths = tuple(folder / f"{name}.{kind}" for kind in ("svg", "png"))
    figure.savefig(paths[0], metadata={"Date": None, "Creator": None})
    figure.savefig(paths[1], dpi=130, metadata={"Software": None})
    return paths
