"""Figures of a day that a sweep watches, by name: what each is called, its unit, and which way is better."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from network.errors import InputError
from network.files.toml_input import one_of
from study.measures.day_figures import LIMITS_S, DayFigures


@dataclass(frozen=True, slots=True)
class DayFigure:
    """One figure. `of` gives None where the day has none, as the lateness of a day on which nothing arrived."""

    name: str
    title: str
    unit: str
    of: Callable[[DayFigures], float | None]
    more_is_better: bool = False

    @property
    def label(self) -> str:
        """Title and unit, for an axis."""
        return f"{self.title}, {self.unit}" if self.unit else self.title


def _within(index: int) -> Callable[[DayFigures], float | None]:
    return lambda day: day.within[index] if day.planned_arrivals else None


_ALL: Final = (
    DayFigure("mean_late_s", "mean lateness of arrivals", "s", lambda day: day.mean_late_s),
    DayFigure("mean_delay_s", "mean delay of arrivals, early as on time", "s", lambda day: day.mean_delay_s),
    DayFigure("median_late_s", "median lateness of arrivals", "s", lambda day: day.median_late_s),
    DayFigure("p95_late_s", "lateness that 5 % of arrivals exceed", "s", lambda day: day.p95_late_s),
    DayFigure("worst_late_s", "latest arrival", "s", lambda day: day.worst_late_s),
    DayFigure("lost_train_minutes", "train-minutes lost", "min", lambda day: day.lost_train_minutes),
    DayFigure("primary_s", "lateness from what was drawn or failed", "s", lambda day: day.primary_s),
    DayFigure("secondary_s", "lateness from waiting for other trains", "s", lambda day: day.secondary_s),
    DayFigure(
        "recovery_mean_s",
        "mean time from a delay until no train is late",
        "s",
        lambda day: day.recovery_mean_s,
    ),
    DayFigure("recovery_s", "longest time with a late train", "s", lambda day: day.recovery_s),
    DayFigure("late_time_s", "time with a late train", "s", lambda day: day.late_time_s),
    *(
        DayFigure(
            f"within_{limit_s:.0f}_s",
            f"arrivals less than {limit_s:.0f} s late",
            "share",
            _within(index),
            more_is_better=True,
        )
        for index, limit_s in enumerate(LIMITS_S)
    ),
    DayFigure(
        "arrived_trains", "trains that arrive", "", lambda day: float(day.arrived_trains), more_is_better=True
    ),
    DayFigure(
        "cancelled_trains", "trains left out by the dispatcher", "", lambda day: float(len(day.cancelled))
    ),
    DayFigure("shortened_trains", "trains cut by the dispatcher", "", lambda day: float(len(day.shortened))),
    DayFigure("missing_trains", "trains that never arrive", "", lambda day: float(len(day.missing))),
    DayFigure(
        "closed_road_min", "closed road at level crossings, together", "min", lambda day: day.closed_road_min
    ),
    DayFigure(
        "least_warned_s",
        "shortest warning of a level crossing before a train",
        "s",
        lambda day: day.least_warned_s,
        more_is_better=True,
    ),
)
FIGURES: Final[Mapping[str, DayFigure]] = {figure.name: figure for figure in _ALL}


def figure_of(name: str, file: str, key: str) -> DayFigure:
    """The figure of that name; InputError otherwise."""
    if name not in FIGURES:
        raise InputError(file, key, name, one_of(FIGURES, name))
    return FIGURES[name]
