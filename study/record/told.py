"""What was sent, what happened and what others say: the rows of the tables `telegrams`, `events` and `comparisons`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final

from study.record.columns import said
from study.record.figure import Adds, Figure, Kind, ShownIn
from study.wording.phrase import Phrase

_FILES: Final = ShownIn.REPORT | ShownIn.TOTALS_COMPARED | ShownIn.ROWS_COMPARED
_LISTED: Final = _FILES | ShownIn.ROWS_LISTED


def _count(en: str, ja: str, seen: ShownIn = _FILES) -> Figure:
    return Figure(Phrase(en, ja), adds=Adds.SUM, seen=seen)


@dataclass(frozen=True, slots=True)
class TelegramsOfWay:
    """One source, destination and kind."""

    source: Annotated[str, said("sent by", "送信元")]
    destination: Annotated[str, said("sent to", "宛先")]
    kind: Annotated[str, said("kind", "種類", ShownIn.REPORT | ShownIn.ROWS_NAMED)]
    sent: Annotated[int, _count("sent", "送信", _LISTED)]
    delivered: Annotated[int, _count("delivered", "到達")]
    lost: Annotated[int, _count("lost", "消失", _LISTED), "by the air"]
    dropped: Annotated[int, _count("dropped", "棄却"), "by the receiver's checks"]
    bytes: Annotated[int, _count("bytes", "バイト", ShownIn.REPORT | ShownIn.ROWS_COMPARED)]


@dataclass(frozen=True, slots=True)
class EventTold:
    """One intervention, refusal, fault: what a person should hear of."""

    t_s: Annotated[float, Figure(Phrase("time", "時刻"), "", 1, seen=ShownIn.REPORT, kind=Kind.CLOCK)]
    source: Annotated[str, said("source", "発生元・出典")]
    kind: Annotated[str, Figure(Phrase("kind", "種別"), seen=ShownIn.REPORT, kind=Kind.WORD)]
    text: Annotated[str, said("text", "内容")]
    text_ja: Annotated[str, "the same in Japanese"] = ""


@dataclass(frozen=True, slots=True)
class ComparedFigure:
    """One figure of ours beside another's."""

    figure: Annotated[str, said("figure", "項目")]
    ours: Annotated[float, Figure(Phrase("ours", "本結果"), "", 2, seen=ShownIn.REPORT)]
    theirs: Annotated[float, Figure(Phrase("theirs", "文献値"), "", 2, seen=ShownIn.REPORT)]
    unit: Annotated[str, said("unit", "編成・単位")]
    difference_percent: Annotated[
        float, Figure(Phrase("difference", "差"), "%", 1, seen=ShownIn.REPORT, kind=Kind.SIGNED), "of theirs"
    ]
    source: Annotated[str, said("source", "発生元・出典")]
    comparable: Annotated[str, said("what is comparable, what not", "比較できる点とできない点")]
