"""The fewest sets of a scenario, with what empty workings could still save, and whether the day runs with them."""

from __future__ import annotations

from dataclasses import dataclass, replace

from network.timetable import Timetable
from plan.roster.cover import Roster, least_roster
from plan.roster.facts import RosterTerms, RosterTrain, roster_trains
from plan.roster.recount import RosterRecount
from plan.roster.written import stranded, with_sets
from simulation.setup import Setup
from study.feasibility.check import feasibility
from study.feasibility.finding import Feasibility


@dataclass(frozen=True, slots=True)
class FewestSets:
    """A roster, recounted. `stranded`: trains for which the least times leave no set; then nothing else is meant.

    `today`: sets as the timetable has them. `at_least_with_empty_workings`: fewer cannot do even if sets run empty
    between trains as quickly as the line allows, whatever is in their way. `judged`: by `branchline check`.
    """

    trains: tuple[RosterTrain, ...]
    roster: Roster
    stranded: tuple[str, ...]
    today: int
    at_least_with_empty_workings: int
    timetable: Timetable
    judged: Feasibility


def fewest_sets(setup: Setup, terms: RosterTerms) -> FewestSets:
    """As few sets as can be for a scenario's timetable. Raises InputError where the line has no way for a train."""
    trains = roster_trains(setup)
    roster = least_roster(trains, terms)
    RosterRecount(trains, terms).refuse(roster.sets, roster.why)
    with_empties = replace(terms, empty_mps=setup.line.max_speed_mps)
    bound = least_roster(trains, with_empties).why
    RosterRecount(trains, with_empties).refuse_bound(bound)
    left = tuple(stranded(trains, roster))
    kinds = {stock_id: kind.id for stock_id, kind in setup.trains.items()}
    timetable = setup.timetable if left else with_sets(setup.timetable, roster, kinds)
    judged = feasibility(replace(setup, timetable=timetable))
    return FewestSets(trains, roster, left, len(setup.timetable.diagrams), bound.sets, timetable, judged)


def named(timetable: Timetable, timetable_id: str) -> Timetable:
    """The timetable under another name, with where its sets come from."""
    made = "diagrams: as few sets as can run these trains, by branchline best roster"
    head = timetable.head.model_copy(update={"id": timetable_id, "assumed": [*timetable.head.assumed, made]})
    return replace(timetable, head=head)
