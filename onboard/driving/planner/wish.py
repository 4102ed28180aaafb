"""What a planner wishes of the driving: how trains run between stops, and where their reserve of time is kept."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Final

from pydantic import Field

from network.files.kinds import about
from network.files.quantities import Share, Wait
from network.files.toml_input import Record


class Style(StrEnum):
    """How a train runs from stop to stop in the time that it has."""

    HOLD = "hold"  # one constant speed, the lowest that is fast enough
    COAST = "coast"  # power to one speed, hold it, shut off at one place, coast, brake
    OPTIMAL = "optimal"  # least energy


class Margin(StrEnum):
    """Where the time goes that a journey has beyond its standard running times (余裕時分)."""

    END = "end"  # every hop in its standard time: what is over stays in hand, and is stood off where a departure waits
    SPREAD = "spread"  # over the hops in proportion to their least times
    SAVING = "saving"  # to the hops where a second saves most


class Planning(Record):
    """`[planning]`: how the time of a journey is spent, by trains whose law follows a plan."""

    style: Annotated[
        Style,
        Field(strict=False),
        about("hold: one speed; coast: one speed, then shut off at one place; optimal: least energy"),
    ] = Style.OPTIMAL
    margin: Annotated[
        Margin,
        Field(strict=False),
        about(
            "end: hops in their standard times, the rest stays in hand; spread: over the hops in proportion; saving:"
            " where a second saves most energy"
        ),
    ] = Margin.SAVING
    late_reserve_share: Annotated[
        Share,
        about(
            "of the least running time, that a plan takes beyond it however late the train is: the last seconds cost"
            " more than all others",
            "assumed: what an expert driver leaves",
        ),
    ] = 0.01
    free_reserve_share: Annotated[
        Share,
        about("the same where nobody says when the train is to be there", "assumed: a usual supplement"),
    ] = 0.05
    plan_tolerance_s: Annotated[
        Wait,
        about(
            "a plan may be this much later than the timetable where trains cannot meet, and on time where they can;"
            " never early",
            "assumed: none; a timetable in whole minutes hides up to 59 s",
        ),
    ] = 0.0


PLAIN: Final = Planning()  # what nobody wishes otherwise
