"""A timetable run by other sets, and which tracks nobody could leave or reach so."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from network.timetable import AtPortal, BecomesTrain, Diagram, FromTrain, Stabled, Timetable, TimetableTrain
from plan.roster.cover import Roster
from plan.roster.facts import RosterTrain


def stranded(trains: Sequence[RosterTrain], roster: Roster) -> Iterator[str]:
    """Trains that begin a set on a track on which another was before, or end one where another comes after."""
    goes_on = set(roster.follows.values())
    for train in trains:
        others = [event for t in trains if t is not train for event in (t.begins, t.ends)]
        begins, ends = train.begins, train.ends
        first = train.number not in roster.follows and not begins.outside
        last = train.number not in goes_on and not ends.outside
        before = (e.place == begins.place and e.time_s < begins.time_s for e in others)
        after = (e.place == ends.place and e.time_s > ends.time_s for e in others)
        if (first and any(before)) or (last and any(after)):
            yield train.number


def with_sets(timetable: Timetable, roster: Roster, kinds: Mapping[str, str]) -> Timetable:
    """The timetable with these sets; `kinds` of today's stock by its id, whose names they take."""
    today = {number: own.stock_id for own in timetable.diagrams for number in own.train_numbers}
    free = [diagram.stock_id for diagram in timetable.diagrams]
    diagrams: list[Diagram] = []
    for own in roster.sets:
        wanted = [s for s in (today[number] for number in own) if s in free]
        kind = kinds[today[own[0]]]
        stock_id = (wanted or [s for s in free if kinds[s] == kind])[0]
        free.remove(stock_id)
        diagrams.append(Diagram(stock_id, own))
    goes_on = {before: number for number, before in roster.follows.items()}
    trains = {
        number: _train(train, roster.follows.get(number), goes_on.get(number))
        for number, train in timetable.trains.items()
    }
    return replace(timetable, trains=trains, diagrams=tuple(diagrams))


def _train(train: TimetableTrain, follows: str | None, becomes: str | None) -> TimetableTrain:
    begins, ends = train.begins, train.ends
    if not isinstance(begins, AtPortal):
        begins = Stabled() if follows is None else FromTrain(follows)
    if not isinstance(ends, AtPortal):
        ends = Stabled() if becomes is None else BecomesTrain(becomes)
    return replace(train, begins=begins, ends=ends)
