"""Faults, acts and expectations of a drill in words, from what they are: kind, target, figures, events."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Any, Final

from network.clock import clock
from network.raw import is_row
from simulation.events import WORLD
from simulation.faults.links import BOTH_WAYS, FaultyLink
from simulation.faults.script import Act, Expectation, Matcher, ScriptedFault
from study.wording.catalogue import phrase, phrase_or_name, phrases_of
from study.wording.event_names import EVENT_NAMES
from study.wording.parties import party
from study.wording.phrase import NOTHING, Phrase, joined_phrases
from study.wording.procedure import act_step, role_name, step_name
from study.wording.reasons import reason

LEVELS: Final[Mapping[int, Phrase]] = {
    0: phrase("ended"),
    1: phrase("service brake"),
    2: phrase("emergency brake"),
}

ANY_NETWORK: Final = ("network", "any")  # goes without saying


def fault_text(kind: str, target: object, parameters: Mapping[str, Any]) -> Phrase:
    """A fault with whose it is and its figures."""
    figures = [
        Phrase(
            f"{name} {value}" if isinstance(value, str) else f"{name} {value:g}",
            phrases_of("fault figure").get(name, Phrase("", f"{name} {{}}")).ja.format(value),
        )
        for name, value in parameters.items()
        if (name, value) != ANY_NETWORK
    ]
    head = Phrase(f"{kind} {target}", f"{fault_name(kind).in_('ja')}（{_target(target)}）")
    return joined_phrases((head, *figures))


def act_text(
    act: str,
    person: str,
    target: str,
    sections: tuple[str, ...] = (),
    position: str = "",
    notch: int = 0,
    step: Phrase = NOTHING,
) -> Phrase:
    """What a person does."""
    handle = phrase("notch {notch}").fill(notch=f"{notch:+d}") if notch else NOTHING
    english = [f"{person}:" if person else "", act, target, " ".join(sections), position, handle.en, step.en]
    name = phrase_or_name(act, "act").in_("ja")
    of = [
        _target(target) if target else "",
        "・".join(sections),
        _position(position).in_("ja"),
        handle.in_("ja"),
        step.in_("ja"),
    ]
    by = f"{party(person).in_('ja')}：" if person else ""
    about = "、".join(filter(None, of))
    return Phrase(" ".join(filter(None, english)), f"{by}{name}" + (f"（{about}）" if about else ""))


def item_text(item: ScriptedFault | Act) -> Phrase:
    """A fault or an act of a script."""
    if isinstance(item, Act):
        about = (item.sections, item.position, item.notch, act_step(item))
        return act_text(item.kind.value, item.person, item.target, *about)
    return fault_text(item.fault.kind, item.fault.target, item.fault.parameters())


def expectation_text(expectation: Expectation) -> Phrase:
    """What is expected: in English as its file says it, in Japanese from what is judged."""
    if expectation.event is not None:
        core = _expected(
            "{event} never" if expectation.absent else "{event}", event=matcher_text(expectation.event)
        )
    elif expectation.holds is not None:
        core = _expected(
            expectation.holds.value,
            unit=expectation.unit,
            section=expectation.section,
            kmh=expectation.kmh,
        )
        core = _expected("not: {what}", what=core) if expectation.absent else core
    else:
        return Phrase(expectation.text)
    when = [
        ""
        if expectation.after is None
        else _expected("after {event}", event=matcher_text(expectation.after)),
        ""
        if expectation.within_s is None
        else _expected("within {within_s:g} s", within_s=expectation.within_s),
        "" if expectation.by_s is None else _expected("until {event}", event=clock(int(expectation.by_s))),
        ""
        if expectation.until is None
        else _expected("until {event}", event=matcher_text(expectation.until)),
    ]
    clause = "、".join(filter(None, when))
    return Phrase(expectation.text, core + (f"［{clause}］" if clause else ""))


def _expected(form: str, **parts: object) -> str:
    """What is expected, in Japanese: the English stands in the drill's file."""
    return phrase(form, "expected").fill(**parts).ja


def matcher_text(matcher: Matcher) -> str:
    """An event that is waited for, in Japanese."""
    name = "・".join(dict.fromkeys(EVENT_NAMES[event].in_("ja") for event in matcher.events))
    values = [value_text(field, value).in_("ja") for field, value in matcher.data.items()]
    about = f"（{'、'.join(filter(None, values))}）" if values else ""
    if matcher.train:
        return _expected("{event} of train {train}", train=matcher.train, event=name + about)
    if matcher.who and matcher.who != WORLD:
        return _expected("{event} of {who}", who=party(matcher.who), event=name + about)
    return name + about


def value_text(field: str, value: object) -> Phrase:
    """A field of an event in words."""
    if is_row(value):
        each = [value_text(field, item) for item in value]
        return joined_phrases(each, " ", "・")
    if isinstance(value, Enum):
        return value_text(field, value.value)
    if value is None or value == "":
        return NOTHING
    if isinstance(value, bool):
        return phrase("yes", "value") if value else phrase("no", "value")
    if isinstance(value, float):
        return Phrase(f"{value:g}")
    known = _BY_FIELD.get(field)
    return Phrase(str(value)) if known is None else known(value)


def _target(target: object) -> str:
    if isinstance(target, FaultyLink):
        link = phrase("between {a} and {b}" if target.both_ways else "from {a} to {b}")
        return link.fill(a=party(target.source), b=party(target.destination)).in_("ja")
    text = str(target)
    if BOTH_WAYS in text or "->" in text:
        return _target(FaultyLink.parse(text))
    return party(text).in_("ja")


def fault_name(value: object) -> Phrase:
    """What people call a kind of fault."""
    return phrase_or_name(str(value), "fault")


def _act(value: object) -> Phrase:
    return act_text(str(value), "", "")


def _position(value: object) -> Phrase:
    return phrase_or_name(str(value), "points")


def _level(value: object) -> Phrase:
    return LEVELS.get(int(str(value)), Phrase(str(value)))


def _purpose(value: object) -> Phrase:
    return phrase(str(value), "tag")


def _direction(value: object) -> Phrase:
    return phrase_or_name(str(value))


def _why(value: object) -> Phrase:
    return Phrase(str(value), reason(str(value)).in_("ja"))


def _signal(value: object) -> Phrase:
    known = phrase_or_name(str(value), "signal")
    return Phrase(known.en.replace("_", " "), known.ja)


def _barriers(value: object) -> Phrase:
    return phrase_or_name(str(value), "barriers")


def _reader(value: object) -> Phrase:
    return phrase_or_name(str(value), "reader")


def _party(value: object) -> Phrase:
    return party(str(value))


_BY_FIELD: Final = {
    "kind": fault_name,
    "act": _act,
    "position": _position,
    "lies": _position,
    "level": _level,
    "purpose": _purpose,
    "direction": _direction,
    "why": _why,
    "was": _why,
    "stage": _why,
    "reader": _reader,
    "aspect": _signal,
    "does": _signal,
    "after": _reader,
    "state": _barriers,
    "step": step_name,
    "to_whom": role_name,
    "by": _party,
    "target": _party,
    "source": _party,
    "receiver": _party,
    "device_id": _party,
}
