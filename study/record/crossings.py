"""Level crossings: the rows of the tables `crossings` and `warnings`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final

from study.record.columns import Crossing, Hour, Train, Unit, clock, seconds
from study.record.figure import Adds, Figure, Kind, ShownIn
from study.wording.catalogue import phrase

_FILES: Final = ShownIn.REPORT | ShownIn.ROWS_COMPARED
_LISTED: Final = _FILES | ShownIn.ROWS_LISTED
_TOTALS: Final = ShownIn.TOTALS_COMPARED


def _warned(name: str, adds: Adds, over: str = "") -> Figure:
    return Figure(phrase(name), "s", 1, adds, over, _LISTED | _TOTALS)


@dataclass(frozen=True, slots=True)
class CrossingHour:
    """A crossing with a device and an hour of the run, in which its road was closed or not."""

    crossing: Crossing
    hour: Hour
    closed_s: Annotated[
        float,
        Figure(phrase("road closed"), "s", 1, Adds.SUM, seen=_LISTED | ShownIn.LISTED_BY),
        "lamps lit or barriers not raised, in this hour",
    ]
    closures: Annotated[
        int, Figure(phrase("closures"), "", 0, Adds.SUM, seen=_FILES | _TOTALS), "that began in this hour"
    ]
    closure_s_max: Annotated[
        float | None,
        Figure(phrase("longest closure"), "s", 1, Adds.LARGEST, seen=_FILES | _TOTALS),
        "of those, with what of it lies in later hours",
    ]
    trains: Annotated[
        int,
        Figure(phrase("trains over it"), "", 0, Adds.SUM, seen=_LISTED | _TOTALS),
        "whose front came in this hour",
    ]
    warned_s_mean: Annotated[
        float | None,
        _warned("mean warning", Adds.WEIGHED_MEAN, "trains"),
        "before the front; a front without any warning counts as 0",
    ]
    warned_s_min: Annotated[float | None, _warned("least warning", Adds.SMALLEST)]
    warned_s_max: Annotated[
        float | None,
        _warned("longest warning", Adds.LARGEST),
        "of the second train in one closure: from when the first was warned of",
    ]


@dataclass(frozen=True, slots=True)
class CrossingPassage:
    """A front that came onto a crossing with a device."""

    crossing: Crossing
    train: Train
    unit: Unit
    at_s: Annotated[float, clock("front on the road")]
    speed_mps: float
    warned_s: Annotated[float, seconds("warning before it", 1), "since lamps shine; 0: none did"]
    closed_s: Annotated[
        float | None,
        seconds("closed before it", 1),
        "since the barriers are down; none: they are not, or there are none",
    ]
    ran_s: Annotated[
        float | None,
        seconds("since it began to move", 1),
        "none: its unit has not said so",
    ]
    from_stand: Annotated[
        bool,
        Figure(phrase("from a stand within the approach"), seen=ShownIn.REPORT, kind=Kind.WORD),
        "began to move while the crossing warned",
    ]
