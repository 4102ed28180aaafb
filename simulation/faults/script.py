"""What a drill does and expects: faults, acts and expectations, and when they take effect (試験メニュー, table 5).

Everything here is data. A trigger is a time, or an event of the journal in words ("train 323M passes tag 4"), and
may add a delay. `TriggerWatch` looks at every journal entry as it is written and says what has come due.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, Final

from network.raw import is_row
from onboard.notes import Arrived, Departs, Holds, MissionBegun, UnitRestarted
from simulation.events import (
    Entered,
    EventType,
    JournalEntry,
    PointsLocked,
    PointsMoving,
    TagPassed,
    Uncommissioned,
    unit_of,
    word_of,
)
from simulation.faults.fault import Fault
from wayside.said import Started


class ActKind(Enum):
    """What people do."""

    CONFIRM_OUTSIDE = "confirm_outside"
    TAKE_BACK = "take_back"
    CONFIRM_HOLDING = "confirm_holding"
    ACCEPT_PICTURE = "accept_picture"
    POWER_ON = "power_on"
    COMMISSION = "commission"
    REPAIR_POINTS = "repair_points"
    ENTER_SECTION = "enter_section"
    REENTER_BY_HAND = "reenter_by_hand"
    REENTER_ASSISTED = "reenter_assisted"
    BAR_UNIT = "bar_unit"
    UNBAR_UNIT = "unbar_unit"
    HAUL_AWAY = "haul_away"
    BRING_POWER = "bring_power"
    FREE_ROAD = "free_road"
    GUARD_ROAD = "guard_road"
    LEAVE_ROAD = "leave_road"
    GIVE_BACK = "give_back"
    HOLD_TRAIN = "hold_train"
    LET_GO = "let_go"
    END_TRAIN = "end_train"
    DRIVE = "drive"
    DRIVE_BY_ATO = "drive_by_ato"
    TAKE_ROLE = "take_role"
    HAND_BACK_ROLE = "hand_back_role"
    DO_STEP = "do_step"
    LEAVE_OUT_STEP = "leave_out_step"


ACT_MEANINGS: Final[Mapping[ActKind, str]] = {
    ActKind.CONFIRM_OUTSIDE: "controller: this unit is off the line, by which portal it left",
    ActKind.TAKE_BACK: "controller: what persons said of this unit may be wrong",
    ActKind.CONFIRM_HOLDING: "controller: enters what a silent unit holds",
    ActKind.ACCEPT_PICTURE: "controller: the restored picture is complete and right",
    ActKind.POWER_ON: "crew or staff: switch a device or unit on again",
    ActKind.COMMISSION: "staff: put a party whose durable state is lost into service again",
    ActKind.REPAIR_POINTS: "staff: set points by hand into a position, lock them, remove their faults",
    ActKind.ENTER_SECTION: "controller, after a restart: these sections are this unit's; without a unit, free",
    ActKind.REENTER_BY_HAND: "controller: enters every section, one by one, as the crews say by voice",
    ActKind.REENTER_ASSISTED: "controller: watches the picture until it is complete, and accepts it",
    ActKind.BAR_UNIT: "controller or staff: nothing that this unit says is to count",
    ActKind.UNBAR_UNIT: "controller or staff: what this unit says is to count again",
    ActKind.HAUL_AWAY: "staff: haul a train without power off the line, out of the portal where it stands",
    ActKind.BRING_POWER: "staff: bring a generator to a set that stands without charge, until it has what it needs",
    ActKind.FREE_ROAD: "controller or staff: no train comes to this level crossing, and none is on it",
    ActKind.GUARD_ROAD: "staff: guard this level crossing, and stop its road by hand for trains that stand before it",
    ActKind.LEAVE_ROAD: "staff: guard this level crossing no longer",
    ActKind.GIVE_BACK: "crew: return the route ahead, not yet entered, and ask for none for a while",
    ActKind.HOLD_TRAIN: "controller: no route for this unit for a while, or until another one has a section",
    ActKind.LET_GO: "controller: what this unit was kept back for does not count any more",
    ActKind.END_TRAIN: "controller: this unit's train ends where it stands, its set goes on as a later one",
    ActKind.DRIVE: "crew: drive by hand, with this notch",
    ActKind.DRIVE_BY_ATO: "crew: leave the driving to the law that the scenario has for the stock",
    ActKind.TAKE_ROLE: "anybody: be this one of substitute working, whose steps then wait for the person",
    ActKind.HAND_BACK_ROLE: "anybody: be this one no more; the program plays on",
    ActKind.DO_STEP: "who has the role: do a step of substitute working, in its turn or not",
    ActKind.LEAVE_OUT_STEP: "who has the role: go on as though a step had been done",
}
# What a person does as one of those who work a line by substitute working.
BY_ROLE: Final = frozenset(
    {ActKind.TAKE_ROLE, ActKind.HAND_BACK_ROLE, ActKind.DO_STEP, ActKind.LEAVE_OUT_STEP}
)
AT_CROSSING: Final = frozenset({ActKind.FREE_ROAD, ActKind.GUARD_ROAD, ActKind.LEAVE_ROAD})
OF_STEP: Final = frozenset({ActKind.DO_STEP, ActKind.LEAVE_OUT_STEP})


@dataclass(frozen=True, slots=True)
class Matcher:
    """An event of the journal: who (a party, or the train number it then runs), what, and data that must be equal."""

    text: str
    events: tuple[EventType, ...]
    who: str | None = None
    train: str | None = None
    data: Mapping[str, object] = field(default_factory=dict[str, object])  # by the name of the field

    def __post_init__(self) -> None:
        for event in self.events:
            unknown = sorted(set(self.data) - set(event.__struct_fields__))
            if unknown:
                raise ValueError(f"{word_of(event)} has no field {', '.join(unknown)}")

    def matches(self, entry: JournalEntry, train_of: Mapping[str, str]) -> bool:
        """Whether an entry is this event; `train_of` gives the present train number of each unit."""
        event = entry.event
        if not isinstance(event, self.events) or (self.who is not None and entry.who != self.who):
            return False
        if self.train is not None and train_of.get(unit_of(entry)) != self.train:
            return False
        return all(_same(getattr(event, name), value) for name, value in self.data.items())


def _same(actual: object, wanted: object) -> bool:
    """A wanted list must be contained in the actual one, as must a single value; an enum is its word."""
    if isinstance(actual, Enum):
        return actual.value == wanted or actual is wanted
    if not isinstance(actual, tuple):
        return actual == wanted
    return all(item in actual for item in (wanted if is_row(wanted) else (wanted,)))


@dataclass(frozen=True, slots=True)
class Trigger:
    """A time (s since midnight), or an event, the `nth` of its kind, and a delay after it."""

    at_s: float | None = None
    on: Matcher | None = None
    after_s: float = 0.0
    nth: int = 1


@dataclass(frozen=True, slots=True)
class ScriptedFault:
    """A fault with its beginning and, unless it lasts, its duration."""

    fault: Fault[Any]
    trigger: Trigger
    duration_s: float | None = None


@dataclass(frozen=True, slots=True)
class Act:
    """Something a person does."""

    kind: ActKind
    target: str
    trigger: Trigger
    person: str = "controller"
    sections: tuple[str, ...] = ()
    position: str = ""
    hold_s: float = 300.0
    place: str = ""
    pace_s: float | None = None  # time for each word of a re-entry; None: drawn from `[people]`
    behind: str = ""
    train: str = ""
    notch: int = 0
    step: str = ""
    block: str = ""


class Property(Enum):
    """What must hold over a whole run or a stretch of it."""

    NO_INVARIANT_BROKEN = "no_invariant_broken"
    EVERYONE_ARRIVES = "everyone_arrives"
    SPEED_AT_MOST = "speed_at_most"  # unit, kmh, between from and until
    NEVER_ENTERS = "never_enters"  # unit, section, between from and until


@dataclass(frozen=True, slots=True)
class Expectation:
    """An event by a time, or a property; exactly one of `event` and `holds` is set. `absent`: that it is not so.

    `rules`: of invariants that are broken, as persons are wrong, those that may be, and no others.
    """

    text: str
    event: Matcher | None = None
    absent: bool = False
    after: Matcher | None = None
    within_s: float | None = None
    by_s: float | None = None
    holds: Property | None = None
    unit: str = ""
    section: str = ""
    kmh: float = 0.0
    until: Matcher | None = None
    rules: tuple[str, ...] = ()


# What every drill expects unless its file says otherwise of the same property.
DEFAULTS: Final = (
    Expectation("every train reaches its station", holds=Property.EVERYONE_ARRIVES),
    Expectation("no invariant is broken", holds=Property.NO_INVARIANT_BROKEN),
)


@dataclass(frozen=True, slots=True)
class Script:
    """All of a drill."""

    faults: tuple[ScriptedFault, ...] = ()
    acts: tuple[Act, ...] = ()
    expectations: tuple[Expectation, ...] = ()


_WORDS: Final[tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], dict[str, Any]]], ...]] = (
    (
        re.compile(r"train (\S+) passes tag (\d+)"),
        lambda m: {"events": (TagPassed,), "train": m[1], "data": {"tag_id": int(m[2])}},
    ),
    (
        re.compile(r"train (\S+) departs (\S+)"),
        lambda m: {"events": (Departs,), "train": m[1], "data": {"station": m[2]}},
    ),
    (
        re.compile(r"train (\S+) arrives (\S+)"),
        lambda m: {"events": (Arrived,), "train": m[1], "data": {"station": m[2]}},
    ),
    (re.compile(r"train (\S+) enters"), lambda m: {"events": (Entered,), "data": {"train": m[1]}}),
    (
        re.compile(r"train (\S+) holds (\S+)"),
        lambda m: {"events": (Holds,), "train": m[1], "data": {"section_ids": m[2]}},
    ),
    (re.compile(r"points (\S+) move"), lambda m: {"events": (PointsMoving,), "data": {"points_id": m[1]}}),
    (re.compile(r"points (\S+) lock"), lambda m: {"events": (PointsLocked,), "data": {"points_id": m[1]}}),
    (
        re.compile(r"(\S+) waits to be commissioned"),
        lambda m: {"events": (Uncommissioned,), "data": {"device_id": m[1]}},
    ),
    (re.compile(r"(\S+) restarts"), lambda m: {"events": (UnitRestarted, Started), "who": m[1]}),
)
WORDS_HELP: Final = (
    "words such as 'train 323M passes tag 4', 'train 323M departs OGN', 'train 323M arrives OGN', 'train"
    " 323M enters', 'train 323M holds OGN.1', 'points OGN.11 move', 'points OGN.11 lock', 'V1 restarts', 'V1 waits to"
    " be commissioned'"
)


def matcher_of(text: str) -> Matcher | None:
    """The event that words name; None if they name none."""
    for pattern, build in _WORDS:
        match = pattern.fullmatch(text.strip())
        if match is not None:
            return Matcher(text, **build(match))
    return None


@dataclass(slots=True)
class ItemCourse:
    """What became of a failure or an act: when it began, and when it was over (None: never)."""

    item: ScriptedFault | Act
    begun_s: float
    over_s: float | None = None


class TriggerWatch:
    """Follows the journal: which train each unit runs, and which triggers have come due."""

    def __init__(self, triggers: Mapping[int, Trigger], due: Callable[[int, float], None]) -> None:
        self.train_of: dict[str, str] = {}
        self._open = {key: trigger for key, trigger in triggers.items() if trigger.on is not None}
        self._due = due
        self._seen: dict[int, int] = {}

    def see(self, entry: JournalEntry) -> None:
        """An entry was written. A trigger fires once, at the event that it counts to."""
        if isinstance(entry.event, MissionBegun):
            self.train_of[entry.who] = entry.event.train
        if not self._open:
            return
        fired = [
            key
            for key, trigger in self._open.items()
            if trigger.on is not None and trigger.on.matches(entry, self.train_of)
        ]
        for key in fired:
            self._seen[key] = self._seen.get(key, 0) + 1
            if self._seen[key] < self._open[key].nth:
                continue
            trigger = self._open.pop(key)
            self._due(key, entry.t_s + trigger.after_s)
