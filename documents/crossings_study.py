"""What docs/studies/level-crossings.md shows: warnings by each way of finding the position, and by contacts."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import polars as pl
from matplotlib.figure import Figure
from numpy.typing import NDArray

from documents.studies_pictures import DPI
from network.model import CrossingControl, LevelCrossing
from study.record.read_back import RunRead
from study.report.data import ReportedRun
from study.report.style import DIRECTION_COLOUR, RED, WIDTH_IN, drawing

CASES: Final = ("by_tags", "by_curvature", "by_gnss", "by_all", "by_contacts", "networks_lost")
STATED: Final = {
    "by_tags": "radio, tags",
    "by_curvature": "radio, curvature",
    "by_gnss": "radio, satellites",
    "by_all": "radio, all three",
    "by_contacts": "contacts",
    "networks_lost": "radio, tags, both networks lost 12:00–13:00",
}
CONSTANT_S: Final = 1.0  # a warning by radio is constant to this and the bound over the speed
SETTLED_S: Final = 45.0  # whoever has run for so long has been running when he asked


@dataclass(frozen=True, slots=True)
class WarningBefore:
    """One warning: `warned_s` of `least_s` that the line wants, by a train that passed at `speed_mps`.

    `beyond_m`: how far the unit's bound lay ahead of the front when the warning began; `run_s`: by contacts, how long
    the front took from the contact to the road by the recorded positions, a second apart.
    """

    warned_s: float
    wanted_s: float
    speed_mps: float
    settled: bool
    from_stand: bool
    beyond_m: float
    run_s: float | None
    crossing_id: str
    at_s: float

    @property
    def constant(self) -> bool:
        """Whether it is as long as wanted, to a second and the bound over the speed."""
        return -CONSTANT_S <= self.warned_s - self.wanted_s <= CONSTANT_S + self.beyond_m / self.speed_mps


def warnings_of(run: RunRead | ReportedRun) -> list[WarningBefore]:
    """All of a run."""
    courses = {unit: rows for (unit,), rows in run.tables.trajectory.group_by(["unit"], maintain_order=True)}
    found: list[WarningBefore] = []
    for row in run.tables.warnings.iter_rows(named=True):
        crossing, course = run.line.crossings[row["crossing"]], courses[row["unit"]]
        t_s = course["t_s"].to_numpy()
        begun = max(int(np.searchsorted(t_s, float(row["at_s"] - row["warned_s"]), "right")) - 1, 0)
        then = course.row(begun, named=True)
        ahead_m = float(then["bound_ahead_m"]) + float(then["estimate_error_m"])
        found.append(
            WarningBefore(
                row["warned_s"],
                crossing.warning_s,
                row["speed_mps"],
                row["ran_s"] is not None and row["ran_s"] >= SETTLED_S and not row["from_stand"],
                row["from_stand"],
                max(ahead_m, 0.0),
                _run_s(crossing, course, t_s, row["at_s"]),
                crossing.id,
                row["at_s"],
            )
        )
    return found


def _run_s(
    crossing: LevelCrossing, course: pl.DataFrame, t_s: NDArray[np.float64], at_s: float
) -> float | None:
    """From the first contact to the road, s, by straight lines between recorded positions."""
    if crossing.control is not CrossingControl.CONTACTS:
        return None
    here = int(np.searchsorted(t_s, at_s, "right")) - 1
    sign = int(course["direction"][here])
    start_m = next(m for direction, m in crossing.starts_m.items() if int(direction) == sign)
    before = np.flatnonzero(t_s <= at_s)[::-1]
    km_m = course["kilometrage_m"].to_numpy()
    passed = next((i for i in before if sign * (start_m - km_m[i]) >= 0.0), None)
    if passed is None:
        return None
    share = (start_m - km_m[passed]) / (km_m[passed + 1] - km_m[passed])
    return at_s - float(t_s[passed] + share * (t_s[passed + 1] - t_s[passed]))


def _stated(values: Sequence[float], digits: int = 1) -> str:
    if not values:
        return "–"
    mean, spread = float(np.mean(values)), float(np.std(values))
    return f"{mean:.{digits}f} ± {spread:.{digits}f} ({min(values):.{digits}f} to {max(values):.{digits}f})"


def table(run_named: Callable[[str], RunRead]) -> Iterator[str]:
    """Warnings and closed roads of the day in every case."""
    yield (
        "| case | passages | warning of those that had run for 45 s, s | constant to 1 s and bound over speed"
        " | bound over speed, mean and largest, s | of starts within the approach, s | without any"
        " | roads closed a day, min |"
    )
    yield "|---|---|---|---|---|---|---|---|"
    for name in CASES:
        run = run_named(f"level_crossings/{name}")
        found = warnings_of(run)
        settled = [one for one in found if one.settled]
        bound_s = [one.beyond_m / one.speed_mps for one in settled]
        closed_min = float(run.tables.crossings["closed_s"].sum()) / 60.0
        constant = f"{sum(one.constant for one in settled)} of {len(settled)}"
        bounds = f"{np.mean(bound_s):.2f}, {max(bound_s):.2f}"
        by_contacts = name == "by_contacts"
        yield (
            f"| {STATED[name]} | {len(found)} | {_stated([one.warned_s for one in settled])}"
            f" | {'–' if by_contacts else constant} | {'–' if by_contacts else bounds}"
            f" | {_stated([one.warned_s for one in found if one.from_stand])}"
            f" | {sum(one.warned_s == 0.0 for one in found)} | {closed_min:.0f} |"
        )


def by_hand(run_named: Callable[[str], RunRead]) -> Iterator[str]:
    """Warnings by contacts, beside what they must be: each begins as the first train of a closure is at its contact."""
    yield "| trains in one closure | passages | largest difference of warning and run from the contact, s |"
    yield "|---|---|---|"
    closures: dict[tuple[str, float], list[WarningBefore]] = defaultdict(list)
    for one in warnings_of(run_named("level_crossings/by_contacts")):
        closures[one.crossing_id, round(one.at_s - one.warned_s, 1)].append(one)
    for count in sorted({len(trains) for trains in closures.values()}):
        differ_s: list[float] = []
        for trains in (each for each in closures.values() if len(each) == count):
            begins_s = min(one.at_s - one.run_s for one in trains if one.run_s is not None)
            differ_s += [abs(one.at_s - begins_s - one.warned_s) for one in trains]
        yield f"| {count} | {len(differ_s)} | {max(differ_s):.2f} |"


def picture(file: Path, run_named: Callable[[str], RunRead]) -> None:
    """Warning over the speed at the road, a panel a case; the line is the warning that is wanted."""
    with drawing():
        figure = Figure(figsize=(WIDTH_IN, 5.6), layout="constrained")
        panels = figure.subplots(2, 3, sharex=True, sharey=True).ravel()
        for axes, name in zip(panels, CASES, strict=True):
            found = warnings_of(run_named(f"level_crossings/{name}"))
            for stood, colour, label in (
                (False, DIRECTION_COLOUR[1], "running"),
                (True, RED, "from a stand within the approach"),
            ):
                shown = [one for one in found if one.from_stand is stood]
                kmh = [3.6 * one.speed_mps for one in shown]
                axes.plot(
                    kmh, [one.warned_s for one in shown], ".", color=colour, ms=4, alpha=0.5, label=label
                )
            axes.axhline(found[0].wanted_s, color="grey", lw=0.8)
            axes.set_title(STATED[name], fontsize=8)
            axes.set_ylim(0.0, 180.0)
        for axes in panels[3:]:
            axes.set_xlabel("speed at the road, km/h")
        for axes in panels[::3]:
            axes.set_ylabel("warning, s")
        panels[0].legend(loc="upper left", fontsize=7)
        figure.savefig(file, dpi=DPI, metadata={"Software": None})
