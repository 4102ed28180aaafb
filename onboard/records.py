"""The on-board unit's fast state: one row a train, read and written by compiled code every step.

Positions are path coordinates (m, growing in the direction of travel) of the train's front. Everything here is
what the unit believes; the truth is elsewhere and never read.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from onboard.driving_settings import Driving
from vehicle.record import dtype_of

# what the compiled tick reports to the unit's event-driven part (bits)
EVENT_STOPPED: Final = 1
EVENT_SAFE_REAR: Final = 2  # the safe rear end passed `rear_trigger_m`
EVENT_INTERVENTION: Final = 4  # supervision began or ended a brake application
EVENT_TAG_OVERDUE: Final = 8  # the expected tag was not read within its window
EVENT_MOVING: Final = 16  # the train began to move
EVENT_POSITION: Final = (
    32  # the position passed `position_trigger_m`, or had not passed `look_before_m` in time
)
EVENT_TACHOMETER: Final = 64  # the tachometer shows what cannot be
EVENT_VERDICT: Final = 128  # the stop at the mark has turned out impossible: `stop_verdict`
EVENT_OFF_PLAN: Final = 512  # the train is off its plan by more than `replan_s`
EVENT_FIX: Final = 256  # what came of a sensor's reading is another than before: `readers.outcome`
EVENT_PLACE: Final = 1024  # a fix makes certain that the front is beyond `place_trigger_m`
EVENT_FOUND: Final = 2048  # a fix has told the position, which was not known
EVENT_CONTRADICTED: Final = 4096  # fixes of absolute sensors miss the bounds, one after the other
EVENT_IDLE: Final = 8192  # it may drive on to its mark, and stands

# unit.mode
MODE_HOLD: Final = 0  # stand with the brakes applied
MODE_DRIVE: Final = 1  # drive to `target_stop_m`

# unit.intervention
NO_INTERVENTION: Final = 0
SERVICE_INTERVENTION: Final = 1
EMERGENCY_INTERVENTION: Final = 2


class UnitRow(Protocol):
    """What the on-board unit believes and decides."""

    # localisation
    position_m: float
    bound_ahead_m: Annotated[float, "the front is at most this far ahead of position_m"]
    bound_behind_m: float
    bound_growth: Annotated[float, "m of bound per m run"]
    slid_ahead_m: Annotated[float, "by which slides have widened the bound ahead in all, beyond its growth"]
    slipped_behind_m: Annotated[float, "the same of slips and the bound behind"]
    step_short_m: Annotated[float, "by which the tachometer's count of the last step may be short"]
    step_long_m: Annotated[float, "or long: what was passed within it lies by so much elsewhere"]
    position_known: int
    odometer_m: Annotated[float, "what was counted until the last tick: the tachometer's reading, and"]
    odometer_off_m: Annotated[float, "what the last axle has counted more than it, in its place"]
    pulse_m: Annotated[
        float, "of the tachometer: it shows whole pulses, so a way between two readings may be one off"
    ]
    odometer_scale: Annotated[float, "calibration against the distance between tags"]
    tachometer_doubt_s: Annotated[float, "for how long its readings have not fitted what was commanded"]
    # the tachometer against the last axle (`onboard.localisation.axles`)
    last_axle_mps: Annotated[float, "its speed a step ago; negative: none has been shown"]
    axles_differ_share: Annotated[float, "two that roll differ by no more: what the way of a turn varies by"]
    short_m: Annotated[float, "by which the tachometer has counted less than that axle, beyond this share"]
    short_most_m: Annotated[float, "up to where the bound ahead holds it: by a pulse more at most"]
    long_m: Annotated[float, "the same of what it has counted more"]
    long_most_m: float
    apart: Annotated[int, "1: the two contradict one another"]
    agree_m: Annotated[float, "the way since they last did"]
    braked_mps: Annotated[float, "what the train may still run at while they do"]
    sure_stand_s: Annotated[float, "for how long one has turned while the train surely stands"]
    liar: Annotated[int, "which of them turned while the train surely stood"]
    wheel_slide: Annotated[int, "from the slide protection: -1 slides, 1 slips, 0 rolls"]
    may_slip_s: Annotated[float, "above 0: what it calls a slide may still be the slip that it saw before"]
    speed_mps: float
    believes_wheels: Annotated[int, "1: the estimate goes by what they count also while they slide or slip"]
    train_mps: Annotated[float, "the train's own speed: the wheel's, but while that slides"]
    may_run_mps: Annotated[float, "the train runs no faster than this, also while its wheels are locked"]
    turns_s: Annotated[float, "for how long wheels that stood or slid have turned since"]
    turned_mps: Annotated[float, "what they showed first"]
    slid_mps: Annotated[float, "nor than this since its wheels began to slide or slip; 0: they roll"]
    let_go_s: Annotated[float, "for how long then the slide protection has let the last axle go"]
    free_s: Annotated[float, "and for how long brakes should have been off"]
    rolls_s: Annotated[float, "for how long then wheels have rolled again"]
    acceleration_mps2: Annotated[float, "smoothed"]
    seen_speed_mps: Annotated[float, "the train's own by a sensor that does not go by its wheels"]
    seen_within_mps: Annotated[float, "by which that may be wrong; 0: none tells"]
    expected_tag_m: Annotated[float, "where the next tag should be read; +inf: none"]
    tag_window_m: Annotated[float, "beyond the bounds by this much without reading: overdue"]
    # fixes of absolute sensors, of which virtual tags are made (`onboard.localisation.places`)
    fix_came: Annotated[int, "of the reading looked at: 0 it gave none, else FIX_CUT or FIX_MISSED of `fix`"]
    fix_low_m: Annotated[float, "where the last fix taken had the front at least"]
    fix_high_m: Annotated[float, "and at most"]
    fix_at_m: Annotated[float, "position when an absolute sensor last told it; -inf: not on this path"]
    fix_odometer_m: Annotated[float, "what the tachometer showed then"]
    fix_reader: Annotated[int, "whose it was: its place in READERS"]
    narrow: Annotated[
        int, "1: there is a narrowest fix since one measured the wheels, what wheels have added counted"
    ]
    narrow_low_m: Annotated[float, "where that had the front at least"]
    narrow_high_m: Annotated[float, "and at most"]
    narrow_odometer_m: Annotated[float, "what the tachometer showed then"]
    narrow_slid_m: Annotated[float, "`slid_ahead_m` then"]
    narrow_slipped_m: Annotated[float, "`slipped_behind_m` then"]
    sure_m: Annotated[float, "by such fixes alone the front is beyond this; -inf: by none"]
    place_trigger_m: Annotated[float, "the next virtual tag; +inf: none"]
    found: Annotated[int, "1: a fix has told in this step what was not known, and nobody has believed it yet"]
    missed_fixes: Annotated[int, "of absolute sensors, one after the other"]
    # authority and supervision
    stop_limit_m: Annotated[float, "停止限界: never passed by the front"]
    restricted_mps: Annotated[float, "speed ceiling of the operating mode (非常運転); +inf: none"]
    ceiling_mps: Annotated[float, "the least limit wherever the train may be, and that of the operating mode"]
    permitted_mps: Annotated[float, "that, and what is left before the stop limit"]
    intervention: int
    # driving
    mode: int
    target_stop_m: Annotated[float, "where the front is to stop"]
    mark_m: Annotated[
        float, "the mark itself: further than `target_stop_m` while the stop limit lies before it"
    ]
    due_s: Annotated[float, "when it should be there, since midnight; +inf: no matter when"]
    cruise_mps: float
    replan_s: Annotated[float, "off its plan by more than this a train asks for another; +inf: it has asked"]
    target_mps: float
    braking_to_stop: Annotated[int, "latched: the stop pattern has taken over"]
    fix_correction_m: Annotated[float, "by which the last fix moved the position; taken up by the next tick"]
    stop_verdict: Annotated[int, "onboard.driving.tasc.Verdict"]
    idle_s: Annotated[float, "for how long it stands without power although it may drive on to its mark"]
    notch: Annotated[float, "> 0 power, < 0 brake"]
    notch_held_s: float
    emergency: int
    rear_trigger_m: float
    position_trigger_m: float
    look_s: Annotated[float, "by its clock: it looks then, if its front is not surely beyond `look_before_m`"]
    look_before_m: float
    # where this train's rows of the path database begin, and how many there are
    path_offset: int
    path_rows: int
    paths_taken_up: Annotated[int, "how many it has gone by: with each the coordinates are others"]
    boots: Annotated[int, "how often it was switched on again: its sensors went on meanwhile"]
    places_offset: Annotated[int, "the same of the places that it knows, by position"]
    places_rows: int
    plan_offset: Annotated[int, "the same of its plan"]
    plan_rows: Annotated[int, "0: no plan"]
    plan_due_s: Annotated[float, "when the plan has the front at `target_stop_m`, since midnight"]


UNIT: Final = dtype_of(UnitRow)


class PathRow(Protocol):
    """One metre of the path database."""

    climb_m: Annotated[float, "elevation, with the climb that the curves are worth to this train"]
    body_elevation_m: Annotated[float, "mean over the train's length, its front here"]
    permitted_mps: Annotated[float, "supervision: speed limits with the brake curves towards them"]
    driving_mps: Annotated[float, "automatic driving stays under this one"]
    curvature_per_m: Annotated[
        float, "of the map (線路曲率), to the right, as it is compared; nan: not in it"
    ]


PATTERN: Final = dtype_of(PathRow)

# PlaceRow.kind
PLACE_BEACON: Final = 1
PLACE_MARKERS: Final = 2


class PlaceRow(Protocol):
    """Something that lies at one place of a path and that a sensor may find there."""

    kind: Annotated[int, "PLACE_BEACON or PLACE_MARKERS"]
    position_m: Annotated[float, "path coordinate"]
    number: Annotated[int, "of a beacon its id, of markers their pattern"]
    told: Annotated[int, "1: who passes it reads the number"]
    used: Annotated[int, "1: databases go by it"]
    window_m: Annotated[float, "of a beacon: it is looked for this far either way; 0: by a rule"]


PLACE: Final = dtype_of(PlaceRow)


class Chart(NamedTuple):
    """What units know of their ways: rows of PATTERN and of PLACE of all of them; UNIT says where its own begin."""

    path: NDArray[np.void]
    places: NDArray[np.void]


NO_PLACES: Final = np.zeros(0, dtype=PLACE)


@dataclass(frozen=True, slots=True)
class PathData:
    """The unit's path database of one mission: rows of PATTERN, where they lie in the pool, and the places there."""

    rows: NDArray[np.void]
    offset: int
    places_offset: int = 0
    places_rows: int = 0


class BehaviourRow(Protocol):
    """How a unit drives and supervises."""

    service_guaranteed_mps2: float
    service_reaction_s: float
    emergency_guaranteed_mps2: float
    emergency_reaction_s: float
    settings: Driving  # `stop_deceleration_mps2` is of the target-speed pattern (目標速度パターン)
    standing_brake_notch: float
    step_s: float


BEHAVIOUR: Final = dtype_of(BehaviourRow)
