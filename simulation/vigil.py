"""Looks at trains and roads now and then, so that one that waits for nothing is found; it moves nothing."""

from __future__ import annotations

from typing import Final

from simulation.agenda import AgendaKind
from simulation.cabs import Cabs
from simulation.duties import Duties
from simulation.judge.checkers import Checkers
from simulation.judge.liveness import LOOKS_EVERY_S, TrainAndDisplay
from simulation.roads_closed import RoadsClosedForNothing
from simulation.setup import STEPS_PER_S
from simulation.world.stage import World

LOOKS_EVERY_STEPS: Final = round(LOOKS_EVERY_S * STEPS_PER_S)


class Vigil:
    """What the liveness checker is shown: the truth of each train and what its unit shows, roads closed for nothing."""

    def __init__(self, world: World, cabs: Cabs, duties: Duties, checkers: Checkers, step: int) -> None:
        self._trains = world.trains
        self._cabs = cabs
        self._duties = duties
        self._agenda = world.agenda
        self.roads: Final = RoadsClosedForNothing(world.trains, world.on_board, world.wayside.crossings)
        self._checkers = checkers
        self._next_step = step

    def look(self, step: int) -> None:
        """Look at all of them, if it is time. Stretches are not cut for it, so it may be late by one of them."""
        if step < self._next_step:
            return
        self._next_step = step + LOOKS_EVERY_STEPS
        of_crews = {subject.partition(" ")[2] for subject in self._agenda.subjects(AgendaKind.CREW)}
        awaited = self._agenda.subjects(AgendaKind.DUTY) | of_crews
        slots = range(len(self._trains.stock_ids))
        self._checkers.alive(
            step / STEPS_PER_S, [self._seen(slot, awaited) for slot in slots], self.roads.for_nothing()
        )

    def _seen(self, slot: int, awaited: frozenset[str]) -> TrainAndDisplay:
        trains, cabs = self._trains, self._cabs
        stock_id = trains.stock_ids[slot]
        return TrainAndDisplay(
            stock_id,
            self._duties.place(slot),
            self._duties.has_duty(slot) and cabs.answers(slot),
            float(trains.plants[slot].travelled_m),
            timer=cabs.wakes(slot),
            pulls=bool(trains.units[slot].notch > 0.0),
            awaits=stock_id in awaited or cabs.crew_watches(slot) or trains.premises.runs_on(slot),
            waits_for=cabs.waits_for(slot),
        )
