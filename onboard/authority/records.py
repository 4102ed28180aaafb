"""What the authority machine works on: its state, the events it takes and the actions it returns."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from network.model import Position, Route
from onboard.notes import Note
from radio.messages import AnyMessage, SignOff, SignOn

NEVER: Final = math.inf


@dataclass(frozen=True, slots=True)
class Held:
    """A section held: under which token, and for a points section what proves it, by terminal."""

    section_id: str
    token: int
    macs: tuple[tuple[str, bytes], ...] = ()

    def mac_for(self, terminal_id: str) -> bytes:
        """The capability's code for a terminal; empty where none was granted."""
        return next((mac for terminal, mac in self.macs if terminal == terminal_id), b"")


@dataclass(frozen=True, slots=True)
class PointsNeeded:
    """A set of points as the path needs it."""

    points_id: str
    position: Position
    section_id: str
    terminal_id: str


@dataclass(frozen=True, slots=True)
class Command:
    """A points command not yet proven."""

    needed: PointsNeeded
    token: int
    mac: bytes
    correlation: int
    next_s: float
    refusal: str = ""


@dataclass(frozen=True, slots=True)
class Authority:
    """The state. `refusal` says why the last request was not granted: what the train waits for."""

    unit_id: str
    manager_id: str
    held: tuple[Held, ...] = ()
    token: int = 0
    on_line: bool = False  # signed on and not signed off
    sign_on: SignOn | None = None
    entering: bool = False  # the sign-on asks for a portal
    sign_off: SignOff | None = None
    next_sign_s: float = NEVER
    asked: Route | None = None
    next_ask_s: float = NEVER
    refusal: str = ""
    commands: tuple[Command, ...] = ()
    proven: tuple[PointsNeeded, ...] = ()
    unsaid: tuple[Command, ...] = ()  # not commanded any more, but a proof of them still counts
    report_due: bool = False
    next_report_s: float = NEVER
    correlation: int = 0  # of the newest request; each open request keeps its own
    sign_correlation: int = 0
    ask_correlation: int = 0
    report_correlation: int = 0

    def holds(self, section_id: str) -> bool:
        """Whether the unit holds a section."""
        return any(held.section_id == section_id for held in self.held)

    def section_ids(self) -> tuple[str, ...]:
        """Sections held, in order of travel."""
        return tuple(held.section_id for held in self.held)

    def next_timer_s(self) -> float:
        """When the machine wants a Tick; NEVER if it waits for nothing."""
        times = [self.next_sign_s, self.next_ask_s, self.next_report_s]
        return min([*times, *(command.next_s for command in self.commands)])


@dataclass(frozen=True, slots=True)
class BeginOnLine:
    """The train has come onto the line and claims these sections; None: switched on, it knows nothing."""

    section_ids: tuple[str, ...] | None
    enters: bool = False  # a wish for a portal, not a fact: until it is accepted the unit holds nothing


@dataclass(frozen=True, slots=True)
class EndOnLine:
    """The train leaves the line; it holds nothing but its portal."""


@dataclass(frozen=True, slots=True)
class Ask:
    """Ask for a route (閉そく確保要求)."""

    route: Route


@dataclass(frozen=True, slots=True)
class Throw:
    """Command points inside what is held (転換指示)."""

    points: tuple[PointsNeeded, ...]


@dataclass(frozen=True, slots=True)
class CheckedByCrew:
    """The crew has seen that these points lie and are locked as the path needs them (開通方向の確認)."""

    points: PointsNeeded


@dataclass(frozen=True, slots=True)
class Withdrawn:
    """The front may have come onto points of these sections: they must not be asked to move any more."""

    section_ids: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Cleared:
    """The safe rear has left these sections."""

    section_ids: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class GiveBack:
    """The train stands and surely short of these sections: it gives up the route not entered (進路取消)."""

    section_ids: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class TurnedBack:
    """The train changed ends: what was behind is ahead; proofs made for the old path are forgotten."""


@dataclass(frozen=True, slots=True)
class Heard:
    """An authentic telegram. `fresh`: its sender has heard this boot; `correlation`: of what it answers."""

    source: str
    message: AnyMessage
    fresh: bool
    correlation: int


@dataclass(frozen=True, slots=True)
class Tick:
    """A timer is due, or the radio reaches again."""


Event = (
    BeginOnLine
    | EndOnLine
    | Ask
    | Throw
    | Withdrawn
    | CheckedByCrew
    | Cleared
    | GiveBack
    | TurnedBack
    | Heard
    | Tick
)


@dataclass(frozen=True, slots=True)
class Send:
    """Send a telegram."""

    destination: str
    message: AnyMessage
    correlation: int


Action = Send | Note
