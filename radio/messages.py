"""What is said over the radio: on-board units, block manager (閉そく管理装置), point terminals
(制御端末装置).

Frozen MessagePack records, each an array led by an integer tag. Section 2 of Sugiyama et al. 2017 gives the
exchange: request of the sections to the arrival track in one go, throw of the points inside them, release of
those passed. The manager never talks to a terminal (table 2), so a grant carries a capability per terminal.
Identifiers are those of `network.model`; a token is the fencing token of `wayside.block_manager`.

What a unit owes, so that no late answer gives it back what it has released:
- A request is repeated with the same correlation and contents until it is answered; a new one has a new
  correlation, from 1 up. RouteGranted takes effect once, for the request outstanding, and only if its token
  is greater than the unit's own.
- SignOnAccepted takes effect once, for the sign-on outstanding or the claim just made. A unit that knows
  what it holds takes token and capabilities from it, never sections.
- A refused claim, a confirmation of less than it holds, or Contested stops its train; it moves again when a
  HoldingConfirmed has all that it holds and nothing contested.
- HoldingConfirmed never adds a section. A unit may take a greater token from it or from SignOnAccepted, and
  then gives up the request outstanding.
- Every ClaimQuery is answered at once, with the whole of what is held and the correlation of the query. A
  unit that waits for its portal holds nothing yet. One that has booted, and was or may have been on the line
  before, does not know what it holds, whether or not its crew has entered a train number yet.
- TrackOrdered and TrainOrdered count for the request outstanding, RouteTakenBack under the token of the newest grant;
  a unit that cannot do it says OrderRefused. Silence gives nothing away: the request is open or the route held, as
  before.
- A unit drops a section before it reports; it repeats the sign-off until accepted, and reports when it is
  refused. Signed off, it holds its portal until its train is off the line.
"""

from __future__ import annotations

from enum import Enum

import msgspec

from network.model import Position


class RefusalReason(Enum):
    """Why the block manager refused."""

    UNDEFINED = 1  # a registered unit is unknown since the restart, or claims contradict each other
    HELD = 2  # another unit holds a section asked for
    UNKNOWN_ROUTE = 3  # no such route, or its sections are not those of the line file
    UNKNOWN_SECTION = 4
    NOT_CONNECTED = 5  # the unit holds neither the track the route leaves from nor a section of it
    NOT_SIGNED_ON = 6  # this boot of the unit has not signed on
    STILL_HOLDING = 7  # signs off while it holds more than a portal
    STALE_TOKEN = 8
    CLAIM_NEEDED = 9  # neither side knows what the unit holds: a person must say
    WRONG_UNIT = 10  # the unit named is not the one that sent it
    NO_WAY_ON = 11  # granted, not every train could still finish; named: who is waited for, to come where
    UNKNOWN_TOKEN = 13  # claimed under a token that was never granted
    NOT_ITS_TURN = 12  # another goes first by the order of trains; named likewise
    OVERLAP = 14  # another comes in whose overrun would foul the way there, or is in the way of one's own


class OrderRefusalReason(Enum):
    """Why a unit refused what the dispatcher ordered."""

    NOT_AT_A_STOP = 1  # it is under way, or does not know where it is
    UNKNOWN_TRACK = 2  # its train has no such way
    NOT_HELD = 3  # it has no such route ahead, or got it anew
    MAY_HAVE_ENTERED = 4  # its front may be on the route already
    UNKNOWN_TRAIN = 5  # its set has no such train that can begin where it stands


class PointsRefusalReason(Enum):
    """Why a point terminal refused."""

    UNKNOWN_POINTS = 1
    WRONG_SECTION = 2  # the points lie in another section
    BAD_CAPABILITY = 3  # the manager granted this to nobody, to another, or with another token
    OLD_TOKEN = 4  # a newer holder has commanded since
    LOCKED = 5  # this holder already has the points locked the other way
    NOT_DETECTED = 6  # thrown, but position or lock did not prove in time
    LOCKED_BY_HAND = 7  # a crew passes them on sight and has the key
    BARRED = 8  # persons have barred the unit


class Capability(msgspec.Struct, frozen=True, array_like=True):
    """Proof of a grant that one terminal can check offline; `mac` by `radio.keys.capability_mac`."""

    terminal_id: str
    section_id: str
    mac: bytes


class Message(msgspec.Struct, frozen=True, array_like=True):
    """Base of every message."""


class RouteRequest(Message, frozen=True, array_like=True, tag=1):
    """Unit to manager: the sections of a route up to and with the arrival track (閉そく確保要求), or those of them that
    lie ahead of a train on its way. `token`: the greatest that it knows.
    """

    unit_id: str
    route_id: str
    section_ids: tuple[str, ...]
    token: int = 0


class RouteGranted(Message, frozen=True, array_like=True, tag=2):
    """Manager to unit: all of them are yours under `token`; those of `on_sight` must be swept: run through on sight."""

    route_id: str
    section_ids: tuple[str, ...]
    token: int
    capabilities: tuple[Capability, ...]
    on_sight: tuple[str, ...] = ()


class RouteRefused(Message, frozen=True, array_like=True, tag=3):
    """Manager to unit: none of them is; `section_id` and `holder` name what stands against it, if known."""

    route_id: str
    reason: RefusalReason
    section_id: str | None = None
    holder: str | None = None


class HoldingReport(Message, frozen=True, array_like=True, tag=4):
    """Unit to manager: all that it holds now, in order of travel. What it no longer lists is free
    (閉そく解除). `swept`: what it has run through on sight from end to end, and found empty.
    """

    section_ids: tuple[str, ...]
    token: int
    swept: tuple[str, ...] = ()


class HoldingConfirmed(Message, frozen=True, array_like=True, tag=5):
    """Manager to unit: what the register says it holds, and its current token; the answer to every report.

    `contested`: what of it another claims, or may be in. While there is any, the train is not to move; `on_sight` as
    in a grant.
    """

    section_ids: tuple[str, ...]
    token: int
    contested: tuple[str, ...] = ()
    on_sight: tuple[str, ...] = ()


class SignOn(Message, frozen=True, array_like=True, tag=6):
    """Unit to manager: I am here and hold this; None: I have started again and do not know.

    A portal that the unit does not hold yet is a wish to enter there, and granted like a route.
    """

    unit_id: str
    section_ids: tuple[str, ...] | None
    token: int = 0


class SignOnAccepted(Message, frozen=True, array_like=True, tag=7):
    """Manager to unit: the answer to SignOn and Claim, all the unit holds. It may be more than it claimed.

    `on_sight` as in a grant.
    """

    section_ids: tuple[str, ...]
    token: int
    route_id: str | None
    capabilities: tuple[Capability, ...]
    on_sight: tuple[str, ...] = ()


class SignOnRefused(Message, frozen=True, array_like=True, tag=8):
    """Manager to unit: the claim cannot stand; `section_id` and `holder` name what it contradicts."""

    reason: RefusalReason
    section_id: str | None = None
    holder: str | None = None


class SignOff(Message, frozen=True, array_like=True, tag=9):
    """Unit to manager: I leave the line and hold nothing but my portal."""

    unit_id: str
    token: int


class SignOffAccepted(Message, frozen=True, array_like=True, tag=10):
    """Manager to unit: your train may leave; the portal is yours until it has."""


class SignOffRefused(Message, frozen=True, array_like=True, tag=11):
    """Manager to unit: you stay registered on the line."""

    reason: RefusalReason


class ClaimQuery(Message, frozen=True, array_like=True, tag=12):
    """Manager to unit: say what you hold. To be answered with a Claim of the same correlation."""


class Claim(Message, frozen=True, array_like=True, tag=13):
    """Unit to manager: what I hold and under which token; None: I do not know; empty: I am off the line."""

    section_ids: tuple[str, ...] | None
    token: int


class LeavingClaim(Claim, frozen=True, array_like=True, tag=24):
    """Unit to manager, in place of a Claim: I have signed off, and may still stand in this portal until I say that I do
    not.
    """


class PointsCommand(Message, frozen=True, array_like=True, tag=14):
    """Unit to terminal: throw and lock these points (転換指示). `mac` is that of the capability."""

    points_id: str
    position: Position
    section_id: str
    token: int
    mac: bytes


class PointsProof(Message, frozen=True, array_like=True, tag=15):
    """Terminal to unit: what is detected. Only `detected` and `locked` in the position asked for is a
    proof. What takes one back only restricts; it is said again until the points are commanded, or lie so.
    """

    points_id: str
    position: Position | None
    locked: bool
    detected: bool
    token: int


class PointsRefused(Message, frozen=True, array_like=True, tag=16):
    """Terminal to unit: the command with this token was not, or could not be, carried out."""

    points_id: str
    reason: PointsRefusalReason
    token: int


class Restarted(Message, frozen=True, array_like=True, tag=17):
    """Any device: your telegram was meant for my previous boot; send again. The envelope names the new
    boot.
    """


class Contested(Message, frozen=True, array_like=True, tag=18):
    """Manager to unit, unasked: of what you hold, another claims these, or may be in them: stop, and report.

    It only restricts. Lost, it is said again with the answer to every report, and while the contradiction lasts.
    """

    section_ids: tuple[str, ...]


class TrackOrdered(Message, frozen=True, array_like=True, tag=19):
    """Manager to unit, in answer to a request: not by this route; ask for `instead`, to another track of that station.

    Lost, the request is repeated and answered again.
    """

    route_id: str
    instead: str


class RouteTakenBack(Message, frozen=True, array_like=True, tag=20):
    """Manager to unit: set back the route granted under `token`, which you have not entered; ask for none for `hold_s`.

    It only restricts. Lost, it is said again when who waits for the line asks again.
    """

    route_id: str
    token: int
    hold_s: float


class OrderRefused(Message, frozen=True, array_like=True, tag=21):
    """Unit to manager: what was ordered about this route is not done. Lost, it is said again to the next such order."""

    route_id: str
    reason: OrderRefusalReason


class TrainOrdered(Message, frozen=True, array_like=True, tag=22):
    """Manager to unit, in answer to a request: end this train where it stands; your set goes on from there as `train`.

    Lost, the request is repeated and answered again.
    """

    route_id: str
    train: str


class NextTrainReport(Message, frozen=True, array_like=True, tag=23):
    """Unit to manager: a report of all that it holds; its train has ended there as ordered, and `train` is its next.

    Repeated until it is confirmed, as every report is; no train is taken up before.
    """

    section_ids: tuple[str, ...]
    token: int
    swept: tuple[str, ...]
    train: str


class CrossingRequest(Message, frozen=True, array_like=True, tag=26):
    """Unit to level crossing: my front can be on it in `arrives_s`, no sooner; I must know it closed in `proof_s`, or I
    brake. Both count from when it is sent.

    Repeated until the unit is over it, so that the crossing knows the time as it is now; lost, no proof comes.
    """

    arrives_s: float
    proof_s: float


class CrossingProof(Message, frozen=True, array_like=True, tag=27):
    """Level crossing to unit: whether it is closed, as detected. It holds for `valid_s`.

    Only `closed` is a proof; not closed takes back the one before. Lost, or late, it only restricts: the unit counts
    from when it first heard it, by its own clock.
    """

    closed: bool
    valid_s: float


class CrossingOver(Message, frozen=True, array_like=True, tag=28):
    """Unit to level crossing: nothing of my train is on it or comes onto it by what you told me; `passed`: it was.

    Repeated until it is heard; until then the crossing stays closed.
    """

    passed: bool


class CrossingOverHeard(Message, frozen=True, array_like=True, tag=29):
    """Level crossing to unit: you are not announced any more. Lost, the unit says it again and is answered again."""


class CrossingClear(Message, frozen=True, array_like=True, tag=30):
    """Level crossing that contacts control to unit (特殊信号発光機): whether no button is pressed and its detector sees
    nothing on it. It holds for `valid_s`.

    Only `clear` lets the unit pass; not clear takes back the one before. Lost, or late, it only restricts.
    """

    clear: bool
    valid_s: float


CrossingMessage = CrossingRequest | CrossingProof | CrossingOver | CrossingOverHeard | CrossingClear
AnyMessage = (
    RouteRequest
    | RouteGranted
    | RouteRefused
    | HoldingReport
    | HoldingConfirmed
    | SignOn
    | SignOnAccepted
    | SignOnRefused
    | SignOff
    | SignOffAccepted
    | SignOffRefused
    | ClaimQuery
    | Claim
    | PointsCommand
    | PointsProof
    | PointsRefused
    | Restarted
    | Contested
    | TrackOrdered
    | RouteTakenBack
    | OrderRefused
    | LeavingClaim
    | TrainOrdered
    | NextTrainReport
    | CrossingMessage
)
