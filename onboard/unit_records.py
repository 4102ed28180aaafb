"""How an on-board unit (車上装置) behaves: its parameters."""

from __future__ import annotations

from typing import Annotated

from network.files.kinds import about
from network.files.quantities import (
    Distance,
    PositionBound,
    Share,
    SightSpeedMps,
    TagsWrong,
    Wait,
    WheelError,
)
from network.files.toml_input import Record
from onboard.duty_parameters import DutyParameters


class UnitParameters(Record):
    """`[unit]`: how on-board units time, localise and run on sight; the papers give no figures."""

    dwell_min_s: Annotated[
        Wait,
        about("shortest passenger stop; a scenario takes that of its timetable", "timetable.dwell_min_s"),
    ] = 20.0
    request_lead_s: Annotated[
        Wait,
        about("a route is asked for this long before the departure", "assumed: throw and telegrams"),
    ] = 45.0
    time_margin_s: Annotated[
        Wait, about("trains aim to arrive this long before the timetable", "assumed: a driver's habit")
    ] = 10.0
    standoff_m: Annotated[
        Distance, about("trains stop this far before a stop limit that is no mark", "assumed: stop error")
    ] = 15.0
    tag_accuracy_m: Annotated[
        PositionBound, about("half-width of the position's bounds at a tag", "assumed: reader's field")
    ] = 0.5
    tags_wrong_together: Annotated[
        TagsWrong,
        about(
            "how many of the tags read one after another may be wrong or moved; the bounds span one tag more;"
            " 0: every possible tag is trusted",
            "assumed: a tag that was moved, an id mixed up, two that were swapped",
        ),
    ] = 1
    wheel_error_share: Annotated[
        WheelError,
        about(
            "growth of the bounds with distance, until tags have measured the wheel", "assumed: worn wheels"
        ),
    ] = 0.02
    doubt_error_share: Annotated[
        Share,
        about(
            "growth after a position fault, until two tags agree with the wheels", "assumed: ten times that"
        ),
    ] = 0.2
    doubt_bound_max_m: Annotated[
        Distance,
        about("a train that stands with wider bounds than this goes on sight", "assumed: a train and a half"),
    ] = 60.0
    wheel_scale_limit: Annotated[
        WheelError,
        about(
            "greatest wear of a wheel, as a share; the rest of wheel_error_share changes on the way: creep,"
            " the tread's slope in curves",
            "assumed: below wheel_error_share",
        ),
    ] = 0.015
    tag_window_m: Annotated[
        PositionBound,
        about("a tag this far from where it is expected is a fault", "assumed: slip between tags"),
    ] = 5.0
    emergency_release_s: Annotated[
        Wait, about("the driver's acknowledgement after an emergency stop", "assumed: a radio call")
    ] = 30.0
    believes_wheels: Annotated[
        bool,
        about(
            "the estimate goes by what wheels count also while they slide or slip; off: by what brakes and motors give",
            "assumed: slides and slips are noticed; on, it is the equipment of Harada, 2.1",
        ),
    ] = False
    restricted_mps: Annotated[
        SightSpeedMps,
        about("speed limit on sight, while the position is unknown", "assumed: 15 km/h, customary on sight"),
    ] = 15.0 / 3.6

    @property
    def wheel_varies_share(self) -> float:
        """By how much at most the way of a turn changes on the way, as a share; what more it is worth is wear."""
        return max(self.wheel_error_share - self.wheel_scale_limit, 0.0)

    @property
    def duty(self) -> DutyParameters:
        """Those that the duty works with."""
        return DutyParameters(self.dwell_min_s, self.request_lead_s, self.emergency_release_s)
