"""What a sweep moves: the faults and acts of a drill as one rigid piece, or single faults of every kind.

A drill's faults and acts keep the times between them that they have in the drill itself. What waits for an event is
put where the event was in the run of the drill as it is written: at another instant the same event may never come, or
be another one. What never came due there is left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final

from network.errors import InputError
from scenario.scenario import Scenario
from scenario.script_file import names_of
from simulation.events import TagPassed
from simulation.faults.fault import Fault, Names
from simulation.faults.links import ANY, BOTH_WAYS, LinkFault
from simulation.faults.script import Act, Script, ScriptedFault, Trigger
from simulation.faults.speech import FalseClaims
from simulation.faults.table import FAULTS
from simulation.faults.tag_reader import WrongId
from simulation.setup import STEPS_PER_S, Setup, step_not_before
from study.drilling.every_instant import Variation
from study.drilling.forks import result_of_copy
from study.runner.run import simulation_of
from study.wording.script import item_text

NO_TIME: Final = Trigger()


@dataclass(frozen=True, slots=True)
class MovedDrill:
    """A drill as a sweep moves it. `left_out`: what never came due in the drill itself, in words."""

    variation: Variation
    left_out: tuple[str, ...]


def what_is_moved(scenario: Scenario) -> MovedDrill:
    """What a sweep of a drill moves. InputError where there is nothing, or no fault begins in the drill itself."""
    setup, script = scenario.setup, scenario.setup.script
    if not script.faults and not script.acts:
        raise InputError(scenario.file, "fault", None, "at least one [[fault]] or [[act]] that can be moved")
    steps = _steps(setup)
    begun = [step for step in steps[: len(script.faults) or None] if step is not None]
    if not begun:
        expected = "a time, or an event that happens in the drill itself, so that it can be moved"
        raise InputError(scenario.file, "fault[0].start", None, expected)
    at = min(begun)
    both = list(zip(_items(script), steps, strict=True))
    kept = [(step - at, item) for item, step in both if step is not None]
    faults = tuple((offset, item) for offset, item in kept if isinstance(item, ScriptedFault))
    acts = tuple((offset, item) for offset, item in kept if isinstance(item, Act))
    left_out = tuple(item_text(item).en for item, step in both if step is None)
    stocks = stocks_of([item for _, item in faults], setup)
    return MovedDrill(Variation(scenario.id, faults, acts, stocks), left_out)


def stocks_of(failures: Iterable[ScriptedFault], setup: Setup) -> frozenset[str]:
    """The stocks whose trains a sweep follows: those that the faults aim at; all, where one aims at something else."""
    everyone = frozenset(diagram.stock_id for diagram in setup.timetable.diagrams)
    named: set[str] = set()
    for failure in failures:
        target = failure.fault.target
        ends = (target.source, target.destination) if isinstance(failure.fault, LinkFault) else (target,)
        hit = everyone.intersection(ends)
        if not hit:
            return everyone
        named |= hit
    return frozenset(named) or everyone


def _items(script: Script) -> tuple[ScriptedFault | Act, ...]:
    return (*script.faults, *script.acts)


def _steps(setup: Setup) -> list[int | None]:
    """When each fault and act begins in the drill itself; None for never."""
    triggers = [item.trigger for item in _items(setup.script)]
    if any(trigger.at_s is None for trigger in triggers):
        return result_of_copy(list[int | None], partial(_begun, setup))
    return [step_not_before((trigger.at_s or 0.0) + trigger.after_s) for trigger in triggers]


def _begun(setup: Setup) -> list[int | None]:
    with simulation_of(setup) as simulation:
        courses = simulation.run().courses
    step_of = {id(course.item): round(course.begun_s * STEPS_PER_S) for course in courses}
    return [step_of.get(id(item)) for item in _items(setup.script)]


# single faults of every kind ------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class LoneFault:
    """A kind of fault as it is swept alone: how long it lasts (None: it is over at once), and its own keys."""

    duration_s: float | None
    keys: Mapping[str, Any]


SINGLES: Final[Mapping[str, LoneFault]] = {
    "power_off": LoneFault(60.0, {}),
    "restart": LoneFault(None, {}),
    "lost_store": LoneFault(60.0, {}),
    "frozen": LoneFault(30.0, {}),
    "clock": LoneFault(60.0, {"offset_s": 30.0}),
    "false_claims": LoneFault(60.0, {}),
    "doors": LoneFault(30.0, {}),
    "brake": LoneFault(30.0, {}),
    "motors": LoneFault(60.0, {"cut_out": 64}),
    "cut": LoneFault(60.0, {}),
    "loss": LoneFault(120.0, {"p": 0.5}),
    "delay": LoneFault(60.0, {"seconds": 5.0}),
    "duplicate": LoneFault(120.0, {"p": 0.5}),
    "reorder": LoneFault(120.0, {"p": 0.5, "seconds": 2.0}),
    "flip": LoneFault(120.0, {"p": 0.5}),
    "dead_zone": LoneFault(120.0, {"length_m": 1000.0}),
    "cable_cut": LoneFault(60.0, {}),
    "scale": LoneFault(60.0, {"factor": 0.9}),
    "stuck_output": LoneFault(20.0, {}),
    "no_output": LoneFault(20.0, {}),
    "slippery": LoneFault(60.0, {"factor": 0.8}),
    # Half a second before each passage, and nowhere else.
    "miss": LoneFault(1.0, {}),
    "wrong_id": LoneFault(1.0, {}),
    "no_beacon": LoneFault(120.0, {}),
    "false_beacon": LoneFault(None, {}),
    "gyro_dead": LoneFault(60.0, {}),
    "gyro_stuck": LoneFault(60.0, {}),
    "gyro_bias": LoneFault(60.0, {"jump_degps": 0.1}),
    "gyro_noise": LoneFault(60.0, {"factor": 10.0}),
    "stuck": LoneFault(60.0, {}),
    "no_detection": LoneFault(60.0, {}),
    "slow": LoneFault(60.0, {"factor": 3.0}),
    "charger_dead": LoneFault(600.0, {}),
    "barriers_stuck": LoneFault(60.0, {}),
    "stalled_vehicle": LoneFault(60.0, {}),
    "lamps_dead": LoneFault(60.0, {}),
    "crossing_undetected": LoneFault(60.0, {}),
    "button_pressed": LoneFault(60.0, {}),
    "detector_blind": LoneFault(60.0, {}),
    "detector_occupied": LoneFault(60.0, {}),
    "detector_off": LoneFault(60.0, {}),
    "gnss_antenna": LoneFault(60.0, {}),
    "gnss_jammed": LoneFault(60.0, {}),
    "gnss_reflections": LoneFault(60.0, {"bias_m": 30.0}),
    "gnss_jump": LoneFault(60.0, {"bias_m": 30.0}),
    "gnss_time_tag": LoneFault(60.0, {"late_s": 1.0}),
    "gnss_frozen": LoneFault(60.0, {}),
    "lidar_blind": LoneFault(60.0, {}),
    "lidar_fog": LoneFault(60.0, {"visibility_m": 20.0}),
    "marker_missing": LoneFault(600.0, {}),
}


def staffed(scenario: Scenario) -> Scenario:
    """The scenario with staff who react, without whom nothing goes on after some faults."""
    people = scenario.setup.people.model_copy(update={"react": True})
    return replace(scenario, setup=replace(scenario.setup, people=people))


def single_faults(setup: Setup, kinds: Sequence[str] = ()) -> tuple[Variation, ...]:
    """Single faults of every kind, or of some: on every party, link, train and points, on each tag as it is passed."""
    names = names_of(setup)
    wanted = tuple(kinds or SINGLES)
    of_tags = any(FAULTS[kind].aims_at == "tag" for kind in wanted)
    passages = result_of_copy(list[tuple[int, int]], partial(_passages, setup)) if of_tags else []
    variations: list[Variation] = []
    for kind in wanted:
        single, fault = SINGLES[kind], FAULTS[kind]
        for target in _targets(fault, names):
            keys = {**single.keys, **_named(fault, target, names)}
            failure = ScriptedFault(fault(target=target, **keys), NO_TIME, single.duration_s)
            before = None
            if fault.aims_at == "tag":
                before = tuple(step - STEPS_PER_S // 2 for step, tag in passages if str(tag) == target)
                if not before:
                    continue  # no train passes it
            stocks = stocks_of([failure], setup)
            name = f"{kind} {target}"
            variations.append(Variation(name, ((0, failure),), (), stocks, before))
    return tuple(variations)


def _targets(kind: type[Fault[Any]], names: Names) -> tuple[str, ...]:
    """What a kind is swept on: a cut on each link of a unit, what comes by chance on all links together."""
    if not issubclass(kind, LinkFault):
        return kind.targets(names)
    if kind.kind != "cut":
        return (f"{ANY}{BOTH_WAYS}{ANY}",)
    return tuple(f"{unit}{BOTH_WAYS}{device}" for unit in names.units for device in names.devices)


def _named(kind: type[Fault[Any]], target: str, names: Names) -> dict[str, Any]:
    """Keys that name something of this line: the tag that another reads as, what is claimed in the line's middle."""
    match kind.kind:
        case WrongId.kind:
            return {"id": _another(target, names)}
        case FalseClaims.kind:
            return {"section": names.sections[len(names.sections) // 2]}
        case _:
            return {}


def _another(tag: str, names: Names) -> int:
    """The tag that another reads as: the one beside it in the line's table."""
    at = names.tags.index(tag)
    return int(names.tags[at - 1 if at else 1])


def _passages(setup: Setup) -> list[tuple[int, int]]:
    """Which tag is passed at which step when nothing fails."""
    with simulation_of(replace(setup, script=Script())) as simulation:
        entries = simulation.run().journal.entries
    return [(round(e.t_s * STEPS_PER_S), e.event.tag_id) for e in entries if isinstance(e.event, TagPassed)]
