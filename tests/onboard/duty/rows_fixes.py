"""Rows of the table of the duty for trains without a reader of tags: virtual tags, a position found anew."""

from typing import Final

from msgspec.structs import replace

from onboard import notes
from onboard.authority.records import Authority, Commit, OpenCommand, Renew, RequestKind, Write
from onboard.duty.records import (
    AtMark,
    DrivingOrder,
    DutyPhase,
    FoundByOtherSensor,
    Looked,
    StopLimit,
    TagReached,
)
from tests.onboard.duty.stage import (
    APPROACH,
    AT_A,
    AT_B,
    FINISHED,
    HOLDS_8,
    HOLDS_ALL,
    HOLDS_REST,
    ON_6,
    ON_SIGHT,
    ON_THE_LINE,
    P7,
    POSITION,
    RELEASE_LATER,
    REPORT_OPEN,
    RUNNING,
    STANDING,
    STATES,
    Case,
    changed,
    commanded,
    holds,
    moved,
    reported,
)

ARRIVAL: Final = 7
THROWING: Final = replace(
    RUNNING, authority=replace(HOLDS_REST, commands=(OpenCommand(P7, sent=True),)), wanted=(P7,)
)
UNTOLD: Final = moved(ON_6, untold=True)
ELSEWHERE: Final = replace(ON_SIGHT, authority=Authority(held=("3", "5"), commandable=("5",), on_line=True))
UPON_5: Final = replace(
    STANDING, authority=HOLDS_ALL, limit=StopLimit(1, "5", "points not proven"), may_ask=True, may_leave=True
)
BEHIND: Final = Authority(held=("7", "8"), commandable=("7",), on_line=True)

FIXES: Final[dict[str, Case]] = {
    **{
        f"at the place of {tag}, by its estimate, the arrival points are thrown": (
            RUNNING,
            TagReached(index),
            ON_6,
            THROWING,
            (Commit(P7), *commanded(P7)),
        )
        for tag, index in (("the approach tag", APPROACH), ("the next tag", POSITION))
    },
    "at the place of the arrival tag, by its estimate, nothing is proved and nothing given back": changed(
        replace(FINISHED, authority=BEHIND, entered=frozenset({"7"})), TagReached(ARRIVAL), AT_B
    ),
    **{
        f"at a place before the approach nothing is thrown: {at.value}": changed(
            STATES[at], TagReached(0), STATES[at].place
        )
        for at in ON_THE_LINE
        if at is not DutyPhase.FINISHED
    },
    "a fix ends running on sight where the register has the train as well": (
        ON_SIGHT,
        FoundByOtherSensor(),
        UNTOLD,
        replace(THROWING, place=UNTOLD, entered=frozenset({"3", "5", "6"})),
        (
            Write(notes.PositionFound()),
            Write(notes.Resumed(next_target=1)),
            DrivingOrder.RESUME,
            Commit(P7),
            *commanded(P7),
        ),
    ),
    "found where the register has it not: the position is given up, on sight": changed(
        ELSEWHERE,
        FoundByOtherSensor(),
        UNTOLD,
        (Write(notes.PositionFound()), DrivingOrder.LOSE),
        place=moved(UNTOLD, known=False, emergency=True),
    ),
    "at a stop, its bounds reaching onto points not proven: the position is given up, its crew looks at them": changed(
        UPON_5,
        Looked(),
        moved(AT_A, perhaps=2),
        (DrivingOrder.LOSE, RELEASE_LATER),
        phase=DutyPhase.ON_SIGHT,
        stands_at=0,
        released=False,
        place=moved(AT_A, perhaps=2, known=False, emergency=True),
    ),
    "at its mark, unsure where it stands, it waits for the driver's word": changed(
        replace(FINISHED, phase=DutyPhase.STANDING, may_leave=False),
        FoundByOtherSensor(),
        moved(AT_B, unsure=True),
        (Write(notes.PositionFound()),),
    ),
    "and with it has arrived": changed(
        replace(FINISHED, phase=DutyPhase.STANDING, place=moved(AT_B, unsure=True), authority=BEHIND),
        AtMark(1, beyond_m=10.0),
        AT_B,
        (Renew(RequestKind.REPORT), holds("8"), *reported("8")),
        authority=replace(HOLDS_8, requests=(REPORT_OPEN,)),
    ),
    **{
        f"found: {at.value}": changed(
            STATES[at], FoundByOtherSensor(), STATES[at].place, (Write(notes.PositionFound()),)
        )
        for at in ON_THE_LINE
        if at not in (DutyPhase.STANDING, DutyPhase.ON_SIGHT)
    },
}
