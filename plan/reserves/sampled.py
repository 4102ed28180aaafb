"""What late days bring to the trains of a timetable: come late to their portals, stand longer at stops, held doors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from simulation.late.entry import entry_late_s
from simulation.late_day import DrawnStay, late_day
from simulation.setup import Setup


@dataclass(frozen=True, slots=True)
class SampledDay:
    """A day's draws of `[late]`, by train, and by train and station; what breaks is left out."""

    entries_s: Mapping[str, float]
    stays: Mapping[tuple[str, str], DrawnStay]


def sampled_days(setup: Setup, seeds: Sequence[int]) -> tuple[SampledDay, ...]:
    """The days of these seeds, as runs draw them."""
    found: list[SampledDay] = []
    for seed in seeds:
        day = replace(setup, seed=seed)
        entries_s = {
            number: entry_late_s(day.late, seed, day.today, train)
            for number, train in day.timetable.trains.items()
        }
        found.append(SampledDay(entries_s, late_day(day).stays))
    return tuple(found)
