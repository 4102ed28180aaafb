"""One run as the report's figures need it: line, timetable and tables, with the questions they share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import polars as pl
from numpy.typing import NDArray

from network.model import Alignment, Direction, Line, Section, Station
from network.timetable import Timetable
from study.record.tables import RunTables
from study.wording.phrase import Phrase


@dataclass(frozen=True)
class ReportedRun:
    """A run to report on. The answers below are computed once, when first asked for."""

    line: Line
    timetable: Timetable
    tables: RunTables

    @cached_property
    def trajectory(self) -> pl.DataFrame:
        """Samples on the line with a finite time, place and speed, by time."""
        known = (
            pl.col("t_s").is_finite() & pl.col("kilometrage_m").is_finite() & pl.col("speed_mps").is_finite()
        )
        return self.tables.trajectory.filter(known, pl.col("piece").is_in(list(self.line.pieces))).sort(
            "t_s", maintain_order=True
        )

    @cached_property
    def courses(self) -> Mapping[tuple[str, str], pl.DataFrame]:
        """Samples of each (unit, train), in the order in which they began to run."""
        parts = self.trajectory.partition_by("unit", "train", maintain_order=True)
        return {(str(part["unit"][0]), str(part["train"][0])): part for part in parts}

    @cached_property
    def directions(self) -> Mapping[str, Direction]:
        """Direction of each train by the timetable, or of its first sample for trains that are not in it."""
        planned = {number: train.direction for number, train in self.timetable.trains.items()}
        ran = {train: Direction(int(part["direction"][0])) for (_, train), part in self.courses.items()}
        return {**ran, **planned}

    @cached_property
    def trains(self) -> tuple[str, ...]:
        """Every train planned or run, by the time at which it begins."""
        begins_s: dict[str, float] = {
            number: float(train.calls[0].first_s) for number, train in self.timetable.trains.items()
        }
        for (_, train), part in self.courses.items():
            begins_s.setdefault(train, float(part["t_s"][0]))
        return tuple(sorted(begins_s, key=lambda number: (begins_s[number], number)))

    @cached_property
    def units(self) -> tuple[str, ...]:
        """Every unit that is planned, ran or held a section, by name."""
        planned = (diagram.stock_id for diagram in self.timetable.diagrams)
        return tuple(sorted({*planned, *self.tables.trajectory["unit"], *self.tables.blocks["unit"]}))

    @cached_property
    def stations(self) -> tuple[Station, ...]:
        """Stations and halts by kilometrage."""
        return tuple(sorted(self.line.stations.values(), key=lambda station: station.position_m))

    def along(self, direction: Direction, leg: tuple[str, str]) -> tuple[float, float, tuple[str, str]]:
        """Where a leg stands among those of a direction: by both ends, from outside first, out of the line last."""
        at_m = {station.id: direction * station.position_m for station in self.stations}
        return at_m.get(leg[0], -np.inf), at_m.get(leg[1], np.inf), leg

    @cached_property
    def extent_m(self) -> tuple[float, float]:
        """Lowest and highest kilometrage of stations and stopping marks, m."""
        marks_m = [m for station in self.stations for track in station.tracks for m in track.marks_m.values()]
        at_m = [*marks_m, *(station.position_m for station in self.stations)]
        return min(at_m), max(at_m)

    @cached_property
    def window_s(self) -> tuple[float, float]:
        """First and last time planned for trains that ran, or sampled, s; (0, 60) for an empty run."""
        ran = {train for _, train in self.courses}
        times = [
            float(time_s)
            for number, train in self.timetable.trains.items()
            if number in ran or not ran
            for time_s in (train.calls[0].first_s, train.calls[-1].last_s)
        ]
        if len(self.trajectory):
            times += [float(self.trajectory["t_s"][0]), float(self.trajectory["t_s"][-1])]
        return (min(times), max(times)) if times else (0.0, 60.0)


def sections_in_order(run: ReportedRun) -> tuple[Section, ...]:
    """Sections by the kilometrage of their middle, then by name; the order in which figures have them."""
    pieces = run.line.pieces

    def key(section: Section) -> tuple[float, str]:
        ends_m = [m for piece in section.piece_ids for m in (pieces[piece].from_m, pieces[piece].to_m)]
        return (round((min(ends_m) + max(ends_m)) / 2), section.id) if ends_m else (0.0, section.id)

    return tuple(sorted(run.line.sections.values(), key=key))


def limits_mps(
    line: Line, alignment: Alignment, direction: Direction
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Steps of the speed limit in `direction`: breaks in m and the limit from each to the next, m/s.

    Line maximum and limits of the alignment; those of points' diverging legs depend on the route.
    """
    limits = [limit for limit in alignment.limits if direction in limit.directions]
    ends = [end_m for limit in limits for end_m in (limit.from_m, limit.to_m)]
    breaks_m = np.unique([alignment.from_m, alignment.to_m, *ends])
    speed_mps = np.full(len(breaks_m), line.max_speed_mps)
    for limit in limits:
        within = (breaks_m >= limit.from_m) & (breaks_m < limit.to_m)
        speed_mps[within] = np.minimum(speed_mps[within], limit.speed_mps)
    return breaks_m, speed_mps


def section_name(run: ReportedRun, section_id: str, *, japanese: bool = False) -> str:
    """A section's id with the names of stations for their ids: NII.1 is Niiya 1, YSH-NII is Yoshii–Niiya."""
    ends = [
        " ".join(place_name(run, part, japanese=japanese) for part in end.split("."))
        for end in section_id.split("-")
    ]
    named = any(part in run.line.stations for end in section_id.split("-") for part in end.split("."))
    return "–".join(ends) if named else section_id


def place_name(run: ReportedRun, place: str, *, japanese: bool = False) -> str:
    """A station's name; a portal section's id."""
    station = run.line.stations.get(place)
    if station is None:
        return place
    return (station.name_ja or station.name) if japanese else station.name


def place_said(run: ReportedRun, place: str) -> Phrase:
    """The same in both languages."""
    return Phrase(place_name(run, place), place_name(run, place, japanese=True))
