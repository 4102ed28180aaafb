"""Whether a set's charge takes it to its next charge: decided before it leaves, by its own prediction (充電残量の照査).

Whatever the rule, no set leaves with its pantograph up: that comes down by itself when it is due by its unit's clock.
Where it leaves a charger, or begins a train, it wants a reserve beyond what it predicts; on its way from there, where
waiting would help nobody, what it predicts with all off at its stands that can wait is enough. It reckons with the
charge it will have when it is to leave.
Once its time has come and it has too little, it charges until its way is free, and only then lowers its pantograph:
down at once, it would use up what it was charged for while it waits for its way, and so on without end.
While it stands without a charger it keeps that and a reserve: with less, what can wait of its auxiliaries is off.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import Final, Protocol

from network.model import Line
from onboard.duty.unable import NoCharge, Unable
from onboard.mission import Mission
from onboard.reach import Reach, SetWays, charger_at, to_next_charge

SHOWN_J: Final = 1e4


class Gauge(Protocol):
    """What the battery and its pantograph show, and what they are told."""

    def has_j(self, at_s: float) -> float:
        """What will be available at a time, J: charging goes on until its pantograph comes down for that."""
        ...

    @property
    def charges(self) -> bool:
        """Whether the set stands at a charger that works."""
        ...

    @property
    def full(self) -> bool:
        """Whether the battery takes no more."""
        ...

    @property
    def up(self) -> bool:
        """Whether the pantograph is up."""
        ...

    @property
    def connected(self) -> bool:
        """Whether the pantograph is not down."""
        ...

    @property
    def ready(self) -> bool:
        """Whether the pantograph is up and has no more to wait for: there is what is asked for, and some to spare."""
        ...

    def ask(self, needed_j: float, leaves_s: float, keeps_j: float) -> None:
        """The set is to leave at a time of its unit's clock (+inf: not known, -inf: once it can), with so much.

        `keeps_j` is what its stand without a charger is to leave it.
        """
        ...


@dataclass(frozen=True, slots=True)
class ChargeRules:
    """`waits`: a set with too little stays; `reserve_j` it keeps back, `prediction_share` it adds to predictions."""

    waits: bool
    reserve_j: float
    prediction_share: float

    def needed_j(self, reach: Reach, *, commits: bool) -> float:
        """What must be available for a way, J; `commits`: where the set could wait. Where waiting would help nobody
        that is what it takes with all switched off at its stands that can wait.
        """
        takes_j = reach.needed_j - (0.0 if commits else reach.saves_j)
        return (1.0 + self.prediction_share) * takes_j + (self.reserve_j if commits else 0.0)


def commits_at(line: Line, mission: Mission, at: int) -> bool:
    """Whether a set could wait at a stop: it begins its train there, or there is a charger."""
    return at == 0 or bool(charger_at(line, mission.targets[at]))


def _leaves_s(mission: Mission, at: int) -> float:
    """When a set is to leave a stop; -inf where the plan has no time for that."""
    departs_s = mission.targets[at].departure_s
    return -math.inf if departs_s is None else departs_s


class ChargeWatch:
    """The charge of one set, as its unit watches it."""

    def __init__(self, line: Line, ways: SetWays, rules: ChargeRules, gauge: Gauge) -> None:
        self.now_s = 0.0
        self._line: Final = line
        self._ways: Final = ways
        self._rules: Final = rules
        self._gauge: Final = gauge
        self._dead: Collection[str] = ()
        self._asked: tuple[str, int] | None = None
        self._due_at: tuple[str, int] | None = None
        self._stays_up = self._comes_down = False
        self._reach: Reach | None = None
        self._needed_j = 0.0
        self._leaves_s = math.inf

    def hear_of_dead(self, dead: Collection[str]) -> None:
        """The crew is told which chargers are dead."""
        self._dead, self._asked = frozenset(dead), None

    def why_not(self, mission: Mission, at: int) -> NoCharge | None:
        """Why the set may not leave the stop where it stands; None where it may."""
        self._look(mission, at)
        if self._reach is None:
            return None
        if self.now_s >= self._leaves_s:
            self._due_at = mission.number, at  # and stays so, though its clock be set back
        due = self._due_at == (mission.number, at)
        has_j = self._gauge.has_j(self._leaves_s)
        short = self._rules.waits and has_j < self._needed_j
        if short and due and not self._stays_up:
            self._stays_up, self._comes_down = True, False
            self._ask(math.inf)
        if not short and not (self._gauge.connected and due):
            return None
        return NoCharge(
            station=self._reach.place or "",
            has_j=math.floor(has_j / SHOWN_J) * SHOWN_J,
            needed_j=math.ceil(self._needed_j / SHOWN_J) * SHOWN_J,
            charges=self._gauge.charges,
            full=short and self._gauge.full,
            connected=not short,
            up=self._gauge.up,
            stays_up=not short and (self._comes_down or (self._stays_up and self._gauge.ready)),
        )

    def told(self, unable: Unable | None) -> None:
        """What keeps the set, as its duty has it: nothing but a pantograph that stays up until its way is free?"""
        if self._stays_up and isinstance(unable, NoCharge) and unable.stays_up:
            self._stays_up, self._comes_down = False, True
            self._ask(-math.inf)

    def on_sight(self, mission: Mission, at: int) -> None:
        """On sight at a stop its crew decides: all that is asked for is a pantograph that is down when it is due."""
        self._reckon(mission, at)
        self._asked = None
        self._gauge.ask(0.0, self._leaves_s, self._needed_j + self._rules.reserve_j)

    @property
    def connected(self) -> bool:
        """Whether the pantograph is not down."""
        return self._gauge.connected

    def _look(self, mission: Mission, at: int) -> None:
        """What the way from a stop takes: worked out when the set comes there, and when chargers fail or are mended."""
        if self._asked == (mission.number, at):
            return
        self._asked = mission.number, at
        self._reckon(mission, at)
        self._stays_up = self._comes_down = False
        self._ask(self._leaves_s)

    def _ask(self, leaves_s: float) -> None:
        self._gauge.ask(self._needed_j, leaves_s, self._needed_j + self._rules.reserve_j)

    def _reckon(self, mission: Mission, at: int) -> None:
        """What the way from a stop takes, and when it is to begin."""
        ahead = self._ways.ahead(mission.number, at)
        last = at + 1 >= len(mission.targets)
        self._leaves_s = math.inf if last else _leaves_s(mission, at)
        self._reach = None if last or not ahead else to_next_charge(ahead, self._dead)
        self._needed_j = 0.0
        if self._reach is not None and self._rules.waits:
            commits = commits_at(self._line, mission, at)
            self._needed_j = self._rules.needed_j(self._reach, commits=commits)
