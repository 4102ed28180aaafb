"""Events that a person should hear of, as sentences: one template a type of event and language.

`TOLD` is the whole table. A field that may be empty has a clause of its own, which then is left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from network.clock import clock
from onboard import notes
from radio.noted import Noted, TelegramDropped
from simulation import events
from simulation.events import EventType
from simulation.judge.checkers import Checker
from study.wording.outcome import CHECKERS, unsafe_text
from study.wording.phrase import NOTHING, Names, Phrase
from study.wording.script import act_text, fault_text, value_text
from study.wording.telegrams import telegram
from wayside import said


@dataclass(frozen=True, slots=True)
class EventWording:
    """How the report tells a type of event: under which kind, in which words, with which clauses where it has them."""

    kind: str
    words: Phrase
    clauses: Mapping[str, Phrase] = field(default_factory=dict[str, Phrase])


_WHY: Final = {"why": Phrase(": {}", "：{}")}
_OF_UNIT: Final = {
    "unit_id": Phrase(" to {}", "{}の"),
    "section_ids": Phrase(", sections {}", "（区間 {}）"),
    "token": Phrase(", token {}", "、トークン {}"),
    "other_id": Phrase(", against {}", "、相手 {}"),
    **_WHY,
}
_AT_POINTS: Final = {
    "section_id": Phrase(", section {}", "（{}区間）"),
    "token": Phrase(", token {}", "、トークン {}"),
    **_WHY,
}
TOLD: Final[Mapping[EventType, EventWording]] = {
    notes.Intervention: EventWording("intervention", Phrase("{level}", "{level}")),
    notes.EmergencyReleased: EventWording(
        "intervention", Phrase("the driver has acknowledged the emergency stop", "非常停止を運転士が確認")
    ),
    notes.RouteDenied: EventWording(
        "refusal", Phrase("route {route_id} refused{why}", "進路 {route_id} の要求を拒否された{why}"), _WHY
    ),
    notes.ThrowDenied: EventWording(
        "refusal",
        Phrase("points {points_id} refused{why}", "転てつ機 {points_id} の制御を拒否された{why}"),
        _WHY,
    ),
    notes.SignOnDenied: EventWording(
        "refusal", Phrase("sign-on refused{why}", "在線登録を拒否された{why}"), _WHY
    ),
    said.Refused: EventWording(
        "refusal",
        Phrase(
            "refused{unit_id}{section_ids}{token}{other_id}{why}",
            "{unit_id}要求を拒否{section_ids}{token}{other_id}{why}",
        ),
        _OF_UNIT,
    ),
    said.ThrowRefused: EventWording(
        "refusal",
        Phrase(
            "points {points_id}: command of {unit_id} refused{section_id}{token}{why}",
            "{unit_id}からの転てつ機 {points_id} の制御を拒否{section_id}{token}{why}",
        ),
        _AT_POINTS,
    ),
    said.Contradicted: EventWording(
        "contradiction",
        Phrase(
            "contradiction{unit_id}{section_ids}{token}{other_id}{why}",
            "{unit_id}登録が矛盾{section_ids}{token}{other_id}{why}",
        ),
        _OF_UNIT | {"unit_id": Phrase(" of {}", "{}の")},
    ),
    events.FaultBegan: EventWording("fault", Phrase("{fault}", "{fault}")),
    events.FaultOver: EventWording("fault over", Phrase("{fault}", "{fault}")),
    events.Acted: EventWording("act", Phrase("{acted}", "{acted}")),
    events.CameLate: EventWording(
        "late",
        Phrase(
            "{train} ({unit_id}) comes {late_s:.0f} s late to its portal",
            "{train}（{unit_id}）が線区端に {late_s:.0f} 秒遅れて到着",
        ),
    ),
    events.DoorsHeld: EventWording(
        "doors",
        Phrase(
            "doors of {train} ({unit_id}) at {station} closed at {until}:"
            " {people_s:.0f} s for passengers, {doors_s:.0f} s for doors",
            "{train}（{unit_id}）{station} の戸閉が {until}（客扱い {people_s:.0f} 秒、戸閉不良 {doors_s:.0f} 秒）",
        ),
    ),
    notes.PositionFault: EventWording("fault", Phrase("position fault{why}", "位置検知異常{why}"), _WHY),
    notes.PositionFound: EventWording("position found", Phrase("the position is known again", "位置が確定")),
    notes.FoundElsewhere: EventWording(
        "fix refused",
        Phrase(
            "{reader} gives a position where the train does not hold all sections",
            "{reader}の示す位置が確保区間の外のため棄却",
        ),
    ),
    notes.FixTaken: EventWording(
        "fix",
        Phrase(
            "fix by {reader} after {after}: the position moved by {correction_m:+.2f} m",
            "{reader}による位置補正 {correction_m:+.2f} m（直前：{after}）",
        ),
    ),
    notes.FixRefused: EventWording(
        "fix refused",
        Phrase("the fix by {reader} lies outside the bounds", "{reader}の示す位置が誤差範囲の外のため棄却"),
    ),
    notes.FixMissed: EventWording(
        "fix missed", Phrase("{reader} detects nothing where it should", "{reader}が検知すべき所で検知なし")
    ),
    notes.ForeignTrack: EventWording(
        "foreign track",
        Phrase(
            "{reader} sees a track that is not the map's", "{reader}の測定が地図と一致しない（異曲率区間）"
        ),
    ),
    notes.StoppedShort: EventWording(
        "stop",
        Phrase("stands {short_m:.1f} m before its target{why}", "停止位置の {short_m:.1f} m 手前で停止{why}"),
        _WHY,
    ),
    notes.StopImpossible: EventWording(
        "stop",
        Phrase("the stop at {station} cannot be made{why}", "{station} の停止位置に停止できない{why}"),
        _WHY,
    ),
    notes.UnableToLeave: EventWording(
        "unable to leave", Phrase("unable to leave {station}{why}", "{station} を出発できない{why}"), _WHY
    ),
    notes.AbleToLeave: EventWording(
        "able to leave", Phrase("able to leave {station}", "{station} を出発できる")
    ),
    notes.Overran: EventWording(
        "stop",
        Phrase("stands {beyond_m:.2f} m beyond the mark", "停止目標を {beyond_m:.2f} m 行き過ぎて停止"),
    ),
    events.Unsafe: EventWording("unsafe", Phrase("{unit_id} {how}", "{unit_id}{how}")),
    events.Collision: EventWording("unsafe", Phrase("{text}", CHECKERS[Checker.SUMO_COLLISION])),
    events.PointsForced: EventWording(
        "unsafe", Phrase("points {points_id} were run through", "転てつ機 {points_id} の割出し")
    ),
    TelegramDropped: EventWording(
        "telegram",
        Phrase(
            "telegram dropped by {receiver}{kind}{source}{why}", "{receiver}が電文を棄却{kind}{source}{why}"
        ),
        {"kind": Phrase(": {}", "（{}）"), "source": Phrase(" of {}", "、送信元 {}"), **_WHY},
    ),
    said.PointsUnproven: EventWording(
        "points",
        Phrase(
            "points {points_id} of {unit_id} not proven{section_id}{token}{why}",
            "{unit_id}の転てつ機 {points_id} が未照査{section_id}{token}{why}",
        ),
        _AT_POINTS,
    ),
    events.Reversed: EventWording(
        "reversal", Phrase("{unit_id} changes ends", "{unit_id} が折返し（エンド交換）")
    ),
    events.Entered: EventWording(
        "train", Phrase("{train} ({unit_id}) comes onto the line", "{train}（{unit_id}）が線区に進入")
    ),
    events.Left: EventWording("train", Phrase("{unit_id} has left the line", "{unit_id} が線区から進出")),
}


def event_text(event: Noted, names: Names) -> Phrase:
    """An event as a sentence, with the names of stations."""
    told = TOLD[type(event)]
    return told.words.of(**{name: _part(told, name, value) for name, value in _values(event, names).items()})


def _part(told: EventWording, name: str, value: object) -> object:
    clause = told.clauses.get(name)
    if clause is None:
        return value
    words = value if isinstance(value, Phrase) else Phrase(str(value))
    return (
        NOTHING
        if words.en in ("", "0")
        else Phrase(clause.en.format(words.en), clause.ja.format(words.in_("ja")))
    )


def _values(event: Noted, names: Names) -> dict[str, object]:
    """The fields of an event in words, figures as they are, and what several fields say together."""
    fields: dict[str, object] = {name: getattr(event, name) for name in event.__struct_fields__}
    match event:
        case events.FaultBegan() | events.FaultOver():
            return {"fault": fault_text(event.kind, event.target, event.parameters)}
        case events.Acted():
            return {"acted": act_text(event.act, "", event.target, event.section_ids)}
        case events.DoorsHeld():
            fields["until"] = clock(int(event.until_s))
        case events.Unsafe():
            fields["how"] = unsafe_text(event)
        case TelegramDropped():
            fields["kind"] = NOTHING if event.kind is None else telegram(event.kind)
        case _:
            pass
    return {name: _in_words(name, value, names) for name, value in fields.items()}


def _in_words(name: str, value: object, names: Names) -> object:
    if isinstance(value, float | Phrase):
        return value
    if name == "station":
        return names.get(str(value), Phrase(str(value)))
    words = value_text(name, value)
    return value if isinstance(value, int) and words.en == str(value) else words  # a template says its digits
