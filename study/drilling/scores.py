"""How well a drill went, beyond passed or not: lateness, and the time back to normal after the last heal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import polars as pl

from simulation.faults.script import ItemCourse, ScriptedFault
from study.wording.outcome import FAULT_LASTS, NOTHING_DISTURBED, SOME_MISSING
from study.wording.phrase import NOTHING, Phrase

ON_TIME_S: Final = 60.0  # a departure no later than this after plan is on time


@dataclass(frozen=True, slots=True)
class Scores:
    """Figures of one drill.

    `late_s_max` None: no train arrived. `normal_after_s` None: it was never normal again, or nothing was disturbed;
    `why` says.
    """

    late_s_max: float | None
    healed_s: float | None
    normal_after_s: float | None
    why: Phrase = NOTHING
    on_time_s: float = ON_TIME_S

    def as_dict(self) -> dict[str, Any]:
        """For summary.json."""
        return {
            "late_s_max": self.late_s_max,
            "last_heal_s": self.healed_s,
            "normal_after_s": self.normal_after_s,
            "on_time_tolerance_s": self.on_time_s,
            "why": self.why.en,
        }


def healed_at_s(courses: tuple[ItemCourse, ...]) -> float | None:
    """When the last fault was over or the last act was done; None if a fault lasts, or nothing began."""
    ends = [course.over_s if isinstance(course.item, ScriptedFault) else course.begun_s for course in courses]
    known = [end for end in ends if end is not None]
    return max(known) if known and len(known) == len(ends) else None


def score(
    courses: tuple[ItemCourse, ...], stops: pl.DataFrame, late_s_max: float | None, *, all_arrived: bool
) -> Scores:
    """Scores from what happened and the table of stops.

    Back to normal is when the last departure left that was later than `ON_TIME_S` and left after the last heal;
    0 s if there was none. One that was cancelled counts as leaving as late as the scenario states.
    """
    if not courses:
        return Scores(late_s_max, None, None, NOTHING_DISTURBED)
    healed_s = healed_at_s(courses)
    if healed_s is None:
        return Scores(late_s_max, None, None, FAULT_LASTS)
    if not all_arrived:
        return Scores(late_s_max, healed_s, None, SOME_MISSING)
    left_s = pl.col("planned_departure_s") + pl.col("late_departure_s")
    late = (
        stops.filter(left_s > healed_s, pl.col("late_departure_s") > ON_TIME_S)
        .select(left_s)
        .to_series()
        .to_list()
    )
    return Scores(late_s_max, healed_s, round(max(late, default=healed_s) - healed_s, 1))
