"""The road at level crossings: the rows of the table `road`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from study.record.columns import Crossing, Hour
from study.record.figure import Adds, Figure, ShownIn
from study.wording.catalogue import phrase


@dataclass(frozen=True, slots=True)
class RoadHour:
    """A crossing with a road and an hour of the run, or one in which vehicles came, or stood."""

    crossing: Crossing
    hour: Hour
    passages: Annotated[
        int,
        Figure(phrase("road vehicles"), "", 0, Adds.SUM, seen=ShownIn.REPORT),
        "of vehicles that wanted to come in it",
    ]
    waited_h: Annotated[
        float,
        Figure(phrase("waiting time of the road"), "h", 2, Adds.SUM, seen=ShownIn.REPORT),
        "vehicle-hours, over passages that nothing hinders",
    ]
    waited_s_max: Annotated[
        float, Figure(phrase("longest wait of a vehicle"), "s", 0, Adds.LARGEST, seen=ShownIn.REPORT)
    ]
    queue: Annotated[
        int,
        Figure(phrase("longest queue"), "", 0, Adds.LARGEST, seen=ShownIn.REPORT),
        "vehicles that stand in one lane",
    ]
