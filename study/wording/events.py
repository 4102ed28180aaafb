"""Events that a person should hear of, as sentences: one template a type of event and language.

`EVENT_WORDINGS` is the whole table. A field that may be empty has a clause of its own, which then is left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from network.clock import clock
from onboard import crossing_notes, notes
from onboard.vehicle import DOORS_OPEN
from radio.noted import Noted, TelegramDropped
from simulation import events
from simulation.events import EventType
from simulation.judge.checkers import Checker
from study.wording.catalogue import phrase
from study.wording.outcome import checker_name, unsafe_text
from study.wording.phrase import NOTHING, Names, Phrase
from study.wording.procedure import says_text
from study.wording.reasons import reason
from study.wording.script import act_text, fault_text, value_text
from study.wording.telegrams import telegram
from wayside import crossing_said, said


@dataclass(frozen=True, slots=True)
class EventWording:
    """How the report tells a type of event: under which kind, in which words, with which clauses where it has them."""

    kind: str
    words: Phrase
    clauses: Mapping[str, Phrase] = field(default_factory=dict[str, Phrase])


_WHY: Final = {"why": phrase(": {}")}
_OF_UNIT: Final = {
    "unit_id": phrase(" to {}"),
    "section_ids": phrase(", sections {}"),
    "token": phrase(", token {}"),
    "other_id": phrase(", against {}"),
    **_WHY,
}
_AT_POINTS: Final = {
    "section_id": phrase(", section {}"),
    "token": phrase(", token {}"),
    **_WHY,
}
_SAID_BY_TWO: Final = phrase(", as another person has said: proofs are taken back")
_OF_STEP: Final = {"train": phrase(" for train {}"), **_WHY}
_LEVELS: Final[Mapping[events.BatteryLevel, Phrase]] = {
    events.BatteryLevel.ENOUGH: phrase("enough", "battery level"),
    events.BatteryLevel.LOW: phrase("low, heating and cooling are off", "battery level"),
    events.BatteryLevel.EMPTY: phrase("empty", "battery level"),
}
_DOORS_OPEN: Final = EventWording("doors", phrase("its doors are not shown as closed", "reason"))
EVENT_WORDINGS: Final[Mapping[EventType, EventWording]] = {
    notes.Intervention: EventWording("intervention", phrase("{level}")),
    notes.EmergencyReleased: EventWording(
        "intervention", phrase("the driver has acknowledged the emergency stop")
    ),
    notes.RouteDenied: EventWording("refusal", phrase("route {route_id} refused{why}"), _WHY),
    notes.ThrowDenied: EventWording(
        "refusal",
        phrase("points {points_id} refused{why}"),
        _WHY,
    ),
    notes.SignOnDenied: EventWording("refusal", phrase("sign-on refused{why}"), _WHY),
    said.Refused: EventWording(
        "refusal",
        phrase("refused{unit_id}{section_ids}{token}{other_id}{why}"),
        _OF_UNIT,
    ),
    said.TrackChanged: EventWording("order", phrase("{why}", "clause")),
    said.TrainCut: EventWording("order", phrase("{why}", "clause")),
    said.GoesOnAs: EventWording("order", phrase("{unit_id} goes on as {train}")),
    said.WaitBidden: EventWording(
        "order",
        phrase("{by}: {unit_id} is kept back for {hold_s:.0f} s{other_id}{section_id}"),
        {
            "other_id": phrase(" at most, behind {}", "kept back"),
            "section_id": phrase(" over {}", "kept back"),
        },
    ),
    said.WaitOver: EventWording("order", phrase("{unit_id} is not kept back any more")),
    said.TrainEndBidden: EventWording(
        "order", phrase("{by}: the train of {unit_id} ends where it stands, and its set goes on as {train}")
    ),
    said.RouteAskedBack: EventWording("order", phrase("{why}", "clause")),
    said.NotDone: EventWording(
        "refusal", phrase("{unit_id} refuses an order about route {route_id}{why}"), _WHY
    ),
    said.ThrowRefused: EventWording(
        "refusal",
        phrase("points {points_id}: command of {unit_id} refused{section_id}{token}{why}"),
        _AT_POINTS,
    ),
    said.Contradicted: EventWording(
        "contradiction",
        phrase("contradiction{unit_id}{section_ids}{token}{other_id}{why}"),
        _OF_UNIT | {"unit_id": phrase(" of {}")},
    ),
    events.FaultBegan: EventWording("fault", phrase("{fault}")),
    events.FaultOver: EventWording("fault over", phrase("{fault} is over")),
    events.Acted: EventWording(
        "act",
        phrase("{acted}{unsaid}"),
        {"unsaid": phrase("; leaves out {}, where its train stands or which its unit shows as held")},
    ),
    events.CameLate: EventWording(
        "late",
        phrase("{train} ({unit_id}) comes {late_s:.0f} s late to its portal"),
    ),
    events.DoorsHeld: EventWording(
        "doors",
        phrase(
            "doors of {train} ({unit_id}) at {station} closed at {until}:"
            " {people_s:.0f} s people, {doors_s:.0f} s doors"
        ),
    ),
    notes.PositionFault: EventWording("fault", phrase("position fault{why}"), _WHY),
    notes.PositionFound: EventWording("position found", phrase("the position is known again")),
    notes.FoundElsewhere: EventWording(
        "fix refused",
        phrase("{reader} gives a position where the train does not hold all sections"),
    ),
    notes.FixTaken: EventWording(
        "fix",
        phrase("fix by {reader} after {after}: the position moved by {correction_m:+.2f} m"),
    ),
    notes.FixRefused: EventWording("fix refused", phrase("the fix by {reader} lies outside the bounds")),
    notes.FixMissed: EventWording("fix missed", phrase("{reader} detects nothing where it should")),
    notes.ForeignTrack: EventWording(
        "foreign track",
        phrase("{reader} sees a track that is not the map's"),
    ),
    notes.StoppedShort: EventWording(
        "stop",
        phrase("stands {short_m:.1f} m before its target{why}"),
        _WHY,
    ),
    notes.StopImpossible: EventWording(
        "stop",
        phrase("the stop at {station} cannot be made{why}"),
        _WHY,
    ),
    notes.UnableToLeave: EventWording("unable to leave", phrase("unable to leave {station}{why}"), _WHY),
    notes.AbleToLeave: EventWording("able to leave", phrase("able to leave {station}")),
    notes.Overran: EventWording(
        "stop",
        phrase("stands {beyond_m:.2f} m beyond the mark"),
    ),
    events.ProcedureStep: EventWording("substitute working", phrase("to {to_whom}: {says}")),
    events.StepLeftOut: EventWording(
        "substitute working", phrase("{step} in {block}{train} left out{why}"), _OF_STEP
    ),
    events.StepOutOfOrder: EventWording(
        "substitute working", phrase("{step} in {block}{train} out of order{why}"), _OF_STEP
    ),
    events.StepRefused: EventWording(
        "substitute working", phrase("{step} in {block}{train} cannot be done{why}"), _OF_STEP
    ),
    events.BatteryAt: EventWording("battery", phrase("the battery of {unit_id}: {level}")),
    events.UnitRestrains: EventWording(
        "substitute working", phrase("{unit_id} is told to go, and its unit does not let it")
    ),
    events.SignalActed: EventWording(
        "act",
        phrase("{does}{signal_id}{lever_id}"),
        {"signal_id": phrase(" at signal {}"), "lever_id": phrase(" {}", "direction lever")},
    ),
    events.SignalShows: EventWording("signal", phrase("signal {signal_id} shows {aspect}")),
    events.SignalPassed: EventWording("signal", phrase("{unit_id} passes signal {signal_id} at {aspect}")),
    events.WrongDeparture: EventWording(
        "signal", phrase("wrong departure of {unit_id} past signal {signal_id}")
    ),
    events.Unsafe: EventWording("unsafe", phrase("{unit_id} {how}")),
    events.VehicleStruck: EventWording(
        "unsafe", phrase("{unit_id} strikes a road vehicle at crossing {crossing_id} at {speed_mps:.1f} m/s")
    ),
    crossing_said.CrossingUnproven: EventWording(
        "level crossing", phrase("the crossing does not prove closed{why}"), _WHY
    ),
    crossing_said.NoTrainSaid: EventWording(
        "level crossing", phrase("{by} says that no train comes{agreed}")
    ),
    crossing_notes.CrossingProofLost: EventWording(
        "level crossing", phrase("the proof of level crossing {crossing_id} holds no more{why}"), _WHY
    ),
    crossing_notes.CrossingCreep: EventWording(
        "level crossing", phrase("the driver has leave to creep over level crossing {crossing_id}{guarded}")
    ),
    events.Collision: EventWording("unsafe", Phrase("{text}", checker_name(Checker.SUMO_COLLISION.value).ja)),
    events.PointsForced: EventWording("unsafe", phrase("points {points_id} were run through")),
    TelegramDropped: EventWording(
        "telegram",
        phrase("telegram dropped by {receiver}{kind}{source}{why}"),
        {"kind": phrase(": {}", "clause"), "source": phrase(" of {}", "clause"), **_WHY},
    ),
    said.NoOrderKnown: EventWording("order", phrase("no order is known in which all can finish: {unit_ids}")),
    notes.UnitRestarted: EventWording("fault", phrase("the unit is switched on again")),
    notes.VehicleUnfit: EventWording("fault", phrase("the vehicle is not in order{why}"), _WHY),
    notes.Mismatch: EventWording(
        "contradiction", phrase("register and unit contradict each other{why}"), _WHY
    ),
    said.PointsUnproven: EventWording(
        "points",
        phrase("points {points_id} of {unit_id} not proven{section_id}{token}{why}"),
        _AT_POINTS,
    ),
    events.Reversed: EventWording("reversal", phrase("{unit_id} changes ends")),
    events.Entered: EventWording("train", phrase("{train} ({unit_id}) comes onto the line")),
    events.Left: EventWording("train", phrase("{unit_id} has left the line")),
}


def wording_of(event: Noted) -> EventWording | None:
    """How the report tells an event; None where it does not. Doors alone, which people hold open, are no fault."""
    if isinstance(event, notes.VehicleUnfit) and event.why == DOORS_OPEN:
        return _DOORS_OPEN
    return EVENT_WORDINGS.get(type(event))


def event_text(event: Noted, names: Names) -> Phrase:
    """An event as a sentence, with the names of stations."""
    wording = wording_of(event) or EVENT_WORDINGS[type(event)]
    return wording.words.fill(
        **{name: _part(wording, name, value) for name, value in _values(event, names).items()}
    )


def _part(wording: EventWording, name: str, value: object) -> object:
    clause = wording.clauses.get(name)
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
            acted = act_text(event.act, "", event.target, event.section_ids, notch=event.notch)
            return {"acted": acted, "unsaid": Phrase(", ".join(event.unsaid_section_ids))}
        case events.ProcedureStep(step=step, block=block, train=train):
            fields["says"] = says_text(step, block, train)
        case events.DoorsHeld():
            fields["until"] = clock(int(event.until_s))
        case notes.UnableToLeave(why=why):
            fields["why"] = reason(why, names)
        case events.BatteryAt(level=level):
            fields["level"] = _LEVELS[level]
        case events.Unsafe():
            fields["how"] = unsafe_text(event)
        case crossing_notes.CrossingCreep(guarded=guarded):
            fields["guarded"] = phrase(", its road stopped by hand") if guarded else NOTHING
        case crossing_said.NoTrainSaid(agreed=agreed):
            fields["agreed"] = _SAID_BY_TWO if agreed else NOTHING
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
