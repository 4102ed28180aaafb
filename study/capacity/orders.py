"""In which order two trains can take their legs, and how soon the second can come to its event in the best of them.

Each train goes its legs one after another; of two legs that need one section the one goes first or the other, and no
leg ends in a place where the other train stands. An order of all legs says who goes first everywhere. By it a leg
departs as soon as its own train has stood as long as it must, and as all that went before over its sections has freed
them: a longest way from the first train's event, which may go from the one train to the other and back where the first
waits for the second at a meet. The least headway is that of the order in which it is least (docs/decisions/084).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field

from study.capacity.legs import SetLeg, slack_of, stand_of
from study.capacity.occupation import TOUCH_S, Occupation

FIRST_WAITS = True  # off: the first train never waits for the second
BACK_MAX = 1_000  # legs of the second before that of its event; 1: what lies further back can always wait


@dataclass(frozen=True, slots=True)
class SectionHandover:
    """A section goes from the one train to the other: as it was held, and as it is needed."""

    hold: Occupation
    need: Occupation


@dataclass(frozen=True, slots=True)
class OrderedLeg:
    """A leg in an order, whose it is, and how many legs of its train lie between it and that of the event."""

    leg: SetLeg
    second: bool
    away: int


@dataclass(slots=True)
class TimedOrder:
    """An order with its times. `later_s`: by how much each leg is later than planned, the first's event as planned;
    minus infinity: by as little as one likes. `came`: from which leg, and by which section, if not by its own train.
    """

    moves: tuple[OrderedLeg, ...]
    later_s: list[float]
    came: dict[int, tuple[int, SectionHandover | None]] = field(
        default_factory=dict[int, tuple[int, SectionHandover | None]]
    )


class DayOfLegs:
    """What is worked out of the legs of a day, once for all pairs of trains."""

    def __init__(self, dwell_min_s: float = math.inf) -> None:
        self.dwell_min_s = dwell_min_s
        self.crosses: dict[tuple[int, int], tuple[float, SectionHandover] | None] = {}
        self._legs: dict[int, SetLeg] = {}  # by which the ids stay theirs
        self._departs_s: dict[int, float] = {}
        self._passes: dict[int, bool] = {}
        self._gaps_s: dict[tuple[int, int], float] = {}

    def keep(self, leg: SetLeg) -> int:
        """The id of a leg, which nothing else will have."""
        self._legs[id(leg)] = leg
        return id(leg)

    def departs_s(self, leg: SetLeg) -> float:
        """When it departs as planned, s."""
        if id(leg) not in self._departs_s:
            self._departs_s[self.keep(leg)] = leg.departs_s
        return self._departs_s[id(leg)]

    def passes(self, leg: SetLeg) -> bool:
        """Whether its train does not stop before it."""
        if id(leg) not in self._passes:
            self._passes[self.keep(leg)] = leg.start is not None and stand_of(leg.start).passes
        return self._passes[id(leg)]

    def gap_s(self, before: SetLeg, leg: SetLeg) -> float:
        """How much later than planned a leg must be where the one before it is as planned, s."""
        key = id(before), id(leg)
        if key not in self._gaps_s:
            start = leg.start
            least_s = 0.0 if start is None else stand_of(start, self.dwell_min_s).least_s
            self._gaps_s[self.keep(before), self.keep(leg)] = before.arrives_s + least_s - leg.departs_s
        return self._gaps_s[key]

    def frees_s(self, one: Occupation, from_s: float) -> float:
        """When a section is free again; a stand that comes after a time is as short as it can be."""
        if stand_of(one).arrives_s < from_s - TOUCH_S:
            return one.end_s
        return one.end_s - math.fsum(slack_of(one, self.dwell_min_s).values())


class Orders:
    """The orders of two chains of legs: those of the first from that of its event on, of the second up to its own.

    `ahead` is in order of travel, that of the event at `event`, what lies before it runs with it without a stop;
    `behind` is in reverse, that of the event first.
    """

    def __init__(
        self,
        ahead: Sequence[SetLeg],
        event: int,
        behind: Sequence[SetLeg],
        known: DayOfLegs,
    ) -> None:
        self._ahead, self._event, self._behind = ahead, event, behind
        self._known = known
        self._alone, self._comes = False, True
        self._room: Collection[str] = ()
        self._ends: dict[tuple[int, int], bool] = {}
        self._rest_s: list[float] = []  # by how much the second's last leg must be later than one so far back
        self._comes_s = math.inf
        self._seen: dict[tuple[int, int], list[dict[tuple[bool, int], float]]] = {}
        self._best: TimedOrder | None = None
        self._best_s = math.inf

    def least(self) -> TimedOrder | None:
        """The order by which the second's leg is soonest; None: in none it comes after the first's."""
        legs, rest_s = self._behind, [0.0]
        for before, after in zip(legs[1:], legs, strict=False):
            rest_s.append(rest_s[-1] + self._known.gap_s(before, after))
        self._rest_s, self._comes_s = rest_s, legs[0].arrives_s
        sets_out_s = self._ahead[0].departs_s
        for back in range(min(len(self._behind), BACK_MAX + 1)):
            if sets_out_s + rest_s[back] - legs[back].arrives_s >= self._best_s:  # too long a way from there
                break
            if not self._begins(back):
                continue
            moves: list[OrderedLeg] = []
            at = back
            while at + 1 < len(self._behind) and self._known.passes(self._behind[at]):
                at += 1
                moves.insert(0, OrderedLeg(self._behind[at], second=True, away=at))
            self._go(moves, [-math.inf] * len(moves), 0, back)
        return self._best

    def alone(self, room: Collection[str] = (), *, comes: bool) -> TimedOrder | None:
        """The two legs of the events alone, wherever else the trains are; some sections have room for both.

        `comes`: the second comes to where its leg starts after the first has left that.
        """
        self._room, self._alone, self._comes = room, True, comes
        self._ahead, self._behind = self._ahead[: self._event + 1], self._behind[:1]
        ahead = [OrderedLeg(leg, second=False, away=at - self._event) for at, leg in enumerate(self._ahead)]
        self._take((*ahead, OrderedLeg(self._behind[0], second=True, away=0)))
        return self._best

    def crossing(self, one: OrderedLeg, other: OrderedLeg) -> tuple[float, SectionHandover] | None:
        """How much later the other must be for each second that the one is later, by the section that decides."""
        if self._alone:
            return self._cross(one, other)
        known = self._known
        key = id(one.leg), id(other.leg)
        if key not in known.crosses:
            known.crosses[known.keep(one.leg), known.keep(other.leg)] = self._cross(one, other)
        return known.crosses[key]

    # places -----------------------------------------------------------------------------------------------------------

    def _first_in(self, gone: int) -> str:
        """The place in which the first stands after so many legs; empty where it holds none."""
        if gone == 0:
            return _id(self._ahead[0].start)
        end = self._ahead[gone - 1].end
        over = gone == len(self._ahead) and end is not None and math.isfinite(end.leaves_s)
        return "" if over else _id(end)

    def _second_in(self, back: int) -> str:
        """The place in which the second stands before its leg so far back; empty: it is not on the line yet."""
        return "" if back >= BACK_MAX or self._signs_on(back) else _id(self._behind[back].start)

    def _signs_on(self, back: int) -> bool:
        start = self._behind[back].start
        last = back + 1 == len(self._behind) and self._comes
        return last and start is not None and math.isfinite(start.enters_s)

    def _may(self, gone: int, back: int, *, second: bool) -> bool:
        """Whether a train can go its next leg as the two stand."""
        if not second:
            return gone < len(self._ahead) and not _one(self._ahead[gone].end, self._second_in(back))
        in_turn = back > 0 or gone > self._event
        return in_turn and not _one(self._behind[back].end, self._first_in(gone))

    def _can(self, gone: int, back: int) -> bool:
        """Whether the second can come to its event from a state: legs gone, and legs yet to go less one."""
        key = gone, back
        if key not in self._ends:
            comes = self._may(gone, back, second=True) and (back == 0 or self._can(gone, back - 1))
            self._ends[key] = comes or (self._may(gone, back, second=False) and self._can(gone + 1, back))
        return self._ends[key]

    def _begins(self, back: int) -> bool:
        """Whether the second may be before its leg so far back as the first sets out."""
        taken = {self._first_in(gone) for gone in range(self._event + 1)} - {""}
        return self._second_in(back) not in taken and self._can(0, back)

    def _could_be_there(self, back: int, at_s: float) -> bool:
        """Whether the second could as well have begun where its leg so far back takes it: nothing came before that."""
        return math.isinf(at_s) and back > 0 and not self._known.passes(self._behind[back - 1])

    # orders -----------------------------------------------------------------------------------------------------------

    def _go(self, moves: list[OrderedLeg], later_s: list[float], gone: int, back: int) -> None:
        """All orders that go on from here and may be better than the best so far."""
        if back < 0:
            self._take(tuple(moves))
            return
        if not self._can(gone, back) or self._is_worse(moves, later_s, gone, back):
            return
        if self._may(gone, back, second=True):
            move = OrderedLeg(self._behind[back], second=True, away=back)
            at_s = self._soonest_s(moves, later_s, move)
            late = at_s + self._rest_s[back] >= self._best_s - TOUCH_S
            if not (late or self._could_be_there(back, at_s)):
                self._add(moves, later_s, move, at_s, gone, back - 1)
        if self._may(gone, back, second=False):
            move = OrderedLeg(self._ahead[gone], second=False, away=gone - self._event)
            at_s = 0.0 if gone <= self._event else self._soonest_s(moves, later_s, move)
            until_s = self._best_s + self._comes_s
            if move.away <= 0 or self._known.departs_s(move.leg) + at_s < until_s:
                self._add(moves, later_s, move, at_s, gone + 1, back)

    def _add(
        self,
        moves: list[OrderedLeg],
        later_s: list[float],
        move: OrderedLeg,
        at_s: float,
        gone: int,
        back: int,
    ) -> None:
        """Go on with a further leg; one that its train does not stop before makes the one before it later, too."""
        both = [*moves, move]
        if not self._known.passes(move.leg) or (not move.second and move.away <= 0):
            self._go(both, [*later_s, at_s], gone, back)
            return
        timed = self._timed(tuple(both))
        if timed is not None:
            self._go(both, timed.later_s, gone, back)

    def _is_worse(self, moves: Sequence[OrderedLeg], later_s: Sequence[float], gone: int, back: int) -> bool:
        """Whether as much was gone in another order with nothing later; not asked while a train runs through."""
        if gone <= self._event or any(
            self._known.passes(leg) for leg in (*self._ahead[gone : gone + 1], self._behind[back])
        ):
            return False
        mine = {(m.second, m.away): s for m, s in zip(moves, later_s, strict=True)}
        others = self._seen.setdefault((gone, back), [])
        if any(all(s <= mine.get(key, -math.inf) + TOUCH_S for key, s in one.items()) for one in others):
            return True
        others.append(mine)
        return False

    def _soonest_s(self, moves: Sequence[OrderedLeg], later_s: Sequence[float], move: OrderedLeg) -> float:
        """The least that a further leg is later by what went before it."""
        return max((later_s[at] + w_s for at, w_s, _ in self.after(moves, move)), default=-math.inf)

    def after(
        self, moves: Sequence[OrderedLeg], move: OrderedLeg
    ) -> Iterator[tuple[int, float, SectionHandover | None]]:
        """The legs that a further one has to come after: the last of its own train, and all that share a section."""
        own = next((at for at in range(len(moves) - 1, -1, -1) if moves[at].second is move.second), None)
        if own is not None:
            yield own, self._known.gap_s(moves[own].leg, move.leg), None
        if not (FIRST_WAITS or move.second):
            return
        for at, before in enumerate(moves):
            found = self.crossing(before, move) if before.second is not move.second else None
            if found is not None:
                yield at, *found

    def _take(self, moves: tuple[OrderedLeg, ...]) -> None:
        """An order whole, if it is better than the best so far."""
        found = self._timed(moves)
        if found is not None and found.later_s[-1] < self._best_s - TOUCH_S:
            self._best, self._best_s = found, found.later_s[-1]

    def _timed(self, moves: tuple[OrderedLeg, ...]) -> TimedOrder | None:
        """The longest ways of an order; None: in it one waits for what waits for it.

        A train that does not stop between two legs goes both at once.
        """
        edges: list[tuple[int, int, float, SectionHandover | None]] = []
        for at, move in enumerate(moves):
            for before, w_s, cross in self.after(moves[:at], move):
                edges.append((before, at, w_s, cross))
                if cross is None and self._known.passes(move.leg):
                    edges.append((at, before, -w_s, None))
        found = TimedOrder(moves, [-math.inf] * len(moves))
        source = next((at for at, move in enumerate(moves) if not move.second and move.away == 0), None)
        if source is None:
            return found
        found.later_s[source] = 0.0
        for _ in range(len(moves) + 1):
            changed = False
            for before, at, w_s, cross in edges:
                if found.later_s[before] + w_s > found.later_s[at] + TOUCH_S:
                    found.later_s[at] = found.later_s[before] + w_s
                    found.came[at] = before, cross
                    changed = True
            if not changed:
                return found if found.later_s[source] <= 0.0 else None
        return None

    def _cross(self, one: OrderedLeg, other: OrderedLeg) -> tuple[float, SectionHandover] | None:
        chain = self._behind[::-1] if one.second else self._ahead
        last = one.leg is chain[-1]
        holds = {o.section_id: o for o in one.leg.held if math.isfinite(o.end_s)}
        if one.leg.end is not None and not last:
            holds.pop(one.leg.end.section_id, None)
        found: tuple[float, SectionHandover] | None = None
        known = self._known
        for need in self.needed(other):
            hold = holds.get(need.section_id)
            if hold is None or need.section_id in self._room:
                continue
            w_s = known.frees_s(hold, known.departs_s(one.leg)) - need.begin_s
            if found is None or w_s > found[0] + TOUCH_S:
                found = w_s, SectionHandover(hold, need)
        return found

    def needed(self, move: OrderedLeg) -> Iterator[Occupation]:
        """The sections that a leg needs, in order of travel; the portal first where its train signs on."""
        if move.second and self._signs_on(move.away) and move.leg.start is not None:
            yield move.leg.start
        yield from (one for one in move.leg.occupations if math.isfinite(one.begin_s))


def _id(place: Occupation | None) -> str:
    return "" if place is None else place.section_id


def _one(place: Occupation | None, section_id: str) -> bool:
    """Whether a place is that section."""
    return place is not None and place.section_id == section_id
