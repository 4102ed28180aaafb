"""Faults, acts and expectations of a scenario file, checked against the line, the timetable and the parties.

Refused with one message: an unknown kind, a target that does not exist, words that name no event, and an
expectation that could never be evaluated.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, Final

import msgspec
from pydantic import ConfigDict, Field

from network.errors import InputError
from network.files.raw import is_list
from network.files.toml_input import Record, one_of, validate
from network.timetable import Timetable
from radio.noted import key_of
from simulation.events import EVENTS, WORLD
from simulation.faults.fault import Names
from simulation.faults.script import (
    DEFAULTS,
    WHOLE_RUN,
    WORDS_HELP,
    Act,
    ActKind,
    Expectation,
    Failure,
    Matcher,
    Property,
    Script,
    Trigger,
    matcher_of,
)
from simulation.faults.table import FAULTS
from simulation.setup import Setup
from wayside.config import MANAGER_ID

_CLOCK: Final = re.compile(r"(\d{1,2}):([0-5]\d)(?::([0-5]\d(?:\.\d)?))?")
PEOPLE: Final = ("controller", "staff", "crew")


class FaultTable(Record):
    """`[[fault]]`: what every kind has. The kind's own keys are those of its class in `simulation.faults`."""

    model_config = ConfigDict(extra="allow")

    kind: str
    target: str
    start: str | dict[str, Any]
    after_s: float = Field(default=0.0, ge=0.0)
    duration_s: float | None = Field(default=None, gt=0.0)


class ActTable(Record):
    """`[[act]]`."""

    kind: str
    start: str | dict[str, Any]
    target: str = ""
    after_s: float = Field(default=0.0, ge=0.0)
    person: str = "controller"
    sections: list[str] = Field(default_factory=list)
    position: str = ""
    place: str = ""
    hold_s: float = Field(default=300.0, ge=0.0)
    pace_s: float = Field(default=0.0, ge=0.0, le=600.0)


class ExpectTable(Record):
    """`[[expect]]`: an event (words or a table), its absence, or a property."""

    text: str
    event: str | dict[str, Any] | None = None
    absent: bool = False
    after: str | dict[str, Any] | None = None
    until: str | dict[str, Any] | None = None
    within_s: float | None = Field(default=None, gt=0.0)
    by: str | None = None
    property: str | None = None
    unit: str = ""
    section: str = ""
    kmh: float | None = None


def names_of(setup: Setup) -> Names:
    """Every name that a script of the scenario may use."""
    line, timetable = setup.line, setup.timetable
    terminals = sorted({points.terminal_id for points in line.points.values()})
    return Names(
        units=tuple(diagram.stock_id for diagram in timetable.diagrams),
        devices=(MANAGER_ID, *terminals),
        tags=tuple(str(tag) for tag in line.tags),
        points=tuple(line.points),
        sections=tuple(line.sections),
        stations=tuple(line.stations),
        trains=tuple(timetable.trains),
        people=PEOPLE,
    )


def script_of(
    file: str,
    setup: Setup,
    faults: Sequence[FaultTable],
    acts: Sequence[ActTable],
    expectations: Sequence[ExpectTable],
) -> Script:
    """The script of a scenario. InputError for anything that cannot be carried out or evaluated."""
    names = names_of(setup)
    own = tuple(
        _expectation(file, f"expect[{i}]", table, names, setup.timetable)
        for i, table in enumerate(expectations)
    )
    judged = {expectation.holds for expectation in own}
    return Script(
        tuple(_fault(file, f"fault[{i}]", table, names) for i, table in enumerate(faults)),
        tuple(_act(file, f"act[{i}]", table, names) for i, table in enumerate(acts)),
        (*own, *(default for default in DEFAULTS if default.holds not in judged)),
    )


def _fault(file: str, key: str, table: FaultTable, names: Names) -> Failure:
    kind = FAULTS.get(table.kind)
    if kind is None:
        raise InputError(file, f"{key}.kind", table.kind, one_of(FAULTS, table.kind))
    try:
        fault = validate({"target": table.target, **(table.model_extra or {})}, file, kind)
    except InputError as error:
        expected = f"{error.expected}, for {kind.kind}"
        raise InputError(file, f"{key}.{error.key}", error.value, expected) from error
    if expected := fault.wrong_target(names):
        raise InputError(file, f"{key}.target", table.target, expected)
    if kind.momentary and table.duration_s is not None:
        raise InputError(
            file, f"{key}.duration_s", table.duration_s, f"no such key: {kind.kind} is over at once"
        )
    trigger = _trigger(file, f"{key}.start", table.start, table.after_s, names)
    return Failure(fault, trigger, table.duration_s)


def _act(file: str, key: str, table: ActTable, names: Names) -> Act:
    kinds = [kind.value for kind in ActKind]
    if table.kind not in kinds:
        raise InputError(file, f"{key}.kind", table.kind, one_of(kinds, table.kind))
    kind = ActKind(table.kind)
    targets: dict[ActKind, tuple[str, ...]] = {
        ActKind.CONFIRM_OUTSIDE: names.units,
        ActKind.CONFIRM_HOLDING: names.units,
        ActKind.TAKE_BACK: names.units,
        ActKind.POWER_ON: (*names.units, *names.devices),
        ActKind.REPAIR_POINTS: names.points,
        ActKind.ENTER_SECTION: ("", *names.units),
        ActKind.GIVE_BACK: names.units,
    }
    known = targets.get(kind)
    if known is not None and table.target not in known:
        raise InputError(file, f"{key}.target", table.target, one_of(known, table.target))
    for i, section in enumerate(table.sections):
        if section not in names.sections:
            raise InputError(
                file, f"{key}.sections[{i}]", section, f"a section: {one_of(names.sections, section)}"
            )
    if table.place and (kind is not ActKind.CONFIRM_OUTSIDE or table.place not in names.sections):
        expected = f"a section, with confirm_outside: {one_of(names.sections, table.place)}"
        raise InputError(file, f"{key}.place", table.place, expected)
    if kind is ActKind.REPAIR_POINTS and table.position not in ("normal", "reverse"):
        raise InputError(file, f"{key}.position", table.position, "normal or reverse")
    if kind in (ActKind.CONFIRM_HOLDING, ActKind.ENTER_SECTION) and not table.sections:
        raise InputError(file, f"{key}.sections", table.sections, "the sections that are entered")
    trigger = _trigger(file, f"{key}.start", table.start, table.after_s, names)
    sections = tuple(table.sections)
    return Act(
        kind,
        table.target,
        trigger,
        table.person,
        sections,
        table.position,
        table.hold_s,
        table.place,
        table.pace_s,
    )


def _expectation(file: str, key: str, table: ExpectTable, names: Names, timetable: Timetable) -> Expectation:
    if (table.event is None) == (table.property is None):
        raise InputError(file, key, table.text, "either event or property, and not both")
    after = None if table.after is None else _matcher(file, f"{key}.after", table.after, names)
    until = None if table.until is None else _matcher(file, f"{key}.until", table.until, names)
    by_s = None if table.by is None else time_of(file, f"{key}.by", table.by)
    last_s = max(call.last_s for train in timetable.trains.values() for call in train.calls)
    if by_s is not None and by_s > last_s + 86_400:
        raise InputError(file, f"{key}.by", table.by, "a time within the run")
    if table.within_s is not None and after is None:
        raise InputError(file, f"{key}.within_s", table.within_s, "an 'after' to count from")
    if table.event is not None:
        event = _matcher(file, f"{key}.event", table.event, names)
        return Expectation(table.text, event, table.absent, after, table.within_s, by_s, until=until)
    known = [item.value for item in Property]
    if table.property not in known:
        raise InputError(file, f"{key}.property", table.property, one_of(known, str(table.property)))
    holds = Property(table.property)
    whole = holds in WHOLE_RUN
    if whole and (after is not None or until is not None or by_s is not None):
        raise InputError(file, key, table.text, f"no after, until or by: {holds.value} is of the whole run")
    if table.absent and not whole:
        raise InputError(file, f"{key}.absent", True, "an event, or a property of the whole run")
    if not whole and table.unit not in names.units:
        raise InputError(file, f"{key}.unit", table.unit, f"a unit: {one_of(names.units, table.unit)}")
    if holds is Property.SPEED_AT_MOST and (table.kmh is None or table.kmh < 0.0):
        raise InputError(file, f"{key}.kmh", table.kmh, "a speed in km/h")
    if holds is Property.NEVER_ENTERS and table.section not in names.sections:
        raise InputError(
            file, f"{key}.section", table.section, f"a section: {one_of(names.sections, table.section)}"
        )
    return Expectation(
        table.text,
        absent=table.absent,
        after=after,
        until=until,
        by_s=by_s,
        holds=holds,
        unit=table.unit,
        section=table.section,
        kmh=table.kmh or 0.0,
    )


def _trigger(file: str, key: str, given: str | Mapping[str, Any], after_s: float, names: Names) -> Trigger:
    if isinstance(given, str) and _CLOCK.fullmatch(given):
        return Trigger(at_s=time_of(file, key, given), after_s=after_s)
    return Trigger(on=_matcher(file, key, given, names), after_s=after_s)


def time_of(file: str, key: str, text: str) -> float:
    """Seconds after midnight of a time in a file or on the command line. InputError for anything else."""
    match = _CLOCK.fullmatch(text)
    if match is None:
        raise InputError(file, key, text, "a time HH:MM or HH:MM:SS")
    return int(match[1]) * 3600.0 + int(match[2]) * 60.0 + float(match[3] or 0.0)


def _matcher(file: str, key: str, given: str | Mapping[str, Any], names: Names) -> Matcher:
    matcher = matcher_of(given) if isinstance(given, str) else _table_matcher(file, key, given)
    if matcher is None:
        raise InputError(file, key, given, WORDS_HELP)
    parties = (*names.units, *names.devices, WORLD, *names.people)
    if matcher.who is not None and matcher.who not in parties:
        raise InputError(file, f"{key}.who", matcher.who, one_of(parties, matcher.who))
    checks = {
        "tag_id": names.tags,
        "points_id": names.points,
        "section_ids": names.sections,
        "section_id": names.sections,
        "unit_id": names.units,
        "train": names.trains,
        "station": (*names.stations, *names.sections),
    }
    for name, value in {**matcher.data, **({"train": matcher.train} if matcher.train else {})}.items():
        known = checks.get(name)
        for item in value if is_list(value) else (value,):
            if known is not None and str(item) not in known:
                raise InputError(file, f"{key}: {key_of(name)}", item, one_of(known, str(item)))
    return matcher


def _table_matcher(file: str, key: str, given: Mapping[str, Any]) -> Matcher:
    data = dict(given)
    what = data.pop("what", None)
    event = EVENTS.get(what) if isinstance(what, str) else None
    if event is None:
        raise InputError(file, f"{key}.what", what, one_of(sorted(EVENTS), str(what)))
    who, train = data.pop("who", None), data.pop("of_train", None)
    text = " ".join(str(part) for part in (who or train or "someone", what, *data.values()))
    field_of = {field.encode_name: field.name for field in msgspec.structs.fields(event)}
    for name, value in data.items():
        if name not in field_of:
            raise InputError(
                file, f"{key}.{name}", value, f"data of {what}: {one_of(sorted(field_of), name)}"
            )
    wanted = {field_of[name]: value for name, value in data.items()}
    return Matcher(text, (event,), who, train, wanted)
