"""What knowing where the train is means to operations: the Karasuyama weekday by sensor sets, whole and failing.

Each case is a scenario of its own that extends the line's day, read through the same door as a planner's file. What is
compared: bounds on the way, where a section could be given back (at its arrival tag) and at the mark; how long after
the whole train has truly left a section it is free again; where trains stop; how late they are; who had to brake.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import polars as pl
from numpy.typing import NDArray

from host.scratch import scratch
from network.model import SectionKind, TagPurpose
from onboard import notes
from onboard.fixes import EYE
from simulation.events import TagPassed
from study.papers.position_cases import CASES, SOON_S, Case, carries
from study.papers.position_chart import write_chart
from study.papers.reproduction import Figure, NullMethod, Options, Parameter, Reproduction, Row
from study.run.localisation import known_positions
from study.run.run import Link, Run, execute
from study.scenario.scenario import load_scenario

BASE: Final = "karasuyama_weekday"
SLICE: Final = "karasuyama_round_trip"
WHOLE: Final = "everyone arrives, no invariant broken, the truth within the bounds in every step"
LATER: Final = "releases later than with tags, s"
NULL: Final = NullMethod("wheels and the driver's word", (LATER,))
WHEELS: Final = Case("wheels", NULL.name, carries("lidar"), SOON_S, "the line has no markers")
EARLY_S: Final = -1.0  # telegrams and steps; no set may free a section before the train has left it
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Spread:
    """Median, 95 % and the largest of some values; empty: none."""

    median: float | None = None
    p95: float | None = None
    most: float | None = None

    @classmethod
    def of(cls, values: Floats) -> Spread:
        """Of values, of which none may be left out."""
        if values.size == 0:
            return cls()
        return cls(*(round(float(np.percentile(values, share)), 2) for share in (50.0, 95.0, 100.0)))

    def __str__(self) -> str:
        return "none" if self.median is None else f"{self.median:g} / {self.p95:g} / {self.most:g}"

    def as_dict(self) -> dict[str, float | None]:
        """For the figures."""
        return {"median": self.median, "p95": self.p95, "most": self.most}


@dataclass(frozen=True, slots=True)
class Day:
    """What came of a case. Half-widths and stop errors m, releases s from the true clearing of a section."""

    case: Case
    arrived: int
    planned: int
    broken: tuple[str, ...]
    on_the_way: Spread
    at_release: Spread
    at_marks: Spread
    releases: Mapping[tuple[str, str], float]
    stop_error: Spread
    late_s: float
    mean_late_s: float
    interventions: int
    lost: int
    asked: int

    @property
    def release(self) -> Spread:
        """Seconds from the true clearing of a section to its release."""
        return Spread.of(np.array(list(self.releases.values())))

    def later_than(self, other: Day) -> Floats:
        """By how much each section is released later after its train has left it than with another set, s."""
        both = self.releases.keys() & other.releases.keys()
        return np.array([self.releases[key] - other.releases[key] for key in sorted(both)])

    def as_dict(self) -> dict[str, Any]:
        """For the figures and the picture."""
        return {
            "half_width_m": self.on_the_way.as_dict(),
            "half_width_at_release_m": self.at_release.as_dict(),
            "half_width_at_marks_m": self.at_marks.as_dict(),
            "release_s": self.release.as_dict(),
            "stop_error_m": self.stop_error.as_dict(),
            "late_s_max": round(self.late_s, 1),
            "late_s_mean": round(self.mean_late_s, 2),
            "interventions": self.interventions,
            "positions_lost": self.lost,
            "drivers_asked": self.asked,
            "trains_arrived": self.arrived,
        }


def reproduce(options: Options) -> Reproduction:
    """Every case on the day of `seed`, on SUMO; quick: the three trains of a round trip, and four of the cases."""
    days = {case.name: day_of(case, options) for case in CASES if case.quick or not options.quick}
    trip = replace(options, quick=True)
    null = {
        "tags": days["tags"] if options.quick else day_of(days["tags"].case, trip),
        "wheels": day_of(WHEELS, trip),
    }
    remarks = [
        "Spreads are median / 95 % / largest. A release counts from when the rear truly left the section; the departure"
        " track and its points are held until the next station by the paper's rule, whatever the sensors.",
        "Half-widths are of what units state; that the truth lies within is judged in every step by `within-bounds`.",
        "Faults and slippery rail last an hour from 08:00; `broken` names what is not whole.",
    ]
    if options.quick:
        remarks.append("quick: one round trip instead of the day, and only some of the cases.")
    if options.out is not None:
        shown = {name: day.as_dict() | {"release_later_s": _later(day, days)} for name, day in days.items()}
        written = write_chart(shown, Path(options.out))
        remarks.append(f"Wrote {', '.join(path.name for path in written)}.")
    return Reproduction(
        "position-operations",
        "A weekday of the Karasuyama line by what trains carry to know where they are",
        _parameters(options),
        (*_rows(days), *NULL.rows(_rows(null))),
        tuple(remarks),
        tuple(
            Figure(
                f"{name}: {day.case.title}",
                day.as_dict() | {"release_later_s": _later(day, days)},
                "half-widths and stop errors m, releases s after the rear has left, and later than with tags",
            )
            for name, day in days.items()
        ),
        null=NULL,
    )


def _later(day: Day, days: Mapping[str, Day]) -> dict[str, float | None]:
    return Spread.of(day.later_than(days["tags"])).as_dict()


def day_of(case: Case, options: Options) -> Day:
    """Run one case and measure it."""
    with scratch("branchline-") as folder:
        file = folder / f"{case.name}.toml"
        file.write_text(case.text(SLICE if options.quick else BASE), "utf-8")
        run = execute(load_scenario(str(file), options.seed), Link.SIMULATED)
    return measured(case, run)


def measured(case: Case, run: Run) -> Day:
    """The figures of a run."""
    tables, summary = run.tables, run.summary
    half = known_positions(tables).select("unit", "t_s", "half_m").sort("t_s")
    stops = tables.stops.filter(pl.col("arrival_s").is_not_null())
    said = [entry.event for entry in run.result.journal.entries]
    late = tables.stops["late_arrival_s"].drop_nulls().to_numpy()
    return Day(
        case,
        summary["trains_arrived"],
        summary["trains_planned"],
        run.broken,
        Spread.of(half["half_m"].to_numpy()),
        Spread.of(_half_at(half, _passed(run))),
        Spread.of(_half_at(half, stops.select("unit", t_s="arrival_s"))),
        _releases(run),
        Spread.of(np.abs(stops["stop_error_m"].drop_nulls().to_numpy())),
        float(summary["late_s_max"] or 0.0),
        float(np.maximum(late, 0.0).mean()) if late.size else 0.0,
        sum(isinstance(event, notes.Intervention) and event.level > 0 for event in said),
        sum(isinstance(event, notes.PositionFault) for event in said),
        sum(isinstance(event, notes.FixTaken) and event.reader == EYE for event in said),
    )


def _passed(run: Run) -> pl.DataFrame:
    """When trains truly passed the arrival tags, at which what lies behind is given back."""
    arrival = {tag.id for tag in run.scenario.setup.line.tags.values() if tag.purpose is TagPurpose.ARRIVAL}
    found = [
        (entry.event.unit_id, entry.t_s)
        for entry in run.result.journal.entries
        if isinstance(entry.event, TagPassed) and entry.event.tag_id in arrival
    ]
    return pl.DataFrame(found, schema={"unit": pl.String, "t_s": pl.Float64}, orient="row")


def _half_at(half: pl.DataFrame, at: pl.DataFrame) -> Floats:
    """Half-widths at times of units, m: of the last second before each in which the position was known and it moved."""
    joined = at.sort("t_s").join_asof(half, on="t_s", by="unit", tolerance=5.0, check_sortedness=False)
    return joined["half_m"].drop_nulls().to_numpy()


def _releases(run: Run) -> dict[tuple[str, str], float]:
    """By train and section: seconds from the true clearing to the release; a portal is given back by the sign-off."""
    sections = run.scenario.setup.line.sections.values()
    portals = [section.id for section in sections if section.kind is SectionKind.PORTAL]
    blocks = run.tables.blocks.filter(~pl.col("section").is_in(portals))
    done = blocks.drop_nulls(["released_s", "cleared_s"])
    return {
        (train, section): float(released_s - cleared_s)
        for train, section, released_s, cleared_s in done.select(
            "train", "section", "released_s", "cleared_s"
        ).iter_rows()
    }


# what is judged --------------------------------------------------------------------------------------------------


def _rows(days: Mapping[str, Day]) -> Iterator[Row]:
    tags = days["tags"]
    for name, day in days.items():
        whole = day.arrived == day.planned and not day.broken
        yield Row(
            f"{name}: {WHOLE}",
            day.planned,
            day.arrived if whole else {"arrived": day.arrived, "broken": day.broken[:3]},
            whole,
            "all checkers, on SUMO",
        )
    for name, day in days.items():
        early_s = min(day.releases.values(), default=-math.inf)  # a day without a release shows nothing
        yield Row(
            f"{name}: earliest release, s after the rear has left",
            None,
            round(early_s, 1),
            early_s >= EARLY_S,
            "never before it",
        )
        if day.case.later_s is not None and day is not tags:
            later_s = Spread.of(day.later_than(tags))
            yield Row(
                f"{name}: {LATER}",
                None,
                str(later_s),
                later_s.p95 is not None and later_s.p95 <= day.case.later_s,
                f"95 % at most {day.case.later_s:g} s later: {day.case.why}",
            )


def _parameters(options: Options) -> tuple[Parameter, ...]:
    return (
        Parameter("scenario", SLICE if options.quick else BASE, "", "the line's day; each case extends it"),
        Parameter("cases", len(CASES), "", "study/papers/position_cases.py: the tables that differ"),
        Parameter(
            "faults", "08:00, 3600 s", "", "assumed: an hour of the morning, when trains meet at Ogane"
        ),
    )
