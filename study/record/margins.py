"""The margin (余裕時分) of every hop of the timetable: the rows of the table `margins`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final

from study.record.columns import From, Revenue, To, Train, seconds
from study.record.figure import Figure, Kind, ShownIn
from study.wording.catalogue import phrase

_FILES: Final = ShownIn.REPORT | ShownIn.ROWS_COMPARED


@dataclass(frozen=True, slots=True)
class HopMargin:
    """One train and hop: the margin as planned, and what was left of it on arrival."""

    unit: str
    train: Train
    revenue: Revenue
    from_station: From
    to_station: To
    planned_s: Annotated[
        float,
        seconds("planned", seen=_FILES),
        "from departure to the latest arrival that keeps arrival and next departure",
    ]
    least_s: Annotated[
        float, seconds("least", 1, seen=_FILES), "least running time at the limits of the line"
    ]
    attainable_s: Annotated[
        float, seconds("attainable", 1), "the same as far below the limits as trains are driven"
    ]
    margin_s: Annotated[
        float, seconds("margin", 1, Kind.SIGNED, _FILES | ShownIn.ROWS_LISTED), "planned less least"
    ]
    margin_percent: Annotated[
        float | None, Figure(phrase("margin"), "%", kind=Kind.SIGNED), "of the least running time"
    ]
    run_s: Annotated[float | None, seconds("run", 1, seen=_FILES)]
    left_s: Annotated[
        float | None,
        seconds("left", 1, Kind.SIGNED, _FILES | ShownIn.ROWS_LISTED),
        "from the true arrival to that latest one; what never came counts as there when the run ends whatever happens,"
        " what was cancelled as late as stated",
    ]
