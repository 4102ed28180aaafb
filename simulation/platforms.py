"""People and doors at stops: on a late day passengers need longer, and doors do not close at once (客扱い, 戸閉).

The world keeps the doors open, and the unit sees by its input that they are; it knows neither why nor until when, and
does not leave. Nothing is shown of what the plan's stop takes up by itself. Doors that a fault holds open stay open.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from simulation.agenda import AgendaKind
from simulation.cabs import Cabs
from simulation.events import WORLD, DoorsHeld
from simulation.late_day import DrawnStay, LateDay
from simulation.setup import STEPS_PER_S, step_not_before
from simulation.world.stage import World

BEFORE_S: Final = 2.0  # doors are seen to be open from so long before the train could leave
LOOKS_AGAIN_S: Final = 5.0  # while the unit does not know that it is at its mark
LET_OFF_STEPS: Final = 3 * STEPS_PER_S  # from power on until wheels turn, at most
OPEN: Final = "open"
CLOSE: Final = "close"


@dataclass(frozen=True, slots=True)
class DoorsAtStop:
    """Doors at one stop. `ready_s`: when it could leave without; `boarded_s`: when all are on; `until_s`: shut."""

    number: str
    at: int
    station_id: str
    ready_s: float
    boarded_s: float
    until_s: float


def held_until(
    stay: DrawnStay, stood_s: float, departure_s: float, dwell_s: float, *, begins: bool
) -> tuple[float, float, float]:
    """When a train could leave by dwell and plan alone, when its passengers are on, and when its doors are shut, s.

    It came to a stand at `stood_s`; one that begins there has had its passengers on before.
    """
    ready_s = max(departure_s, stood_s if begins else stood_s + dwell_s)
    boarded_s = ready_s if begins else max(ready_s, stood_s + dwell_s + stay.people_s)
    return ready_s, boarded_s, boarded_s + stay.doors_s


class Platforms:
    """The doors of all trains: what people do with them, and what faults do."""

    def __init__(self, world: World, cabs: Cabs, day: LateDay) -> None:
        self._dwell_s = world.setup.unit.dwell_min_s
        self._stays = day.stays
        self._trains, self._on_board, self._cabs = world.trains, world.on_board, cabs
        self._books, self._agenda, self._journal = world.books, world.agenda, world.journal
        self._held: dict[int, DoorsAtStop] = {}  # by slot: what is to be, or is
        self._open_until_s: dict[int, float] = {}  # by slot: doors that people hold open
        self._faulty: set[int] = set()  # slots whose doors a fault holds open
        self._open_from: dict[int, int] = {}  # by slot: since which step its doors are not closed
        if self._stays:
            world.books.stands.add(self._stands)

    def fault(self, slot: int, step: int, *, closed: bool) -> None:
        """A fault has the doors show that they are open, or is over."""
        (self._faulty.discard if closed else self._faulty.add)(slot)
        self._show(slot, step)

    def are_open(self, slot: int, step: int) -> bool:
        """Whether a train that begins to move now does it with open doors, which were not closed as it was let off."""
        return step - self._open_from.get(slot, step) > LET_OFF_STEPS

    def due(self, step: int, subject: str) -> None:
        """Doors are to be held open, or to close."""
        what, stock_id = subject.split(" ", 1)
        slot = self._trains.slot_of[stock_id]
        if what == CLOSE:
            if self._open_until_s.get(slot, math.inf) * STEPS_PER_S <= step + 0.5:
                del self._open_until_s[slot]
                self._show(slot, step)
        elif (held := self._held.get(slot)) is not None:
            self._hold(slot, held, step)

    def _stands(self, slot: int, at: int, now_s: float) -> None:
        """A train has come to a stand at a stop, or begins there."""
        self._held.pop(slot, None)
        duty = self._trains.duties[slot]
        if duty is None:
            return
        target = duty.mission.targets[at]
        stay = self._stays.get((duty.train.number, target.station_id or ""))
        if stay is None or target.departure_s is None or not target.passengers:
            return
        ready_s, boarded_s, until_s = held_until(
            stay, now_s, target.departure_s, self._dwell_s, begins=at == 0
        )
        if until_s <= ready_s:
            return
        self._held[slot] = DoorsAtStop(
            duty.train.number, at, target.station_id or "", ready_s, boarded_s, until_s
        )
        self._put(max(now_s + 1.0, ready_s - BEFORE_S), OPEN, slot)

    def _hold(self, slot: int, held: DoorsAtStop, step: int) -> None:
        """Hold the doors open, if the train still stands there and its unit knows that it does."""
        now_s, stock_id, duty = step / STEPS_PER_S, self._trains.stock_ids[slot], self._trains.duties[slot]
        there = duty is not None and duty.train.number == held.number
        if not there or now_s >= held.until_s or self._books.stands_at(slot) != held.at:
            return
        shown = self._on_board.shown_to_driver(slot)
        if not (self._cabs.answers(slot) and shown.at_mark and shown.at == held.at):
            self._put(now_s + LOOKS_AGAIN_S, OPEN, slot)
            return
        told = DoorsHeld(
            unit_id=stock_id,
            train=held.number,
            station=held.station_id,
            until_s=round(held.until_s, 1),
            people_s=round(held.boarded_s - held.ready_s, 1),
            doors_s=round(held.until_s - held.boarded_s, 1),
        )
        self._journal.write(now_s, WORLD, told)
        self._open_until_s[slot] = held.until_s
        self._show(slot, step)
        self._put(held.until_s, CLOSE, slot)

    def _put(self, at_s: float, what: str, slot: int) -> None:
        self._agenda.put(step_not_before(at_s), AgendaKind.PEOPLE, f"{what} {self._trains.stock_ids[slot]}")

    def _show(self, slot: int, step: int) -> None:
        closed = slot not in self._open_until_s and slot not in self._faulty
        if closed:
            self._open_from.pop(slot, None)
        else:
            self._open_from.setdefault(slot, step)
        self._cabs.vehicle_shows(slot, step, "doors_closed", closed)
