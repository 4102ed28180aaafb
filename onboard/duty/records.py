"""What the duty machine works on: its state, what its sensors and its crew tell it, what it does.

Small and hashable: the place of the train is a handful of counts of joints, marks are indices, timers are names. The
plan and the times stand outside. All that crosses the unit's one door is a msgspec struct, so that a unit can be a
process of its own.
"""

from __future__ import annotations

import math
from enum import Enum
from typing import Final

import msgspec

from onboard.authority.records import Authority, Ordered, Timer
from onboard.authority.records import Event as AuthorityEvent
from onboard.duty.unable import Unable
from onboard.plan import DutyPlan, PointsNeeded


class DutyPhase(Enum):
    """Where the unit is in its duty."""

    OFF = "off"
    SIGNING_ON = "signing on"
    STANDING = "standing"
    RUNNING = "running"
    ON_SIGHT = "on sight"  # switched on again, or lost its position, until all is known again
    FINISHED = "finished"
    SIGNING_OFF = "signing off"
    LEAVING = "leaving"  # signed off; its train may still stand in its portal
    GONE = "gone"


AT_A_MARK: Final = (DutyPhase.STANDING, DutyPhase.FINISHED, DutyPhase.SIGNING_OFF)

ASK: Final = Timer("ask")  # a route is asked for some time before the departure
LEAVE: Final = Timer("leave")  # the departure, after the dwell
RELEASE: Final = Timer("release")  # the driver's acknowledgement after an emergency stop
ABLE: Final = Timer("able")  # a train that is unable to leave looks again


class PlaceInJoints(msgspec.Struct, frozen=True):
    """Where the train is by its own localisation, in joints; `onboard.motion` makes it of metres.

    `sure` and `perhaps` count the spans whose beginning the front has surely, or perhaps, passed; `clear` those that
    the safe rear has left, `clear_at_mark` the same for a train whose driver sees that it stands at its mark.
    `here` is the span of the estimate, `reach` the first joint that lies far enough ahead to start for it. `near` is
    the stop whose mark is near (-1: none), `passed` the last one whose mark has been passed. `unfit`: what
    is wrong with the vehicle, wherever it is; empty: nothing. `unable`: at a stop, why the train could not reach the
    next one if it left now. `unsure`: its bounds leave open whether it stands at its mark, as it reads no
    tags or they keep it short of it, and it waits for the driver's word. `untold`, of a train without a reader of tags:
    it was found by what does not tell tracks apart, so that the register must have it there, too. `crossing`: the level
    crossing ahead that a train that stands waits for; its unit fills it in.
    """

    known: bool = False
    covered: bool = True
    stands: bool = True
    emergency: bool = False
    here: int = 0
    sure: int = 0
    perhaps: int = 0
    clear: int = 0
    clear_at_mark: int = 0
    reach: int = 0
    near: int = -1
    passed: int = 0
    unfit: str = ""
    unable: Unable | None = None
    unsure: bool = False
    untold: bool = False
    crossing: str = ""


class StopLimit(msgspec.Struct, frozen=True):
    """Where the train must stop (停止限界点): a joint, and the section beyond it that it may not enter."""

    joint: int
    before: str | None
    why: str


class DutyState(msgspec.Struct, frozen=True):
    """The state. `at`: the stop where the train stands or that it left last; `stands_at`: the stop at which a train
    without a position stands, by its crew. `wanted`: points to be thrown as soon as and whenever they can be;
    `entered`: points sections that the train came onto by their proof. `proved`: spans that the tags read so far prove
    to be behind the train; `freed`: those of them that are to be given back, the arrival being told, or each at once.
    `halted`: braked because register and unit contradict each other; `seeks_radio`: on sight all the same, within where
    it stands, to where it can be heard; `listens`: without a position, it has heard nothing since its driver was
    asked to acknowledge that; `sweeps`: runs on sight through what it holds.
    `unable`: why it may not leave its stop, as its driver was told. `ordered`: the route by which the dispatcher wants
    it to go instead of the one that it asks for, until its driver has taken up that way; `next_train`: as which train
    he wants its set to go on from here, until its driver has ended this one.
    """

    phase: DutyPhase = DutyPhase.OFF
    place: PlaceInJoints = PlaceInJoints()
    authority: Authority = Authority()
    at: int = 0
    stands_at: int | None = None
    wanted: tuple[PointsNeeded, ...] = ()
    entered: frozenset[str] = frozenset()
    proved: int = 0
    freed: int = 0
    limit: StopLimit = StopLimit(0, None, "no mission")
    halted: bool = False
    seeks_radio: bool = False
    listens: bool = False
    sweeps: bool = False
    may_ask: bool = False
    may_leave: bool = False
    released: bool = True  # no emergency stop waits for the driver's acknowledgement
    unable: Unable | None = None
    ordered: str = ""
    next_train: str = ""

    @property
    def must_stand(self) -> bool:
        """Halted, and not on its way to where it can be heard."""
        return self.halted and not self.seeks_radio


# events: people -------------------------------------------------------------------------------------------------


class Begin(msgspec.Struct, frozen=True, tag=True):
    """The crew has entered the train number at the first stop; `signs_on`: the stock comes onto the line."""

    plan: DutyPlan
    signs_on: bool


class SwitchedOn(msgspec.Struct, frozen=True, tag=True):
    """Power is back: the crew enters the train number and, if it stands at one, the stop (復旧)."""

    plan: DutyPlan
    stands_at: int | None
    epoch: int = 0  # of this boot; the unit fills it in


class TakeUpWay(msgspec.Struct, frozen=True, tag=True):
    """The driver has taken up the way ordered: the same train, from where it stands by another route, or to no further
    than there.
    """

    plan: DutyPlan


class NoSuchWay(msgspec.Struct, frozen=True, tag=True):
    """The train has no way on by the route ordered, or its set no such train from where it stands."""


class ChangeEnds(msgspec.Struct, frozen=True, tag=True):
    """The driver has changed ends; the next train number follows."""


class Leave(msgspec.Struct, frozen=True, tag=True):
    """The train leaves the line from its portal."""


class OffTheLine(msgspec.Struct, frozen=True, tag=True):
    """The whole train has left the line by its portal."""


class SetBack(msgspec.Struct, frozen=True, tag=True):
    """The crew sets back the route ahead, and asks for none for `hold_s` (進路取消)."""

    hold_s: float


class PointsSeen(msgspec.Struct, frozen=True, tag=True):
    """The crew has seen that points ahead lie as needed; `under`: its train stands on them."""

    points: PointsNeeded
    under: bool = False


class PointsWrong(msgspec.Struct, frozen=True, tag=True):
    """The crew stands before points that lie otherwise, and has the unit command them if it holds them."""

    points: PointsNeeded


class AtMark(msgspec.Struct, frozen=True, tag=True):
    """The driver has brought the whole train to a stand at a stop, and sees so (到着確認).

    `beyond_m`: how far beyond the mark it stands by his eye, to the nearest ten metres.
    """

    stop: int
    beyond_m: float = 0.0


class EndOfHeld(msgspec.Struct, frozen=True, tag=True):
    """On sight, a train stands where what is held ends; its driver sees in which span of the plan it is."""

    span: int


class NotAtMark(msgspec.Struct, frozen=True, tag=True):
    """Asked whether the whole train is at its mark, the driver sees that it is not."""


class CreepOver(msgspec.Struct, frozen=True, tag=True):
    """The driver, standing before a level crossing that has not proved closed, has leave to creep over it; `guarded`:
    by the word of somebody who has stopped its road.
    """

    crossing_id: str
    guarded: bool = False


# events: localisation and driving --------------------------------------------------------------------------------


class TagBelieved(msgspec.Struct, frozen=True, tag=True):
    """A tag was read and believed; `tag` is its index on the plan. `found`: before it the position was unknown.

    On a train without a reader of tags, fixes prove that its front is beyond the tag's place (仮想地上子).
    """

    tag: int
    found: bool


class TagReached(msgspec.Struct, frozen=True, tag=True):
    """On a train without a reader of tags: by its estimate the front is at a tag's place, and nothing proves it."""

    tag: int


class FoundByOtherSensor(msgspec.Struct, frozen=True, tag=True):
    """Another sensor than the reader of tags, or the driver's eye, has told the position, which was unknown."""


class PositionLost(msgspec.Struct, frozen=True, tag=True):
    """The position cannot be trusted any more (位置検知異常, table 5)."""


class WheelsTurning(msgspec.Struct, frozen=True, tag=True):
    """The wheels have begun to turn."""


class MarkRelation(Enum):
    """How the train stands with respect to its next mark."""

    SHORT = "short"
    AT = "at"
    BEYOND = "beyond"


class Stopped(msgspec.Struct, frozen=True, tag=True):
    """The train has come to a stand, `away_m` beyond the mark where it is to stop next; `how`: judged by that."""

    how: MarkRelation
    away_m: float


class Looked(msgspec.Struct, frozen=True, tag=True):
    """The place has changed: a joint was passed, the radio reaches again, or the train can do more or less."""


class VehicleChecked(msgspec.Struct, frozen=True, tag=True):
    """What the vehicle shows of itself has changed; the place has what is wrong."""


# events: time and radio ------------------------------------------------------------------------------------------


class TimerDue(msgspec.Struct, frozen=True, tag=True):
    """A timer has run out."""

    timer: Timer


class TelegramHeard(msgspec.Struct, frozen=True, tag=True):
    """A telegram, as it relates to what is open."""

    event: AuthorityEvent


Person = (
    Begin
    | SwitchedOn
    | TakeUpWay
    | NoSuchWay
    | ChangeEnds
    | Leave
    | OffTheLine
    | SetBack
    | PointsSeen
    | PointsWrong
    | AtMark
    | NotAtMark
    | EndOfHeld
)
Sensed = (
    TagBelieved
    | TagReached
    | FoundByOtherSensor
    | PositionLost
    | WheelsTurning
    | Stopped
    | Looked
    | VehicleChecked
)
Happening = Person | Sensed | CreepOver  # the last for the unit's crossings alone
Event = Person | Sensed | TimerDue | TelegramHeard | Ordered


# actions ----------------------------------------------------------------------------------------------------------


class SetTimerAt(msgspec.Struct, frozen=True, tag=True):
    """Start a timer anew: it runs out when the unit's clock shows `at_s`, and not before `after_s` have passed."""

    timer: Timer
    at_s: float
    after_s: float = 0.0


class Finished(msgspec.Struct, frozen=True, tag=True):
    """To the driver: the plan's last stop is reached and the sections behind are given back."""

    number: str


class LeftLine(msgspec.Struct, frozen=True, tag=True):
    """To the driver: signed off, the train may be taken off the line."""

    number: str


class EntryAllowed(msgspec.Struct, frozen=True, tag=True):
    """To the driver: signed on; who waits outside may enter the portal."""

    number: str


class WayOrdered(msgspec.Struct, frozen=True, tag=True):
    """To the driver: the dispatcher wants the train to go by another route than this one."""

    route_id: str
    instead: str


class TrainEndsHere(msgspec.Struct, frozen=True, tag=True):
    """To the driver: the dispatcher wants the train to end where it stands, and its set to go on as another train."""

    train: str


Told = Finished | LeftLine | EntryAllowed | WayOrdered | TrainEndsHere


class DrivingOrder(Enum):
    """What the driving part is told once, besides what the command says for as long as it stands."""

    DEPART = "depart"
    RELEASE = "release"
    RESUME = "resume"
    STOP = "stop"  # by the emergency brake
    LOSE = "lose"  # the position is of no use here: on sight from now on


class CrossingCommand(msgspec.Struct, frozen=True):
    """What level crossings mean to the driving part and the driver, by their ids; empty: none.

    `before`: the one before which the limit lies, `guarded`: that at which it must lie should nobody say more, `at`:
    the one that keeps it standing; `creeps`: over one on sight. `look_s`: when, by its clock, it is to look again if
    its front is not surely on `unless_on` by then.
    """

    before: str = ""
    guarded: str = ""
    at: str = ""
    creeps: bool = False
    unless_on: str = ""
    look_s: float = math.inf


class DrivingCommand(msgspec.Struct, frozen=True):
    """What the unit wants of its driving part: run or stand, how far, and what to watch for.

    `target`: the stop to run to; None: none. `rear`: the span that the safe rear is to leave next. What is held
    and proven, and what the train waits for, is shown to the driver. `sweeps`: what is held must first be passed on
    sight; `confirm`: the driver is asked whether the whole train is at its mark; `unable`: told why the train may not
    leave. `within_section`: on sight, no further than the end of that where it stands. `orders` are given once.
    """

    drive: bool = False
    on_sight: bool = False
    at_mark: bool = False
    target: int | None = None
    at: int = 0
    stands_at: int | None = None
    limit: StopLimit = StopLimit(0, None, "no mission")
    rear: int | None = None
    await_radio: bool = False
    orders: tuple[DrivingOrder, ...] = ()
    on_line: bool = False
    held: tuple[str, ...] = ()
    proven: tuple[PointsNeeded, ...] = ()
    waits_for: str = ""
    sweeps: bool = False
    within_section: bool = False
    confirm: bool = False
    unable: Unable | None = None
    crossings: CrossingCommand = CrossingCommand()
