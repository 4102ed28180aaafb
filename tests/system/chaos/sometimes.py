"""What random cases are meant to come to: a counter each, which must be above zero over all cases of a night.

A generator that never leads into a situation shows nothing about it, however many of its cases end well.
"""

from collections.abc import Iterable
from types import MappingProxyType
from typing import Final

from onboard import crossing_notes, notes
from radio.envelope import DropReason
from radio.messages import RefusalReason
from radio.noted import Lost, TelegramDropped
from simulation import events
from simulation.faults.chargers import ChargerDead
from simulation.faults.lidar import LidarFault, MarkerMissing
from simulation.faults.script import ActKind
from simulation.faults.table import FAULTS
from simulation.settings import PositionSensor
from wayside import said
from wayside.config import MANAGER_ID
from wayside.crossing_said import CrossingOpens, CrossingUnproven

SOMETIMES: Final[MappingProxyType[str, events.EventType]] = MappingProxyType(
    {
        "a telegram is lost": Lost,
        "a party loses its power": events.PowerOff,
        "a lost store waits for its commissioning": events.Uncommissioned,
        "a party is commissioned anew": events.Commissioned,
        "a unit forgets its position": notes.PositionFault,
        "a position is found again": notes.PositionFound,
        "a tag is doubted": notes.TagDoubted,
        "a fix is refused": notes.FixRefused,
        "a wheel is seen to lie": notes.TachometerFault,
        "supervision brakes": notes.Intervention,
        "a train stops short of its mark": notes.StoppedShort,
        "a proof of points is dropped": notes.ProofDropped,
        "a crew locks points by hand": events.PointsLockedByHand,
        "staff set points by hand": events.PointsSetByHand,
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
        "a person acts": events.Acted,
        "people work the line": events.ProcedureStep,
        "a battery is low": events.BatteryAt,
        "a level crossing is asked to close": crossing_notes.CrossingAsked,
        "a level crossing is heard closed": crossing_notes.CrossingHeardClosed,
        "the proof of a level crossing is lost": crossing_notes.CrossingProofLost,
        "a level crossing does not prove closed": CrossingUnproven,
        "a driver creeps over a level crossing": crossing_notes.CrossingCreep,
        "a level crossing opens": CrossingOpens,
        "a train is ordered to another track": said.TrackChanged,
        "a train takes up the way there": notes.WayChanged,
        "a train is ended early, or left out": said.TrainCut,
        "a set goes on as another train": said.GoesOnAs,
        "a route is asked back": said.RouteAskedBack,
        "a unit refuses what is ordered": said.NotDone,
        "a dispatcher keeps a train back": said.WaitBidden,
        "a train that was kept back may go": said.WaitOver,
        "a dispatcher ends a train": said.TrainEndBidden,
        "a train stays for what it cannot do": notes.UnableToLeave,
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
IN_BLOCKS: Final = "two trains are in the blocks of one section"
ON_ITS_WAY: Final = "a train on its way gives back what is behind it"
MOST_AT_A_STAND: Final = 2  # sections: the points by which it came, and its track
WAITS_TO_COME_IN: Final = "a train waits for leave to come in"
BY_LIDAR: Final = "a fix by a LiDAR is believed"
BY_HAND: Final = "a train is driven by hand"
ONE_NETWORK: Final = "one of two networks fails"
NO_LIDAR: Final = "a LiDAR sees less"
NO_MARKER: Final = "a marker is missing"
NO_CHARGER: Final = "a charger is dead"
OF_FAULTS: Final[MappingProxyType[str, str]] = MappingProxyType(
    {
        LidarFault.changes: NO_LIDAR,
        MarkerMissing.changes: NO_MARKER,
        ChargerDead.changes: NO_CHARGER,
    }
)
ALL: Final = (
    *SOMETIMES,
    RESTARTED_MANAGER,
    *DROPS,
    IN_BLOCKS,
    ON_ITS_WAY,
    WAITS_TO_COME_IN,
    BY_LIDAR,
    BY_HAND,
    ONE_NETWORK,
    *OF_FAULTS.values(),
)


def _cut(section_ids: Iterable[str]) -> set[str]:
    """Sections of which these are blocks."""
    return {section_id.rpartition("_")[0] for section_id in section_ids if "_" in section_id}


class _Course:
    """What follows from several entries: who holds what."""

    def __init__(self) -> None:
        self._held: dict[str, tuple[str, ...]] = {}

    def see(self, entry: events.JournalEntry) -> str | None:
        """What an entry comes to; None: nothing of this."""
        match entry.event:
            case notes.Holds(section_ids=section_ids):
                self._held[entry.who] = section_ids
                others = (held for unit_id, held in self._held.items() if unit_id != entry.who)
                return IN_BLOCKS if any(_cut(section_ids) & _cut(held) for held in others) else None
            case said.Freed(unit_id=unit_id):
                return ON_ITS_WAY if len(self._held.get(unit_id, ())) > MOST_AT_A_STAND else None
            case said.Refused(why=RefusalReason.OVERLAP.name):
                return WAITS_TO_COME_IN
            case notes.FixTaken(reader=PositionSensor.LIDAR.value):
                return BY_LIDAR
            case events.Acted(act=ActKind.DRIVE.value):
                return BY_HAND
            case events.FaultBegan(kind=kind, parameters=parameters):
                one_network = parameters.get("network", "any") != "any"
                return ONE_NETWORK if one_network else OF_FAULTS.get(FAULTS[kind].changes)
            case _:
                pass
        return None


def come_to(entries: Iterable[events.JournalEntry]) -> frozenset[str]:
    """What of all this a run came to."""
    by_type = {kind: name for name, kind in SOMETIMES.items()}
    why = {reason.value: name for name, reason in DROPS.items()}
    came = set[str]()
    course = _Course()
    for entry in entries:
        event = entry.event
        came.update(name for name in (by_type.get(type(event)), course.see(entry)) if name is not None)
        if isinstance(event, TelegramDropped) and event.why in why:
            came.add(why[event.why])
        if isinstance(event, events.PowerOff) and event.device_id == MANAGER_ID:
            came.add(RESTARTED_MANAGER)
    return frozenset(came)
