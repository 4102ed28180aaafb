"""Events of the journal as a scenario file names them, checked against the types of events.

Refused with one message: words that name no event, data that the event has not, a value of another type or that no
event of a run can have, and an author who never writes it. A sentence or a measured figure is not checked word by
word; it may stand where nothing comes of an event that never happens, and is refused where that would count as met.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, Final, get_args, get_origin

import msgspec

from network.errors import InputError
from network.files.toml_input import one_of
from network.raw import is_list
from onboard import notes
from onboard.driving.tasc import StopVerdict
from onboard.fixes import EYE
from onboard.localisation.fix import OUTCOMES
from onboard.localisation.table import READER_NAMES
from radio.envelope import DropReason
from radio.messages import AnyMessage, PointsRefusalReason, RefusalReason
from radio.noted import Lost, Sent, TelegramDropped, TookEffect, key_of
from simulation import events
from simulation.faults.fault import Names
from simulation.faults.links import FaultyLink, LinkFault
from simulation.faults.script import WORDS_HELP, ActKind, Matcher, matcher_of
from simulation.faults.table import FAULTS
from simulation.line_signals.machine import Aspect
from simulation.line_signals_settings import SignalDeed
from simulation.procedure import WorkingStep
from wayside import said
from wayside.config import MANAGER_ID
from wayside.register import ReentryStage, UnitStanding

# What a field may hold, by its name: whatever event it stands in.
_NAMED: Final[Mapping[str, Callable[[Names], Collection[str]]]] = {
    "tag_id": lambda names: names.tags,
    "points_id": lambda names: names.points,
    "section_ids": lambda names: names.sections,
    "unsaid_section_ids": lambda names: names.sections,
    "section_id": lambda names: names.sections,
    "before": lambda names: names.sections,
    "piece_id": lambda names: names.pieces,
    "route_id": lambda names: names.routes,
    "unit_id": lambda names: names.units,
    "other_id": lambda names: names.units,
    "train": lambda names: names.trains,
    "station": lambda names: (*names.stations, *names.sections),
    "device_id": lambda names: (*names.devices, *names.units),
    "source": lambda names: (*names.devices, *names.units),
    "receiver": lambda names: (*names.devices, *names.units),
    "by": lambda names: names.people,
    "signal_id": lambda names: names.signals,
    "stops": lambda names: names.signals,
    "lever_id": lambda names: names.levers,
    "block": lambda names: tuple(sorted({block for _, block in names.steps})),
    "crossing_id": lambda names: names.crossings,
}


def _told(words: Iterable[RefusalReason] | Iterable[PointsRefusalReason]) -> tuple[str, ...]:
    """Reasons as a unit notes them."""
    return tuple(word.name.lower().replace("_", " ") for word in words)


_VERDICTS: Final = tuple(verdict.name.lower().replace("_", " ") for verdict in StopVerdict if verdict.value)
_TELEGRAMS: Final = tuple(message.__name__ for message in get_args(AnyMessage))
_STANDINGS: Final = tuple(standing.value for standing in UnitStanding)
# The same where it depends on the event: every word that it can be.
_WORDS: Final[Mapping[tuple[events.EventType, str], tuple[object, ...]]] = {
    (notes.MissionBegun, "direction"): ("down", "up"),
    (notes.Intervention, "level"): (0, 1, 2),
    (notes.StopImpossible, "why"): _VERDICTS,
    (notes.FixRefused, "reader"): READER_NAMES,
    (notes.FixTaken, "reader"): (*READER_NAMES, EYE),
    (notes.PlacePassed, "reader"): (*READER_NAMES, EYE),
    (notes.FoundElsewhere, "reader"): (*READER_NAMES, EYE),
    (notes.FixTaken, "after"): OUTCOMES,
    (notes.ForeignTrack, "reader"): READER_NAMES,
    (notes.FixMissed, "reader"): READER_NAMES,
    (notes.SignOnDenied, "why"): _told(RefusalReason),
    (notes.SignOffDenied, "why"): _told(RefusalReason),
    (notes.RouteDenied, "why"): _told(RefusalReason),
    (notes.ThrowDenied, "why"): _told(PointsRefusalReason),
    (said.ThrowRefused, "why"): tuple(reason.name for reason in PointsRefusalReason),
    (said.PictureChanged, "stage"): tuple(stage.value for stage in ReentryStage),
    (events.Accepted, "was"): _STANDINGS,
    (events.Outside, "was"): _STANDINGS,
    (TelegramDropped, "why"): tuple(reason.value for reason in DropReason),
    (events.FaultBegan, "kind"): tuple(FAULTS),
    (events.FaultOver, "kind"): tuple(FAULTS),
    (events.Acted, "act"): tuple(kind.value for kind in ActKind),
    **{
        (event, "step"): tuple(step.value for step in WorkingStep)
        for event in (events.ProcedureStep, events.StepLeftOut, events.StepOutOfOrder, events.StepRefused)
    },
    (events.SignalActed, "does"): tuple(deed.value for deed in SignalDeed),
    (events.SignalShows, "aspect"): tuple(aspect.value for aspect in Aspect),
    (events.SignalPassed, "aspect"): tuple(aspect.value for aspect in Aspect),
    **{(event, "kind"): _TELEGRAMS for event in (Sent, Lost, TelegramDropped, TookEffect)},
}


def matcher_in(
    file: str,
    key: str,
    given: str | Mapping[str, Any],
    names: Names,
    *,
    exact: bool = False,
    or_else: str = "",
) -> Matcher:
    """The event that a key of a file names. InputError for what no run can have in its journal.

    `exact`: an event that never happens would count as met, or would leave something out without a word, so every
    value must be one that can be checked. `or_else`: what besides an event may stand there, in words.
    """
    matcher = matcher_of(given) if isinstance(given, str) else _table(file, key, given, names, exact=exact)
    if matcher is None:
        raise InputError(file, key, given, or_else + WORDS_HELP)
    parties = (*names.units, *names.devices, events.WORLD, *names.people)
    if matcher.who is not None and matcher.who not in parties:
        raise InputError(file, f"{key}.who", matcher.who, one_of(parties, matcher.who))
    if isinstance(given, str):
        named = {**({"train": matcher.train} if matcher.train else {}), **matcher.data}
        for name, value in named.items():
            _check_known(file, f"{key}: {key_of(name)}", matcher.events[0], name, value, names)
    _check_author(file, key, matcher, names)
    return matcher


def _table(file: str, key: str, given: Mapping[str, Any], names: Names, *, exact: bool) -> Matcher:
    """An event written as a table: `what` it is, `who` wrote it, `of_train`, and data by the journal's keys."""
    data = dict(given)
    what = data.pop("what", None)
    event = events.EVENTS.get(what) if isinstance(what, str) else None
    if event is None:
        raise InputError(file, f"{key}.what", what, one_of(sorted(events.EVENTS), str(what)))
    who, train = data.pop("who", None), data.pop("of_train", None)
    for name, word in (("who", who), ("of_train", train)):
        if word is not None and not isinstance(word, str):
            raise InputError(file, f"{key}.{name}", word, "text")
    if train is not None and train not in names.trains:
        raise InputError(file, f"{key}.of_train", train, one_of(names.trains, train))
    fields = {field.encode_name: field for field in msgspec.structs.fields(event)}
    for name, value in data.items():
        if name not in fields:
            expected = f"data of {what}: {one_of(sorted(fields), name)}"
            raise InputError(file, f"{key}.{name}", value, expected)
        _check_type(file, f"{key}.{name}", fields[name].type, value)
        known = _check_known(file, f"{key}.{name}", event, fields[name].name, value, names)
        if exact and not known and _is_open(fields[name].type):
            expected = f"no such key here: a {name} that is misspelt or a little off would never be noticed"
            raise InputError(file, f"{key}.{name}", value, expected)
    _check_target(file, key, event, data, names)
    text = " ".join(str(part) for part in (who or train or "someone", what, *data.values()))
    return Matcher(text, (event,), who, train, {fields[name].name: value for name, value in data.items()})


def _check_type(file: str, key: str, kind: Any, value: object) -> None:  # noqa: ANN401
    """The value has the field's type; of a list one entry may stand for all that has it."""
    if get_origin(kind) is tuple and not is_list(value):
        kind = get_args(kind)[0]
    try:
        msgspec.convert(value, kind, strict=True)
    except msgspec.ValidationError as error:
        reason = str(error).partition(" - at `")[0]
        words = f": {one_of(_enum_words(kind), str(value))}" if _enum_words(kind) else ""
        raise InputError(file, key, value, f"{reason.removeprefix('Expected ')}{words}") from error
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError(file, key, value, "a finite number")


def _enum_words(kind: Any) -> list[str]:  # noqa: ANN401
    options = [option for option in (kind, *get_args(kind)) if hasattr(option, "__members__")]
    return [str(word.value) for option in options for word in option]


def _is_open(kind: Any) -> bool:  # noqa: ANN401
    """Whether a field holds words or a measured figure, of which no list can be made."""
    return kind in (str, float) or any(map(_is_open, get_args(kind)))


def _check_known(
    file: str, key: str, event: events.EventType, name: str, value: object, names: Names
) -> bool:
    """Whether it is known what the field may hold; InputError if the value, or one of a list, is none of that."""
    by_name = _NAMED.get(name)
    known = _WORDS.get((event, name), None if by_name is None else tuple(by_name(names)))
    if known is None:
        return event in (events.FaultBegan, events.FaultOver, events.Acted) and name == "target"
    for item in value if is_list(value) else (value,):
        if item not in known and not (name == "tag_id" and str(item) in known):
            raise InputError(file, key, item, one_of(map(str, known), str(item)))
    return True


def _check_target(
    file: str, key: str, event: events.EventType, data: Mapping[str, Any], names: Names
) -> None:
    """The target of a fault is one of its kind, that of an act something that people act on."""
    target = data.get("target")
    if target is None or event not in (events.FaultBegan, events.FaultOver, events.Acted):
        return
    if event is events.Acted:
        known = ("", *names.units, *names.devices, *names.points, *names.posts)
        if target not in known:
            raise InputError(file, f"{key}.target", target, one_of(known[1:], str(target)))
        return
    kinds = [FAULTS[data["kind"]]] if "kind" in data else list(FAULTS.values())
    wrong = [_wrong_target(kind, str(target), names) for kind in kinds]
    if all(wrong):
        raise InputError(
            file, f"{key}.target", target, wrong[0] if len(kinds) == 1 else "a target of some fault"
        )


def _wrong_target(kind: Any, target: str, names: Names) -> str:  # noqa: ANN401
    """What should stand there for a fault of this kind; empty if the target exists."""
    try:
        meant = FaultyLink.parse(target) if issubclass(kind, LinkFault) else target
    except ValueError as error:
        return str(error)
    return str(kind.model_construct(target=meant).wrong_target(names))


def _check_author(file: str, key: str, matcher: Matcher, names: Names) -> None:
    """Whoever is named can have written the event."""
    if matcher.who is None:
        return
    own = _author(matcher.who, names)
    authors = {author for event in matcher.events for author in events.authors_of(event)}
    if own not in authors:
        words = " or ".join(sorted(author.value for author in authors))
        expected = f"who writes {' or '.join(map(events.word_of, matcher.events))}: {words}"
        raise InputError(file, f"{key}.who", matcher.who, expected)


def _author(who: str, names: Names) -> events.Author:
    if who == events.WORLD:
        return events.Author.WORLD
    if who == MANAGER_ID:
        return events.Author.MANAGER
    if who in names.units:
        return events.Author.UNIT
    if who in names.crossings:
        return events.Author.CROSSING
    return events.Author.TERMINAL if who in names.devices else events.Author.PERSON
