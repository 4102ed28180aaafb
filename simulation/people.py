"""`[people]`: how long people take between what they see or hear and what they do about it (人の時間).

One mean for each act that the model has and no plan gives a time to; none is zero unless a scenario says so, but the
key that a driver presses as the train leaves. Times are lognormal: most people take about the same, a few much longer.
What a plan or a script gives a time to (`operation.change_ends_s`, an act's `start`) takes that; stock that stands on
the line as the run opens has its number.
"""

from __future__ import annotations

from enum import Enum
from typing import Annotated, Final

from network.files.chances import DelayFactor, PeopleSigma, PersonTime
from network.files.kinds import about
from network.files.toml_input import Record

LID_TIMES: Final = 6.0  # nobody takes longer than so many times the mean


class People(Record):
    """`[people]`: times that people take, each drawn anew from a lognormal distribution, at most six times its mean."""

    times: Annotated[
        DelayFactor,
        about("factor of all draws; 0: everybody acts at once", "1: the means below"),
    ] = 1.0
    sigma: Annotated[
        PeopleSigma,
        about(
            "standard deviation of the logarithm; 0: always the mean", "assumed: one in six over 1.5 times"
        ),
    ] = 0.5
    boot_s: Annotated[
        PersonTime,
        about(
            "mean time from a unit's boot until its crew has entered the train number",
            "assumed: sees the display, looks the number up, types it; no paper has a figure",
        ),
    ] = 20.0
    sign_on_s: Annotated[
        PersonTime,
        about(
            "mean time from when a stock stands at its portal until its crew has entered the train number",
            "assumed: the same; far less than `operation.portal_lead_s`",
        ),
    ] = 20.0
    entry_s: Annotated[
        PersonTime,
        about(
            "mean time from when the unit shows that the portal may be entered until the train is in it",
            "assumed: a look",
        ),
    ] = 4.0
    sign_off_s: Annotated[
        PersonTime,
        about(
            "mean time from the end of a journey at a portal until the crew signs off", "assumed: two keys"
        ),
    ] = 8.0
    leave_s: Annotated[
        PersonTime,
        about(
            "mean time from when the unit shows that it is signed off until the train has gone through the portal",
            "assumed: brakes released, and a length of 40 m at 15 km/h",
        ),
    ] = 12.0
    gone_s: Annotated[
        PersonTime,
        about(
            "mean time from when a train has gone through the portal, or its unit has booted beyond it, until its"
            " driver has entered that it is off the line",
            "assumed: a key pressed as the train passes the boundary",
        ),
    ] = 0.0
    stand_s: Annotated[
        PersonTime,
        about(
            "mean time from when a train on sight, or one that is not at its mark, has stopped until its crew has"
            " looked out and entered it",
            "assumed: a look and a key; Sugiyama, 4.4 (3), has the crew look",
        ),
    ] = 6.0
    key_s: Annotated[
        PersonTime,
        about(
            "mean time from when a train has passed points that its crew locked until the key is given back",
            "assumed: a few words by telephone",
        ),
    ] = 15.0
    crossing_s: Annotated[
        PersonTime,
        about(
            "mean time from when a train waits for a level crossing that has not proved closed until its driver has"
            " leave to creep over it",
            "assumed: seen, reported to the dispatcher, answered",
        ),
    ] = 60.0
    flag_s: Annotated[
        PersonTime,
        about(
            "mean time from when a train stands before a level crossing that somebody guards until its road is stopped"
            " by hand and its driver has that one's word",
            "assumed: a flag held to the road, a look, a flag shown to the driver",
        ),
    ] = 15.0
    word_s: Annotated[
        PersonTime,
        about(
            "mean time of a controller for each word entered: of a picture without `pace_s`, after the first of"
            " several sections, and for an act that waits for an event and has no `after_s`",
            "assumed: heard, read back, typed; Sugiyama, 5, calls it laborious and has no figure",
        ),
    ] = 5.0
    react: Annotated[
        bool,
        about(
            "whether staff repair and restore what they see failing; otherwise people do only what acts say"
        ),
    ] = False
    power_s: Annotated[
        PersonTime,
        about(
            "with react, mean time from when a device or unit is off until they have switched it on, or put it into"
            " service again",
            "assumed: noticed, gone to it; one that comes back by itself within a minute mostly does before",
        ),
    ] = 120.0
    points_s: Annotated[
        PersonTime,
        about(
            "with react, mean time from when points lie in no position, or do not move, until they are set by hand",
            "assumed: somebody is at the station",
        ),
    ] = 60.0
    picture_s: Annotated[
        PersonTime,
        about(
            "with react, mean time from the block manager's restart until its controller begins to restore the picture",
            "assumed: an alarm is heard, the line is looked at",
        ),
    ] = 60.0
    silent_s: Annotated[
        PersonTime,
        about(
            "with react, mean time from when a unit is silent until two persons say where it is",
            "assumed: longer than a unit's boot and its crew's, which speaks for itself",
        ),
    ] = 150.0
    road_s: Annotated[
        PersonTime,
        about(
            "with react, mean time from when a level crossing is closed and no train comes until two persons say so",
            "assumed: somebody who waits calls, the line is looked at, staff are sent",
        ),
    ] = 300.0
    guard_s: Annotated[
        PersonTime,
        about(
            "with react, mean time from when a level crossing is out of order until somebody guards it",
            "assumed: reported, and gone to by road",
        ),
    ] = 900.0
    notice_s: Annotated[
        PersonTime,
        about(
            "mean time from the block manager's failure until its dispatcher orders substitute working",
            "assumed: an alarm, a restart tried, the stations called",
        ),
    ] = 300.0
    reach_s: Annotated[
        PersonTime,
        about(
            "mean time until staff have come to a station that has none, for substitute working, and with react to a"
            " set that stands without charge",
            "assumed: by road along a branch line of 20 km",
        ),
    ] = 1500.0
    telephone_s: Annotated[
        PersonTime,
        about(
            "mean time of a sentence by telephone with its read-back, in substitute working",
            "assumed: called, said, read back, written down",
        ),
    ] = 40.0
    crank_s: Annotated[
        PersonTime,
        about(
            "mean time to set and lock one set of points by hand, in substitute working",
            "assumed: a walk of 100 m, the crank, the lock",
        ),
    ] = 120.0
    board_s: Annotated[
        PersonTime,
        about(
            "mean time for the pilot to board or leave a train, and for its driver to cut the unit out",
            "assumed: a walk along the platform",
        ),
    ] = 20.0

    def mean_s(self, pause: Pause) -> float:
        """The mean of a pause, s."""
        mean_s: float = getattr(self, pause.value)
        return mean_s * self.times


class Pause(Enum):
    """What people take time for, by the key of its mean."""

    BOOT = "boot_s"
    SIGN_ON = "sign_on_s"
    ENTRY = "entry_s"
    SIGN_OFF = "sign_off_s"
    LEAVE = "leave_s"
    GONE = "gone_s"
    STAND = "stand_s"
    KEY = "key_s"
    CROSSING = "crossing_s"
    WORD = "word_s"
    POWER = "power_s"
    POINTS = "points_s"
    PICTURE = "picture_s"
    SILENT = "silent_s"
    ROAD = "road_s"
    FLAG = "flag_s"
    GUARD = "guard_s"
    NOTICE = "notice_s"
    REACH = "reach_s"
    TELEPHONE = "telephone_s"
    CRANK = "crank_s"
    BOARD = "board_s"
