"""The grid of telegrams: a fault just before and just after each telegram is sent or takes effect (電文の前後の試験).

What a party knows changes with telegrams and with nothing else, so between two of them it does not matter to it when
something fails. On a grid of seconds a window of a few tenths between a word and its answer is found by luck; on this
one it cannot be missed. Instants are those of the run as it is written, with its own faults and acts. A fault of a
party counts when that party says or hears something, one of points when their terminal does, one of links or the radio
when a telegram is sent that it would stop and that is not lost as it is; any other at each telegram. What is said again
in vain, once more unheard, tells nobody anything and is no instant. What nobody can notice has one instant.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from itertools import pairwise
from typing import Any, Final

import msgspec

from network.timetable import BecomesTrain, Diagram, Stabled, TimetableTrain
from radio.chance import generator
from scenario.script_file import names_of
from simulation.faults.cable import CableFault
from simulation.faults.devices import PowerCut
from simulation.faults.fault import Fault
from simulation.faults.links import ONE_WAY, Cut, DeadZone, FaultyLink, LinkFault
from simulation.faults.points import PointsFault
from simulation.faults.script import ScriptedFault
from simulation.faults.table import FAULTS
from simulation.settings import Interlocking
from simulation.setup import STEPS_PER_S, Setup, latest_end_s
from simulation.world.dead_zones import DeadZonesInForce
from study.drilling.every_instant import InstantWindow, Variation
from study.drilling.forks import result_of_copy
from study.drilling.moving import NO_TIME, SINGLES, single_faults
from study.drilling.outcome_class import SweptRun, expected_breaks, swept_run_of
from study.drilling.seen_telegrams import SeenTelegram, TelegramWatch
from study.runner.run import simulation_of

BEFORE_S: Final = 60.0  # of when something in the script begins or is over, and
AFTER_S: Final = 300.0  # after it
LASTS_S: Final = 3600.0  # without a script, from the first telegram on
ENDS_AFTER_S: Final = (
    14_400.0  # a day that is cut goes on so long at most, as the whole one could; a stall ends it
)
FOLLOWS_S: Final = (
    1200.0  # trains that begin later than this after the last instant cannot show anything of it
)


class FaultChoice(StrEnum):
    """Which faults."""

    POWER = "power"  # of each party
    LINKS = "links"  # a cut of each link, one way
    ALL = "all"  # of every kind


class _WrittenRun(msgspec.Struct, frozen=True):
    """The run as it is written: who told whom something, at which step; when all of its script began and was over."""

    telegrams: list[SeenTelegram]
    script_s: list[float]
    own: SweptRun


@dataclass(frozen=True, slots=True)
class TelegramGrid:
    """What is swept: the setup, cut after the last instant, and each fault with its instants.

    `own`: what is wrong without any fault beside, where the setup expects that. `of`: runs of the complete grid, where
    this is a sample.
    """

    setup: Setup
    variations: tuple[Variation, ...]
    own: tuple[SweptRun, ...]
    of: int

    @property
    def runs(self) -> int:
        """How many runs it takes."""
        return _runs(self.variations)

    def sample(self, runs: int) -> TelegramGrid:
        """So many runs of this grid or fewer, evenly over faults and instants; which ones follows from the seed."""
        every = [(variation, step) for variation in self.variations for step in variation.instants or ()]
        if runs >= len(every):
            return self
        chance = generator(self.setup.seed, "telegram grid").random()
        drawn = [every[int((i + chance) * len(every) / runs)] for i in range(runs)]
        steps: dict[str, list[int]] = {}
        for variation, step in drawn:
            steps.setdefault(variation.name, []).append(step)
        return replace(
            self,
            variations=tuple(
                replace(v, instants=tuple(steps[v.name])) for v in self.variations if v.name in steps
            ),
        )


def _runs(variations: Iterable[Variation]) -> int:
    return sum(len(variation.instants or ()) for variation in variations)


def grid_of(setup: Setup, chosen: FaultChoice, window: InstantWindow) -> TelegramGrid:
    """The grid of a setup; `window` may give the first and the last instant."""
    if (known_s := _last_known_s(setup, window)) is not None:
        setup = shortened_setup(setup, known_s + FOLLOWS_S)
    course = result_of_copy(_WrittenRun, partial(_course, setup))
    steps = [seen.step for seen in course.telegrams] or [0]
    spans = _spans(course.script_s, min(steps) / STEPS_PER_S - 1.0, window)
    own = _own(setup, course)
    setup = shortened_setup(setup, spans[-1][1] + FOLLOWS_S)
    names = names_of(setup)
    parties = frozenset((*names.units, *names.devices))
    within = [
        seen
        for seen in course.telegrams
        if _is_in(seen.step, spans) and {seen.source, seen.receiver} <= parties
    ]
    variations = (
        replace(v, instants=_instants(v, within, setup))
        if v.instants is None
        else replace(v, instants=tuple(step for step in v.instants if _is_in(step, spans)))
        for v in _faults(setup, chosen, within)
    )
    found = tuple(v for v in variations if v.instants)
    return TelegramGrid(setup, found, own, _runs(found))


def _spans(script_s: Sequence[float], begins_s: float, window: InstantWindow) -> list[tuple[float, float]]:
    """From when until when instants lie, in order: round all of the script, else an hour; or as the window says."""
    spans = [(time_s - BEFORE_S, time_s + AFTER_S) for time_s in sorted(script_s)]
    spans = spans or [(begins_s, begins_s + LASTS_S)]
    if window.from_s is None and window.to_s is None:
        return spans
    first_s = spans[0][0] if window.from_s is None else window.from_s
    return [(first_s, spans[-1][1] if window.to_s is None else window.to_s)]


def _is_in(step: int, spans: Iterable[tuple[float, float]]) -> bool:
    return any(from_s * STEPS_PER_S <= step <= to_s * STEPS_PER_S for from_s, to_s in spans)


def _course(setup: Setup) -> _WrittenRun:
    with simulation_of(setup) as simulation:
        watch = TelegramWatch(simulation.trains.radio_place)
        simulation.journal.watch(watch.see)
        result = simulation.run()
    own = (*setup.script.faults, *setup.script.acts)  # and nothing that staff did of themselves
    courses = [course for course in result.courses if course.item in own]
    script_s = [t for course in courses for t in (course.begun_s, course.over_s) if t is not None]
    return _WrittenRun(watch.telegrams(), script_s, swept_run_of(result, setup.script))


def _last_known_s(setup: Setup, window: InstantWindow) -> float | None:
    """The last instant, where it is known before anything is run."""
    faults = [(failure.trigger, failure.duration_s or 0.0) for failure in setup.script.faults]
    items = [*faults, *((act.trigger, act.hold_s) for act in setup.script.acts)]
    times_s = [t.at_s + t.after_s + lasts_s for t, lasts_s in items if t.at_s is not None]
    script_s = max(times_s) + AFTER_S if times_s and len(times_s) == len(items) else None
    return script_s if window.to_s is None else window.to_s


def _own(setup: Setup, course: _WrittenRun) -> tuple[SweptRun, ...]:
    """What a drill comes to as it is written that expects what is wrong: with staff who react, and without, and what it
    says may be broken. Of any other nothing is its own.
    """
    if not any(e.absent and e.holds for e in setup.script.expectations):
        return ()
    people = setup.people.model_copy(update={"react": False})
    return (
        course.own,
        result_of_copy(_WrittenRun, partial(_course, replace(setup, people=people))).own,
        *expected_breaks(setup.script),
    )


def _faults(setup: Setup, chosen: FaultChoice, telegrams: list[SeenTelegram]) -> Iterator[Variation]:
    if chosen is FaultChoice.POWER:
        yield from single_faults(setup, [PowerCut.kind])
    if chosen is FaultChoice.ALL:
        yield from single_faults(setup, [name for name in FAULTS if name != Cut.kind])
    if chosen is not FaultChoice.POWER:
        for link in sorted({(seen.source, seen.receiver) for seen in telegrams}):
            yield _cut(setup, *link)


def _cut(setup: Setup, source: str, receiver: str) -> Variation:
    failure = ScriptedFault(Cut(target=FaultyLink(source, receiver)), NO_TIME, SINGLES[Cut.kind].duration_s)
    stocks = frozenset(diagram.stock_id for diagram in setup.timetable.diagrams)
    return Variation(f"{Cut.kind} {source}{ONE_WAY}{receiver}", ((0, failure),), (), stocks)


def _instants(variation: Variation, telegrams: list[SeenTelegram], setup: Setup) -> tuple[int, ...]:
    """Before and after each telegram that this fault may have to do with: in a step, faults come after telegrams."""
    ((_, failure),) = variation.faults
    concerns = _concerns(failure.fault, setup)
    steps = {step for seen in telegrams if concerns(seen) for step in (seen.step - 1, seen.step)}
    return tuple(sorted(steps))[: None if _may_be_noticed(failure.fault, setup) else 1]


def _concerns(fault: Fault[Any], setup: Setup) -> Callable[[SeenTelegram], bool]:
    """Which telegrams a fault may have to do with."""
    names = names_of(setup)
    match fault:
        case LinkFault():  # asked as a telegram is sent, and so are the radio and the cable
            return lambda seen: _goes_out(seen) and fault.target.joins(seen.source, seen.receiver)
        case DeadZone():
            zones = DeadZonesInForce(setup.line)
            zones.put_stretches(fault.target, fault.applied_to(()))
            return lambda seen: _goes_out(seen) and seen.place is not None and zones.hides_place(*seen.place)
        case CableFault():
            return _goes_out
        case PointsFault():
            terminal_id = setup.line.points[fault.target].terminal_id
            return lambda seen: seen.party == terminal_id and not seen.is_repeat
        case _ if fault.target in (*names.units, *names.devices):
            return lambda seen: seen.party == fault.target and not seen.is_repeat
        case _:
            return lambda seen: not seen.is_repeat


def _goes_out(seen: SeenTelegram) -> bool:
    """Whether it is sent now, and would be missed."""
    return seen.is_sent and not seen.is_lost


def _may_be_noticed(fault: Fault[Any], setup: Setup) -> bool:
    """Whether there is what fails: the sensor aboard, the cable between a central interlocking and its points."""
    if isinstance(fault, CableFault):
        return setup.operation.interlocking is not Interlocking.ONBOARD
    return fault.of_sensor is None or fault.of_sensor in setup.sensors.carried_by(fault.target)


def _goes_on(diagram: Diagram, kept: Mapping[str, TimetableTrain]) -> Iterator[str]:
    """The next train of a stock that is not kept, where it would stand in the way of another stock until then."""
    mine = diagram.train_numbers
    for before, after in pairwise(mine):
        if before in kept and after not in kept and isinstance(kept[before].ends, BecomesTrain):
            stands_at, from_s = kept[before].calls[-1].station_id, kept[before].calls[0].first_s
            calls = (call for n, train in kept.items() if n not in mine for call in train.calls)
            if any(call.station_id == stands_at and call.last_s >= from_s for call in calls):
                yield after


def shortened_setup(setup: Setup, until_s: float) -> Setup:
    """The setup without trains that begin after a time; stock that would become one of them stays where it is, if no
    other train comes there: else it has to go on, and so have those in its way.
    """
    old = setup.timetable
    kept = {n: train for n, train in old.trains.items() if train.calls[0].first_s <= until_s}
    while in_the_way := [n for d in old.diagrams for n in _goes_on(d, kept)]:
        kept |= {n: old.trains[n] for n in in_the_way}
    if len(kept) == len(old.trains):
        return setup
    diagrams = [
        replace(diagram, train_numbers=numbers)
        for diagram in old.diagrams
        if (numbers := tuple(n for n in diagram.train_numbers if n in kept))
    ]
    last = {diagram.train_numbers[-1] for diagram in diagrams}
    trains = {
        n: replace(train, ends=Stabled()) if n in last and isinstance(train.ends, BecomesTrain) else train
        for n, train in kept.items()
    }
    stocks = {diagram.stock_id for diagram in diagrams}
    gone = {diagram.stock_id for diagram in old.diagrams} - stocks
    if any(end in gone for failure in setup.script.faults for end in str(failure.fault.target).split()):
        return setup
    if any(act.target in gone for act in setup.script.acts):
        return setup
    timetable = replace(old, trains=trains, diagrams=tuple(diagrams))
    limits = setup.limits
    time_limit_s = limits.time_limit_s + setup.latest_end_s - latest_end_s(timetable, limits)
    return replace(
        setup,
        timetable=timetable,
        limits=limits.model_copy(update={"time_limit_s": min(time_limit_s, ENDS_AFTER_S)}),
        trains={stock_id: train for stock_id, train in setup.trains.items() if stock_id in stocks},
    )
