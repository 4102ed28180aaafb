"""Every event that a journal may have, each a type: what units and devices note, and what the world shows.

`EVENTS` is the whole table, by word. Who writes an event, reads it or waits for it in a script does so by its type,
so that a renamed one does not pass the type checker. Pure data: nothing here decides anything.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from types import MappingProxyType
from typing import Final, get_args

import msgspec

from network.model import Position
from onboard import notes
from onboard.crossing_notes import CrossingCreep
from onboard.notes import Holds, ProofDropped, Proven, Reported, UnitRestarted
from radio.noted import Lost, Noted, Sent, TookEffect
from wayside import said
from wayside.crossing_said import CrossingOpens
from wayside.said import (
    Accepted,
    Barred,
    ConfirmedByHand,
    Freed,
    Granted,
    Outside,
    PictureChanged,
    Started,
    TakenBack,
)

# What the checkers match on; they take it from here, so that they import nothing of who writes it.
__all__ = [
    "Accepted",
    "Barred",
    "ConfirmedByHand",
    "CrossingCreep",
    "CrossingOpens",
    "Freed",
    "Granted",
    "Holds",
    "Outside",
    "PictureChanged",
    "ProofDropped",
    "Proven",
    "Reported",
    "Sent",
    "Started",
    "TakenBack",
    "TookEffect",
    "UnitRestarted",
]

WORLD: Final = "world"
MANAGER: Final = "block-manager"


class Entered(Noted, frozen=True, kw_only=True, tag="entered"):
    """A train is put on the line; `edge_ids` from the one under its rear to the one under its front."""

    unit_id: str
    train: str
    edge_ids: tuple[str, ...]


class Reversed(Noted, frozen=True, kw_only=True, tag="reversed"):
    """A train changed ends where it stands."""

    unit_id: str


class Left(Noted, frozen=True, kw_only=True, tag="left"):
    """A train was taken off the line."""

    unit_id: str


class TagPassed(Noted, frozen=True, kw_only=True, tag="tag_passed"):
    """The reader of a train came over a tag, whether it reads it or not."""

    unit_id: str
    tag_id: int


class PointsUnlocked(Noted, frozen=True, kw_only=True, tag="points_unlocked"):
    """The lock of points opened."""

    points_id: str


class PointsMoving(Noted, frozen=True, kw_only=True, tag="points_moving"):
    """The motor of points began to move the blades."""

    points_id: str
    target: Position


class PointsLocked(Noted, frozen=True, kw_only=True, tag="points_locked"):
    """Points lie in a position and are locked there."""

    points_id: str
    position: Position


class PointsForced(Noted, frozen=True, kw_only=True, tag="points_forced"):
    """A train ran through points set against it: they lie in no position."""

    points_id: str


class PointsLockedByHand(Noted, frozen=True, kw_only=True, tag="points_locked_by_hand"):
    """A crew has locked points on the spot for its passage and has the key: their motor is cut out (鎖錠)."""

    points_id: str
    unit_id: str


class PointsKeyBack(Noted, frozen=True, kw_only=True, tag="points_key_back"):
    """The key of points locked by hand is back, and their motor may run again."""

    points_id: str
    unit_id: str


class PointsSetByHand(Noted, frozen=True, kw_only=True, tag="points_set_by_hand"):
    """Staff set points by hand, locked them and took their faults away (手回し)."""

    points_id: str
    position: Position


class CrossingLamps(Noted, frozen=True, kw_only=True, tag="crossing_lamps"):
    """The lamps of a level crossing begin or cease to shine."""

    crossing_id: str
    lit: bool


class BarrierState(Enum):
    """Where the barriers of a level crossing are."""

    RAISED = "raised"
    LOWERING = "lowering"
    LOWERED = "lowered"
    RISING = "rising"


class CrossingBarriers(Noted, frozen=True, kw_only=True, tag="crossing_barriers"):
    """The barriers of a level crossing are now so."""

    crossing_id: str
    state: BarrierState


class RoadGuarded(Noted, frozen=True, kw_only=True, tag="road_guarded"):
    """Somebody guards the road of a level crossing by hand from now on, or no longer (`there`)."""

    crossing_id: str
    there: bool


class RoadStopped(Noted, frozen=True, kw_only=True, tag="road_stopped"):
    """Who guards a level crossing has stopped its road by hand, for the train of a unit that stands before it."""

    crossing_id: str
    unit_id: str


class CrossingEntered(Noted, frozen=True, kw_only=True, tag="crossing_entered"):
    """The front of a train came onto a level crossing."""

    unit_id: str
    crossing_id: str
    speed_mps: float


class PowerOff(Noted, frozen=True, kw_only=True, tag="power_off"):
    """A device or unit lost its power."""

    device_id: str


class PowerOn(Noted, frozen=True, kw_only=True, tag="power_on"):
    """A device or unit has power again."""

    device_id: str


class Uncommissioned(Noted, frozen=True, kw_only=True, tag="uncommissioned"):
    """A device or unit could have power again, but its durable state is lost: it waits for people to commission it."""

    device_id: str


class Commissioned(Noted, frozen=True, kw_only=True, tag="commissioned"):
    """People have put a device or unit into service again, for the `number`th time by their own record (使用開始)."""

    device_id: str
    number: int


class FaultBegan(Noted, frozen=True, kw_only=True, tag="fault"):
    """A fault of the script came into force."""

    kind: str
    target: str
    parameters: dict[str, float | str] = msgspec.field(default_factory=dict)


class FaultOver(Noted, frozen=True, kw_only=True, tag="fault_over"):
    """A fault of the script is over."""

    kind: str
    target: str
    parameters: dict[str, float | str] = msgspec.field(default_factory=dict)


class Acted(Noted, frozen=True, kw_only=True, tag="act"):
    """A person did something; its author is the person. `unsaid_section_ids`: of a word about a unit, what is not in it
    and its train stands in, or the unit shows to its crew as held.
    """

    act: str
    target: str
    section_ids: tuple[str, ...] = ()
    notch: int = 0
    unsaid_section_ids: tuple[str, ...] = ()


class ProcedureStep(Noted, frozen=True, kw_only=True, tag="procedure_step"):
    """A step of substitute working was done; its author did it. `block`: section between stations, or station."""

    block: str
    step: str
    to_whom: str
    says: str
    unit_id: str = ""
    train: str = ""


class StepNoted(Noted, frozen=True, kw_only=True):
    """What is written of a step of substitute working that is not simply done; `why`: what is wrong with it."""

    block: str
    step: str
    why: str
    unit_id: str = ""
    train: str = ""


class StepLeftOut(StepNoted, frozen=True, kw_only=True, tag="step_left_out"):
    """A step of substitute working was left out, and people go on as though it had been done."""


class StepOutOfOrder(StepNoted, frozen=True, kw_only=True, tag="step_out_of_order"):
    """A person does the step of substitute working that is written next, before what its table has it wait for."""


class StepRefused(StepNoted, frozen=True, kw_only=True, tag="step_refused"):
    """A person wanted to do a step of substitute working, and it cannot be done."""


class CutOut(Noted, frozen=True, kw_only=True, tag="cut_out"):
    """A driver has cut the unit out (開放): nothing but him stops the train."""

    unit_id: str


class CutIn(Noted, frozen=True, kw_only=True, tag="cut_in"):
    """A driver has cut the unit in again: it boots."""

    unit_id: str


class BatteryLevel(Enum):
    """What a set has in its battery: `low`, what can wait of its auxiliaries is off; `empty`, it cannot move."""

    ENOUGH = "enough"
    LOW = "low"
    EMPTY = "empty"


class BatteryAt(Noted, frozen=True, kw_only=True, tag="battery"):
    """The battery of a set has come to another level; every set begins with enough."""

    unit_id: str
    level: BatteryLevel


class UnitRestrains(Noted, frozen=True, kw_only=True, tag="unit_restrains"):
    """A driver was told to go, and the unit, which is not cut out and has no authority, does not let the train move."""

    unit_id: str


class SignalActed(Noted, frozen=True, kw_only=True, tag="signal_act"):
    """Somebody did something at a line signal or a direction lever; its author did it."""

    does: str
    signal_id: str = ""
    lever_id: str = ""


class SignalShows(Noted, frozen=True, kw_only=True, tag="signal_shows"):
    """A line signal shows another aspect."""

    signal_id: str
    aspect: str


class SignalPassed(Noted, frozen=True, kw_only=True, tag="signal_passed"):
    """The front of a train passed a line signal, which showed this."""

    unit_id: str
    signal_id: str
    aspect: str


class WrongDeparture(Noted, frozen=True, kw_only=True, tag="wrong_departure"):
    """A detector saw a train leave past a signal at stop; `stops`: the signals that it keeps at stop from now on, if it
    works.
    """

    unit_id: str
    signal_id: str
    stops: tuple[str, ...]
    works: bool


class Danger(Enum):
    """What must never happen to a train on the track, and does; with the points where it is about some."""

    CANNOT_TURN = "overran its track and cannot turn back"
    END_OF_TRACK = "ran off the end of the track"
    PANTOGRAPH_UP = "moved with its pantograph up"
    DOORS_OPEN = "moved off with its doors open"
    NO_POSITION = "ran onto points {points} that lie in no position"
    WRONG_WAY = "was sent the wrong way at points {points}"
    SET_AGAINST = "ran through points {points} set against it"


class Unsafe(Noted, frozen=True, kw_only=True, tag="unsafe"):
    """Something happened to a train on the track that must never happen."""

    unit_id: str
    danger: Danger
    points_id: str = ""

    @property
    def text(self) -> str:
        """What happened, in words."""
        return self.danger.value.format(points=self.points_id)


class CameLate(Noted, frozen=True, kw_only=True, tag="came_late"):
    """A train comes to its portal `late_s` later than planned."""

    unit_id: str
    train: str
    late_s: float


class DoorsHeld(Noted, frozen=True, kw_only=True, tag="doors_held"):
    """Doors stay open beyond the time to leave: for passengers, and then because they do not close.

    `until_s`: when they are closed. `people_s` and `doors_s`: how long each keeps them, s.
    """

    unit_id: str
    train: str
    station: str
    until_s: float
    people_s: float
    doors_s: float


class VehicleStruck(Noted, frozen=True, kw_only=True, tag="vehicle_struck"):
    """A train and a road vehicle are in one place on a level crossing; the speed is the train's as they met."""

    unit_id: str
    crossing_id: str
    vehicle_id: str
    speed_mps: float

    @property
    def text(self) -> str:
        """The same in words."""
        at = f"{3.6 * self.speed_mps:.1f} km/h"
        return f"collision of {self.unit_id} with the road vehicle {self.vehicle_id} at {self.crossing_id}, at {at}"


class Collision(Noted, frozen=True, kw_only=True, tag="collision"):
    """The carrier found two trains in one place."""

    text: str


WorldEvent = (
    Lost
    | Entered
    | Reversed
    | Left
    | TagPassed
    | PointsUnlocked
    | PointsMoving
    | PointsLocked
    | PointsForced
    | PointsLockedByHand
    | PointsKeyBack
    | CrossingLamps
    | CrossingBarriers
    | RoadGuarded
    | RoadStopped
    | CrossingEntered
    | PowerOff
    | PowerOn
    | Uncommissioned
    | Commissioned
    | FaultBegan
    | FaultOver
    | CameLate
    | DoorsHeld
    | Unsafe
    | VehicleStruck
    | Collision
    | CutOut
    | CutIn
    | BatteryAt
    | UnitRestrains
    | SignalShows
    | SignalPassed
    | WrongDeparture
)
PersonEvent = (
    Acted | PointsSetByHand | ProcedureStep | StepLeftOut | StepOutOfOrder | StepRefused | SignalActed
)
Event = notes.Note | said.Note | WorldEvent | PersonEvent | Sent
EventType = type[Noted]


class JournalEntry(msgspec.Struct, frozen=True):
    """One line of the journal: simulated time, s since midnight, its author, and what happened."""

    t_s: float
    who: str
    event: Event


def word_of(event: EventType) -> str:
    """The word of a type of event in a line of the journal (its `what`)."""
    return str(event.__struct_config__.tag)


class Author(Enum):
    """Who can have written an entry."""

    UNIT = "unit"
    MANAGER = "block manager"
    TERMINAL = "point terminal"
    CROSSING = "level crossing"
    WORLD = "the world"
    PERSON = "a person"


_WRITES: Final = (
    (Author.UNIT, notes.Note | Sent),
    (Author.MANAGER, said.ManagerNote | Sent),
    (Author.TERMINAL, said.TerminalNote | Sent),
    (Author.CROSSING, said.CrossingNote | Sent),
    (Author.WORLD, WorldEvent),
    (Author.PERSON, PersonEvent),
)
EVENTS: Final[Mapping[str, EventType]] = MappingProxyType(
    {word_of(event): event for event in get_args(Event)}
)


def authors_of(event: EventType) -> tuple[Author, ...]:
    """Who may write an event of this type."""
    return tuple(author for author, kinds in _WRITES if event in get_args(kinds))


def unit_of(entry: JournalEntry) -> str:
    """The unit that an entry speaks of: the one it names, else its author."""
    return str(getattr(entry.event, "unit_id", entry.who))
