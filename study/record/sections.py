"""Who had which section when: the rows of the tables `blocks` and `blocking`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from study.record.columns import Train, Unit, Way, clock
from study.record.figure import Figure, Kind, ShownIn
from study.wording.catalogue import phrase

_SECTION = Figure(phrase("section"), seen=ShownIn.REPORT, kind=Kind.TEXT)


@dataclass(frozen=True, slots=True)
class SectionHeld:
    """One section and grant: the manager's register (granted, released) and the truth (entered, cleared)."""

    section: Annotated[str, _SECTION]
    unit: Unit
    train: Train
    token: int
    granted_s: Annotated[float, clock("granted")]
    released_s: Annotated[float | None, clock("released")]
    entered_s: Annotated[float | None, clock("entered")]
    cleared_s: Annotated[float | None, clock("cleared")]


@dataclass(frozen=True, slots=True)
class SliceOfBlocking:
    """One slice of an occupation (`study.capacity.occupation`): from when a section can be had until it is free."""

    occupation: Annotated[int, "slices of one number make up one occupation"]
    section: str
    unit: str
    train: Annotated[str, "by which the stock came in"]
    direction: Way
    route: Annotated[str, "by which it came in; empty: it signed on there, or was there"]
    part: Annotated[str, "what the time goes into (`study.capacity.occupation.Part`)"]
    cost: Annotated[str, "what it is spent on, as a planner would change it (`Cost` there)"]
    from_s: float
    to_s: float
    enters_s: Annotated[float, "its front; minus infinity: it was there, infinite: it never comes"]
    leaves_s: Annotated[float, "infinite: it stays"]
    waited_s: Annotated[float, "wanted while it, or its route, was another's: before the occupation begins"]
