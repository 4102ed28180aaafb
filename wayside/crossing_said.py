"""What the device of a level crossing is told and says besides telegrams: inputs, outputs, lines of the journal.

Lamps and barriers stand in the simulated world; the device drives and senses them as by relays. Pure data, without any
rule; `wayside.said` has them among those of the other devices.
"""

from __future__ import annotations

from enum import Enum

import msgspec

from radio.noted import Noted


class CrossingDetected(msgspec.Struct, frozen=True, array_like=True, tag=13):
    """World to level crossing: what its contacts show, at each change and after a restart: lamps lit, barriers at
    either end, something on the closed road, the button pressed. What is not detected shows neither end.
    """

    lamps: bool
    lowered: bool
    raised: bool
    obstacle: bool = False
    button: bool = False

    @property
    def is_free(self) -> bool:
        """Whether nobody has pressed the button and nothing is seen on the road."""
        return not (self.obstacle or self.button)


class CrossingContact(msgspec.Struct, frozen=True, array_like=True, tag=14):
    """World to level crossing: a front has passed the `first` contact of its direction, or a rear the last one."""

    first: bool


class NoTrainComes(msgspec.Struct, frozen=True, array_like=True, tag=15):
    """Operator to level crossing: `person` has made sure that no train comes there and none is on it."""

    person: str


CrossingInput = CrossingDetected | CrossingContact | NoTrainComes


class CloseCrossing(msgspec.Struct, frozen=True, array_like=True, tag=3):
    """Level crossing to world: lamps on, barriers down."""

    crossing_id: str


class OpenCrossing(msgspec.Struct, frozen=True, array_like=True, tag=4):
    """Level crossing to world: barriers up, lamps off."""

    crossing_id: str


class CrossingWarns(Noted, frozen=True, kw_only=True, tag="crossing_warns"):
    """A level crossing begins to close: for this unit, or since a contact was passed."""

    unit_id: str = ""


class CrossingProven(Noted, frozen=True, kw_only=True, tag="crossing_proven"):
    """A level crossing is closed, as detected."""


class WhyUnproven(Enum):
    """Why a level crossing does not prove closed."""

    LATE = "not detected in time"
    LOST = "lost"
    OBSTACLE = "something is on it"
    BUTTON = "its button is pressed"


class CrossingUnproven(Noted, frozen=True, kw_only=True, tag="crossing_unproven"):
    """A level crossing that is commanded closed is not, or no longer, detected so."""

    why: WhyUnproven


class CrossingOpens(Noted, frozen=True, kw_only=True, tag="crossing_opens"):
    """A level crossing opens: no train is announced any more. `struck_off`: units, and trains that contacts have
    counted in (an empty name), of which persons alone say that they do not come.
    """

    struck_off: tuple[str, ...] = ()


class NoTrainSaid(Noted, frozen=True, kw_only=True, tag="no_train_said"):
    """A person has said at a level crossing that no train comes; `agreed`: another one had, so proofs are taken back,
    and it opens unless a unit says otherwise until then.
    """

    by: str
    agreed: bool = False


CrossingWord = CrossingWarns | CrossingProven | CrossingUnproven | CrossingOpens | NoTrainSaid
