"""What an on-board unit (車上装置) writes in the journal: one type an event. Pure data, without any rule.

A line carries the unit as its author. Positions are by the unit's own belief; what is true stands in the lines that
the world writes. A `station` is a station's id, or a section's where the target is no station.
"""

from __future__ import annotations

import msgspec

from network.model import Position, TagPurpose
from onboard.crossing_notes import CrossingNote
from radio.noted import Noted, TelegramDropped, TookEffect

# its duty ---------------------------------------------------------------------------------------------------


class MissionBegun(Noted, frozen=True, kw_only=True, tag="mission"):
    """The unit has taken up a train."""

    train: str
    direction: str


class MissionDone(Noted, frozen=True, kw_only=True, tag="mission_done"):
    """The last target of the train is reached and what lies behind is given back."""

    train: str


class ChangedEnds(Noted, frozen=True, kw_only=True, tag="changed_ends"):
    """The driver has changed ends."""


class UnitRestarted(Noted, frozen=True, kw_only=True, tag="restarted"):
    """Switched on again: position and holdings are forgotten."""

    epoch: int


class Resumed(Noted, frozen=True, kw_only=True, tag="resumed"):
    """Position and holdings are known again: normal running."""

    next_target: int


class Departs(Noted, frozen=True, kw_only=True, tag="departs"):
    """The time has come and the way is free: the train may start."""

    station: str


class Moving(Noted, frozen=True, kw_only=True, tag="moving"):
    """The wheels have begun to turn after a stop."""


class Arrived(Noted, frozen=True, kw_only=True, tag="arrived"):
    """Stands at a target; `error_m` beyond the mark, None on sight."""

    station: str
    error_m: float | None


class StoppedShort(Noted, frozen=True, kw_only=True, tag="stopped_short"):
    """Stands before the next target, held by its stop limit."""

    short_m: float
    why: str


class Overran(Noted, frozen=True, kw_only=True, tag="overran"):
    """Stands beyond the mark by more than counts as at it."""

    beyond_m: float


class StopImpossible(Noted, frozen=True, kw_only=True, tag="stop_impossible"):
    """The stop at the next mark cannot be made as designed."""

    why: str
    station: str


class LearnedFromStop(Noted, frozen=True, kw_only=True, tag="learned"):
    """What the last stop says of the brake, unless it is `left_out`, and what is used from now on (自動調整)."""

    left_out: str | None
    dead_time_s: float | None
    offset_mps2: float | None
    uses_dead_time_s: float
    uses_offset_mps2: float


class RuleWon(msgspec.Struct, frozen=True, kw_only=True):
    """From now on a rule of a driving law won, by its grade, which `premise` made, over the best of the others."""

    t_s: float
    rule: str
    grade: float
    premise: str
    over: str
    over_grade: float
    notch: float


class RuleHeld(msgspec.Struct, frozen=True, kw_only=True):
    """For how long in all a rule has won."""

    rule: str
    held_s: float


class DrivenByRules(Noted, frozen=True, kw_only=True, tag="driven_by_rules"):
    """How the run that has just ended was driven: seconds under each rule, notch changes, and which rule won when.

    `changes` are those of the winning rule; `won` tells the first of them.
    """

    law: str
    held: tuple[RuleHeld, ...]
    notch_changes: int
    changes: int
    won: tuple[RuleWon, ...]


class Intervention(Noted, frozen=True, kw_only=True, tag="intervention"):
    """Supervision brakes (1 service brake, 2 emergency brake), or has ended (0)."""

    level: int


class VehicleUnfit(Noted, frozen=True, kw_only=True, tag="vehicle_unfit"):
    """The vehicle or its brake is not in order: no start, and a train on its way is stopped."""

    why: str


class VehicleFit(Noted, frozen=True, kw_only=True, tag="vehicle_fit"):
    """The vehicle and its brake are in order again."""


class UnableToLeave(Noted, frozen=True, kw_only=True, tag="unable_to_leave"):
    """By its own prediction the train cannot reach its next stop: it stays, asks for no route, and looks again."""

    station: str
    why: str


class AbleToLeave(Noted, frozen=True, kw_only=True, tag="able_to_leave"):
    """What kept the train from leaving is over."""

    station: str


class EmergencyReleased(Noted, frozen=True, kw_only=True, tag="emergency_released"):
    """The driver has acknowledged an emergency stop."""


# where it is -------------------------------------------------------------------------------------------------


class TagRead(Noted, frozen=True, kw_only=True, tag="tag_read"):
    """A tag was read and believed; the position moved by `correction_m`."""

    tag_id: int
    purpose: TagPurpose
    correction_m: float


class PlacePassed(Noted, frozen=True, kw_only=True, tag="place_passed"):
    """Fixes alone prove that the front is beyond a tag's place (仮想地上子); `reader` gave the one that did."""

    tag_id: int
    purpose: TagPurpose
    reader: str


class FoundElsewhere(Noted, frozen=True, kw_only=True, tag="found_elsewhere"):
    """A fix finds the train where its unit does not hold all that it may stand in: it is not believed."""

    reader: str


class TagDoubted(Noted, frozen=True, kw_only=True, tag="tag_doubted"):
    """A tag was read but is not believed yet."""

    tag_id: int


class SignSeen(Noted, frozen=True, kw_only=True, tag="sign_seen"):
    """The camera has seen the sign of the next mark; the position moved by `correction_m`."""

    station: str | None
    correction_m: float


class FixRefused(Noted, frozen=True, kw_only=True, tag="fix_refused"):
    """What a sensor shows misses the bounds of the position, and is not believed until it fits again."""

    reader: str


class FixTaken(Noted, frozen=True, kw_only=True, tag="fix_taken"):
    """A sensor's fix is believed, the first one or the first `after` another outcome; it moved the position."""

    reader: str
    correction_m: float
    after: str


class ForeignTrack(Noted, frozen=True, kw_only=True, tag="foreign_track"):
    """What a sensor sees is not what the map has here (異曲率区間): nothing of it is a fix until it fits again."""

    reader: str


class FixMissed(Noted, frozen=True, kw_only=True, tag="fix_missed"):
    """What a sensor should have shown by now has not come."""

    reader: str


class PositionFault(Noted, frozen=True, kw_only=True, tag="position_fault"):
    """The position cannot be trusted any more: the train stops, then runs on sight."""

    why: str


class PositionFound(Noted, frozen=True, kw_only=True, tag="position_found"):
    """A tag, another sensor or the driver's eye has told where the train is."""


class TachometerFault(Noted, frozen=True, kw_only=True, tag="tachometer_fault"):
    """The tachometer shows what cannot be."""

    speed_mps: float


# what it may occupy --------------------------------------------------------------------------------------------


class SignedOn(Noted, frozen=True, kw_only=True, tag="signed_on"):
    """The manager has accepted the sign-on with these sections."""

    section_ids: tuple[str, ...]


class SignOnDenied(Noted, frozen=True, kw_only=True, tag="sign_on_refused"):
    """The manager refused the sign-on; it is repeated."""

    why: str


class SignedOff(Noted, frozen=True, kw_only=True, tag="signed_off"):
    """The manager has accepted the sign-off: the train may leave the line."""


class SignOffDenied(Noted, frozen=True, kw_only=True, tag="sign_off_refused"):
    """The manager refused the sign-off; it is repeated."""

    why: str


class Mismatch(Noted, frozen=True, kw_only=True, tag="mismatch"):
    """Register and unit contradict each other: the train is stopped until they agree."""

    why: str


class Agreed(Noted, frozen=True, kw_only=True, tag="agreed"):
    """Register and unit have the same again."""


class Holds(Noted, frozen=True, kw_only=True, tag="holds"):
    """All that the unit counts as held from now on."""

    section_ids: tuple[str, ...]
    token: int


class Claimed(Noted, frozen=True, kw_only=True, tag="claimed"):
    """Asked by a manager that has restarted, the unit answered that it holds this."""

    section_ids: tuple[str, ...]
    token: int


class Reported(Noted, frozen=True, kw_only=True, tag="reported"):
    """The unit reported all that it holds; what is not in it is given back."""

    section_ids: tuple[str, ...]
    token: int


class GaveBack(Noted, frozen=True, kw_only=True, tag="gave_back"):
    """The crew has set back the route ahead (進路取消)."""

    section_ids: tuple[str, ...]


class GiveBackDenied(Noted, frozen=True, kw_only=True, tag="give_back_refused"):
    """The route ahead cannot be set back."""

    why: str


class WayChanged(Noted, frozen=True, kw_only=True, tag="way_changed"):
    """By the dispatcher's order the train goes by this route instead of another, to another track of that station."""

    route_id: str
    instead: str


class EndedEarly(Noted, frozen=True, kw_only=True, tag="ended_early"):
    """By the dispatcher's order the train ends at this station, and its set goes on as another train."""

    train: str
    station: str
    next_train: str


class OrderDenied(Noted, frozen=True, kw_only=True, tag="order_denied"):
    """The unit refused what the dispatcher ordered about this route."""

    route_id: str
    why: str


class RouteHeld(Noted, frozen=True, kw_only=True, tag="route_held"):
    """A route was granted and counts as held."""

    route_id: str
    token: int


class RouteDenied(Noted, frozen=True, kw_only=True, tag="route_refused"):
    """The manager refused a route, for a reason that is new."""

    route_id: str
    why: str


class LimitSet(Noted, frozen=True, kw_only=True, tag="stop_limit"):
    """The stop limit (停止限界点) has changed; `before` is the section not to be entered, None at the path's end."""

    kilometrage_m: float
    piece_id: str
    before: str | None
    why: str


class Proven(Noted, frozen=True, kw_only=True, tag="proven"):
    """Points ahead are proven to the unit, by their terminal or by the crew's eye."""

    points_id: str
    position: Position
    token: int
    by_crew: bool = False


class ProofDropped(Noted, frozen=True, kw_only=True, tag="proof_dropped"):
    """The proof of points is withdrawn."""

    points_id: str


class ThrowDenied(Noted, frozen=True, kw_only=True, tag="points_refused"):
    """A terminal refused to throw points, for a reason that is new."""

    points_id: str
    why: str


# its crew ------------------------------------------------------------------------------------------------------


class CrewCheckedPoints(Noted, frozen=True, kw_only=True, tag="crew_checked_points"):
    """The crew sees points lie locked as the train needs them."""

    points_id: str
    lies: Position | None


class CrewWaitsAtPoints(Noted, frozen=True, kw_only=True, tag="crew_waits_at_points"):
    """The crew sees points lie otherwise, or unlocked."""

    points_id: str
    lies: Position | None


Note = (
    MissionBegun
    | MissionDone
    | ChangedEnds
    | UnitRestarted
    | Resumed
    | Departs
    | Moving
    | Arrived
    | StoppedShort
    | Overran
    | StopImpossible
    | LearnedFromStop
    | DrivenByRules
    | Intervention
    | VehicleUnfit
    | VehicleFit
    | UnableToLeave
    | AbleToLeave
    | EmergencyReleased
    | TagRead
    | PlacePassed
    | FoundElsewhere
    | TagDoubted
    | SignSeen
    | FixRefused
    | FixTaken
    | ForeignTrack
    | FixMissed
    | PositionFault
    | PositionFound
    | TachometerFault
    | SignedOn
    | SignOnDenied
    | SignedOff
    | SignOffDenied
    | Mismatch
    | Agreed
    | Holds
    | Claimed
    | Reported
    | GaveBack
    | GiveBackDenied
    | WayChanged
    | EndedEarly
    | OrderDenied
    | RouteHeld
    | RouteDenied
    | LimitSet
    | Proven
    | ProofDropped
    | ThrowDenied
    | CrossingNote
    | CrewCheckedPoints
    | CrewWaitsAtPoints
    | TelegramDropped
    | TookEffect
)
