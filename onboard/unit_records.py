"""What the on-board unit (車上装置) is made of and says: its parameters, fixed data, phases and actions."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from network.model import Line
from onboard.notes import Note


class Phase(Enum):
    """Where the unit is in its duty."""

    OFF = "off"
    SIGNING_ON = "signing on"
    STANDING = "standing"
    RUNNING = "running"
    RESTARTED = "restarted"  # on sight: switched on again, or lost its position, until all is known again
    FINISHED = "finished"
    SIGNING_OFF = "signing off"
    GONE = "gone"


@dataclass(frozen=True, slots=True)
class UnitParameters:
    """How a unit behaves; `assumed` unless the scenario says otherwise (the paper gives no figures)."""

    dwell_min_s: float = 20.0
    request_lead_s: float = 45.0  # a route is asked for this long before the departure
    time_margin_s: float = 10.0  # arrive this much before the time
    standoff_m: float = 15.0  # stop this far before a stop limit that is no mark
    tag_accuracy_m: float = 0.5
    wheel_error_share: float = 0.02  # worn wheels: growth of the bounds
    doubt_error_share: float = 0.2  # the same after a position fault, until two tags agree with it
    doubt_bound_max_m: float = 60.0  # a train that cannot go on for bounds wider than this goes on sight
    wheel_scale_limit: float = 0.015
    tag_window_m: float = 5.0
    emergency_release_s: float = 30.0  # the driver's acknowledgement after an emergency stop
    restricted_mps: float = 15.0 / 3.6  # on sight while the position is unknown


@dataclass(frozen=True, slots=True)
class UnitFacts:
    """Fixed data of one unit (固定データ)."""

    unit_id: str
    line: Line
    manager_id: str
    parameters: UnitParameters


@dataclass(frozen=True, slots=True)
class Transmit:
    """A sealed telegram for the air."""

    destination: str
    kind: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Finished:
    """The mission's last target is reached and the sections behind are given back."""

    number: str


@dataclass(frozen=True, slots=True)
class LeftLine:
    """Signed off: the train may be taken off the line."""


UnitAction = Transmit | Note | Finished | LeftLine
