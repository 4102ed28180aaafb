"""What an on-board unit writes in the journal of level crossings (踏切), for `onboard.notes`."""

from __future__ import annotations

from enum import Enum

from radio.noted import Noted


class CrossingAsked(Noted, frozen=True, kw_only=True, tag="crossing_asked"):
    """The unit has announced itself to a level crossing: its front can be there in `arrives_s`."""

    crossing_id: str
    arrives_s: float


class CrossingHeardClosed(Noted, frozen=True, kw_only=True, tag="crossing_heard_closed"):
    """The unit has the proof that a level crossing is closed."""

    crossing_id: str


class WhyProofLost(Enum):
    """Why the proof of a level crossing does not hold any more."""

    SILENCE = "silence"
    NOT_CLOSED = "not closed"


class CrossingProofLost(Noted, frozen=True, kw_only=True, tag="crossing_proof_lost"):
    """The proof that a level crossing is closed does not hold any more."""

    crossing_id: str
    why: WhyProofLost


class CrossingHeardClear(Noted, frozen=True, kw_only=True, tag="crossing_heard_clear"):
    """A level crossing that contacts control has told the unit that nothing is known to be on it."""

    crossing_id: str


class CrossingCreep(Noted, frozen=True, kw_only=True, tag="crossing_creep"):
    """The driver has leave to creep over a level crossing that has not proved closed, whistling, on sight; `guarded`:
    by the word of somebody who has stopped its road by hand.
    """

    crossing_id: str
    guarded: bool = False


class CrossingLeftBehind(Noted, frozen=True, kw_only=True, tag="crossing_left"):
    """The unit says that nothing of its train is on a level crossing any more (`passed`), or comes onto it now."""

    crossing_id: str
    passed: bool


CrossingNote = (
    CrossingAsked
    | CrossingHeardClosed
    | CrossingHeardClear
    | CrossingProofLost
    | CrossingCreep
    | CrossingLeftBehind
)
