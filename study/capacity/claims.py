"""What a headway between an event of one train and one of another goes into, along what the two need of each other.

Each stood where it sets out for as long as it liked; but where the other one is going, or was, it is not free to. Who
goes first over what both need is `study.capacity.orders`; what decides is a chain of claims: the first train has a
section from its event until that is free, the second from its need of it goes on to its own event, or, where the first
waits for it, until a section is free that the first needs, and so on. All stands between are the shortest.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

from study.capacity.legs import SetLeg, costs_between, slack_of, stand_of, stands_in
from study.capacity.occupation import COST_OF, TOUCH_S, Occupation, OccupationCost
from study.capacity.orders import DayOfLegs, OrderedLeg, Orders, TimedOrder

WAY_IN_COUNTS = True  # off: a train that starts from where another one was may have been there all the time
NEED_ON_THE_WAY_COUNTS = True  # off: what a train takes before it needs a section on its way counts as well


@dataclass(frozen=True, slots=True)
class Event:
    """A train arrives at a place, or departs from it: the leg into it, or out of it.

    `before`: by which legs its set came to where that leg starts, the last one first; `after`: by which it goes on.
    """

    leg: SetLeg
    arrival: bool
    before: tuple[SetLeg, ...] = ()
    after: tuple[SetLeg, ...] = ()

    @property
    def time_s(self) -> float:
        """When."""
        return self.leg.arrives_s if self.arrival else self.leg.departs_s

    @property
    def track_id(self) -> str:
        """The section of the place."""
        place = self.leg.end if self.arrival else self.leg.start
        return "" if place is None else place.section_id


@dataclass(frozen=True, slots=True)
class LegRun:
    """A stretch of the time of a headway, from a leg's departure on, and how long it lasts, s.

    It lasts until the section `frees` is free again, until the set departs as `follows`, or until the leg arrives.
    `enters`: it begins as the front comes into that section, which the train needs on its way only. `back`: the chain
    goes it backwards, so that the headway is the shorter, the longer it lasts.
    """

    leg: SetLeg
    lasts_s: float
    frees: str = ""
    follows: SetLeg | None = None
    back: bool = False
    enters: str = ""


@dataclass(frozen=True, slots=True)
class Claims:
    """What the first train holds from its event on, and what the second needs up to its own, in the best order.

    `first_s` and `second_s` make up the least time; `section_id` is the section by which the first is last in the
    second's way. `ahead` are the legs that the first goes before the second's event, that of its event first, `behind`
    those of the second, that of its event first; `ahead_waits_s` and `behind_waits_s` say for how much longer than it
    must a train stands before each: the first goes as soon as it can, the second as late. `runs`: what of the time is
    running, as the chain goes over it. `possible`: off where the second can never come after the first, and the legs
    of the two events alone count.
    """

    section_id: str
    first_s: Mapping[OccupationCost, float]
    second_s: Mapping[OccupationCost, float]
    ahead: tuple[SetLeg, ...]
    behind: tuple[SetLeg, ...]
    ahead_waits_s: tuple[float, ...]
    behind_waits_s: tuple[float, ...]
    runs: tuple[LegRun, ...]
    possible: bool


def claims_of(
    first: Event, second: Event, known: DayOfLegs, room: Collection[str] | None = None
) -> Claims | None:
    """The claims of two events; None where the two share nothing, or the second cannot come after the first.

    `room`: the legs of the two events alone count, and of these not the sections that have room for all that wait.
    """
    started = tuple(_runs_in(first))
    orders = Orders([*started, first.leg, *first.after], len(started), [second.leg, *second.before], known)
    timed = orders.least() if WAY_IN_COUNTS and room is None else None
    possible = timed is not None or not WAY_IN_COUNTS or room is not None
    timed = timed or orders.alone(room or (), comes=not possible)
    if timed is None or math.isinf(timed.later_s[-1]):
        return None
    return _Chain(orders, timed, first, second, known).claims(possible=possible)


def _runs_in(event: Event) -> Iterator[SetLeg]:
    """The legs by which a train came on which it did not stop before its event, in order of travel."""
    found: list[SetLeg] = []
    leg = event.leg
    for before in event.before:
        if leg.start is None or not stand_of(leg.start).passes:
            break
        found.insert(0, before)
        leg = before
    yield from found


class _Chain:
    """The chain of claims that decides, from the first train's event to the second's."""

    def __init__(
        self, orders: Orders, timed: TimedOrder, first: Event, second: Event, known: DayOfLegs
    ) -> None:
        self._orders, self._timed, self._first, self._second = orders, timed, first, second
        self._known = known
        self._path = [len(timed.moves) - 1]
        while not self._is_source(self._path[0]):
            self._path.insert(0, timed.came[self._path[0]][0])

    def claims(self, *, possible: bool) -> Claims:
        """What the time goes into, and what each train does meanwhile."""
        timed, at = self._timed, self._first
        spent_s: tuple[list[Mapping[OccupationCost, float]], list[Mapping[OccupationCost, float]]] = ([], [])
        section_id = ""
        for place, (before, after) in enumerate(pairwise(self._path)):
            one, other, cross = timed.moves[before], timed.moves[after], timed.came[after][1]
            if cross is None and before < after:
                spent_s[one.second].extend((_rest_s(at), self._stood_s(other.leg)))
            elif cross is None:
                back_s = _sum(_run_s(at), self._stood_s(one.leg), _run_s(Event(other.leg, arrival=True)))
                spent_s[one.second].append(_times(back_s, -1.0))
            else:
                spent_s[one.second].append(self._hold(cross.hold, at))
            at = Event(other.leg, arrival=False)
            if cross is not None:
                section_id = cross.need.section_id if other.second else section_id
                at = self._until(place + 1, other)
                spent_s[other.second].append(self._need(cross.need, at))
        if self._second.arrival and not at.arrival:
            spent_s[True].append(_rest_s(at))
        ahead = tuple(move.leg for move in timed.moves if not move.second and move.away >= 0)
        behind = tuple(move.leg for move in timed.moves if move.second)[::-1]
        waits_s = self._waits_s()
        return Claims(
            section_id,
            _sum(*spent_s[False]),
            _sum(*spent_s[True]),
            ahead,
            behind,
            tuple(waits_s[id(leg)] for leg in ahead),
            tuple(waits_s[id(leg)] for leg in behind),
            tuple(self._runs()),
            possible,
        )

    def _runs(self) -> Iterator[LegRun]:
        """What the chain runs over, from the first's event to the second's."""
        moves, came, known = self._timed.moves, self._timed.came, self._known
        if self._first.arrival:
            leg = self._first.leg
            yield LegRun(leg, leg.arrives_s - leg.departs_s, back=True)
        for before, after in pairwise(self._path):
            leg, cross = moves[before].leg, came[after][1]
            enters, from_s = self._comes_in(before)
            if cross is not None:
                frees_s = known.frees_s(cross.hold, leg.departs_s)
                yield LegRun(leg, frees_s - from_s, frees=cross.hold.section_id, enters=enters)
                continue
            if before > after:
                leg, follows = moves[after].leg, leg
                enters, from_s = "", leg.departs_s
            else:
                follows = moves[after].leg
            lasts_s = known.gap_s(leg, follows) + follows.departs_s - from_s
            yield LegRun(leg, lasts_s, follows=follows, back=before > after, enters=enters)
        leg, (enters, from_s) = self._second.leg, self._comes_in(self._path[-1])
        if self._second.arrival:
            yield LegRun(leg, leg.arrives_s - from_s, enters=enters)
        elif enters:
            yield LegRun(leg, leg.departs_s - from_s, follows=leg, enters=enters)

    def _comes_in(self, at: int) -> tuple[str, float]:
        """From which section on, and when, s, the chain runs over a leg: that it waits for on its way, or departing."""
        leg = self._timed.moves[at].leg
        cross = self._timed.came[at][1] if at in self._timed.came else None
        on_the_way = cross is not None and cross.need.begin_s > leg.departs_s and NEED_ON_THE_WAY_COUNTS
        if cross is None or not on_the_way or not math.isfinite(cross.need.enters_s):
            return "", leg.departs_s
        return cross.need.section_id, cross.need.enters_s

    def _is_source(self, at: int) -> bool:
        move = self._timed.moves[at]
        return not move.second and move.away == 0

    def _until(self, place: int, move: OrderedLeg) -> Event:
        """Up to which event a leg counts as that by which a section is needed."""
        if place + 1 == len(self._path):
            return self._second
        after = self._path[place + 1]
        goes_on = self._timed.came[after][1] is None and after > self._path[place]
        return Event(move.leg, arrival=goes_on)

    def _waits_s(self) -> dict[int, float]:
        """For how much longer than it must each train stands before each leg, by leg."""
        moves, orders = self._timed.moves, self._orders
        at_s = [
            s if not move.second else math.inf for s, move in zip(self._timed.later_s, moves, strict=True)
        ]
        at_s[-1] = self._timed.later_s[-1]
        before: list[int | None] = [None] * len(moves)
        for at in range(len(moves) - 1, -1, -1):
            for earlier, w_s, cross in orders.after(moves[:at], moves[at]):
                if cross is None:
                    before[at] = earlier
                if moves[earlier].second:
                    at_s[earlier] = min(at_s[earlier], at_s[at] - w_s)
        found: dict[int, float] = {}
        for at, move in enumerate(moves):
            came = before[at]
            least_s = 0.0 if came is None else self._known.gap_s(moves[came].leg, move.leg)
            wait_s = 0.0 if came is None else at_s[at] - at_s[came] - least_s
            found[id(move.leg)] = wait_s if math.isfinite(wait_s) else 0.0
        return found

    def _hold(self, one: Occupation, event: Event) -> dict[OccupationCost, float]:
        """What a train has a section for after an event; a stand after that is as short as it can be."""
        spent_s = costs_between(one, event.time_s, one.end_s)
        if stand_of(one).arrives_s < event.time_s - TOUCH_S:
            return spent_s
        return _sum(spent_s, _times(slack_of(one, self._known.dwell_min_s), -1.0))

    def _need(self, one: Occupation, event: Event) -> dict[OccupationCost, float]:
        """What a train needs a section for until an event; the portal where it signs on with the shortest stand.

        Once its front is out of a section it drives on to its event, however long its rear holds the section.
        """
        leg = event.leg
        if one is leg.start:
            signs_on_s = costs_between(one, one.begin_s, stand_of(one).arrives_s)
            return _sum(signs_on_s, self._stood_s(leg), _run_s(event))
        until_s = min(event.time_s, max(one.leaves_s, one.begin_s))
        spent_s = costs_between(one, one.begin_s, until_s, leg.occupations)
        spent_s[OccupationCost.DRIVING] += event.time_s - until_s
        return spent_s

    def _stood_s(self, leg: SetLeg) -> dict[OccupationCost, float]:
        """What the shortest stand before a leg goes into, s; infinite parts of one that has no end are left out."""
        place = leg.start
        stand = None if place is None else stand_of(place)
        if (
            place is None
            or stand is None
            or not (math.isfinite(stand.arrives_s) and math.isfinite(stand.departs_s))
        ):
            return dict.fromkeys(OccupationCost, 0.0)
        stood_s = costs_between(place, stand.arrives_s, stand.departs_s)
        return _sum(stood_s, _times(slack_of(place, self._known.dwell_min_s), -1.0))


def _run_s(event: Event) -> dict[OccupationCost, float]:
    """What the time from a leg's departure to its event goes into, s."""
    found = dict.fromkeys(OccupationCost, 0.0)
    if event.arrival:
        leg = event.leg
        for stand in (s for one in leg.occupations[:-1] for s in stands_in(one)):
            found[COST_OF[stand.part]] += stand.length_s
        found[OccupationCost.DRIVING] += leg.arrives_s - leg.departs_s - math.fsum(found.values())
    return found


def _rest_s(event: Event) -> dict[OccupationCost, float]:
    """What the time from a leg's event to its arrival goes into, s."""
    return dict.fromkeys(OccupationCost, 0.0) if event.arrival else _run_s(Event(event.leg, arrival=True))


def _times(costs_s: Mapping[OccupationCost, float], by: float) -> dict[OccupationCost, float]:
    return {cost: by * time_s for cost, time_s in costs_s.items()}


def _sum(*costs_s: Mapping[OccupationCost, float]) -> dict[OccupationCost, float]:
    return {cost: math.fsum(one.get(cost, 0.0) for one in costs_s) for cost in OccupationCost}
