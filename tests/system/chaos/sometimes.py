"""What random cases are meant to come to: a counter each, which must be above zero over all cases of a night.

A generator that never leads into a situation shows nothing about it, however many of its cases end well.
"""

from collections.abc import Iterable
from types import MappingProxyType
from typing import Final

from onboard import crossing_notes, notes
from radio.envelope import DropReason
from radio.noted import Lost, TelegramDropped
from simulation.events import (
    Acted,
    Commissioned,
    Event,
    EventType,
    PointsLockedByHand,
    PointsSetByHand,
    PowerOff,
    Uncommissioned,
)
from wayside import said
from wayside.config import MANAGER_ID
from wayside.crossing_said import CrossingOpens, CrossingUnproven

SOMETIMES: Final[MappingProxyType[str, EventType]] = MappingProxyType(
    {
        "a telegram is lost": Lost,
        "a party loses its power": PowerOff,
        "a lost store waits for its commissioning": Uncommissioned,
        "a party is commissioned anew": Commissioned,
        "a unit forgets its position": notes.PositionFault,
        "a position is found again": notes.PositionFound,
        "a tag is doubted": notes.TagDoubted,
        "a fix is refused": notes.FixRefused,
        "a wheel is seen to lie": notes.TachometerFault,
        "supervision brakes": notes.Intervention,
        "a train stops short of its mark": notes.StoppedShort,
        "a proof of points is dropped": notes.ProofDropped,
        "a crew locks points by hand": PointsLockedByHand,
        "staff set points by hand": PointsSetByHand,
        "a throw is refused": said.ThrowRefused,
        "points do not come into position": said.PointsUnproven,
        "a unit and the register contradict each other": said.Contradicted,
        "a unit is told so": notes.Mismatch,
        "a word of a person is written down": said.WordTaken,
        "a word of a person is in force": said.ConfirmedByHand,
        "what persons said is taken back": said.TakenBack,
        "the picture of a restored line changes": said.PictureChanged,
        "a unit is barred": said.Barred,
        "a unit is unbarred": said.Unbarred,
        "sections are to be swept": said.ToBeSwept,
        "sections are swept": said.Swept,
        "a crew gives its route back": notes.GaveBack,
        "the dispatcher holds a train back": said.HeldBack,
        "the order of trains is changed": said.OrderChanged,
        "a certificate is found": said.Certified,
        "a sign-off waits for the train to have left": said.Leaving,
        "a person acts": Acted,
        "a level crossing is asked to close": crossing_notes.CrossingAsked,
        "a level crossing is heard closed": crossing_notes.CrossingHeardClosed,
        "the proof of a level crossing is lost": crossing_notes.CrossingProofLost,
        "a level crossing does not prove closed": CrossingUnproven,
        "a driver creeps over a level crossing": crossing_notes.CrossingCreep,
        "a level crossing opens": CrossingOpens,
    }
)
RESTARTED_MANAGER: Final = "the manager loses its power"
STALE: Final = "a telegram is too old"
REPEATED: Final = "a telegram comes twice"
EARLIER_BOOT: Final = "a telegram is meant for an earlier boot"
DAMAGED: Final = "a telegram is damaged"
DROPS: Final[MappingProxyType[str, DropReason]] = MappingProxyType(
    {
        STALE: DropReason.STALE,
        REPEATED: DropReason.REPEATED,
        EARLIER_BOOT: DropReason.EARLIER_BOOT,
        DAMAGED: DropReason.CORRUPTED,
    }
)
ALL: Final = (*SOMETIMES, RESTARTED_MANAGER, *DROPS)


def come_to(events: Iterable[Event]) -> frozenset[str]:
    """What of all this a run came to."""
    by_type = {kind: name for name, kind in SOMETIMES.items()}
    why = {reason.value: name for name, reason in DROPS.items()}
    came = set[str]()
    for event in events:
        if (name := by_type.get(type(event))) is not None:
            came.add(name)
        if isinstance(event, TelegramDropped) and event.why in why:
            came.add(why[event.why])
        if isinstance(event, PowerOff) and event.device_id == MANAGER_ID:
            came.add(RESTARTED_MANAGER)
    return frozenset(came)
