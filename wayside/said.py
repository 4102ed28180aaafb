"""What wayside devices are told and say besides telegrams: inputs, outputs, and their lines of the journal, one type
an event. Pure data, without any rule.

Points stand in the simulated world; a terminal drives them by outputs and sees them by inputs, as a real one does by
relays (転てつ機制御出力・表示入力, table 4 of Sugiyama et al. 2017). Persons' words are inputs of the block manager.
"""

from __future__ import annotations

import msgspec

from network.model import Position
from radio.noted import Noted, TelegramDropped, TookEffect
from wayside.crossing_said import CloseCrossing, CrossingInput, CrossingWord, OpenCrossing


class ConfirmOutside(msgspec.Struct, frozen=True, array_like=True, tag=1):
    """Operator to manager: `person` has made sure that the unit is off the line, by which portal it left (`place`)."""

    unit_id: str
    person: str
    place: str = ""


class ConfirmHolding(msgspec.Struct, frozen=True, array_like=True, tag=2):
    """Operator to manager: by-hand entry (手動入力) of all that a silent unit occupies and holds."""

    unit_id: str
    section_ids: tuple[str, ...]
    person: str


class PointsDetected(msgspec.Struct, frozen=True, array_like=True, tag=3):
    """World to terminal: what the detection contacts show, at each change and after a restart. None:
    neither. `by_hand`: a crew has locked the machine on the spot, and its motor is cut out.
    """

    points_id: str
    position: Position | None
    locked: bool
    by_hand: bool = False


class EnterSection(msgspec.Struct, frozen=True, array_like=True, tag=4):
    """Operator to manager, after its restart: this section belongs to that unit; None: it is free (手動入力)."""

    section_id: str
    unit_id: str | None
    person: str


class AcceptPicture(msgspec.Struct, frozen=True, array_like=True, tag=5):
    """Operator to manager, after its restart: `person` has looked at the whole line as it is shown; it is right."""

    person: str


class TakeBack(msgspec.Struct, frozen=True, array_like=True, tag=6):
    """Operator to manager: what persons have said of a silent unit may be wrong: it is to count for nothing again."""

    unit_id: str
    person: str


class BoundaryPassed(msgspec.Struct, frozen=True, array_like=True, tag=7):
    """World to manager: the contact at the boundary beyond this portal has counted a whole train out of the line."""

    section_id: str


class BarUnit(msgspec.Struct, frozen=True, array_like=True, tag=8):
    """Operator to all devices: the unit is defective or its key stolen; nothing that it says is to count."""

    unit_id: str
    person: str


class UnbarUnit(msgspec.Struct, frozen=True, array_like=True, tag=9):
    """Operator to all devices: what the unit says is to count again."""

    unit_id: str
    person: str


class LetWait(msgspec.Struct, frozen=True, array_like=True, tag=10):
    """Dispatcher to manager: the unit gets no route for `hold_s`, or until `behind` has the section before that."""

    unit_id: str
    person: str
    hold_s: float
    behind: str = ""
    section_id: str = ""


class LetGo(msgspec.Struct, frozen=True, array_like=True, tag=11):
    """Dispatcher to manager: what the unit was told to wait for does not count any more."""

    unit_id: str
    person: str


class EndTrain(msgspec.Struct, frozen=True, array_like=True, tag=12):
    """Dispatcher to manager: the unit's train is to end where it stands, and its set goes on as `next_train`."""

    unit_id: str
    person: str
    next_train: str


Input = (
    ConfirmOutside
    | ConfirmHolding
    | PointsDetected
    | EnterSection
    | AcceptPicture
    | TakeBack
    | BoundaryPassed
    | BarUnit
    | UnbarUnit
    | LetWait
    | LetGo
    | EndTrain
    | CrossingInput
)


class StartThrow(msgspec.Struct, frozen=True, array_like=True, tag=1):
    """Terminal to world: unlock, run the motor to this position, lock."""

    points_id: str
    position: Position


class StopThrow(msgspec.Struct, frozen=True, array_like=True, tag=2):
    """Terminal to world: motor off, because position or lock was not proven in time."""

    points_id: str


Output = StartThrow | StopThrow | CloseCrossing | OpenCrossing


class Started(Noted, frozen=True, kw_only=True, tag="started"):
    """A device has booted: what it knew is gone but for its durable state."""

    epoch: int


class InputRefused(Noted, frozen=True, kw_only=True, tag="input_refused"):
    """An input that this kind of device does not take."""

    why: str


class Granted(Noted, frozen=True, kw_only=True, tag="granted"):
    """The manager has granted a route whole; its sections are the unit's."""

    unit_id: str
    section_ids: tuple[str, ...]
    token: int
    route_id: str


class Refused(Noted, frozen=True, kw_only=True, tag="refused"):
    """A device refused a telegram or a person's word; `other_id` holds the first of the sections."""

    unit_id: str = ""
    section_ids: tuple[str, ...] = ()
    token: int = 0
    other_id: str = ""
    why: str


class Freed(Noted, frozen=True, kw_only=True, tag="freed"):
    """The manager has freed sections: by the unit's own word, the boundary's contact, or `by` a person's word."""

    unit_id: str
    section_ids: tuple[str, ...]
    token: int = 0
    by: str = ""


class Leaving(Noted, frozen=True, kw_only=True, tag="leaving"):
    """The manager has accepted a sign-off: the portal stays the unit's until its train is known to have left."""

    unit_id: str
    section_ids: tuple[str, ...]
    token: int


class Accepted(Noted, frozen=True, kw_only=True, tag="accepted"):
    """The manager has taken a sign-on or a claim: the unit, `was` that before, holds exactly these sections."""

    unit_id: str
    section_ids: tuple[str, ...]
    token: int
    was: str


class Outside(Noted, frozen=True, kw_only=True, tag="outside"):
    """The manager has the unit as off the line: it `was` that before, or persons say so."""

    unit_id: str
    token: int = 0
    was: str = ""
    by: str = ""


class ConfirmedByHand(Noted, frozen=True, kw_only=True, tag="confirmed_by_hand"):
    """The manager has what the unit holds from persons (手動入力)."""

    unit_id: str
    section_ids: tuple[str, ...]
    token: int
    by: str


class WordTaken(Noted, frozen=True, kw_only=True, tag="word_taken"):
    """A person's word is taken down but not in force yet; without a unit, the sections are said to be free."""

    unit_id: str = ""
    section_ids: tuple[str, ...]
    by: str


class PictureChanged(Noted, frozen=True, kw_only=True, tag="picture"):
    """How far the re-entry has come, after so many inputs of persons."""

    stage: str
    inputs: int


class Contradicted(Noted, frozen=True, kw_only=True, tag="contradiction"):
    """What the unit, a person or another holder says does not fit; shown to the operator."""

    unit_id: str
    section_ids: tuple[str, ...] = ()
    token: int = 0
    other_id: str = ""
    why: str = ""


class TakenBack(Noted, frozen=True, kw_only=True, tag="taken_back"):
    """A person has taken back what persons had said of a silent unit."""

    unit_id: str
    by: str


class ToBeSwept(Noted, frozen=True, kw_only=True, tag="to_be_swept"):
    """A silent unit counts as elsewhere by persons' word alone: these sections are locked but for a train on sight."""

    section_ids: tuple[str, ...]


class Barred(Noted, frozen=True, kw_only=True, tag="barred"):
    """Two persons have barred the unit at this device: what it says counts for nothing from now on."""

    unit_id: str
    by: str


class Unbarred(Noted, frozen=True, kw_only=True, tag="unbarred"):
    """Two persons have unbarred the unit at this device."""

    unit_id: str
    by: str


class Swept(Noted, frozen=True, kw_only=True, tag="swept"):
    """A train has run through these sections on sight and found them empty: they are as any other again."""

    unit_id: str
    section_ids: tuple[str, ...]


class Certified(Noted, frozen=True, kw_only=True, tag="certified"):
    """What is granted next leaves every train a way to finish: `moves` in order, each a unit and the section to which
    it goes, until all that are on the line have ended their trains; `beyond` are those of the day after that.
    """

    unit_id: str
    moves: tuple[str, ...]
    beyond: int = 0


class HeldBack(Noted, frozen=True, kw_only=True, tag="held_back"):
    """A unit's route is free, but it waits for another unit to come to the section; `why` says it in a sentence."""

    unit_id: str
    other_id: str
    section_id: str
    certificate: bool = False
    why: str


class OrderChanged(Noted, frozen=True, kw_only=True, tag="order_changed"):
    """The unit goes before the other, which is planned first; `why` says it in a sentence."""

    unit_id: str
    other_id: str
    why: str


class TrackChanged(Noted, frozen=True, kw_only=True, tag="track_changed"):
    """The manager orders a unit to the section, another track of its next station; `why` says it in a sentence."""

    unit_id: str
    section_id: str
    why: str


class TrainCut(Noted, frozen=True, kw_only=True, tag="train_cut"):
    """The manager orders a unit to end its train where it stands and go on as another; `why` says it in a sentence."""

    unit_id: str
    trains: tuple[str, ...]
    next_train: str
    why: str


class GoesOnAs(Noted, frozen=True, kw_only=True, tag="goes_on_as"):
    """A unit has reported that its train has ended where it stands, and that this one is its next."""

    unit_id: str
    train: str


class WaitBidden(Noted, frozen=True, kw_only=True, tag="wait_bidden"):
    """A dispatcher keeps a unit back for so long, or until the other has the section."""

    unit_id: str
    hold_s: float
    other_id: str = ""
    section_id: str = ""
    by: str


class WaitOver(Noted, frozen=True, kw_only=True, tag="wait_over"):
    """A unit that a dispatcher kept back may have its route: the other has the section, or somebody has said so."""

    unit_id: str
    by: str = ""


class TrainEndBidden(Noted, frozen=True, kw_only=True, tag="train_end_bidden"):
    """A dispatcher has a unit's train end where it stands, and its set go on as this one."""

    unit_id: str
    train: str
    by: str


class RouteAskedBack(Noted, frozen=True, kw_only=True, tag="route_asked_back"):
    """The manager wants a route back from a unit that has not left, for another; `why` says it in a sentence."""

    unit_id: str
    other_id: str
    route_id: str
    why: str


class NotDone(Noted, frozen=True, kw_only=True, tag="not_done"):
    """A unit has refused what the manager ordered about this route."""

    unit_id: str
    route_id: str
    why: str


class OrderLacking(Noted, frozen=True, kw_only=True, tag="order_lacking"):
    """No order of least delay is known, so of each two trains the order is that of less delay, as in `least_delay`."""

    why: str


class NoOrderKnown(Noted, frozen=True, kw_only=True, tag="no_order_known"):
    """No order is known in which all can finish, whoever goes next: these units are in each other's way. Where it is
    proven that there is none, routes are granted so that what is planned before some time can be run, or as without a
    certificate if there is no such time; where it is not, none is granted.
    """

    unit_ids: tuple[str, ...]
    why: str


class PointsCommanded(Noted, frozen=True, kw_only=True, tag="points_commanded"):
    """A terminal took a command: the points are the unit's until its section is another's."""

    unit_id: str
    section_id: str
    token: int
    points_id: str
    position: Position


class ThrowRefused(Noted, frozen=True, kw_only=True, tag="throw_refused"):
    """A terminal refused a command."""

    unit_id: str
    section_id: str
    token: int
    points_id: str
    why: str


class PointsProven(Noted, frozen=True, kw_only=True, tag="points_proven"):
    """A terminal proved position and lock to the unit that commanded."""

    unit_id: str
    section_id: str
    token: int
    points_id: str
    position: Position


class PointsUnproven(Noted, frozen=True, kw_only=True, tag="points_unproven"):
    """A terminal withdrew its proof, or the points did not come into position in time."""

    unit_id: str
    section_id: str
    token: int
    points_id: str
    why: str


ManagerNote = (
    Started
    | InputRefused
    | Granted
    | Refused
    | Freed
    | Leaving
    | Accepted
    | Outside
    | ConfirmedByHand
    | WordTaken
    | PictureChanged
    | TakenBack
    | Barred
    | Unbarred
    | ToBeSwept
    | Swept
    | Contradicted
    | Certified
    | HeldBack
    | OrderChanged
    | TrackChanged
    | TrainCut
    | GoesOnAs
    | WaitBidden
    | WaitOver
    | TrainEndBidden
    | RouteAskedBack
    | NotDone
    | OrderLacking
    | NoOrderKnown
    | TelegramDropped
    | TookEffect
)
TerminalNote = (
    Started
    | InputRefused
    | Refused
    | Barred
    | Unbarred
    | PointsCommanded
    | ThrowRefused
    | PointsProven
    | PointsUnproven
    | TelegramDropped
    | TookEffect
)
CrossingNote = (
    Started | InputRefused | Refused | CrossingWord | Barred | Unbarred | TelegramDropped | TookEffect
)
Note = ManagerNote | TerminalNote | CrossingNote
