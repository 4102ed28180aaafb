"""Which units people bar, and unbar again, as they come to see that a unit claims what is not so.

They see a contradiction, or that a unit has been taken to hold what its train is not in and its display does not show;
two of them bar it when that has lasted for their patience, and unbar whoever is barred that long and claims falsely no
more. Who looks at this says besides where the train of a barred unit stands.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from typing import Final

from simulation.events import Commissioned, FaultBegan, FaultOver, JournalEntry
from simulation.faults.script import ActKind
from simulation.faults.speech import FalseClaims
from wayside.config import MANAGER_ID
from wayside.said import Accepted, Barred, Contradicted, Freed, Started, Unbarred


class MadUnits:
    """`held`: what a unit truly holds and stands in, by its slot."""

    def __init__(self, slot_of: Mapping[str, int], held: Callable[[int], tuple[str, ...]]) -> None:
        self._slot_of: Final = slot_of
        self._held: Final = held
        self._mad: Counter[str] = Counter()  # faults in force, also of those that have been mad
        self._wrong_s: dict[str, float] = {}  # since when the register has of it what is not so
        self._barred: dict[str, set[str]] = {}  # the devices that drop what it says
        self._sane_s: dict[str, float] = {}  # since when it is barred and claims what is so

    def see(self, entry: JournalEntry) -> None:
        """An entry of the journal was written."""
        match entry.event:
            case FaultBegan(kind=FalseClaims.kind, target=unit_id):
                self._mad[unit_id] += 1
            case FaultOver(kind=FalseClaims.kind, target=unit_id):
                self._mad[unit_id] -= 1
            case Contradicted(unit_id=unit_id) if unit_id in self._mad and not self.is_barred(unit_id):
                self._wrong_s.setdefault(unit_id, entry.t_s)
            case Accepted(unit_id=unit_id, section_ids=section_ids) if unit_id in self._mad:
                if set(section_ids) <= set(self._held(self._slot_of[unit_id])):
                    self._wrong_s.pop(unit_id, None)
                elif self._mad[unit_id] > 0:  # else it gives back what people have entered for it beyond that
                    self._wrong_s.setdefault(unit_id, entry.t_s)
            case Freed(unit_id=unit_id):
                self._wrong_s.pop(unit_id, None)
            case Started() if entry.who == MANAGER_ID:
                self._wrong_s.clear()
            case _:
                self._see_bars(entry)

    def _see_bars(self, entry: JournalEntry) -> None:
        match entry.event:
            case Barred(unit_id=unit_id):
                self._barred.setdefault(unit_id, set()).add(entry.who)
                if entry.who == MANAGER_ID:
                    self._wrong_s.pop(unit_id, None)
            case Unbarred(unit_id=unit_id):
                self._barred[unit_id].discard(entry.who)
            case Commissioned(device_id=device_id):  # what was barred there is forgotten
                for devices in self._barred.values():
                    devices.discard(device_id)
            case _:
                pass

    def is_barred(self, unit_id: str, device_id: str = MANAGER_ID) -> bool:
        """At a device; at the manager, what it has then of the unit comes of persons' words."""
        return device_id in self._barred.get(unit_id, ())

    def due(self, t_s: float, patience_s: float) -> Iterator[tuple[ActKind, str]]:
        """What two persons are to enter now, of which unit."""
        for unit_id, since_s in self._wrong_s.items():
            if t_s - since_s > patience_s:
                yield ActKind.BAR_UNIT, unit_id
        for unit_id, devices in self._barred.items():
            if self._mad[unit_id] > 0 or not devices:
                self._sane_s.pop(unit_id, None)
            elif t_s - self._sane_s.setdefault(unit_id, t_s) > patience_s:
                yield ActKind.UNBAR_UNIT, unit_id
