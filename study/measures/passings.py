"""Where and when trains run through stations (通過), as planned."""

from __future__ import annotations

from dataclasses import dataclass

from simulation.setup import Setup
from simulation.world.roster import drawn_up


@dataclass(frozen=True, slots=True)
class PlannedPassing:
    """A train runs through a station: its front at a kilometrage of a piece at `time_s`; `before` is its next stop."""

    stock_id: str
    number: str
    revenue: bool
    station_id: str
    track: str
    piece_id: str
    kilometrage_m: float
    time_s: float
    before: str


def planned_passings(setup: Setup) -> tuple[PlannedPassing, ...]:
    """Every passing of the timetable, by stock and in order of travel."""
    found: list[PlannedPassing] = []
    for duties in drawn_up(setup, setup.line).values():
        for duty in duties:
            mission = duty.mission
            for target in mission.targets:
                for passing in target.passings:
                    piece_id, kilometrage_m = mission.path.locate(passing.position_m)
                    found.append(
                        PlannedPassing(
                            duty.stock_id,
                            mission.number,
                            mission.revenue,
                            passing.station_id,
                            passing.track,
                            piece_id,
                            kilometrage_m,
                            passing.time_s,
                            target.place_id,
                        )
                    )
    return tuple(found)
