"""Level crossings in the simulated world: their equipment, and the fronts and rears that pass contacts and roads.

The equipment of each is `crossing_equipment`; a device that is dead or frozen lets it close, as relays fall.
`CrossingLookout` follows the true fronts and rears: a stretch ends with the step in which one passes a place that
matters.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from operator import is_
from typing import Final

from network.model import CrossingControl, LevelCrossing, Line
from network.path import Path
from simulation.agenda import Agenda, AgendaKind
from simulation.carriers.road import Road
from simulation.events import (
    WORLD,
    BarrierState,
    CrossingBarriers,
    CrossingEntered,
    CrossingLamps,
    RoadGuarded,
    RoadStopped,
)
from simulation.faults.crossings import CrossingCondition
from simulation.journal import Journal
from simulation.setup import STEPS_PER_S, step_not_before
from simulation.world import crossing_equipment
from simulation.world.crossing_equipment import (
    ConditionChanged,
    CrossingEquipment,
    EquipmentEvent,
    ObstacleDetected,
)
from simulation.world.trains import Trains
from wayside.crossing_said import CloseCrossing, CrossingContact
from wayside.said import Input

ShowsDevice = Callable[[int, str, Input], None]


class CrossingsOnTrack:
    """The equipment of all crossings that have a device, by id."""

    def __init__(
        self, line: Line, agenda: Agenda, journal: Journal, shows: ShowsDevice, road: Road | None = None
    ) -> None:
        self.on_line: Final = tuple(c for c in line.crossings.values() if c.has_device)
        self.equipment: Final[dict[str, CrossingEquipment]] = {
            crossing.id: crossing_equipment.equipment_of(crossing) for crossing in self.on_line
        }
        self.guarded: Final[set[str]] = set()  # those with somebody who stops the road by hand
        self._agenda, self._journal, self._shows, self._road = agenda, journal, shows, road

    def start(self, step: int) -> None:
        """Every device is shown its equipment."""
        for crossing_id in self.equipment:
            self.show(step, crossing_id)

    def show(self, step: int, crossing_id: str) -> None:
        """What its contacts show the device; nothing where there is no such crossing."""
        equipment = self.equipment.get(crossing_id)
        if equipment is not None:
            self._shows(step, crossing_id, crossing_equipment.detection(equipment))

    def relays_fall(self, step: int, crossing_id: str) -> None:
        """Its device is dead, or frozen, which a watchdog sees: it closes; nothing where there is no such crossing."""
        if crossing_id in self.equipment:
            self.take(step, crossing_id, CloseCrossing(crossing_id))

    def barriers_due(self, step: int, crossing_id: str) -> None:
        """Barriers may have reached their end."""
        self.take(step, crossing_id, crossing_equipment.BarrierTimeOver())

    def is_closed(self, crossing_id: str) -> bool:
        """Whether the road is truly closed: lamps lit, and barriers down where it has some."""
        equipment = self.equipment[crossing_id]
        return equipment.lit and equipment.barriers is BarrierState.LOWERED

    def put_condition(self, step: int, crossing_id: str, condition: CrossingCondition) -> None:
        """Something of it fails, or is mended."""
        self.take(step, crossing_id, ConditionChanged(condition))

    def obstacle(self, crossing_id: str, at_step: int, *, present: bool) -> None:
        """Its detector sees something on the closed road, or no longer does; nothing where it has no device here."""
        if crossing_id in self.equipment:
            self.take(at_step, crossing_id, ObstacleDetected(present))

    def is_blocked(self, crossing_id: str) -> bool:
        """Whether a vehicle stands on the road, as who is there sees; never where no road is carried."""
        return self._road is not None and self._road.blocked(crossing_id)

    def creeps_over(self, crossing_id: str, unit_id: str) -> None:
        """A train has leave to creep over it, and is seen by who drives on its road."""
        if self._road is not None:
            self._road.creeps_over(crossing_id, unit_id)

    def guard(self, step: int, crossing_id: str, *, there: bool) -> None:
        """Somebody guards it (踏切監視員), or goes."""
        if there is (crossing_id in self.guarded):
            return
        (self.guarded.add if there else self.guarded.discard)(crossing_id)
        self._journal.write(step / STEPS_PER_S, WORLD, RoadGuarded(crossing_id=crossing_id, there=there))

    def stop_road(self, step: int, crossing_id: str, unit_id: str) -> None:
        """Who guards it holds a red flag to its road, until the train that stands before it is over it."""
        stopped = RoadStopped(crossing_id=crossing_id, unit_id=unit_id)
        self._journal.write(step / STEPS_PER_S, WORLD, stopped)
        self.creeps_over(crossing_id, unit_id)

    def take(self, step: int, crossing_id: str, event: EquipmentEvent) -> None:
        """What happens to it: written down, shown to its device, and remembered when barriers are due."""
        before, now_s = self.equipment[crossing_id], step / STEPS_PER_S
        after = self.equipment[crossing_id] = crossing_equipment.step(before, event, now_s)
        if after.lit is not before.lit:
            self._journal.write(now_s, WORLD, CrossingLamps(crossing_id=crossing_id, lit=after.lit))
        if after.barriers is not before.barriers and after.has_barriers:
            barriers = CrossingBarriers(crossing_id=crossing_id, state=after.barriers)
            self._journal.write(now_s, WORLD, barriers)
        if self._road is not None:
            self._road.show(crossing_id, crossing_equipment.shown(after))
        if after.due_s is not None and after.due_s != before.due_s:
            self._agenda.put(step_not_before(after.due_s), AgendaKind.POINTS, crossing_id)
        if crossing_equipment.detection(after) != crossing_equipment.detection(before):
            self.show(step, crossing_id)


class PlaceKind(Enum):
    """What a train passes at a crossing, and with what."""

    ROAD = "the front comes onto the road"
    FIRST_CONTACT = "the front passes the first contact"
    LAST_CONTACT = "the rear passes the last contact"


@dataclass(frozen=True, slots=True)
class CrossingPlaceAhead:
    """A place that matters: passed when the front is `at_m` along the path."""

    at_m: float
    kind: PlaceKind
    crossing_id: str


class CrossingLookout:
    """Follows all trains past roads and contacts."""

    def __init__(self, line: Line, trains: Trains, journal: Journal, shows: ShowsDevice) -> None:
        self._crossings: Final = [c for c in line.crossings.values() if c.has_device]
        self._line, self._trains, self._journal, self._shows = line, trains, journal, shows
        self._paths: dict[int, Path] = {}
        self._ahead: dict[int, list[CrossingPlaceAhead]] = {}
        self._front_m: dict[int, float] = {}
        self._active, self._taken = list[int](), list[Path | None]()  # who is on the line, and on which path

    def follow(self) -> list[int]:
        """Take up the paths that trains are on by now, and let the kernel know of what comes next on each; who is
        looked at.
        """
        active = self._trains.active() if self._crossings else []
        paths = self._trains.paths
        if active == self._active and all(map(is_, paths, self._taken)):
            return active
        self._active, self._taken = active, [*paths]
        for slot in active:
            if self._paths.get(slot) is not self._trains.paths[slot]:
                self._follow(slot)
        if len(self._paths) > len(active):
            for slot in self._paths.keys() - set(active):
                del self._paths[slot], self._ahead[slot]
        return active

    def look(self, step: int) -> None:
        """Who has passed what by now."""
        for slot in self.follow():
            truth = self._trains.truths[slot]
            front_m = self._front_m[slot] = float(truth.position_m)
            if front_m >= truth.crossing_m:
                ahead = self._ahead[slot]
                while ahead and ahead[0].at_m <= front_m:
                    self._passed(slot, step, ahead.pop(0))
                self._expect(slot)

    def _expect(self, slot: int) -> None:
        """The stretch ends where the train comes to the next place."""
        ahead = self._ahead[slot]
        self._trains.truths[slot].crossing_m = ahead[0].at_m if ahead else math.inf

    def _follow(self, slot: int) -> None:
        """Take up another path that the train is on; who stands on a road has come onto it before."""
        path, before = self._trains.true_path(slot), self._paths.get(slot)
        front_m = float(self._trains.truths[slot].position_m)
        places = [place for c in self._crossings for place in self._places_of(c, slot, path)]
        ahead = [place for place in places if place.at_m > front_m]
        if before is not None and before.direction is path.direction:
            on_path = {crossing.id for crossing in self._crossings if crossing.piece_id in path}
            moved_m = front_m - self._front_m[slot]
            ahead += [
                CrossingPlaceAhead(place.at_m + moved_m, place.kind, place.crossing_id)
                for place in self._ahead[slot]
                if place.kind is PlaceKind.LAST_CONTACT and place.crossing_id not in on_path
            ]
        self._paths[slot], self._front_m[slot] = path, front_m
        self._ahead[slot] = sorted(ahead, key=lambda place: place.at_m)
        self._expect(slot)

    def _places_of(self, crossing: LevelCrossing, slot: int, path: Path) -> list[CrossingPlaceAhead]:
        if crossing.piece_id not in path:
            return []
        road_m = path.to_road_m(crossing)
        found = [CrossingPlaceAhead(road_m, PlaceKind.ROAD, crossing.id)]
        if crossing.control is CrossingControl.CONTACTS:
            before_m, beyond_m = crossing.contacts_from_road_m(path.direction)
            last_m = road_m + crossing.width_m + beyond_m + float(self._trains.bodies[slot].length_m)
            found.append(CrossingPlaceAhead(road_m - before_m, PlaceKind.FIRST_CONTACT, crossing.id))
            found.append(CrossingPlaceAhead(last_m, PlaceKind.LAST_CONTACT, crossing.id))
        return found

    def _passed(self, slot: int, step: int, place: CrossingPlaceAhead) -> None:
        if place.kind is not PlaceKind.ROAD:
            first = place.kind is PlaceKind.FIRST_CONTACT
            self._shows(step, place.crossing_id, CrossingContact(first))
            return
        entered = CrossingEntered(
            unit_id=self._trains.stock_ids[slot],
            crossing_id=place.crossing_id,
            speed_mps=round(float(self._trains.plants[slot].speed_mps), 2),
        )
        self._journal.write(step / STEPS_PER_S, WORLD, entered)
