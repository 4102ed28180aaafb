"""Where a line has no tag that proves what lies behind a train that has arrived: the release there is weaker.

Sections are given back at the arrival tag (①; (5) in figure 1 of Sugiyama et al. 2017), which an odometer cannot
falsify; where there is none a train's length beyond the joints behind a stop, a person's eye stands in for it.
"""

from __future__ import annotations

from typing import Final

from onboard.plan import plan_of
from simulation.setup import Setup
from simulation.world.roster import drawn_up

CONFIRMED_BY_EYE: Final = (
    "no tag proves the sections behind clear; they are released when the driver confirms the arrival"
)


def confirmed_by_eye(setup: Setup) -> dict[str, list[str]]:
    """Stops of the timetable where that is so, each with the numbers of its trains, in the order of the timetable."""
    found: dict[str, list[str]] = {}
    for stock_id, drawn in drawn_up(setup, setup.believed_line).items():
        length_m = float(setup.trains[stock_id].row[0]["length_m"])
        for duty in drawn:
            plan = plan_of(duty.mission, length_m)
            for stop in plan.stops:
                if stop.by_eye:
                    section_id = plan.spans[stop.span].section_id
                    found.setdefault(f"{stop.place}, section {section_id}", []).append(duty.train.number)
    return found
