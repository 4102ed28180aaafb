"""What was sent, what happened and what others say: the rows of the tables `telegrams`, `events` and `comparisons`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final

from study.record.columns import said_in_both
from study.record.figure import Adds, Figure, Kind, ShownIn
from study.wording.catalogue import phrase

_FILES: Final = ShownIn.REPORT | ShownIn.TOTALS_COMPARED | ShownIn.ROWS_COMPARED
_LISTED: Final = _FILES | ShownIn.ROWS_LISTED


def _count(name: str, seen: ShownIn = _FILES) -> Figure:
    return Figure(phrase(name), adds=Adds.SUM, seen=seen)


@dataclass(frozen=True, slots=True)
class TelegramsOfWay:
    """One source, destination and kind."""

    source: Annotated[str, said_in_both("sent by")]
    destination: Annotated[str, said_in_both("sent to")]
    kind: Annotated[str, said_in_both("kind", ShownIn.REPORT | ShownIn.ROWS_NAMED)]
    sent: Annotated[int, _count("sent", _LISTED)]
    delivered: Annotated[int, _count("delivered")]
    lost: Annotated[int, _count("lost", _LISTED), "by the air"]
    dropped: Annotated[int, _count("dropped"), "by the receiver's checks"]
    bytes: Annotated[int, _count("bytes", ShownIn.REPORT | ShownIn.ROWS_COMPARED)]


@dataclass(frozen=True, slots=True)
class EventInWords:
    """One intervention, refusal, fault: what a person should hear of."""

    t_s: Annotated[float, Figure(phrase("time"), "", 1, seen=ShownIn.REPORT, kind=Kind.CLOCK)]
    source: Annotated[str, said_in_both("source")]
    kind: Annotated[str, said_in_both("kind")]
    text: Annotated[str, said_in_both("text")]
    text_ja: Annotated[str, "the same in Japanese"] = ""


@dataclass(frozen=True, slots=True)
class ComparedFigure:
    """One figure of ours beside another's."""

    figure: Annotated[str, said_in_both("figure")]
    ours: Annotated[float, Figure(phrase("ours"), "", 2, seen=ShownIn.REPORT)]
    theirs: Annotated[float, Figure(phrase("theirs"), "", 2, seen=ShownIn.REPORT)]
    unit: Annotated[str, said_in_both("unit")]
    difference_percent: Annotated[
        float, Figure(phrase("difference"), "%", 1, seen=ShownIn.REPORT, kind=Kind.SIGNED), "of theirs"
    ]
    source: Annotated[str, said_in_both("source")]
    comparable: Annotated[str, said_in_both("what is comparable, what not")]
