"""Whether a plan can work: everything that is looked at, in one list; `study.feasibility.finding` has the rule."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from network.clock import clock
from network.errors import InputError, one_line
from network.model import SectionKind
from simulation.setup import Setup
from study.feasibility.charge import charge_of
from study.feasibility.climbs import climbs_of
from study.feasibility.conflicts import BY_BLOCKS, Pair, conflicts_of, on_paper, pairs_of
from study.feasibility.crossings import crossings_of
from study.feasibility.entries import entries_of
from study.feasibility.equipment import equipment_of
from study.feasibility.finding import (
    HIDDEN_BY_MINUTES_S,
    Feasibility,
    Finding,
    FindingKind,
    Severity,
    length_of_time,
    minute,
)
from study.feasibility.holdings import clashes_of, holds_of
from study.feasibility.meets import day_meets
from study.feasibility.passings import passings_of
from study.feasibility.places import track_place
from study.feasibility.planned import PlannedDay, planned_day
from study.feasibility.rehearsal import BlockedTrain, Rehearsal, RehearsedLateness
from study.feasibility.timing import timing_of

TOLD_FROM_S = HIDDEN_BY_MINUTES_S  # lateness that adds up to less


def feasibility(setup: Setup) -> Feasibility:
    """All meets of the day and all that is wrong with it; nothing is run.

    The times of the plan are looked at first: what each set holds when, what each leg, stop and turn-back takes, what
    units need of the line. A day in which all that goes on is then played through in blocks (`Rehearsal`): for what
    follows from the whole of it, and who makes up for what is short. What makes nobody late by a minute is tight.
    """
    day = planned_day(setup)
    by_section = holds_of(day)
    pairs = pairs_of(clashes_of(by_section))
    meets = day_meets(day)
    met = {frozenset((meet.down_train, meet.up_train)): meet for meet in meets}
    # What a day in blocks knows nothing of:
    beyond_blocks = [*passings_of(setup, day), *charge_of(setup, day), *crossings_of(setup, day)]
    findings = [
        *_missing(setup, day),
        *_nowhere(day),
        *conflicts_of(day.line, pairs, met, by_section),
        *entries_of(setup, day),
        *timing_of(setup, day),
        *climbs_of(setup, day),
        *beyond_blocks,
        *equipment_of(setup, day),
    ]
    paper = frozenset(frozenset(pair) for pair, found in pairs.items() if on_paper(found))
    sure = [f for f in findings if f.severity is Severity.IMPOSSIBLE and not _by_blocks(f, paper)]
    if not sure:
        slowed = {(n, f.place) for f in findings if f.kind is FindingKind.TAG for n in f.trains}
        rehearsal = Rehearsal(setup, day, frozenset(slowed))
        circles, lateness = list(_circles(day, rehearsal.waits)), list(_lateness(day, rehearsal.late))
        untold = [f for f in beyond_blocks if f.severity is Severity.LATE]
        late = {number for finding in (*lateness, *untold) for number in finding.trains}
        if circles:  # and nothing shows who would have made up for what
            stuck = [frozenset(circle.trains) for circle in circles]
            findings = [
                replace(f, severity=Severity.IMPOSSIBLE)
                if f.severity is Severity.LATE and any(trains.issuperset(f.trains) for trains in stuck)
                else f
                for f in findings
            ]
        else:
            findings = [f if late & set(f.trains) else replace(f, severity=Severity.TIGHT) for f in findings]
        findings += [*circles, *lateness]
    findings.sort(key=_gravity)
    clash = {frozenset(f.trains) for f in findings if f.severity is not Severity.TIGHT}
    shown = (replace(m, possible=frozenset((m.down_train, m.up_train)) not in clash) for m in meets)
    return Feasibility(tuple(shown), tuple(findings))


def _gravity(finding: Finding) -> tuple[int, bool, float, tuple[str, ...], str]:
    """The gravest first, and causes before what follows from them."""
    follows, kind = finding.kind in {FindingKind.LATE, FindingKind.CIRCLE}, finding.kind.value
    return list(Severity).index(finding.severity), follows, finding.time_s, finding.trains, kind


def _by_blocks(finding: Finding, paper: frozenset[Pair]) -> bool:
    """Whether the day played through decides about a finding."""
    return finding.kind in BY_BLOCKS and len(finding.trains) == 2 and frozenset(finding.trains) not in paper


class PlanRefusedError(InputError):
    """A plan that cannot work is not run: the first thing that is wrong with it, and how many more."""

    def __init__(self, scenario: str, found: Feasibility) -> None:
        super().__init__(scenario, "", None, "a plan that can work")
        self._found = found

    def __str__(self) -> str:
        """One line for the person who has to mend the plan."""
        first, *more = self._found.impossible
        further = f"; {len(more)} more" if more else ""
        can_run = not any(finding.kind is FindingKind.NO_WAY for finding in self._found.impossible)
        anyway = ", --anyway runs it all the same" if can_run else ""
        shows = f"branchline check {one_line(self.file)} shows all{anyway}"
        return f"{one_line(self.file)} cannot work: {first.sentence}{further}; {shows}"


def refuse(scenario: str, setup: Setup, *, anyway: bool = False) -> Feasibility:
    """Look at a plan before it is run.

    Raises PlanRefusedError where it cannot work; `anyway`, only where the line has no way for a train.
    """
    found = feasibility(setup)
    no_way = any(finding.kind is FindingKind.NO_WAY for finding in found.impossible)
    if no_way or not (found.good or anyway):
        raise PlanRefusedError(scenario, found)
    return found


def _missing(setup: Setup, day: PlannedDay) -> Iterator[Finding]:
    """Trains for which the line has no way."""
    for missing in day.missing:
        first = setup.timetable.trains[missing.number].calls[0]
        text = f"{missing.number} cannot run at {minute(first.last_s)}: {missing.why}"
        remedy = "other tracks, or points that lead there"
        trains = (missing.number,)
        yield Finding(
            FindingKind.NO_WAY, Severity.IMPOSSIBLE, trains, first.station_id, first.last_s, text, remedy
        )


def _nowhere(day: PlannedDay) -> Iterator[Finding]:
    """Trains of one stop alone: a run counts none of them as arrived."""
    for train in day.all():
        if len(train.duty.mission.targets) < 2:
            stand = train.stands[0]
            place = stand.target.place_id
            text = f"{train.number} has one stop alone, at {minute(stand.departs_s)}, and goes nowhere"
            remedy = "a second call, or no train"
            trains = (train.number,)
            yield Finding(
                FindingKind.NO_WAY, Severity.IMPOSSIBLE, trains, place, stand.departs_s, text, remedy
            )


def _circles(day: PlannedDay, waits: Sequence[BlockedTrain]) -> Iterator[Finding]:
    """Trains that never get on, each circle of them once; those that only wait behind one are left out."""
    by_stock = {one.train.stock_id: one for one in waits}
    reported: set[str] = set()
    for one in sorted(waits, key=_planned_s):
        circle = _circle(one, by_stock)
        if not circle or reported & {each.train.stock_id for each in circle}:
            continue
        reported |= {each.train.stock_id for each in circle}
        yield _circle_finding(day, circle)


def _planned_s(one: BlockedTrain) -> float:
    return one.train.nodes[one.node].departs_s


def _circle(first: BlockedTrain, by_stock: dict[str, BlockedTrain]) -> list[BlockedTrain]:
    """From a waiting train on to whom it waits for, until one comes again: those from there on."""
    chain: list[BlockedTrain] = []
    one: BlockedTrain | None = first
    while one is not None and one not in chain:
        chain.append(one)
        holder = one.held_by[0] if one.held_by else ""
        one = by_stock.get(holder)
    return chain if one is None else chain[chain.index(one) :]


def _circle_finding(day: PlannedDay, circle: Sequence[BlockedTrain]) -> Finding:
    line = day.line
    last = max(circle, key=_planned_s)
    parts: list[str] = []
    for one in circle:
        node = one.train.nodes[one.node]
        _, where = track_place(line, node.section_id)
        parts.append(f"{one.train.number} on {where} waits for section {one.section_id}")
    time_s = _planned_s(last)
    text = f"from {minute(time_s)} nothing moves: {', '.join(parts)}"
    in_portal = any(line.sections[one.section_id].kind is SectionKind.PORTAL for one in circle)
    remedy = (
        "a shorter operation.portal_lead_s, or the train from the portal later"
        if in_portal
        else "another track for one of them, or another order"
    )
    place, _ = track_place(line, last.train.nodes[last.node].section_id)
    trains = tuple(one.train.number for one in circle)
    return Finding(FindingKind.CIRCLE, Severity.IMPOSSIBLE, trains, place, time_s, text, remedy)


def _lateness(day: PlannedDay, late: Sequence[RehearsedLateness]) -> Iterator[Finding]:
    """Trains that come late by what adds up: one finding a train, where it is latest."""
    worst: dict[str, RehearsedLateness] = {}
    for one in late:
        if one.late_s >= TOLD_FROM_S and one.late_s > worst.get(one.train.number, one).late_s - 1e-9:
            worst[one.train.number] = one
    for number, one in worst.items():
        name = day.line.stations[one.station_id].name
        at = clock(round(one.due_s + one.late_s))
        does = "leave" if one.leaves else "come to"
        text = f"{number} would {does} {name} at {at}, {length_of_time(one.late_s)} late"
        if one.behind:
            text += f", behind {' and '.join(one.behind)}"
        trains = (number, *(b for b in one.behind if b != number))
        remedy = "more time on its way before that"
        yield Finding(
            FindingKind.LATE, Severity.LATE, trains, one.station_id, one.due_s, text, remedy, one.late_s
        )
