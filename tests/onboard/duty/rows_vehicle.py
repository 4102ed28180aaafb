"""Rows of the table of the duty for what the vehicle shows of itself: next state and actions."""

from __future__ import annotations

from typing import Final

from msgspec.structs import replace

from onboard import notes
from onboard.authority.records import (
    Write,
)
from onboard.duty.records import (
    Order,
    Phase,
    VehicleChecked,
)
from tests.onboard.duty.stage import (
    AT_A,
    BEFORE_7,
    HOLDS_ALL,
    HOLDS_REST,
    ON_6,
    ON_THE_LINE,
    P5,
    P7,
    RELEASE_LATER,
    RUNNING,
    STANDING,
    STATES,
    TO_THE_END,
    Case,
    moved,
)

CLEARED_TO_8: Final = replace(RUNNING, authority=replace(HOLDS_REST, proven=(P7,)), limit=TO_THE_END)

VEHICLE: Final[dict[str, Case]] = {
    **{
        f"the vehicle is not in order: it does not start: {at.value}": (
            STATES[at],
            VehicleChecked(),
            moved(STATES[at].place, unfit="doors not closed"),
            replace(STATES[at], place=moved(STATES[at].place, unfit="doors not closed")),
            (Write(notes.VehicleUnfit(why="doors not closed")),),
        )
        for at in ON_THE_LINE
        if at not in (Phase.RUNNING, Phase.ON_SIGHT)
    },
    **{
        f"the vehicle is not in order: it is stopped: {at.value}": (
            STATES[at],
            VehicleChecked(),
            moved(STATES[at].place, unfit="brake not in order"),
            replace(STATES[at], place=moved(STATES[at].place, unfit="brake not in order")),
            (Write(notes.VehicleUnfit(why="brake not in order")), Order.STOP),
        )
        for at in (Phase.RUNNING, Phase.ON_SIGHT)
    },
    "it stands short of its mark: stopped all the same, and the driver acknowledges": (
        CLEARED_TO_8,
        VehicleChecked(),
        moved(ON_6, stands=True, unfit="doors not closed"),
        replace(CLEARED_TO_8, place=moved(ON_6, stands=True, unfit="doors not closed"), released=False),
        (Write(notes.VehicleUnfit(why="doors not closed")), Order.STOP, RELEASE_LATER),
    ),
    "a vehicle in order again lets a train depart that is ready": (
        replace(
            STANDING, authority=replace(HOLDS_ALL, proven=(P5,)), limit=BEFORE_7, may_ask=True, may_leave=True
        ),
        VehicleChecked(),
        AT_A,
        replace(
            STANDING,
            phase=Phase.RUNNING,
            authority=replace(HOLDS_ALL, proven=(P5,)),
            limit=BEFORE_7,
            may_ask=True,
            may_leave=True,
        ),
        (Write(notes.VehicleFit()), Write(notes.Departs(station="A")), Order.DEPART),
    ),
}
