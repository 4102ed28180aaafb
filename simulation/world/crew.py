"""The crew of a train whose unit does not know where it is: drives on sight, stops before points, looks at them.

Handling outside the system (システム外の取扱い, Sugiyama 4.4 (3)): the train is stopped before points that are not
proven to it, the crew looks how they lie, and goes on only if they lie and are locked as the path needs them; if
not, it has the unit command them, which only the holder of their section can. What it has seen must stay so until its
train has passed, with or without radio: the crew locks the machine on the spot (鎖錠), which cuts out its motor, and
has its key until the rear has left the points, or until the train goes another way; else staff set the points free.
The crew sees the real track, so this is part of the world; what it does is in the journal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from network.model import SectionKind
from onboard.crossing_notes import CrossingCreep
from onboard.duty.arrival import beyond_gap
from onboard.duty.records import (
    AtMark,
    CreepOver,
    DrivingCommand,
    EndOfHeld,
    NotAtMark,
    Person,
    PointsSeen,
    PointsWrong,
)
from onboard.mission import Mission
from onboard.notes import CrewCheckedPoints, CrewWaitsAtPoints
from onboard.plan import ARRIVED_ON_SIGHT_WITHIN_M, DutyPlan, PointsNeeded
from simulation.journal import Journal
from simulation.setup import STEPS_PER_S
from simulation.tolerance import CALLS_BEYOND_M, CALLS_SHORT_M
from simulation.world.on_board import OnBoard
from simulation.world.points import WaysideWorld
from simulation.world.trains import Trains

LOOKS_AGAIN_S: Final = 20.0
CROSSING_STOPS_SHORT_M: Final = 5.0  # of a road that is not closed
SEES_M: Final = 12.0  # stood this near, the crew sees how the points lie
STOPS_SHORT_M: Final = 5.0  # of the end of a track
SEES_TRAIN_M: Final = (
    200.0  # assumed: a train on straight track by day; on sight one stops from 15 km/h in 20 m
)
STOPS_SHORT_OF_TRAIN_M: Final = 20.0
WATCHES_M: Final = 600.0  # nearer than this, drivers look out in every short stretch
SAYS_TO_M: Final = 10.0  # half a coach
SEES_MARK_BEYOND_M: Final = 2.0  # a driver on sight stops with the mark under the cab


@dataclass(frozen=True, slots=True)
class KeyPassage:
    """For what a crew has the key of points: a train of a slot that is to pass a section on its mission."""

    slot: int
    mission: Mission
    section_id: str


class Crew:
    """What the crews of all trains see, by what their units show them and by their eyes, and what they do."""

    def __init__(self, trains: Trains, on_board: OnBoard, wayside: WaysideWorld, journal: Journal) -> None:
        self._trains = trains
        self._on_board = on_board
        self._wayside = wayside
        self._journal = journal
        self.on_sight: set[int] = set()  # slots of trains that run on sight, or sweep
        self._passages: dict[str, KeyPassage] = {}  # by points
        self._creeps: dict[int, str] = {}  # by slot: the level crossing that a train on sight may creep over
        self.by_hand: set[int] = set()  # slots of trains whose unit is cut out, by substitute working

    def look_ahead(self, slot: int) -> None:
        """Set where the driver will stop: before points not proven, at the mark, at the end of what is held."""
        truth, plan, duty = self._trains.truths[slot], self._on_board.plan(slot), self._trains.duties[slot]
        truth.sight_m = self._obstacle_m(slot)
        if slot in self.by_hand:
            truth.sight_m = min(truth.sight_m, self._open_crossing(slot)[1])
        elif not self._on_board.drives_on_sight(slot):
            self._creeps.pop(slot, None)  # leave that he did not use: his unit asks the crossing now
        if not self._on_board.drives_on_sight(slot) or plan is None or duty is None:
            return
        front_m, shown = float(truth.position_m), self._on_board.shown_to_driver(slot)
        spans = duty.mission.spans
        stops = [spans[index].start_m for index, _ in self._unproven(slot, plan, shown)]
        marks_m = [target.mark_m for target in duty.mission.targets[shown.at + 1 :]]
        stops += [m + SEES_MARK_BEYOND_M for m in marks_m if m > front_m - SEES_MARK_BEYOND_M]
        stands = self._trains.plants[slot].speed_mps == 0.0
        if stands and self._mark_reached(duty.mission, shown, front_m) is not None:
            stops.append(front_m)  # until the driver has said that it stands there
        stops.append(self._held_end_m(slot, shown))
        stops.append(self._open_crossing(slot)[1])
        truth.sight_m = min(truth.sight_m, *stops)

    def sees_train(self, slot: int) -> bool:
        """Whether the driver sees a train on what the unit has for its own."""
        return math.isfinite(self._obstacle_m(slot))

    def _obstacle_m(self, slot: int) -> float:
        """Where to stop before a train that the driver sees on what the unit has for its own; infinite without one.

        No train can be there unless somebody was wrong, so nobody looks out while no train runs on sight.
        """
        duty = self._trains.duties[slot]
        if duty is None or not self.on_sight or not self._trains.truths[slot].active:
            return math.inf
        ahead_m, shown = self._trains.train_ahead_m(slot), self._on_board.shown_to_driver(slot)
        if ahead_m - float(self._trains.truths[slot].position_m) > SEES_TRAIN_M:
            return math.inf
        held = shown.on_sight or duty.mission.span_at(ahead_m).section_id in shown.held
        return ahead_m - STOPS_SHORT_OF_TRAIN_M if held else math.inf

    def watch_out(self, slot: int) -> bool:
        """Set again where the driver will stop, as other trains move; whether one is so near that it matters."""
        self.look_ahead(slot)
        front_m = float(self._trains.truths[slot].position_m)
        return self._trains.train_ahead_m(slot) - front_m < WATCHES_M

    def has_to_look(self, slot: int) -> bool:
        """Whether a train stands, and its crew has to look where or before what."""
        shown, on_sight = self._on_board.shown_to_driver(slot), self._on_board.drives_on_sight(slot)
        stands = self._trains.plants[slot].speed_mps == 0.0
        return stands and (on_sight or shown.confirm or self._at_end(slot))

    def _at_end(self, slot: int) -> bool:
        """Whether the track ends before a train that has a stop to run to."""
        truth = self._trains.truths[slot]
        ends = bool(truth.track_end_m - truth.position_m < STOPS_SHORT_M)
        return self._on_board.shown_to_driver(slot).target is not None and ends

    def _open_crossing(self, slot: int) -> tuple[str, float]:
        """The first level crossing ahead at which a driver without his unit stops, and where, m: one that it would have
        asked, or, on sight, whose road he sees is not closed. What contacts close he passes by hand as with his unit.
        """
        found = ("", math.inf)
        for crossing in self._wayside.crossings.on_line:
            path, truth = self._trains.true_path(slot), self._trains.truths[slot]
            if crossing.piece_id not in path:
                continue
            road_m = path.to_road_m(crossing)
            ahead = truth.position_m < road_m < found[1] + CROSSING_STOPS_SHORT_M
            leave = self._creeps.get(slot) == crossing.id
            if leave and truth.position_m > road_m:
                del self._creeps[slot]  # it was for this time
            looks = slot not in self.by_hand
            stops = crossing.by_radio or (looks and not self._wayside.crossings.is_closed(crossing.id))
            if ahead and stops and not leave:
                found = (crossing.id, road_m - CROSSING_STOPS_SHORT_M)
        return found

    def waits_at_crossing(self, slot: int) -> str:
        """The level crossing that keeps a train standing, by its unit or by its driver's eye; empty: none."""
        shown, plant = self._on_board.shown_to_driver(slot), self._trains.plants[slot]
        if plant.speed_mps > 0.0 or not self._trains.truths[slot].active:
            return ""
        if slot not in self.by_hand and not self._on_board.drives_on_sight(slot):
            return shown.crossings.at
        crossing_id, stops_m = self._open_crossing(slot)
        return crossing_id if stops_m - float(self._trains.truths[slot].position_m) < SEES_M else ""

    def creep(self, slot: int, now_s: float, *, guarded: bool = False) -> list[CreepOver]:
        """The driver has leave to creep over the crossing at which the train waits: his unit, if it drives, is told.
        He has none while he sees that something stands on it. `guarded`: by the word of who has stopped the road.
        """
        crossing_id = self.waits_at_crossing(slot)
        if not crossing_id or self._wayside.crossings.is_blocked(crossing_id):
            return []
        self._wayside.crossings.creeps_over(crossing_id, self._trains.stock_ids[slot])
        if slot not in self.by_hand and not self._on_board.drives_on_sight(slot):
            return [CreepOver(crossing_id, guarded)]
        self._creeps[slot] = crossing_id
        leave = CrossingCreep(crossing_id=crossing_id, guarded=guarded)
        self._journal.write(now_s, self._trains.stock_ids[slot], leave)
        self.look_ahead(slot)
        return []

    def creeps_by_hand(self, slot: int) -> bool:
        """Whether a train whose unit is cut out has leave to creep over a crossing onto which it has yet to come."""
        path, crossing_id = self._trains.true_path(slot), self._creeps.get(slot, "")
        crossing = self._trains.setup.line.crossings.get(crossing_id)
        if crossing is None or crossing.piece_id not in path:
            return False
        return bool(self._trains.truths[slot].position_m <= path.to_road_m(crossing))

    def stand(self, slot: int, now_s: float) -> list[Person]:
        """A train on sight stands: what the crew finds, and enters. It looks again every `LOOKS_AGAIN_S`."""
        plan, duty = self._on_board.plan(slot), self._trains.duties[slot]
        shown, on_sight = self._on_board.shown_to_driver(slot), self._on_board.drives_on_sight(slot)
        front_m = float(self._trains.truths[slot].position_m)
        if not self.has_to_look(slot) or plan is None or duty is None:
            return []
        if self._at_end(slot) and not on_sight and shown.target is not None:
            # the unit would go on to a mark that it has passed
            return [self._at_mark(slot, shown.target)]
        if not on_sight:
            there = front_m >= duty.mission.targets[shown.at].mark_m - ARRIVED_ON_SIGHT_WITHIN_M
            return [self._at_mark(slot, shown.at) if there else NotAtMark()]
        reached = self._mark_reached(duty.mission, shown, front_m)
        if reached is not None:
            return [self._at_mark(slot, reached)]
        looked = self._look_at_points(slot, plan, duty.mission, now_s)
        return looked or self._at_end_of_held(slot, duty.mission, shown)

    def _at_mark(self, slot: int, stop: int) -> AtMark:
        return AtMark(stop, self.beyond_m(slot, stop))

    def beyond_m(self, slot: int, stop: int) -> float:
        """How far beyond a mark the front stands by the driver's eye, to the nearest `SAYS_TO_M`."""
        duty = self._trains.duties[slot]
        if duty is None:
            return 0.0
        away_m = float(self._trains.truths[slot].position_m) - duty.mission.targets[stop].mark_m
        return SAYS_TO_M * round(away_m / SAYS_TO_M)

    def _at_end_of_held(self, slot: int, mission: Mission, shown: DrivingCommand) -> list[Person]:
        """The span where it stands, if it cannot go on because the unit does not hold what is ahead, near by or with
        more of its way beyond that.
        """
        front_m = float(self._trains.truths[slot].position_m)
        sections = [span.section_id for span in mission.spans]
        index = mission.spans.index(mission.span_at(front_m))
        lacks = shown.on_line and index + 1 < len(sections) and sections[index + 1] not in shown.held
        ends = self._held_end_m(slot, shown) - front_m < SEES_M or beyond_gap(sections, shown.held, index)
        return [EndOfHeld(index)] if ends and lacks else []

    @staticmethod
    def _mark_reached(mission: Mission, shown: DrivingCommand, front_m: float) -> int | None:
        """The next stop at whose mark the front stands."""
        for index, target in enumerate(mission.targets):
            span = mission.spans[mission.span_index(target.section_id)]
            on_track = span.kind is not SectionKind.BETWEEN  # a halt's section reaches to the next station
            beyond_m = span.end_m if on_track else min(target.mark_m + CALLS_BEYOND_M, span.end_m)
            at_mark = target.mark_m - CALLS_SHORT_M < front_m < beyond_m
            if index > shown.at and shown.stands_at != index and at_mark:
                return index
        return None

    def _look_at_points(self, slot: int, plan: DutyPlan, mission: Mission, now_s: float) -> list[Person]:
        """Standing before points that are not proven to its unit, the crew sees how they lie."""
        front_m = float(self._trains.truths[slot].position_m)
        found = self._at_points(slot, plan, self._on_board.shown_to_driver(slot))
        if found is None:
            return []
        start_m, needed = found
        right = self._locks(slot, mission, needed, now_s)
        machine = self._wayside.machines[needed.points_id]
        seen = CrewCheckedPoints if right else CrewWaitsAtPoints
        note = seen(points_id=needed.points_id, lies=machine.position)
        self._journal.write(now_s, self._trains.stock_ids[slot], note)
        if right:
            return [PointsSeen(needed, under=start_m <= front_m)]
        return [PointsWrong(needed)] if start_m > front_m else []  # never under the train

    def watches(self, slot: int) -> bool:
        """Whether a crew that stands on sight looks at points that may yet come to lie as its way needs them."""
        plan = self._on_board.plan(slot)
        if plan is None or not self._on_board.drives_on_sight(slot):
            return False
        found = self._at_points(slot, plan, self._on_board.shown_to_driver(slot))
        if found is None:
            return False
        machine = self._wayside.machines[found[1].points_id]
        return not (machine.locked and machine.position is found[1].position)

    def _at_points(
        self, slot: int, plan: DutyPlan, shown: DrivingCommand
    ) -> tuple[float, PointsNeeded] | None:
        """The first points not proven, where they begin (m), if they are near enough to be seen and held."""
        duty = self._trains.duties[slot]
        following = self._unproven(slot, plan, shown)
        if duty is None or not following:
            return None
        index, needed = following[0]
        start_m = duty.mission.spans[index].start_m
        # Not held: it may yet learn that it is.
        near = start_m - float(self._trains.truths[slot].position_m) <= SEES_M
        return (start_m, needed) if near and needed.section_id in shown.held else None

    def keys_over(self, slot: int) -> list[str]:
        """Points of which the crew has the key, and that the train has wholly passed, or will not pass any more."""
        return [p for p, passage in self._passages.items() if passage.slot == slot and self._over(passage)]

    def give_keys_back(self, slot: int, now_s: float) -> None:
        """Points of which the crew has no more use for the key are free again."""
        for points_id in self.keys_over(slot):
            del self._passages[points_id]
            step = round(now_s * STEPS_PER_S)
            self._wayside.give_key_back(step, points_id, self._trains.stock_ids[slot])

    def _locks(self, slot: int, mission: Mission, needed: PointsNeeded, now_s: float) -> bool:
        """Locks points that lie as needed; whether they now are so, locked by this crew."""
        stock_id, points_id = self._trains.stock_ids[slot], needed.points_id
        machine = self._wayside.machines[points_id]
        if not machine.locked or machine.position is not needed.position:
            return False
        self._wayside.lock_by_hand(round(now_s * STEPS_PER_S), points_id, stock_id)
        has_key = self._wayside.machines[points_id].key == stock_id
        if has_key:
            self._passages[points_id] = KeyPassage(slot, mission, needed.section_id)
        return has_key

    def _over(self, passage: KeyPassage) -> bool:
        """Whether the train has left the section; or is not in it, and on another mission or no longer its holder."""
        truth, duty = self._trains.truths[passage.slot], self._trains.duties[passage.slot]
        if not truth.active:
            return True
        same = duty is not None and duty.mission is passage.mission
        if not same or passage.section_id not in self._on_board.shown_to_driver(passage.slot).held:
            return not self._trains.stands_in(passage.section_id)
        rear_m = float(truth.position_m) - float(self._trains.bodies[passage.slot].length_m)
        mission = passage.mission
        return rear_m >= mission.spans[mission.span_index(passage.section_id)].end_m

    def _unproven(self, slot: int, plan: DutyPlan, shown: DrivingCommand) -> list[tuple[int, PointsNeeded]]:
        """Points from the front on that the unit does not show as proven, each with the index of its span."""
        duty, front_m = self._trains.duties[slot], float(self._trains.truths[slot].position_m)
        spans = () if duty is None else duty.mission.spans
        return [
            (index, needed)
            for index, span in enumerate(plan.spans)
            if spans[index].end_m > front_m
            for needed in span.points
            if needed not in shown.proven
        ]

    def _held_end_m(self, slot: int, shown: DrivingCommand) -> float:
        """End of what the unit holds from where it is; of the section it is in while it does not know."""
        duty = self._trains.duties[slot]
        if duty is None:
            return math.inf
        here = duty.mission.span_at(float(self._trains.truths[slot].position_m))
        end_m = here.end_m
        begun = False
        for span in duty.mission.spans:
            if span is here:
                begun = True
            elif begun:
                if shown.within_section or span.section_id not in shown.held:
                    break
                end_m = span.end_m
        return end_m - (STOPS_SHORT_M if here.kind is SectionKind.TRACK else 0.0)
