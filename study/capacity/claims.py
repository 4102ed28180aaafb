"""What two trains want of the same sections, each around an event of its own, moved against each other.

Each stood where it sets out for as long as it liked; but where the other one is going, or was, it is not free to. If
the first train was in a place, or comes there, before the second leaves it, the second came there only when it had
gone: the leg by which it came counts, too. If the first comes to a place before the second does, it has to go on: the
leg by which it does counts, too. So the one is followed backwards and the other onwards, as far as that says which goes
first; all stands between are the shortest (docs/decisions/060).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from study.capacity.legs import Leg, costs_between, slack_of, stand_of, stands_in
from study.capacity.occupation import COST_OF, TOUCH_S, Cost, Occupation

WAY_IN_COUNTS = True  # off: a train that starts from where another one was may have been there all the time
BACK_MAX = 1_000  # legs of the second before that of its event; 1: what lies further back can always wait


@dataclass(frozen=True, slots=True)
class Event:
    """A train arrives at a place, or departs from it: the leg into it, or out of it.

    `before`: by which legs its set came to where that leg starts, the last one first; `after`: by which it goes on.
    """

    leg: Leg
    arrival: bool
    before: tuple[Leg, ...] = ()
    after: tuple[Leg, ...] = ()

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
class Claim:
    """A section of one of the two trains, and what the time between its event and the section's end, or begin, goes
    into: for the first from the event until the section is free, for the second from its need of it to the event.
    """

    occupation: Occupation
    costs_s: Mapping[Cost, float]

    @property
    def time_s(self) -> float:
        """The whole of that time, s."""
        return math.fsum(self.costs_s.values())


class Claims:
    """What the first train holds from its event on, and what the second needs up to its own.

    `ahead` are legs of the first, that of its event first, `behind` legs of the second, that of its event first. Of
    `behind[j]` is known that it comes after `ahead[: first[j] + 1]`; there are as many of each as that says of.
    `possible` is off where the second can never come after the first: it was in the first one's way in the morning, or
    the first stays in its way at night.
    """

    def __init__(
        self, first: Event, second: Event, held: Iterable[Occupation], dwell_min_s: float = math.inf
    ) -> None:
        self._dwell_min_s = dwell_min_s
        self._held = tuple(one for one in held if math.isfinite(one.end_s))
        self.ahead: tuple[Leg, ...] = (first.leg, *(() if first.arrival else first.after))
        self.behind: tuple[Leg, ...] = (second.leg, *second.before[:BACK_MAX])
        self.possible = True
        self.first: tuple[int, ...] = tuple(self._order(ends=not first.arrival)) if WAY_IN_COUNTS else (0,)
        self._goes_on = len(self.ahead) > 1
        self.ahead = self.ahead[: self.first[0] + 1]
        self.behind = self.behind[: len(self.first)]
        self._holds = list(self._all_held(first))
        self._needs = list(self._all_needed(second))

    def shared(self) -> Iterator[tuple[Claim, Claim]]:
        """Each section that the second needs after the first held it: the one's claim and the other's.

        What the first has there and back it has until it comes back.
        """
        for goes_first, needs in reversed(list(zip(self.first, self._needs, strict=True))):
            holds = {h.occupation.section_id: h for own in self._holds[: goes_first + 1] for h in own}
            for need in needs:
                hold = holds.get(need.occupation.section_id)
                if hold is not None:
                    yield hold, need

    # which leg goes before which -----------------------------------------------------------------------------------

    def _order(self, *, ends: bool) -> list[int]:
        """Of each leg of the second, from that of its event backwards, the last leg of the first that goes before it.

        Whoever goes before a leg goes before all that come after that; so it is looked at until nothing more follows.
        """
        found = [0]
        changed = True
        while changed:
            before = list(found)
            for later, goes_first in enumerate(before):
                for one in range(goes_first + 1):
                    self._follow(found, one, later, ends=ends)
            for later in reversed(range(len(found) - 1)):
                found[later] = max(found[later], found[later + 1])
            changed = found != before
        return found

    def _follow(self, found: list[int], one: int, later: int, *, ends: bool) -> None:
        """What it says of other legs that `ahead[one]` goes before `behind[later]`."""
        leg, other = self.ahead[one], self.behind[later]
        goes_to, comes_from, comes_to = _id(leg.end), _id(other.start), _id(other.end)
        goes_on = one + 1 < len(self.ahead)
        stays = leg.end is not None and ends and not goes_on and math.isinf(leg.end.leaves_s)
        if stays and goes_to in (comes_from, comes_to):
            self.possible = False
        if goes_on and goes_to and goes_to == comes_to:
            found[later] = max(found[later], one + 1)
        was_in = {o.section_id for o in self._held} if one == 0 else {_id(leg.start)}
        least = one + 1 if goes_on and goes_to == comes_from else one if comes_from in was_in else -1
        if other.start is None or least < 0:
            return
        if later + 1 < len(self.behind):
            found[later + 1 :] = [max([least, *found[later + 1 : later + 2]]), *found[later + 2 :]]
        elif later < BACK_MAX and math.isinf(other.start.enters_s):
            self.possible = False

    # claims ----------------------------------------------------------------------------------------------------------

    def _all_held(self, first: Event) -> Iterator[list[Claim]]:
        """What the first holds, leg by leg; a place to which it comes counts as of the leg by which it leaves that."""
        sooner_s: Mapping[Cost, float] = {}
        place: list[Claim] = []
        for index, leg in enumerate(self.ahead):
            event = first if index == 0 else Event(leg, arrival=False)
            own = self._held if index == 0 else tuple(o for o in leg.occupations if math.isfinite(o.end_s))
            holds = [self._hold(one, event, sooner_s) for one in own]
            goes_on = index + 1 < len(self.ahead) or (index == 0 and self._goes_on and WAY_IN_COUNTS)
            ends = [hold for hold in holds if goes_on and hold.occupation is leg.end]
            yield [*place, *(hold for hold in holds if hold not in ends)]
            place = ends
            if leg.end is not None:
                sooner_s = _sum(sooner_s, _run_s(Event(leg, arrival=True)), self._stood_s(leg.end))

    def _all_needed(self, second: Event) -> Iterator[list[Claim]]:
        """What the second needs, leg by leg, that of its event first; and the portal where it signs on."""
        later_s: Mapping[Cost, float] = {}
        for index, leg in enumerate(self.behind):
            event = second if index == 0 else Event(leg, arrival=True)
            needs = list(_needed(event, later_s))
            start = leg.start
            if start is not None:
                later_s = _sum(later_s, _run_s(event), self._stood_s(start))
                signs_on = math.isfinite(start.enters_s) and len(second.before) == index
                if signs_on and index + 1 == len(self.behind) and WAY_IN_COUNTS:
                    signs_on_s = costs_between(start, start.begin_s, stand_of(start).arrives_s)
                    needs.insert(0, Claim(start, _sum(later_s, signs_on_s)))
            yield needs

    def _hold(self, one: Occupation, event: Event, sooner_s: Mapping[Cost, float]) -> Claim:
        """What the first train holds; a stand that comes after the event is as short as it can be."""
        spent_s = costs_between(one, event.time_s, one.end_s)
        if stand_of(one).arrives_s >= event.time_s - TOUCH_S:
            slack_s = slack_of(one, self._dwell_min_s)
            spent_s = {cost: spent_s[cost] - slack_s[cost] for cost in Cost}
        return Claim(one, _sum(spent_s, sooner_s))

    def _stood_s(self, place: Occupation) -> dict[Cost, float]:
        """What the shortest stand in a place goes into, s; infinite parts of one that has no end are left out."""
        stand = stand_of(place)
        if not (math.isfinite(stand.arrives_s) and math.isfinite(stand.departs_s)):
            return dict.fromkeys(Cost, 0.0)
        stood_s = costs_between(place, stand.arrives_s, stand.departs_s)
        slack_s = slack_of(place, self._dwell_min_s)
        return {cost: stood_s[cost] - slack_s[cost] for cost in Cost}


def _id(place: Occupation | None) -> str:
    return "" if place is None else place.section_id


def _needed(event: Event, later_s: Mapping[Cost, float]) -> Iterator[Claim]:
    """The sections of the leg of an event of the second train, and what comes after that event.

    Once its front is out of a section it drives on to its event, however long its rear holds the section.
    """
    for one in event.leg.occupations:
        if not math.isfinite(one.begin_s):
            continue
        until_s = min(event.time_s, max(one.leaves_s, one.begin_s))
        spent_s = costs_between(one, one.begin_s, until_s, event.leg.occupations)
        spent_s[Cost.DRIVING] += event.time_s - until_s
        yield Claim(one, _sum(spent_s, later_s))


def _run_s(event: Event) -> dict[Cost, float]:
    """What the time from a leg's departure to its event goes into, s."""
    found = dict.fromkeys(Cost, 0.0)
    if event.arrival:
        leg = event.leg
        for stand in (s for one in leg.occupations[:-1] for s in stands_in(one)):
            found[COST_OF[stand.part]] += stand.length_s
        found[Cost.DRIVING] += leg.arrives_s - leg.departs_s - math.fsum(found.values())
    return found


def _sum(*costs_s: Mapping[Cost, float]) -> dict[Cost, float]:
    return {cost: math.fsum(one.get(cost, 0.0) for one in costs_s) for cost in Cost}
