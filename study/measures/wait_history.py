"""What the journal says of the ground over the whole run: who had which section when, how points lay, who had power.

Everything is known to its end, so that a wait can say until when another stock had the section.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from onboard.notes import MissionBegun
from simulation import events
from simulation.events import JournalEntry
from simulation.world.roster import Duty
from study.measures.register_holds import SectionHold, Tenure


@dataclass(slots=True)
class Changes:
    """What something was when: times in order, s, and what it was from each on."""

    times_s: list[float] = field(default_factory=list[float])
    values: list[str] = field(default_factory=list[str])

    def put(self, t_s: float, value: str) -> None:
        """It is `value` from now on."""
        self.times_s.append(t_s)
        self.values.append(value)

    def at(self, t_s: float) -> tuple[str, float, float]:
        """What it is at a moment ("" before the first change), since when and until when, s."""
        index = bisect_right(self.times_s, t_s)
        until_s = self.times_s[index] if index < len(self.times_s) else math.inf
        if index == 0:
            return "", -math.inf, until_s
        return self.values[index - 1], self.times_s[index - 1], until_s


NO_POWER: Final = "no power"
FROZEN: Final = "frozen"
MOVING: Final = "moving"
ON_LINE: Final = "on the line"


class RegisterHistory:
    """The register of sections, the points and the power of devices, as the journal of one run has them.

    `holds` are those of `study.measures.register_holds`.
    """

    def __init__(self, entries: Iterable[JournalEntry], holds: Iterable[SectionHold]) -> None:
        self._tenures: dict[str, list[Tenure]] = defaultdict(list)
        for hold in holds:
            self._tenures[hold.section_id] += hold.tenures
        self._points: dict[str, Changes] = defaultdict(Changes)
        self._ails: dict[str, Changes] = defaultdict(Changes)
        self._trains: dict[str, Changes] = defaultdict(Changes)
        self._begun_s: dict[tuple[str, str], float] = {}  # by stock and train number
        self._line: dict[str, Changes] = defaultdict(Changes)
        self._entered_s: dict[tuple[str, str], float] = {}
        for entry in entries:
            self._take(entry)

    def _take(self, entry: JournalEntry) -> None:
        t_s = entry.t_s
        match entry.event:
            case events.PointsMoving(points_id=points):
                self._points[points].put(t_s, MOVING)
            case events.PointsLocked(points_id=points, position=position):
                self._points[points].put(t_s, position.value)
            case events.PowerOff(device_id=device):
                self._ails[device].put(t_s, NO_POWER)
            case events.FaultBegan(kind="frozen", target=device):
                self._ails[device].put(t_s, FROZEN)
            case events.PowerOn(device_id=device) | events.FaultOver(kind="frozen", target=device):
                self._ails[device].put(t_s, "")
            case MissionBegun(train=train):
                self._trains[entry.who].put(t_s, train)
                self._begun_s.setdefault((entry.who, train), t_s)
            case events.Entered(unit_id=unit, train=train):
                self._entered_s.setdefault((unit, train), t_s)
                self._line[unit].put(t_s, ON_LINE)
            case events.Left(unit_id=unit):
                self._line[unit].put(t_s, "")
            case _:
                pass

    def holder(self, section: str, t_s: float, but: str) -> Tenure | None:
        """Which other stock than `but` has a section at a moment."""
        return next(
            (x for x in self._tenures.get(section, ()) if x.unit != but and x.from_s <= t_s < x.to_s), None
        )

    def next_change_s(self, sections: Iterable[str], t_s: float) -> float:
        """When the register of any of these sections changes next, s; infinite: never."""
        times_s = (
            moment_s
            for section in sections
            for tenure in self._tenures.get(section, ())
            for moment_s in (tenure.from_s, tenure.to_s)
            if moment_s > t_s
        )
        return min(times_s, default=math.inf)

    def points_move(self, points: str, t_s: float) -> tuple[bool, float, float]:
        """Whether points are being thrown at a moment, since when and until when that is so, s."""
        value, since_s, until_s = self._points[points].at(t_s)
        return value == MOVING, since_s, until_s

    def ails(self, device: str, t_s: float) -> tuple[str, float]:
        """What is wrong with a device at a moment (no power, frozen, or nothing: ""), and until when that is so, s."""
        value, _, until_s = self._ails[device].at(t_s)
        return value, until_s

    def train_of(self, unit: str, t_s: float) -> str:
        """The train number of a stock at a moment; before its first train, and without one, empty."""
        return self._trains[unit].at(t_s)[0]

    def ahead(self, duty: Duty, drawn: Mapping[str, Sequence[Duty]]) -> Iterator[tuple[float, float]]:
        """Trains that have the portal of a duty before it: when each comes before it, and is in it, s."""
        portal = duty.mission.spans[0].section_id
        own = self._begun_s.get((duty.stock_id, duty.train.number), math.inf), duty.comes_s
        for each in (each for duties in drawn.values() for each in duties):
            if (
                each.stock_id == duty.stock_id
                or not each.enters
                or each.mission.spans[0].section_id != portal
            ):
                continue
            key = each.stock_id, each.train.number
            if (self._begun_s.get(key, math.inf), each.comes_s) < own:
                yield each.comes_s, self._entered_s.get(key, math.inf)

    def on_line(self, unit: str, t_s: float) -> bool:
        """Whether a stock is truly on the line at a moment."""
        return self._line[unit].at(t_s)[0] == ON_LINE
