"""Blocking times of a run: from what parties and world wrote in the journal, and where trains truly were.

The register says whose a section is: granted, or taken as signed on, until freed. What the unit asked, held, commanded,
had proven and reported are the lines of its own; front and rear are the trace's. A section is wanted from the first
request on; while another has it, or another section of the same route, it is waited for, which is no part of the
occupation. What a run that was cut short leaves open ends with it.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from network.model import Line, SectionKind
from onboard import notes
from simulation.events import JournalEntry, Left
from simulation.result import BatteryEvent, EnergyPhase, RunResult
from simulation.setup import STEPS_PER_S
from study.capacity import passage
from study.capacity.occupation import TOUCH_S, Occupation, OccupationPart
from study.capacity.passage import PassageStand, SectionPassage, occupation_of, setting_out
from study.measures.register_holds import SectionHold
from study.measures.visits import SectionVisit

PART_OF: Final = {
    EnergyPhase.AT_STOP: OccupationPart.DWELL,
    EnergyPhase.HELD: OccupationPart.HELD,
    EnergyPhase.LAYOVER: OccupationPart.LAYOVER,
    EnergyPhase.STABLED: OccupationPart.LAYOVER,
}


def occupations_run(result: RunResult, line: Line, holds: Sequence[SectionHold]) -> tuple[Occupation, ...]:
    """The blocking times that the holds of a run make up, in order of their begin."""
    standing = _standing(result, line, holds)
    ends_s = result.end_step / STEPS_PER_S
    found = [occupation_of(_passage(hold, standing[hold.unit], line), ends_s) for hold in holds]
    return tuple(sorted(found, key=lambda o: (o.begin_s, o.section_id)))


def _passage(hold: SectionHold, standing: tuple[PassageStand, ...], line: Line) -> SectionPassage:
    """The moments of a hold: those of the register and the unit, and those of the truth."""
    visit = hold.visit or SectionVisit(hold.section_id, math.inf, math.inf)
    portal = line.sections[hold.section_id].kind is SectionKind.PORTAL
    leaves_s, rear_s, safe_rear_s = visit.leaves_s, visit.rear_s, visit.safe_rear_s
    reported_s = hold.freed_s if hold.reported_s is None else hold.reported_s
    # signed off there
    if portal and hold.reported_s is None and visit.enters_s <= hold.arrived_s < hold.freed_s:
        leaves_s = rear_s = safe_rear_s = reported_s = hold.arrived_s
    wanted_s, sent_s, heard_s = hold.asked
    held_s = heard_s if hold.held_s is None else hold.held_s
    if visit.enters_s == -math.inf and not hold.route_id:  # there before anybody asked
        wanted_s = sent_s = heard_s = held_s = min(wanted_s, visit.begin_s)
    return SectionPassage(
        hold.section_id,
        hold.unit,
        hold.number,
        hold.direction,
        hold.route_id,
        wanted_s,
        sent_s,
        heard_s,
        held_s,
        visit.enters_s,
        leaves_s,
        rear_s,
        safe_rear_s,
        reported_s,
        hold.freed_s,
        tuple(hold.throwing),
        tuple(s for s in standing if s.end_s > wanted_s and s.begin_s < hold.freed_s),
        hold.waited_s,
    )


def _standing(
    result: RunResult, line: Line, holds: Sequence[SectionHold]
) -> dict[str, tuple[PassageStand, ...]]:
    """What each stock stood for, by the truth; of what went on at once the last one noted counts.

    A stand of no length is that of a train that comes to a stand as the run ends.
    """
    found: dict[str, list[PassageStand]] = defaultdict(list)
    ends_s = result.end_step / STEPS_PER_S
    for record in result.energy:
        lasts = passage.LAST_STANDS and abs(record.end_s - ends_s) <= TOUCH_S
        if record.phase in PART_OF and (record.end_s > record.begin_s or lasts):
            found[record.stock_id].append(PassageStand(PART_OF[record.phase], record.begin_s, record.end_s))
    stood = {unit: tuple(own) for unit, own in found.items()}
    for unit, charged in _charging(result, line):
        found[unit] += [both for both in (_both(charged, s) for s in stood.get(unit, ())) if both is not None]
    for unit, start in _starts(result.journal.entries):
        found[unit] += [both for both in (_both(start, s) for s in stood.get(unit, ())) if both is not None]
    for unit, setting in _settings_out(result.journal.entries, holds):
        found[unit].append(setting)
    for unit, change in _changes(result.journal.entries):
        found[unit].append(change)
    return {stock_id: tuple(found[stock_id]) for stock_id in result.stock_ids}


def _both(one: PassageStand, other: PassageStand) -> PassageStand | None:
    """What of a stand falls into another."""
    begin_s, end_s = max(one.begin_s, other.begin_s), min(one.end_s, other.end_s)
    return PassageStand(one.part, begin_s, end_s) if end_s > begin_s else None


def _charging(result: RunResult, line: Line) -> Iterator[tuple[str, PassageStand]]:
    """The time at chargers on the line, with raising and lowering the pantograph: since the set stood there."""
    stood_s: dict[str, float] = {}
    since_s: dict[str, float] = {}
    for record in result.battery:
        unit, charger = record.stock_id, line.chargers.get(record.station)
        if record.event is BatteryEvent.STANDS:
            stood_s[unit] = record.t_s
        elif record.event is BatteryEvent.CONNECTED and charger is not None:
            since_s[unit] = min(stood_s.get(unit, record.t_s), record.t_s - charger.connect_s)
        elif record.event is BatteryEvent.DISCONNECTED and unit in since_s and charger is not None:
            yield (
                unit,
                PassageStand(OccupationPart.CHARGING, since_s.pop(unit), record.t_s + charger.disconnect_s),
            )
    for unit, from_s in since_s.items():
        yield unit, PassageStand(OccupationPart.CHARGING, from_s, result.end_step / STEPS_PER_S)


def _starts(entries: Iterable[JournalEntry]) -> Iterator[tuple[str, PassageStand]]:
    """From the word to leave until the train moves."""
    told_s: dict[str, float] = {}
    for entry in entries:
        match entry.event:
            case notes.Departs():
                told_s[entry.who] = entry.t_s
            case notes.Moving() if entry.who in told_s:
                yield entry.who, PassageStand(OccupationPart.START, told_s.pop(entry.who), entry.t_s)
            case _:
                pass


def _settings_out(
    entries: Iterable[JournalEntry], holds: Sequence[SectionHold]
) -> Iterator[tuple[str, PassageStand]]:
    """While the first way of a train is set, for which its unit could not ask before it took up its number."""
    begun_s: dict[str, float] = {}
    for entry in entries:
        unit, until_s = entry.who, entry.t_s
        match entry.event:
            case notes.MissionBegun():
                begun_s[unit] = until_s
            case notes.Departs() if unit in begun_s:
                from_s = begun_s.pop(unit)
                for hold in holds:
                    if hold.unit == unit and hold.route_id and from_s <= hold.asked.sent_s <= until_s:
                        held_s = hold.asked.heard_s if hold.held_s is None else hold.held_s
                        ways = hold.asked.sent_s, hold.asked.heard_s, held_s, hold.throwing
                        yield from ((unit, one) for one in setting_out(*ways, until_s))
            case _:
                pass


def _changes(entries: Iterable[JournalEntry]) -> Iterator[tuple[str, PassageStand]]:
    """From the end of a train until the unit takes up the next one where it stands, and what it gives back before."""
    arrived_s: dict[str, float] = {}
    done_s: dict[str, float] = {}
    for entry in entries:
        match entry.event:
            case notes.Arrived():
                arrived_s[entry.who] = entry.t_s
            case notes.MissionDone():
                done_s[entry.who] = entry.t_s
            case Left(unit_id=unit):
                done_s.pop(unit, None)
            case notes.MissionBegun() if entry.who in done_s:
                ended_s = done_s.pop(entry.who)
                yield (
                    entry.who,
                    PassageStand(OccupationPart.RELEASE, arrived_s.get(entry.who, ended_s), ended_s),
                )
                yield entry.who, PassageStand(OccupationPart.CHANGE_ENDS, ended_s, entry.t_s)
            case _:
                pass
