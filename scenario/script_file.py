"""Faults, acts and expectations of a scenario file, checked against the line, the timetable and the parties.

Refused with one message: an unknown kind, a target that does not exist, words that name no event, and an
expectation that could never be evaluated.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, Final

from pydantic import ConfigDict, Field

from network.clock import clock
from network.errors import InputError
from network.files.kinds import about
from network.files.names import Title
from network.files.quantities import DrillTime, Duration, Handle, Pace, SpeedFrom0Kmh
from network.files.toml_input import Record, one_of, validate
from scenario.event_file import matcher_in
from scenario.fleet_file import PEOPLE
from scenario.substitute_choice import steps_in
from simulation.faults.fault import Fault, Names
from simulation.faults.links import DeadZone, LinkFault
from simulation.faults.script import (
    AT_CROSSING,
    BY_ROLE,
    DEFAULTS,
    OF_STEP,
    Act,
    ActKind,
    Expectation,
    Property,
    Script,
    ScriptedFault,
    Trigger,
)
from simulation.faults.table import FAULTS
from simulation.judge.checkers import Checker
from simulation.names import names_in
from simulation.setup import Setup

_CLOCK: Final = re.compile(r"(-?)(\d{1,2}):([0-5]\d)(?::([0-5]\d(?:\.\d)?))?")


class FaultTable(Record):
    """`[[fault]]`: what every kind has. The kind's own keys are those of its class in `simulation.faults`."""

    model_config = ConfigDict(extra="allow")

    kind: Annotated[str, about("kind of fault, of docs/faults.md")]
    target: Annotated[str, about("what fails: a unit, device, link, section, points, tag, station")]
    start: Annotated[str | dict[str, Any], about("a time, or an event, in words or as a table")]
    after_s: Annotated[DrillTime, about("delay after the start")] = 0.0
    duration_s: Annotated[Duration | None, about("how long it lasts; left out: until a person ends it")] = (
        None
    )


class ActTable(Record):
    """`[[act]]`: what a person does. The kinds, with the keys of each, stand at the end of the page."""

    kind: Annotated[str, about("what is done")]
    start: Annotated[str | dict[str, Any], about("a time, or an event, in words or as a table")]
    target: Annotated[str, about("unit, device or points concerned, or the role of substitute working")] = ""
    after_s: Annotated[DrillTime, about("delay after the start")] = 0.0
    person: Annotated[Title, about("who does it; some acts need two different persons")] = "controller"
    sections: Annotated[list[str], about("sections that are entered")] = Field(default_factory=list)
    position: Annotated[str, about("position into which points are set: normal or reverse")] = ""
    place: Annotated[
        str, about("portal by which the unit left the line; section that another is to have first")
    ] = ""
    behind: Annotated[str, about("unit that is to have that section first")] = ""
    train: Annotated[
        str, about("later train of the set, as which it goes on; train for which a step is done")
    ] = ""
    step: Annotated[str, about("step of docs/substitute-working.md")] = ""
    block: Annotated[str, about("section between stations, or station, where the step is done")] = ""
    notch: Annotated[Handle, about("above 0 power, below 0 brake; beyond the train's strongest, that")] = 0
    hold_s: Annotated[
        DrillTime, about("how long the unit then asks for no route, or is kept back at most")
    ] = 300.0
    pace_s: Annotated[
        Pace | None, about("time for each word of a re-entry; left out: drawn from [people]")
    ] = None


class ExpectTable(Record):
    """`[[expect]]`: an event, its absence, or a property."""

    text: Annotated[Title, about("the expectation in a sentence")]
    event: Annotated[
        str | dict[str, Any] | None,
        about("event that must happen, in words or as a table of docs/journal.md"),
    ] = None
    absent: Annotated[bool, about("it must not happen, or not hold")] = False
    after: Annotated[str | dict[str, Any] | None, about("event from which on it counts")] = None
    until: Annotated[str | dict[str, Any] | None, about("event until which it counts")] = None
    within_s: Annotated[Duration | None, about("time within which it must happen, from `after`")] = None
    by: Annotated[str | None, about("time of day by which it must happen")] = None
    property: Annotated[
        str | None, about("everyone_arrives, no_invariant_broken, speed_at_most or never_enters")
    ] = None
    unit: Annotated[str, about("unit of speed_at_most and never_enters")] = ""
    section: Annotated[str, about("section of never_enters")] = ""
    kmh: Annotated[SpeedFrom0Kmh | None, about("speed of speed_at_most")] = None
    rules: Annotated[list[str], about("with absent: which invariants may be broken")] = Field(
        default_factory=list[str]
    )


def names_of(setup: Setup, acts: Sequence[ActTable] = ()) -> Names:
    """Every name that a script of the scenario may use; people besides the usual ones are those who act in it."""
    named = names_in(setup, tuple(dict.fromkeys((*PEOPLE, *(act.person for act in acts)))))
    return replace(named, steps=steps_in(setup))


def script_of(
    file: str,
    setup: Setup,
    faults: Sequence[FaultTable],
    acts: Sequence[ActTable],
    expectations: Sequence[ExpectTable],
) -> Script:
    """The script of a scenario. InputError for anything that cannot be carried out or evaluated."""
    names = names_of(setup, acts)
    own = tuple(
        _expectation(file, f"expect[{i}]", table, names, setup) for i, table in enumerate(expectations)
    )
    judged = {expectation.holds for expectation in own}
    return Script(
        tuple(scripted_fault_of(file, f"fault[{i}]", table, names) for i, table in enumerate(faults)),
        tuple(act_of(file, f"act[{i}]", table, names) for i, table in enumerate(acts)),
        (*own, *(default for default in DEFAULTS if default.holds not in judged)),
    )


def scripted_fault_of(file: str, key: str, table: FaultTable, names: Names) -> ScriptedFault:
    """The fault that a table is. InputError for anything that cannot be carried out."""
    kind = FAULTS.get(table.kind)
    if kind is None:
        raise InputError(file, f"{key}.kind", table.kind, one_of(FAULTS, table.kind))
    fault = fault_of(file, key, kind, {"target": table.target, **(table.model_extra or {})}, names)
    if expected := fault.wrong_target(names):
        raise InputError(file, f"{key}.target", table.target, expected)
    if isinstance(fault, LinkFault | DeadZone) and fault.network not in ("any", *names.networks):
        raise InputError(
            file, f"{key}.network", fault.network, "'any': trains have a radio of one network alone"
        )
    if kind.momentary and table.duration_s is not None:
        raise InputError(
            file, f"{key}.duration_s", table.duration_s, f"no such key: {kind.kind} is over at once"
        )
    trigger = _trigger(file, f"{key}.start", table.start, table.after_s, names)
    return ScriptedFault(fault, trigger, table.duration_s)


def fault_of(
    file: str, key: str, kind: type[Fault[Any]], keys: Mapping[str, Any], names: Names
) -> Fault[Any]:
    """A fault of a kind with its own keys; whether its target exists is not looked at. InputError names the key."""
    try:
        fault = validate(keys, file, kind)
    except InputError as error:
        expected = f"{error.expected}, for {kind.kind}"
        raise InputError(file, f"{key}.{error.key}", error.value, expected) from error
    for name, expected in fault.wrong_names(names).items():
        raise InputError(file, f"{key}.{name}", getattr(fault, name), expected)
    return fault


_ACT: Final = frozenset({"kind", "start", "after_s", "person"})
ACT_KEYS: Final[Mapping[ActKind, frozenset[str]]] = {
    ActKind.CONFIRM_OUTSIDE: frozenset({"target", "place"}),
    ActKind.TAKE_BACK: frozenset({"target"}),
    ActKind.BAR_UNIT: frozenset({"target"}),
    ActKind.UNBAR_UNIT: frozenset({"target"}),
    ActKind.CONFIRM_HOLDING: frozenset({"target", "sections"}),
    ActKind.ACCEPT_PICTURE: frozenset({"pace_s"}),
    ActKind.POWER_ON: frozenset({"target"}),
    ActKind.COMMISSION: frozenset({"target"}),
    ActKind.REPAIR_POINTS: frozenset({"target", "position"}),
    ActKind.ENTER_SECTION: frozenset({"target", "sections"}),
    ActKind.REENTER_BY_HAND: frozenset({"pace_s"}),
    ActKind.REENTER_ASSISTED: frozenset({"pace_s"}),
    ActKind.HAUL_AWAY: frozenset({"target"}),
    ActKind.BRING_POWER: frozenset({"target"}),
    ActKind.FREE_ROAD: frozenset({"target"}),
    ActKind.GUARD_ROAD: frozenset({"target"}),
    ActKind.LEAVE_ROAD: frozenset({"target"}),
    ActKind.GIVE_BACK: frozenset({"target", "hold_s"}),
    ActKind.HOLD_TRAIN: frozenset({"target", "hold_s", "behind", "place"}),
    ActKind.LET_GO: frozenset({"target"}),
    ActKind.END_TRAIN: frozenset({"target", "train"}),
    ActKind.DRIVE: frozenset({"target", "notch"}),
    ActKind.DRIVE_BY_ATO: frozenset({"target"}),
    ActKind.TAKE_ROLE: frozenset({"target"}),
    ActKind.HAND_BACK_ROLE: frozenset({"target"}),
    ActKind.DO_STEP: frozenset({"target", "step", "block", "train"}),
    ActKind.LEAVE_OUT_STEP: frozenset({"target", "step", "block", "train"}),
}


def _lacking(kind: ActKind, names: Names) -> str:
    """The table of the scenario that an act of this kind needs, where there is none."""
    if kind in BY_ROLE and not names.posts:
        return "[substitute]"
    return "[battery]" if kind is ActKind.BRING_POWER and not names.on_battery else ""


def act_of(file: str, key: str, table: ActTable, names: Names) -> Act:
    """The act that a table is. InputError for anything that cannot be carried out."""
    kinds = [kind.value for kind in ActKind]
    if table.kind not in kinds:
        raise InputError(file, f"{key}.kind", table.kind, one_of(kinds, table.kind))
    kind = ActKind(table.kind)
    targets: dict[ActKind, tuple[str, ...]] = {
        ActKind.CONFIRM_OUTSIDE: names.units,
        ActKind.CONFIRM_HOLDING: names.units,
        ActKind.TAKE_BACK: names.units,
        ActKind.BAR_UNIT: names.units,
        ActKind.UNBAR_UNIT: names.units,
        ActKind.POWER_ON: (*names.units, *names.devices),
        ActKind.COMMISSION: (*names.units, *names.devices),
        ActKind.REPAIR_POINTS: names.points,
        ActKind.ENTER_SECTION: ("", *names.units),
        ActKind.HAUL_AWAY: names.units,
        ActKind.BRING_POWER: names.on_battery,
        **dict.fromkeys(AT_CROSSING, names.crossings),
        ActKind.GIVE_BACK: names.units,
        ActKind.HOLD_TRAIN: names.units,
        ActKind.LET_GO: names.units,
        ActKind.END_TRAIN: names.units,
        ActKind.DRIVE: names.units,
        ActKind.DRIVE_BY_ATO: names.units,
        **dict.fromkeys(BY_ROLE, names.posts),
    }
    if table_of := _lacking(kind, names):
        raise InputError(file, f"{key}.kind", table.kind, f"no such act without {table_of}")
    _check_keys(file, key, table, _ACT | ACT_KEYS[kind], kind.value)
    known = targets.get(kind)
    if known is not None and table.target not in known:
        raise InputError(file, f"{key}.target", table.target, one_of(known, table.target))
    for i, section in enumerate(table.sections):
        if section not in names.sections:
            raise InputError(
                file, f"{key}.sections[{i}]", section, f"a section: {one_of(names.sections, section)}"
            )
    if table.place and table.place not in names.sections:
        expected = f"a section: {one_of(names.sections, table.place)}"
        raise InputError(file, f"{key}.place", table.place, expected)
    if table.behind and table.behind not in names.units:
        raise InputError(file, f"{key}.behind", table.behind, one_of(names.units, table.behind))
    if bool(table.behind) is not bool(table.place) and kind is ActKind.HOLD_TRAIN:
        raise InputError(
            file, f"{key}.place", table.place, "the unit that goes first (behind) and over which section"
        )
    if kind is ActKind.END_TRAIN and not table.train:
        raise InputError(file, f"{key}.train", table.train, "the later train of the set, as which it goes on")
    if kind is ActKind.REPAIR_POINTS and table.position not in ("normal", "reverse"):
        raise InputError(file, f"{key}.position", table.position, "normal or reverse")
    if kind in (ActKind.CONFIRM_HOLDING, ActKind.ENTER_SECTION) and not table.sections:
        raise InputError(file, f"{key}.sections", table.sections, "the sections that are entered")
    if kind in OF_STEP:
        _check_step(file, key, table, names)
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
        table.behind,
        table.train,
        table.notch,
        table.step,
        table.block,
    )


def _check_step(file: str, key: str, table: ActTable, names: Names) -> None:
    """The role has this step in that section or station, and the train exists."""
    blocks = [block for post, block in names.steps if post == table.target]
    if table.block not in blocks:
        raise InputError(file, f"{key}.block", table.block, one_of(blocks, table.block))
    steps = names.steps[table.target, table.block]
    if table.step not in steps:
        expected = f"a step of {table.target} in {table.block}: {one_of(steps, table.step)}"
        raise InputError(file, f"{key}.step", table.step, expected)
    if table.train and table.train not in names.trains:
        raise InputError(file, f"{key}.train", table.train, one_of(names.trains, table.train))


def _expectation(file: str, key: str, table: ExpectTable, names: Names, setup: Setup) -> Expectation:
    if (table.event is None) == (table.property is None):
        raise InputError(file, key, table.text, "either event or property, and not both")
    holds = None if table.property is None else _property(file, key, table, names)
    after = None if table.after is None else matcher_in(file, f"{key}.after", table.after, names)
    until = None if table.until is None else matcher_in(file, f"{key}.until", table.until, names)
    by_s = None if table.by is None else _by(file, f"{key}.by", table.by, setup)
    if table.within_s is not None and after is None:
        raise InputError(file, f"{key}.within_s", table.within_s, "an 'after' to count from")
    event = None
    if table.event is not None:
        _check_keys(file, key, table, {*_WHAT, "event", "absent", *_WHEN}, "an expectation of an event")
        # Of what must not happen a misspelt word would count as met.
        event = matcher_in(file, f"{key}.event", table.event, names, exact=table.absent)
    return Expectation(
        event=event,
        after=after,
        by_s=by_s,
        holds=holds,
        kmh=table.kmh or 0.0,
        until=until,
        rules=tuple(table.rules),
        **table.model_dump(include={"text", "absent", "within_s", "unit", "section"}),
    )


# What persons who are wrong can bring about: a train where the register does not have it, and another one beside it.
EXCUSABLE: Final = (Checker.INSIDE_HOLDING.value, Checker.ONE_TRAIN_A_SECTION.value)
BY_LINE_SIGNALS: Final = (
    Checker.SUMO_COLLISION.value,
)  # besides, on a line as it was: an accident that happened
_WHAT: Final = frozenset({"text", "property"})
_WHEN: Final = frozenset({"after", "until", "within_s", "by"})
_PROPERTY_KEYS: Final[Mapping[Property, frozenset[str]]] = {
    Property.EVERYONE_ARRIVES: frozenset({"absent"}),
    Property.NO_INVARIANT_BROKEN: frozenset({"absent", "rules"}),
    Property.SPEED_AT_MOST: frozenset({"unit", "kmh", *_WHEN}),
    Property.NEVER_ENTERS: frozenset({"unit", "section", *_WHEN}),
}


def _property(file: str, key: str, table: ExpectTable, names: Names) -> Property:
    """The property that must hold, with all that it needs and nothing else."""
    known = [item.value for item in Property]
    if table.property not in known:
        raise InputError(file, f"{key}.property", table.property, one_of(known, str(table.property)))
    holds = Property(table.property)
    _check_keys(file, key, table, _WHAT | _PROPERTY_KEYS[holds], holds.value)
    if "unit" in _PROPERTY_KEYS[holds] and table.unit not in names.units:
        raise InputError(file, f"{key}.unit", table.unit, f"a unit: {one_of(names.units, table.unit)}")
    excusable = (*EXCUSABLE, *BY_LINE_SIGNALS) if names.signals else EXCUSABLE
    for i, rule in enumerate(table.rules):
        if rule not in excusable:
            raise InputError(file, f"{key}.rules[{i}]", rule, one_of(excusable, rule))
    if holds is Property.NO_INVARIANT_BROKEN and table.absent is not bool(table.rules):
        raise InputError(
            file, f"{key}.rules", table.rules, "with absent, and then only: which ones may be broken"
        )
    if holds is Property.SPEED_AT_MOST and table.kmh is None:
        raise InputError(file, f"{key}.kmh", None, "this key, which is missing: a speed in km/h")
    if holds is Property.NEVER_ENTERS and table.section not in names.sections:
        expected = f"a section: {one_of(names.sections, table.section)}"
        raise InputError(file, f"{key}.section", table.section, expected)
    return holds


def _check_keys(file: str, key: str, table: Record, known: Collection[str], what: str) -> None:
    """A key that says nothing to such an entry is refused: whoever wrote it meant something by it."""
    for name, field in type(table).model_fields.items():
        value = getattr(table, name)
        if (
            name in table.model_fields_set
            and name not in known
            and value != field.get_default(call_default_factory=True)
        ):
            own = [other for other in type(table).model_fields if other in known]
            raise InputError(file, f"{key}.{name}", value, f"no such key for {what}, but {one_of(own, name)}")


def _by(file: str, key: str, text: str, setup: Setup) -> float:
    """A time of the run: nothing happens before it, and much later it has ended."""
    by_s = time_of(file, key, text)
    calls = [call for train in setup.timetable.trains.values() for call in train.calls]
    first_s = min(call.first_s for call in calls) - setup.operation.portal_lead_s
    if not first_s <= by_s <= max(call.last_s for call in calls) + 86_400:
        raise InputError(file, key, text, f"a time within the run, which begins at {clock(first_s)}")
    return by_s


def _trigger(file: str, key: str, given: str | Mapping[str, Any], after_s: float, names: Names) -> Trigger:
    if isinstance(given, str) and _CLOCK.fullmatch(given):
        return Trigger(at_s=time_of(file, key, given), after_s=after_s)
    on = matcher_in(file, key, given, names, exact=True, or_else="a time (HH:MM:SS), or ")
    return Trigger(on=on, after_s=after_s)


def time_of(file: str, key: str, text: str) -> float:
    """Seconds after midnight of a time in a file or command line, before it with a minus. InputError for any other."""
    match = _CLOCK.fullmatch(text)
    if match is None:
        raise InputError(file, key, text, "a time HH:MM or HH:MM:SS")
    time_s = int(match[2]) * 3600.0 + int(match[3]) * 60.0 + float(match[4] or 0.0)
    return -time_s if match[1] else time_s
