"""What the authority machine works on: its state, the events it takes and the actions it returns.

Everything is symbolic, so that a state is hashable as it stands and small: sections by id, an open request by its
name, a timer by its name. Tokens, correlations and capabilities stand in `onboard.authority.letters`, which tells the
machine of each telegram only how it relates to what is open: does it answer that, is its token newer.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

import msgspec

from onboard import notes
from onboard.plan import PointsNeeded
from radio.messages import OrderRefusalReason


class RequestKind(Enum):
    """What may be open with the block manager, at most one of each."""

    SIGN_ON = "sign on"
    SIGN_OFF = "sign off"
    ROUTE = "route"
    REPORT = "report"


class Timer(NamedTuple):
    """A timer by its name; `of` is the set of points of a command, or empty."""

    name: str
    of: str = ""


class OpenRequest(msgspec.Struct, frozen=True):
    """The record of an open request. Not `sent`: due as soon as the radio reaches; sent: its timer runs.

    `subject`: the route asked for; `section_ids`: its sections, or those of a sign-on (None: does not know).
    `refusal`: why it was not granted the last time; `swept`: with a report, as there. Of a report the subject is the
    next train of a set whose train has ended early.
    """

    ask: RequestKind
    subject: str = ""
    section_ids: tuple[str, ...] | None = ()
    sent: bool = False
    refusal: str = ""
    swept: tuple[str, ...] = ()

    @property
    def timer(self) -> Timer:
        """When it is repeated."""
        return Timer(self.ask.value)


class OpenCommand(msgspec.Struct, frozen=True):
    """A points command not yet proven; `sent` and `refusal` as in a request."""

    needed: PointsNeeded
    sent: bool = False
    refusal: str = ""

    @property
    def timer(self) -> Timer:
        """When it is repeated."""
        return Timer("points", self.needed.points_id)


class Authority(msgspec.Struct, frozen=True):
    """The state. `held`: sections in order of travel; `commandable`: those of them granted with a capability.
    `leaving`: signed off, with its train still in its portal, which it holds until that is off the line.

    `unsaid`: points not commanded any more, of which a proof still counts. `entering`: the sign-on is a wish for a
    portal, so until it is accepted nothing is held. `mismatch`: why register and unit contradict each other, if they
    do. `unswept`: sections held that must be passed on sight; `swept`: those that were, until that is confirmed.
    `unsure`: it has booted, was perhaps on the line before, and its crew has not yet entered a train number.
    """

    held: tuple[str, ...] = ()
    commandable: tuple[str, ...] = ()
    on_line: bool = False  # signed on and not signed off
    leaving: bool = False
    entering: bool = False
    requests: tuple[OpenRequest, ...] = ()
    commands: tuple[OpenCommand, ...] = ()
    proven: tuple[PointsNeeded, ...] = ()
    unsaid: tuple[PointsNeeded, ...] = ()
    mismatch: str = ""
    unswept: tuple[str, ...] = ()
    swept: tuple[str, ...] = ()
    unsure: bool = False

    def holds(self, section_id: str) -> bool:
        """Whether the unit holds a section."""
        return section_id in self.held

    def open(self, ask: RequestKind) -> OpenRequest | None:
        """The open request of a kind."""
        return next((request for request in self.requests if request.ask is ask), None)

    @property
    def perhaps_on_line(self) -> bool:
        """Whether it may stand on the line: it never says then, after a boot, that it holds nothing."""
        claims = self.open(RequestKind.SIGN_ON) is not None and not self.entering
        return self.unsure or self.on_line or self.leaving or claims

    @property
    def waits_for_radio(self) -> bool:
        """Whether something is due that could not be sent for want of coverage."""
        return any(not request.sent for request in self.requests) or any(not c.sent for c in self.commands)


# events: from the duty ------------------------------------------------------------------------------------------


class BeginOnLine(msgspec.Struct, frozen=True, tag=True):
    """The train has come onto the line and claims these sections; None: switched on, it knows nothing."""

    section_ids: tuple[str, ...] | None
    enters: bool = False  # a wish for a portal, not a fact


class FoundAt(msgspec.Struct, frozen=True, tag=True):
    """Its position was found again: the train is, or may be, in these sections, not all of which it holds."""

    section_ids: tuple[str, ...]


class EndOnLine(msgspec.Struct, frozen=True, tag=True):
    """The train leaves the line; it holds nothing but its portal."""


class TakenOff(msgspec.Struct, frozen=True, tag=True):
    """The train of a unit that has signed off is wholly off the line."""


class AskRoute(msgspec.Struct, frozen=True, tag=True):
    """Ask for a route (閉そく確保要求)."""

    route_id: str
    section_ids: tuple[str, ...]


class Throw(msgspec.Struct, frozen=True, tag=True):
    """Command points inside what is held (転換指示)."""

    points: tuple[PointsNeeded, ...]


class CheckedByCrew(msgspec.Struct, frozen=True, tag=True):
    """The crew has seen that these points lie and are locked as the path needs them (開通方向の確認)."""

    points: PointsNeeded


class Withdrawn(msgspec.Struct, frozen=True, tag=True):
    """The front may have come onto points of these sections: they must not be asked to move any more."""

    section_ids: tuple[str, ...]


class Cleared(msgspec.Struct, frozen=True, tag=True):
    """The safe rear has left these sections."""

    section_ids: tuple[str, ...]


class GiveBack(msgspec.Struct, frozen=True, tag=True):
    """The train stands and surely short of these sections: it gives up the route not entered (進路取消).

    `next_train`: it ends there, and its set goes on as that; empty: it does not.
    """

    section_ids: tuple[str, ...]
    next_train: str = ""


class TurnedBack(msgspec.Struct, frozen=True, tag=True):
    """The train changed ends: what was behind is ahead; proofs made for the old path are forgotten."""


class RepeatDue(msgspec.Struct, frozen=True, tag=True):
    """The timer of a request or command has run out; None: the radio reaches again."""

    timer: Timer | None


# events: telegrams, as they relate to what is open ------------------------------------------------------------


class SignOnHeard(msgspec.Struct, frozen=True, tag=True):
    """The manager accepted a sign-on or a claim: it has the unit with these sections."""

    section_ids: tuple[str, ...]
    commandable: tuple[str, ...]
    answers: bool
    newer: bool
    on_sight: tuple[str, ...] = ()


class RefusalHeard(msgspec.Struct, frozen=True, tag=True):
    """The manager refused what is open; `lost_sight`: it does not know the unit as the unit knows itself."""

    ask: RequestKind
    subject: str
    why: str
    lost_sight: bool
    answers: bool


class SignOffHeard(msgspec.Struct, frozen=True, tag=True):
    """The manager has the unit off the line."""

    answers: bool


class GrantHeard(msgspec.Struct, frozen=True, tag=True):
    """The manager grants a route. `fresh`: it has heard this boot; `newer`: by its token."""

    route_id: str
    section_ids: tuple[str, ...]
    commandable: tuple[str, ...]
    answers: bool
    fresh: bool
    newer: bool
    on_sight: tuple[str, ...] = ()


class ConfirmationHeard(msgspec.Struct, frozen=True, tag=True):
    """What the register has for the unit, after a report; `contested`: some of it is."""

    section_ids: tuple[str, ...]
    answers: bool
    newer: bool
    contested: tuple[str, ...] = ()
    on_sight: tuple[str, ...] = ()


class ContestHeard(msgspec.Struct, frozen=True, tag=True):
    """The manager says that another claims, or may be in, what the unit holds."""

    section_ids: tuple[str, ...]


class QueryHeard(msgspec.Struct, frozen=True, tag=True):
    """The manager asks what the unit holds."""


class EarlierBootCalled(msgspec.Struct, frozen=True, tag=True):
    """The manager speaks to an earlier boot of the unit: it has not heard of this one."""


class ProofHeard(msgspec.Struct, frozen=True, tag=True):
    """A terminal shows points: `position` None where none is detected and locked; `mine`: under the token commanded, in
    answer to the command as it was given last.
    """

    points_id: str
    terminal_id: str
    position: str | None
    mine: bool


class PointsDenialHeard(msgspec.Struct, frozen=True, tag=True):
    """A terminal refuses a command; `mine`: under the token commanded; `stale`: the unit's grant is not the newest."""

    points_id: str
    terminal_id: str
    why: str
    mine: bool
    stale: bool = False


class PeerRestarted(msgspec.Struct, frozen=True, tag=True):
    """A device has started again: nothing that was sent before is known to have arrived."""


# for the duty: what the dispatcher orders -----------------------------------------------------------------------


class TrackChangeOrdered(msgspec.Struct, frozen=True, tag=True):
    """The manager wants the train to go by another route than the one asked for; `answers`: the request outstanding."""

    route_id: str
    instead: str
    answers: bool


class TrainEndOrdered(msgspec.Struct, frozen=True, tag=True):
    """The manager wants the train to end where it stands, and its set to go on as `train`; `answers`: as above."""

    route_id: str
    train: str
    answers: bool


class TakeBackOrdered(msgspec.Struct, frozen=True, tag=True):
    """The manager wants a route back that was not entered; `newest`: the one granted last."""

    route_id: str
    newest: bool
    hold_s: float


Ordered = TrackChangeOrdered | TrainEndOrdered | TakeBackOrdered


Event = (
    BeginOnLine
    | FoundAt
    | EndOnLine
    | TakenOff
    | AskRoute
    | Throw
    | CheckedByCrew
    | Withdrawn
    | Cleared
    | GiveBack
    | TurnedBack
    | RepeatDue
    | SignOnHeard
    | RefusalHeard
    | SignOffHeard
    | GrantHeard
    | ConfirmationHeard
    | ContestHeard
    | QueryHeard
    | EarlierBootCalled
    | ProofHeard
    | PointsDenialHeard
    | PeerRestarted
)


# actions --------------------------------------------------------------------------------------------------------


class Renew(msgspec.Struct, frozen=True, tag=True):
    """From here on this is a new request: an answer to the one before it fits no more."""

    ask: RequestKind


class Commit(msgspec.Struct, frozen=True, tag=True):
    """Points are commanded anew, under the token their section is held with now."""

    needed: PointsNeeded


class Take(msgspec.Struct, frozen=True, tag=True):
    """Take the token of the telegram at hand: for these sections, and where it has capabilities for what is held."""

    section_ids: tuple[str, ...]


class SendRequest(msgspec.Struct, frozen=True, tag=True):
    """Say it to the manager: the request open under this name, as it stands."""

    request: OpenRequest


class SendClaim(msgspec.Struct, frozen=True, tag=True):
    """Answer the query at hand; None: it does not know what it holds. `leaving`: it has signed off."""

    section_ids: tuple[str, ...] | None
    leaving: bool = False


class SendRefusal(msgspec.Struct, frozen=True, tag=True):
    """Tell the manager that what it ordered about this route is not done."""

    route_id: str
    reason: OrderRefusalReason


class SendCommand(msgspec.Struct, frozen=True, tag=True):
    """Command points of their terminal."""

    needed: PointsNeeded


class SetTimer(msgspec.Struct, frozen=True, tag=True):
    """Start a timer anew."""

    timer: Timer
    after_s: float


class StopTimer(msgspec.Struct, frozen=True, tag=True):
    """Stop a timer; nothing happens if it does not run."""

    timer: Timer


class Write(msgspec.Struct, frozen=True, tag=True):
    """A line for the journal; `onboard.authority.letters` adds tokens."""

    note: notes.Note


Action = (
    Renew | Commit | Take | SendRequest | SendClaim | SendRefusal | SendCommand | SetTimer | StopTimer | Write
)
