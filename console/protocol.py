"""What pages and panels say to the desk and hear from it: one type a message, JSON on a WebSocket, a version.

The first message of a connection is `hello`; each further one has a number of the sender's own, which its answer
bears. Times are s since midnight, kilometrages m. `python -m documents.desk_protocol` writes the JSON Schema.
"""

from __future__ import annotations

from enum import Enum
from typing import Annotated, Any, Final

import msgspec

from console import line_drawn
from console.pacing import FASTEST
from console.seats import Seat
from network.errors import InputError
from network.files.text_input import check_nesting

VERSION: Final = 3
MESSAGE_BYTES_MAX: Final = 16_384


class Said(msgspec.Struct, frozen=True, kw_only=True, tag_field="say", forbid_unknown_fields=True):
    """What every message has: its word, `say`."""


# from a page ----------------------------------------------------------------------------------------------------------


class Hello(Said, frozen=True, kw_only=True, tag="hello"):
    """Somebody takes a seat; `token` where the desk listens to other machines, `unit`: of which train, for a driver."""

    seat: Seat
    unit: str = ""
    token: str = ""
    version: int = VERSION


class NumberedRequest(Said, frozen=True, kw_only=True):
    """What has an answer."""

    number: int = 0


class MessageNumber(msgspec.Struct, frozen=True):
    """The number of a message, whatever else it has."""

    number: int = 0


class SetPace(NumberedRequest, frozen=True, kw_only=True, tag="pace"):
    """Run so many times as fast as real time; 0: stand."""

    factor: Annotated[float, msgspec.Meta(ge=0.0, le=FASTEST)]


class OneStep(NumberedRequest, frozen=True, kw_only=True, tag="one_step"):
    """Go on by one step, 0.1 s, and stand."""


class NextEvent(NumberedRequest, frozen=True, kw_only=True, tag="next_event"):
    """Go on to where the next thing happens or is due, and stand."""


class RunTo(NumberedRequest, frozen=True, kw_only=True, tag="run_to"):
    """Run to a time as fast as possible, and stand."""

    time_s: Annotated[float, msgspec.Meta(ge=0.0, le=200_000.0)]


class GoBack(NumberedRequest, frozen=True, kw_only=True, tag="go_back"):
    """Be where the run was at a time; what was done after it is undone."""

    time_s: Annotated[float, msgspec.Meta(ge=0.0, le=200_000.0)]


class Fail(NumberedRequest, frozen=True, kw_only=True, tag="fail"):
    """A fault begins: a `[[fault]]` of docs/faults.md without its `start`."""

    fault: dict[str, Any]


class EndFault(NumberedRequest, frozen=True, kw_only=True, tag="end_fault"):
    """A fault that was begun here is over; `deed` is its number."""

    deed: int


class DoAct(NumberedRequest, frozen=True, kw_only=True, tag="act"):
    """A person acts: an `[[act]]` of docs/files/scenario.md without its `start`."""

    act: dict[str, Any]


class ChangeFault(NumberedRequest, frozen=True, kw_only=True, tag="change_fault"):
    """A fault in force that was begun here goes on with other figures: the keys of its kind that change."""

    deed: int
    keys: dict[str, Any]


class ArmScript(NumberedRequest, frozen=True, kw_only=True, tag="arm"):
    """Faults and acts for later: each a `[[fault]]` or `[[act]]` with its `start`, a time to come."""

    faults: tuple[dict[str, Any], ...] = ()
    acts: tuple[dict[str, Any], ...] = ()


class SayToSeat(NumberedRequest, frozen=True, kw_only=True, tag="tell"):
    """The instructor has a message for a seat; None: for all."""

    text: Annotated[str, msgspec.Meta(min_length=1, max_length=400)]
    seat: Seat | None = None


class AskProtocol(NumberedRequest, frozen=True, kw_only=True, tag="protocol"):
    """The answer has the protocol of what was done until now, as JSON (`console.score.DeskScore`)."""


class SaveDrill(NumberedRequest, frozen=True, kw_only=True, tag="save"):
    """The answer has all that was done as a drill file."""

    id: Annotated[str, msgspec.Meta(max_length=64)]
    title: Annotated[str, msgspec.Meta(max_length=200)] = ""


Request = (
    SetPace
    | OneStep
    | NextEvent
    | RunTo
    | GoBack
    | Fail
    | EndFault
    | ChangeFault
    | ArmScript
    | DoAct
    | SayToSeat
    | AskProtocol
    | SaveDrill
)


# to a page ------------------------------------------------------------------------------------------------------------


class DeskAnswer(Said, frozen=True, kw_only=True, tag="answer"):
    """What came of the message with this number; `why` it was refused, `text` of a drill, `deed` that was done."""

    number: int
    good: bool
    why: str = ""
    text: str = ""
    deed: int | None = None


class SectionState(Enum):
    """A section as the block manager has it."""

    FREE = "free"
    HELD = "held"
    UNDEFINED = "undefined"


class Welcome(Said, frozen=True, kw_only=True, tag="welcome"):
    """The seat is taken: what does not change while the run goes on. `acts` and `faults` are what this seat may do.

    `works` and `posts`: substitute working, where the scenario has it, and which roles of it this seat may take.
    `leads`: it may say how fast time goes; `replay`: of a run that has ended, between those two times.
    """

    version: int
    seat: Seat
    run: str
    name: str
    line: str
    line_ja: str
    stations: tuple[line_drawn.StationDrawn, ...]
    sections: tuple[line_drawn.SectionDrawn, ...]
    points: tuple[line_drawn.PointsDrawn, ...]
    units: tuple[str, ...]
    crossings: tuple[line_drawn.CrossingDrawn, ...] = ()
    plan: tuple[line_drawn.TrainOnPlan, ...]
    acts: tuple[str, ...]
    faults: tuple[line_drawn.FaultKind, ...]
    works: tuple[line_drawn.WorkDrawn, ...] = ()
    posts: tuple[line_drawn.PostDrawn, ...] = ()
    leads: bool = False
    replay: bool = False
    begin_s: float = 0.0
    end_s: float = 0.0


class SectionShown(msgspec.Struct, frozen=True, kw_only=True):
    """A section as the manager shows it, and whose it is."""

    id: str
    state: SectionState
    unit: str = ""


class TrainShown(msgspec.Struct, frozen=True, kw_only=True):
    """A train as it was last heard of: where it last stood or left, when, how late, and what the manager has as its.

    For a seat that sees the truth also where it is, how fast, and what it waits for.
    """

    unit: str
    train: str = ""
    station: str = ""
    heard_s: float | None = None
    late_s: float | None = None
    sections: tuple[str, ...] = ()
    at_m: float | None = None
    section: str = ""
    speed_mps: float | None = None
    waits_for: str = ""
    waits_for_ja: str = ""


class PointsShown(msgspec.Struct, frozen=True, kw_only=True):
    """Points as they truly lie; `position` empty: in neither."""

    id: str
    position: str
    state: str


class RoadState(Enum):
    """The road of a level crossing, as far as a seat knows it."""

    OPEN = "open"
    WARNING = "warning"  # it begins to close
    CLOSED = "closed"  # and has proved so
    UNPROVEN = "not proven"
    CLEAR = "nothing known on it"  # contacts close it, and it tells units this alone
    OPENING = "opening"
    ASKED = "asked"  # by a unit, which has no proof yet
    UNHEARD = "no word"


class CrossingKnown(msgspec.Struct, frozen=True, kw_only=True):
    """A level crossing with a device: by what it has said by radio, a word later than `heard_s` being missing, to a
    driver's seat by what the own unit has heard; in truth for a seat that sees that.

    `announced`: units that come, as its device has taken; `creeps`: those with leave to creep over it; `guarded`: by
    somebody on the spot. `occupied` (a vehicle stands on it) and `why` it is not proven: for who sees the truth.
    """

    id: str
    state: RoadState
    announced: tuple[str, ...] = ()
    creeps: tuple[str, ...] = ()
    guarded: bool = False
    occupied: bool = False
    why: str = ""
    why_ja: str = ""
    heard_s: float | None = None


class EventShown(msgspec.Struct, frozen=True, kw_only=True):
    """Something that a person should hear of, in both languages."""

    time_s: float
    who: str
    who_ja: str
    text: str
    text_ja: str
    alarm: bool


class TrainForecast(msgspec.Struct, frozen=True, kw_only=True):
    """How a train will go on, as the dispatcher's rules have it: times (s) and kilometrages (m)."""

    train: str
    times_s: tuple[int, ...]
    at_m: tuple[int, ...]


class BidShown(msgspec.Struct, frozen=True, kw_only=True):
    """A train that a dispatcher keeps back: until when, and behind which other over which section."""

    unit: str
    until_s: float
    behind: str = ""
    section: str = ""


class StepState(Enum):
    """How far a step of substitute working is."""

    DONE = "done"
    LEFT_OUT = "left out"
    UNDER_WAY = "under way"
    NEXT = "next"  # all that it needs is done, and the world lets it
    WAITS = "waits"  # all that it needs is done
    LATER = "later"


class StepShown(msgspec.Struct, frozen=True, kw_only=True):
    """A step of a section or station at present, and whose it is."""

    step: str
    state: StepState
    posts: tuple[str, ...]


class WorkShown(msgspec.Struct, frozen=True, kw_only=True):
    """The book of a section or station while substitute working is in force: the train in it, where the pilot is by it
    (a station, or the unit of the train that he rides), and each step of its table.
    """

    block: str
    train: str
    pilot: str
    steps: tuple[StepShown, ...]


class CrossingInCab(msgspec.Struct, frozen=True, kw_only=True):
    """The next level crossing before a train that its unit asks: how far ahead of the front, m (None: it does not
    know), what the unit has heard of it, and whether the driver has leave to creep over it.
    """

    name: str
    ahead_m: float | None
    state: RoadState
    creeps: bool


class CabShown(msgspec.Struct, frozen=True, kw_only=True):
    """What the unit shows its driver. Distances from the front, m, None: it does not know; speeds m/s, notches above 0
    power. `target_mps`: what automatic driving would stay under; `why`: why its authority ends there.
    """

    unit: str
    train: str
    powered: bool
    speed_mps: float
    permitted_mps: float | None
    target_mps: float
    notch: float
    by_hand: bool
    handle: float
    power_notches: int
    brake_notches: int
    intervention: int
    may_drive: bool
    on_sight: bool
    authority_m: float | None
    why: str
    why_ja: str
    next_stop: str
    next_stop_m: float | None
    arrives_s: float | None
    departs_s: float | None
    held: tuple[str, ...]
    waits_for: str
    waits_for_ja: str
    crossing: CrossingInCab | None = None


class SeatMessage(msgspec.Struct, frozen=True, kw_only=True):
    """What the instructor has said to a seat, or to all (`seat` is empty)."""

    time_s: float
    text: str
    seat: str = ""


class GraphPoint(msgspec.Struct, frozen=True, kw_only=True):
    """A train has stood, or left, at a kilometrage."""

    train: str
    time_s: float
    at_m: float


class DeedShown(msgspec.Struct, frozen=True, kw_only=True):
    """What was done here; `ends`: a fault in force that can be ended."""

    deed: int
    time_s: float
    text: str
    text_ja: str
    ends: bool


class RuleShown(msgspec.Struct, frozen=True, kw_only=True):
    """A checker: how often its rule was broken, and how first."""

    rule: str
    broken: int
    first: str = ""


class State(Said, frozen=True, kw_only=True, tag="state"):
    """The present; `digest` of a run that has ended, as its drill has it.

    `events` and `graph` go on from the last state that this connection had; a new `branch` begins anew. `deeds`,
    `rules`, `points` and `silent` (devices and units without power) are for seats that see the truth, `forecast` for
    those and the dispatcher's, `cab` for a driver's; a `forecast` that is null is as it was. `roles` of substitute
    working are those that persons have taken, `works` its books, for a driver's seat those of the own train.
    """

    time_s: float
    factor: float
    running: bool
    ended: str
    digest: str
    branch: int
    defined: bool
    manager_on: bool
    sections: tuple[SectionShown, ...]
    trains: tuple[TrainShown, ...]
    events: tuple[EventShown, ...] = ()
    graph: tuple[GraphPoint, ...] = ()
    points: tuple[PointsShown, ...] = ()
    crossings: tuple[CrossingKnown, ...] = ()
    silent: tuple[str, ...] = ()
    forecast: tuple[TrainForecast, ...] | None = None
    bids: tuple[BidShown, ...] = ()
    cab: CabShown | None = None
    messages: tuple[SeatMessage, ...] = ()
    deeds: tuple[DeedShown, ...] = ()
    rules: tuple[RuleShown, ...] = ()
    roles: tuple[str, ...] = ()
    works: tuple[WorkShown, ...] = ()


Heard = Welcome | State | DeskAnswer
_REQUESTS: Final[msgspec.json.Decoder[Request]] = msgspec.json.Decoder(Request)
_HELLO: Final = msgspec.json.Decoder(Hello)
_NUMBER: Final = msgspec.json.Decoder(MessageNumber)
_ENCODER: Final = msgspec.json.Encoder()


def hello_of(data: str | bytes) -> Hello:
    """The first message of a connection. Raises msgspec.DecodeError for anything else."""
    return _HELLO.decode(data)


def request_of(data: str | bytes) -> Request:
    """A further message. Raises msgspec.DecodeError for anything else, and for tables deeper than those of a file."""
    try:
        check_nesting("desk", msgspec.json.decode(data), "a message")
        return _REQUESTS.decode(data)
    except (RecursionError, InputError) as error:
        raise msgspec.DecodeError(str(error)) from error


def number_of(data: str | bytes) -> int:
    """The number of a message that is not understood; 0 where it has none."""
    try:
        return _NUMBER.decode(data).number
    except (msgspec.DecodeError, RecursionError):
        return 0


def encoded(message: Heard) -> str:
    """A message as it is sent."""
    return _ENCODER.encode(message).decode()


def schema() -> dict[str, Any]:
    """The JSON Schema of all messages."""
    kinds = (Hello, Request, Heard)
    (hello, asked, heard), parts = msgspec.json.schema_components(kinds, ref_template="#/$defs/{name}")
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "branchline desk protocol",
        "version": VERSION,
        "anyOf": [hello, asked, heard],
        "$defs": parts,
    }
