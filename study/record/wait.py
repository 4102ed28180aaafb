"""What a stock does at a moment of its day, and for what: the words of the table `waits`.

A day of a stock is cut into waits without gap or overlap, moving and off the line included, so that one of them holds
at every moment. Pure data; `study.measures.waits` finds them, `study.measures.wait_text` says them.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Cause(StrEnum):
    """For what a stock waits, or what else it does."""

    RUNS = "runs"
    STOP_LIMIT = "stop limit"  # runs slower, towards a stop limit (停止限界点) short of its next mark
    OUTSIDE = "outside"  # not on the line yet
    LEFT = "left"  # off the line, and nothing follows
    LATE = "late"  # comes to its portal later than planned
    QUEUE = "queue"  # another stock waits before the same portal
    PORTAL = "portal"  # signed on, but a train stands in the portal
    DEPARTURE_TIME = "departure time"
    DWELL = "dwell"
    ROUTE_HELD = "route held"  # another stock has a section of its route
    NO_WAY_ON = "no way on"  # its route is free, but if it went now not every train could still finish
    NOT_ITS_TURN = "not its turn"  # its route is free, but another goes first by the order of trains
    OVERLAP = "overlap"  # another comes in, whose overrun would foul its way, or is in the way of its own (過走余裕)
    REFUSED = "refused"  # the block manager refused, for another reason
    ANSWER = "answer"  # no answer to a request yet
    COVERAGE = "coverage"  # a request cannot be sent where it stands
    SET_BACK = "set back"  # its crew has set back the route, and asks for none for a while (進路取消)
    POINTS_MOVE = "points move"
    POINTS_REFUSED = "points refused"
    POINTS_PROOF = "points proof"  # no proof from the terminal yet
    POINTS_BY_EYE = "points by eye"  # on sight, its crew waits until they lie as needed
    LEVEL_CROSSING = (
        "level crossing"  # one ahead has not proved closed, nor has its driver leave to creep over it
    )
    VEHICLE = "vehicle"  # doors or brake
    UNABLE = "unable"  # by its own prediction it cannot reach its next stop
    EMERGENCY = "emergency"  # the emergency brake is to be acknowledged
    CONTRADICTION = "contradiction"  # register and unit contradict each other
    ON_SIGHT = "on sight"  # its position is unknown, and its crew looks before it goes on
    UNIT_OFF = "unit off"
    BY_HAND = "leave by people"  # its unit is cut out, and its driver goes when people or a signal let him
    UNIT_FROZEN = "unit frozen"
    ARRIVAL_BY_EYE = "arrival by eye"  # its driver is to confirm that the whole train has arrived (到着確認)
    TURN_BACK = "turn back"  # its driver changes ends (折返し)
    NEXT_TRAIN = "next train"  # its crew takes up the next train number
    NUMBER = "train number"  # its crew is yet to enter it, at its portal or after a boot (列車番号の入力)
    ENTRY = "entry"  # signed on, its crew takes it in through the portal
    SIGN_OFF = "sign-off"  # its crew is yet to sign off (在線抹消)
    LEAVING = "leaving"  # signed off, it goes out through the portal
    STARTING = "starting"  # the way is free, and its brakes release
    STABLED = "stabled"  # stands after its last train (留置)


class AwaitedRequest(StrEnum):
    """What the block manager was asked for, where the cause is about a request."""

    NOTHING = ""
    SIGN_ON = "sign-on"
    SIGN_OFF = "sign-off"
    ROUTE = "route"
    REPORT = "report"  # to confirm what the stock holds


MOVING = (Cause.RUNS, Cause.STOP_LIMIT)
NO_WAIT = (Cause.RUNS, Cause.OUTSIDE, Cause.LEFT)  # nothing is waited for


@dataclass(frozen=True, slots=True)
class Wait:
    """A stock from one moment to another, s since midnight, in which it waits for one thing.

    `train` is its train number, before its first train that one. `place` is the station where it stands, else the
    section that holds it up; `at_m` the kilometrage of its front. `party` is who is waited for: the stock that has
    `section` (and its train then), the manager, a terminal, a level crossing. `since_s`: since when that party has the
    section, or since when the request is open. `until_s`: when it ends or should (release, departure, dwell, entry);
    None where nobody knows. `reason` is a word of the refusal, fault or contradiction.
    """

    unit: str
    train: str
    from_s: float
    to_s: float
    cause: Cause
    place: str = ""
    at_m: float | None = None
    asked: AwaitedRequest = AwaitedRequest.NOTHING
    section: str = ""
    points: str = ""
    party: str = ""
    party_train: str = ""
    since_s: float | None = None
    until_s: float | None = None
    reason: str = ""

    @property
    def moves(self) -> bool:
        """Whether it moves meanwhile."""
        return self.cause in MOVING
