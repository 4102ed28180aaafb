"""One late day: what is drawn from `[late]` for a seed and a day, as data that the world carries out.

Every source draws from generators of its own (`radio.chance`), by train, stop or device, so that adding, changing or
switching off one moves no draw of another. What breaks becomes a fault of the run's script; the rest are figures of
single trains and stops.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import Any, Final

from network.clock import clock
from network.model import Line
from network.timetable import Call, CallKind
from radio.chance import generator
from simulation.events import PointsMoving
from simulation.faults.fault import Fault
from simulation.faults.links import DeadZone
from simulation.faults.script import Matcher, ScriptedFault, Trigger
from simulation.faults.table import FAULTS
from simulation.late.entry import STREAM, entry_late_s, entry_of
from simulation.late.settings import DeadZones, DoorDelays, DwellScatter, EntryDelays, Failures
from simulation.names import names_in
from simulation.setup import Setup
from simulation.world.roster import Duty, drawn_up

THROWS_A_PASSAGE: Final = 2  # at most, assumed, of points by a train: what would fail only later is not drawn


@dataclass(frozen=True, slots=True)
class DrawnDisturbance:
    """One thing drawn. `source`: key path of its table; `who`: train or party; `at_s` None: at a count of throws.

    `seconds`: how late, how much longer, or until it is repaired (0: it is over at once).
    """

    source: str
    who: str
    place: str
    at_s: float | None
    seconds: float
    what: str
    of: str  # the distribution, in words

    @property
    def sentence(self) -> str:
        """In words: when, who, what, from which distribution."""
        when = "" if self.at_s is None else f"{clock(int(self.at_s))} "
        return f"{when}{self.what} ({self.source}: {self.of})"


@dataclass(frozen=True, slots=True)
class DrawnStay:
    """What is drawn for one stop of one train, s: passengers beyond the shortest stop, doors that do not close."""

    people_s: float = 0.0
    doors_s: float = 0.0


@dataclass(frozen=True, slots=True)
class LateDay:
    """A day's disturbances. `stays` by train number and station; `drawn` is all of them, in the order of the tables."""

    stays: Mapping[tuple[str, str], DrawnStay] = field(default_factory=dict[tuple[str, str], DrawnStay])
    failures: tuple[ScriptedFault, ...] = ()
    drawn: tuple[DrawnDisturbance, ...] = ()


PUNCTUAL: Final = LateDay()


def late_day(setup: Setup) -> LateDay:
    """The day of a setup, by its seed and day. The entry delays of its trains are those of `roster.drawn_up`."""
    if not setup.late.model_fields_set:
        return PUNCTUAL
    duties = drawn_up(setup, setup.line)
    stays, of_stays = _stays(setup)
    late = setup.late
    zones = [
        pair for name, table in late.dead_zones.items() for pair in _dead_zones(setup, name, table, duties)
    ]
    broken = [pair for name, table in late.failures.items() for pair in _broken(setup, name, table, duties)]
    both = [*zones, *broken]
    drawn = (*_entries(setup), *of_stays, *(told for told, _ in both))
    return LateDay(stays, tuple(failure for _, failure in both), drawn)


def counts_of(day: LateDay) -> dict[str, int]:
    """How many things were drawn from each table, by its key path."""
    counts: dict[str, int] = {}
    for one in day.drawn:
        counts[one.source] = counts.get(one.source, 0) + 1
    return counts


# trains and stops -----------------------------------------------------------------------------------------------


def _entries(setup: Setup) -> Iterator[DrawnDisturbance]:
    for train in setup.timetable.trains.values():
        late_s, table = entry_late_s(setup.late, setup.seed, setup.today, train), entry_of(setup.late, train)
        if late_s <= 0.0 or table is None:
            continue
        portal = getattr(train.begins, "section_id", "")
        planned_s = train.calls[0].first_s - setup.operation.portal_lead_s
        what = f"train {train.number} comes to {portal} {late_s:.1f} s later than planned"
        yield DrawnDisturbance(
            f"late.entry.{table[0]}", train.number, portal, planned_s, late_s, what, _of(table[1])
        )


def _stays(setup: Setup) -> tuple[dict[tuple[str, str], DrawnStay], list[DrawnDisturbance]]:
    """What passengers and doors take at each stop from which a train goes on."""
    stays, drawn = dict[tuple[str, str], DrawnStay](), list[DrawnDisturbance]()
    for train in setup.timetable.trains.values():
        if not train.revenue:
            continue
        for call in train.calls:
            if call.departure_s is None or call.kind is not CallKind.STOP:
                continue
            people = [] if call is train.calls[0] else list(_people(setup, train.number, call))
            doors = list(_doors(setup, train.number, call))
            if people or doors:
                together = (math.fsum(one.seconds for one in found) for found in (people, doors))
                stays[train.number, call.station_id] = DrawnStay(*together)
                drawn += [*people, *doors]
    return stays, drawn


def _people(setup: Setup, number: str, call: Call) -> Iterator[DrawnDisturbance]:
    station_id, at_s = call.station_id, float(call.departure_s or 0.0)
    for name, table in setup.late.dwell.items():
        drawn_s = _perhaps_s(setup, table, ("dwell", name, number, station_id))
        seconds = round(drawn_s * table.factor(station_id, at_s), 1)
        if seconds > 0.0:
            what = f"passengers of train {number} need {seconds:.1f} s more at {station_id}"
            yield DrawnDisturbance(f"late.dwell.{name}", number, station_id, at_s, seconds, what, _of(table))


def _doors(setup: Setup, number: str, call: Call) -> Iterator[DrawnDisturbance]:
    station_id, at_s = call.station_id, float(call.departure_s or 0.0)
    for name, table in setup.late.doors.items():
        seconds = _perhaps_s(setup, table, ("doors", name, number, station_id))
        if seconds > 0.0:
            what = f"doors of train {number} do not close for {seconds:.1f} s at {station_id}"
            yield DrawnDisturbance(f"late.doors.{name}", number, station_id, at_s, seconds, what, _of(table))


def _perhaps_s(setup: Setup, table: DwellScatter | DoorDelays, names: tuple[str, ...]) -> float:
    """A draw for a share of the cases, s; 0 for the others, and where the table is switched off."""
    if not table.on:
        return 0.0
    chance = generator(setup.seed, STREAM, *names, *setup.today)
    hit = chance.random() < table.share
    return table.seconds.draw_s(chance) if hit else 0.0


def _of(table: EntryDelays | DwellScatter | DoorDelays | Failures) -> str:
    share = getattr(table, "share", 1.0)
    words = "" if table.seconds is None else table.seconds.words
    return words if share == 1.0 else f"{share:g} of them, {words}"


# the radio ------------------------------------------------------------------------------------------------------


def _dead_zones(
    setup: Setup, name: str, table: DeadZones, duties: Mapping[str, Sequence[Duty]]
) -> Iterator[tuple[DrawnDisturbance, ScriptedFault]]:
    if not table.on:
        return
    chance = generator(setup.seed, STREAM, "dead_zones", name, *setup.today)
    from_s, to_s = _hours(duties)
    sections = list(setup.line.sections)
    lengths_m = [_length_m(setup.line, section_id) for section_id in sections]
    ends_m = list(accumulate(lengths_m))
    for _ in range(int(chance.poisson(table.per_day))):
        at_s = round(float(chance.uniform(from_s, to_s)), 1)
        at_m = float(chance.uniform(0.0, ends_m[-1]))
        length_m = round(float(chance.uniform(table.length_low_m, table.length_high_m)), 1)
        lasts_s = table.seconds.draw_s(chance)
        index = next(i for i, end_m in enumerate(ends_m) if at_m <= end_m)
        into_m = at_m - (ends_m[index] - lengths_m[index])
        fault = DeadZone(
            target=sections[index], from_share=round(into_m / lengths_m[index], 4), length_m=length_m
        )
        where = f"{length_m:.0f} m from {into_m:.0f} m into {sections[index]}"
        what = f"the radio does not reach {where} for {lasts_s:.1f} s"
        told = DrawnDisturbance(
            f"late.dead_zones.{name}", "radio", sections[index], at_s, lasts_s, what, table.seconds.words
        )
        yield told, ScriptedFault(fault, Trigger(at_s=at_s), max(lasts_s, 0.1))


def _length_m(line: Line, section_id: str) -> float:
    pieces = [line.pieces[piece_id] for piece_id in line.sections[section_id].piece_ids]
    return max(piece.to_m for piece in pieces) - min(piece.from_m for piece in pieces)


# what breaks ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ExposedTime:
    """A stretch of the day in which something may break: from when to when (s), and how much of its use falls in it."""

    from_s: float
    to_s: float
    use: float


def _broken(
    setup: Setup, name: str, table: Failures, duties: Mapping[str, Sequence[Duty]]
) -> Iterator[tuple[DrawnDisturbance, ScriptedFault]]:
    if not table.on:
        return
    kind: type[Fault[Any]] = FAULTS[table.kind]
    for target in table.targets or kind.targets(names_in(setup)):
        names = (STREAM, "failures", name, target)
        when_chance = generator(setup.seed, *names, "when", *setup.today)
        chance = generator(setup.seed, *names, "repair", *setup.today)
        fault = kind.model_validate({"target": target, **(table.model_extra or {})})
        for trigger, when in _triggers(table, target, duties, when_chance):
            repaired_s = (
                None if kind.momentary or table.seconds is None else max(table.seconds.draw_s(chance), 0.1)
            )
            lasts = "" if repaired_s is None else f" for {repaired_s:.1f} s"
            what = f"{table.kind} of {target}{when}{lasts}"
            of = (
                f"{_mean_words(table)}; repair: {_of(table)}"
                if table.seconds is not None
                else _mean_words(table)
            )
            told = DrawnDisturbance(
                f"late.failures.{name}", target, "", trigger.at_s, repaired_s or 0.0, what, of
            )
            yield told, ScriptedFault(fault, trigger, repaired_s)


def _triggers(
    table: Failures,
    target: str,
    duties: Mapping[str, Sequence[Duty]],
    chance: Any,  # noqa: ANN401
) -> Iterator[tuple[Trigger, str]]:
    """When it breaks, by the clock or by counts of throws; in words where it is counted."""
    if table.mtbf_operations is not None:
        throws, most = 0, THROWS_A_PASSAGE * _passages(target, duties)
        while (throws := throws + int(chance.geometric(1.0 / table.mtbf_operations))) <= most:
            on = Matcher(f"points {target} move", (PointsMoving,), data={"points_id": target})
            yield Trigger(on=on, nth=throws), f" at its throw {throws}, if it comes to that"
        return
    mean = table.mtbf_h or table.mtbf_km or math.inf
    uses = _in_hours(target, duties) if table.mtbf_km is None else _in_km(target, duties)
    used = 0.0
    fails_at = float(chance.exponential(mean))
    for stretch in uses:
        while fails_at <= used + stretch.use:
            along = (fails_at - used) / stretch.use
            at_s = round(stretch.from_s + along * (stretch.to_s - stretch.from_s), 1)
            yield Trigger(at_s=at_s), ""
            fails_at += float(chance.exponential(mean))
        used += stretch.use


def _passages(points_id: str, duties: Mapping[str, Sequence[Duty]]) -> int:
    """How many trains are to pass points."""
    missions = (duty.mission for of_stock in duties.values() for duty in of_stock)
    return sum(any(p == points_id for span in m.spans for p, _, _ in span.points) for m in missions)


def _in_hours(target: str, duties: Mapping[str, Sequence[Duty]]) -> list[ExposedTime]:
    """Hours of a unit on the line, as planned; of what is no unit, the hours of the day."""
    if target not in duties:
        from_s, to_s = _hours(duties)
        return [ExposedTime(from_s, to_s, (to_s - from_s) / 3600.0)]
    stretches = [(duty.enter_s, duty.train.calls[-1].last_s) for duty in duties[target]]
    return [
        ExposedTime(from_s, to_s, (to_s - from_s) / 3600.0) for from_s, to_s in stretches if to_s > from_s
    ]


def _in_km(target: str, duties: Mapping[str, Sequence[Duty]]) -> list[ExposedTime]:
    """The kilometres that a unit is to run, train by train."""
    found: list[ExposedTime] = []
    for duty in duties.get(target, ()):
        marks_m = [item.mark_m for item in duty.mission.targets]
        run_km = (marks_m[-1] - marks_m[0]) / 1000.0
        found.append(ExposedTime(duty.train.calls[0].first_s, duty.train.calls[-1].last_s, run_km))
    return [stretch for stretch in found if stretch.use > 0.0]


def _hours(duties: Mapping[str, Sequence[Duty]]) -> tuple[float, float]:
    """From the first train to the last, as planned, s."""
    every = [duty for of_stock in duties.values() for duty in of_stock]
    return min(duty.enter_s for duty in every), max(duty.train.calls[-1].last_s for duty in every)


def _mean_words(table: Failures) -> str:
    for value, unit in ((table.mtbf_h, "h"), (table.mtbf_km, "km"), (table.mtbf_operations, "throws")):
        if value is not None:
            return f"one in {value:g} {unit}"
    return ""
