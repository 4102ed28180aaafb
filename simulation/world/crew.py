"""The crew of a train whose unit does not know where it is: drives on sight, stops before points, looks at them.

Handling outside the system (システム外の取扱い, Sugiyama 4.4 (3)): the train is stopped before points that are not
proven to it, the crew looks how they lie, and goes on only if they lie and are locked as the path needs them; if
not, it has the unit command them, which only the holder of their section can.
The crew sees the real track, so this is part of the world; what it does is in the journal.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from network.model import SectionKind
from onboard.authority.machine import PointsNeeded
from onboard.authority.stop_limit import points_of
from onboard.duty.mission import Mission, SectionSpan
from onboard.notes import CrewCheckedPoints, CrewWaitsAtPoints
from onboard.unit import Phase, Unit
from simulation.journal import Journal
from simulation.world.point_machine import PointMachine
from simulation.world.trains import Trains

LOOKS_AGAIN_S: Final = 20.0
OVERRUN_MAX_M: Final = (
    40.0  # no train sets back: this far beyond the mark on its track it has arrived all the same
)
SEES_M: Final = 12.0  # stood this near, the crew sees how the points lie


@dataclass(frozen=True, slots=True)
class Seen:
    """What the crew of a standing train found: points it may pass, points to be thrown, a target reached."""

    passable: PointsNeeded | None = None
    to_throw: PointsNeeded | None = None
    target: int | None = None


class Crew:
    """What the crews of all trains see and do."""

    def __init__(self, trains: Trains, machine_of: Callable[[str], PointMachine], journal: Journal) -> None:
        self._trains = trains
        self._machine_of = machine_of
        self._journal = journal

    def on_sight(self, slot: int) -> bool:
        """Whether the train is driven on sight now."""
        unit = self._trains.on_board[slot]
        return unit.phase is Phase.RESTARTED and not self._trains.units[slot].position_known

    def look_ahead(self, slot: int) -> None:
        """Set where the driver will stop: before points not proven, at the mark, at the end of what is held."""
        truth = self._trains.truths[slot]
        unit = self._trains.on_board[slot]
        mission = unit.mission
        if not self.on_sight(slot) or mission is None:
            truth.sight_m = math.inf
            return
        front_m = float(truth.position_m)
        stops = [span.start_m for span, _ in self._unproven(mission, unit, front_m)]
        stops += [t.mark_m + 2.0 for t in mission.targets[unit.at + 1 :] if t.mark_m > front_m + 1.0]
        stops.append(self._held_end_m(mission, unit, front_m))
        truth.sight_m = min(stops)

    def stand(self, slot: int, now_s: float) -> Seen:
        """A train on sight stands: what the crew finds. It looks again every `LOOKS_AGAIN_S`."""
        unit = self._trains.on_board[slot]
        mission = unit.mission
        if not self.on_sight(slot) or mission is None:
            return Seen()
        front_m = float(self._trains.truths[slot].position_m)
        for index, target in enumerate(mission.targets):
            end_m = mission.spans[mission.span_index(target.section_id)].end_m
            at_mark = target.mark_m - SEES_M / 2.0 < front_m < min(target.mark_m + OVERRUN_MAX_M, end_m)
            if index > unit.at and unit.stands_at != index and at_mark:
                return Seen(target=index)
        for span, needed in self._unproven(mission, unit, front_m):
            if span.start_m - front_m > SEES_M:
                break
            if not unit.authority.holds(span.section_id):  # it may yet learn that it does
                break
            machine = self._machine_of(needed.points_id)
            right = machine.locked and machine.position is needed.position
            seen = CrewCheckedPoints if right else CrewWaitsAtPoints
            note = seen(points_id=needed.points_id, lies=machine.position)
            self._journal.write(now_s, unit.facts.unit_id, note)
            if right:
                return Seen(passable=needed)
            return Seen(to_throw=needed if span.start_m > front_m else None)  # never under the train
        return Seen()

    def _unproven(
        self, mission: Mission, unit: Unit, front_m: float
    ) -> list[tuple[SectionSpan, PointsNeeded]]:
        return [
            (span, needed)
            for span in mission.spans
            if span.end_m > front_m
            for needed in points_of(span)
            if needed not in unit.authority.proven
        ]

    def _held_end_m(self, mission: Mission, unit: Unit, front_m: float) -> float:
        """End of what the unit holds from where it is; of the section it is in while it does not know."""
        here = mission.span_at(front_m)
        end_m = here.end_m
        begun = False
        for span in mission.spans:
            if span is here:
                begun = True
            elif begun:
                if not unit.authority.holds(span.section_id):
                    break
                end_m = span.end_m
        stop_short_m = 5.0 if here.kind is SectionKind.TRACK else 0.0
        return end_m - stop_short_m
