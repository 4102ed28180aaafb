"""`no-dead-state`: a train that waits for nothing is as bad as a broken rule.

A train that truly stands although its duty is not over must be about to do something: a timer of its unit runs, it
pulls, its crew watches something that can change, or the world will tell it something by itself (its next train). It
must also say what it waits for. What waits for a person or for a fault to heal is not dead as long as it says so and
asks again: whatever a unit has outstanding, it repeats by a timer. A road that stays closed for an hour although no
train comes to its level crossing is dead as well.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Final

from simulation.judge.log import Checker, Log

# Six looks of a crew on sight, and twice a change of ends: what nothing has a time for has happened within it.
STANDS_S: Final = 120.0
LOOKS_EVERY_S: Final = 30.0
ROAD_WAITS_S: Final = 3600.0  # people who see to it have done so by then, at their slowest
NOTHING: Final = ("", "nothing")  # what a unit shows that waits for nothing


@dataclass(frozen=True, slots=True)
class TrainAndDisplay:
    """One train as it truly is, and what its unit shows.

    `bound`: its duty is not over, and its unit has power and is not frozen. `run_m`: true distance since the run began.
    `timer`: one of the unit runs. `pulls`: it asks for power. `awaits`: a word that is sure to come, or what its crew
    watches.
    """

    unit_id: str
    place: str
    bound: bool
    run_m: float
    timer: bool
    pulls: bool
    awaits: bool
    waits_for: str

    @property
    def dead(self) -> str:
        """Why nothing will happen to it any more, if it stands; empty where something will."""
        if not self.bound or self.pulls or self.awaits:
            return ""
        if not self.timer:
            return "no timer runs and nothing comes by itself"
        return "it says so itself" if self.waits_for in NOTHING else ""


class LivenessWatch:
    """Remembers since when each train has stood so in one place, by looks `LOOKS_EVERY_S` apart."""

    def __init__(self, log: Log) -> None:
        self._log = log
        self._since: dict[str, tuple[float, float]] = {}  # unit: when, and what it had run then
        self._closed_s: dict[str, float] = {}  # by crossing: since when its road is closed for nothing

    def look(self, t_s: float, trains: Iterable[TrainAndDisplay]) -> None:
        """All trains at one moment."""
        for seen in trains:
            since_s, run_m = self._since.get(seen.unit_id, (t_s, seen.run_m))
            why = seen.dead
            if not why or run_m != seen.run_m:
                self._since.pop(seen.unit_id, None)
                continue
            self._since[seen.unit_id] = since_s, run_m
            if t_s - since_s >= STANDS_S:
                shown = seen.waits_for or "nothing"
                text = f"{seen.unit_id} stands in {seen.place} and waits for {shown}: {why}"
                self._log.note(t_s, Checker.NO_DEAD_STATE, f"{seen.unit_id} {since_s}", text)

    def look_at_roads(self, t_s: float, for_nothing: Collection[str]) -> None:
        """The level crossings that are closed at one moment although no train comes there."""
        self._closed_s = {crossing: self._closed_s.get(crossing, t_s) for crossing in for_nothing}
        for crossing_id, since_s in self._closed_s.items():
            if t_s - since_s >= ROAD_WAITS_S:
                text = f"the road at level crossing {crossing_id} stays closed, and no train comes"
                self._log.note(t_s, Checker.NO_DEAD_STATE, f"{crossing_id} {since_s}", text)
