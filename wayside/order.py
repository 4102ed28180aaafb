"""Whose turn it is over open line that several trains want: the planned order, and when it is changed.

Planned is that the train goes first that is to leave first by the timetable. That order is kept while the train that
is first is less late than `late_s`. Beyond that it is left to who asks first (`planned`), or both orders are played
through in blocks and minutes for all trains of the line, and the one with less delay is taken (`least_delay`); or it
is what delays all least in the mean (`optimal`), as soon as any train that is to go there is so late.
Nobody waits by it for longer than `hold_s_max`, for a train that cannot come before it, or when `overtaken_max`
trains have gone before it; nor does it let a train on before one that was overtaken so often. In an order of all of
them each train has its place, whatever goes before it: there who has waited for so long waits for nobody, and goes
before others once so many have gone before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Final, NamedTuple

from wayside.certificate import CertificateProof, finishing_order
from wayside.config import OrderRule
from wayside.journeys import DayProgress, Days, PlannedMove, Stands, could_leave_s
from wayside.moves import bits_of
from wayside.order_question import LastOrder, OrderAnswer
from wayside.register import Register

AHEAD_S: Final = 2 * 3600.0  # assumed: how far ahead delays are compared
ORDER_STEPS: Final = 1000  # assumed: moves tried for either order
BOUNDED = True  # off: a train waits for its turn for as long as the order has it
GOES_FIRST = True  # off: who has waited as long as may be goes first, whether it could go or not
BY_TIME = True  # off: who was overtaken `overtaken_max` times goes first in an order of all, after any wait
GAIN_S: Final = 60.0  # assumed: a change of order is worth a minute at least, for it confuses people


@dataclass(frozen=True, slots=True)
class Precedence:
    """Whether a train goes before another that is planned first, and the sentence that says why; else it waits for that
    to come to `section_id`.
    """

    other: int
    goes: bool
    why: str
    section_id: str = ""


@dataclass(frozen=True, slots=True)
class _First:
    """A train that is planned first over a line: its move there, by its place in its day, and how late it is, s."""

    index: int
    place: int
    hop: PlannedMove
    late_s: float


def turn_of(
    register: Register, days: Days, stands: Stands, index: int, solved: LastOrder | None = None
) -> Precedence | None:
    """Whether the train goes now that asks for its next move; None where no other is first, by plan or as solved."""
    ahead = _planned_first(register, days, stands, index)
    order: _Solved | None = None
    if solved is not None and not solved.answer.lacking:
        order = _Solved(None if days.given else solved.answer, solved.left(stands.at))
    overtaken = _too_often(register, days, stands, index, order)
    if order is not None:
        known = {first.index for first in ahead}
        rivals = _rivals(register, days, stands, index)
        ahead += [r for r in rivals if r.index not in known and order.is_first(r, index)]
    changed: Precedence | None = None
    for first in [*ahead, *overtaken]:
        turn = _before(register, days, stands, index, first, order)
        if not turn.goes:
            return turn
        changed = changed or turn
    return changed


def would_starve(register: Register, days: Days, stands: Stands, index: int) -> bool:
    """Whether another waits for line that this train wants, and has as long as may be, or was overtaken as often."""
    for first in _rivals(register, days, stands, index):
        other = register.trip(days.unit_ids[first.index])
        if other.asked_s is None or first.place != stands.at[first.index]:
            continue
        waited_s = register.now_s - max(other.asked_s, first.hop.departs_s)
        if other.overtaken >= days.overtaken_max or waited_s >= days.hold_s_max:
            return True
    return False


@dataclass(frozen=True, slots=True)
class _Solved:
    """An order of all trains: what is left of it as stock and place in its day. `answer`: as solved; None: as given."""

    answer: OrderAnswer | None
    left: list[tuple[int, int]]

    def is_first(self, first: _First, index: int) -> bool:
        """Whether that move comes before the next one of a stock; what is not in the order comes last."""
        mine = next((k for k, (other, _) in enumerate(self.left) if other == index), len(self.left))
        return (first.index, first.place) in self.left[:mine]

    def cost(self) -> str:
        """What it costs, for the sentence."""
        return "so is the order given for the day" if self.answer is None else cost_of(self.answer)


def cost_of(answer: OrderAnswer) -> str:
    """What an order costs, in words."""
    if answer.otherwise_s is not None:
        other = _minutes(answer.otherwise_s)
        return f"{_minutes(answer.delay_s)} min late in all in the mean, the other way {other}"
    proof = "the best order" if answer.delay_s <= answer.bound_s else "the best order known"
    return f"{_minutes(answer.delay_s)} min late in all in {proof}"


def is_disturbed(register: Register, days: Days, stands: Stands, index: int) -> bool:
    """Whether any train is so late that the planned order is left, and others want line that this one wants."""
    known = (k for k, unit_id in enumerate(days.unit_ids) if not register.trip(unit_id).astray)
    late = any(_late_s(register, days, stands, k) >= days.late_s for k in known)
    return late and bool(_rivals(register, days, stands, index))


def _to_come(register: Register, days: Days, stands: Stands, index: int) -> int:
    """The next move of a stock of which it has nothing: where it has a part it is first already."""
    at, hops = stands.at[index], days.hops[index]
    part = register.trip(days.unit_ids[index]).part and at < len(hops)
    return at + bool(part and hops[at].move.needs & stands.holds[index])


def _rivals(register: Register, days: Days, stands: Stands, index: int) -> list[_First]:
    """Trains that are to go over line that this one wants, within the time that is looked ahead."""
    mine, until_s = days.hops[index][stands.at[index]], register.now_s + AHEAD_S
    found: list[_First] = []
    for other, hops in enumerate(days.hops):
        if other == index or register.trip(days.unit_ids[other]).astray:
            continue
        for place in range(_to_come(register, days, stands, other), len(hops)):
            if hops[place].departs_s >= until_s:
                break
            if hops[place].line & mine.line:
                found.append(_First(other, place, hops[place], _late_s(register, days, stands, other)))
                break
    return found


def _planned_first(register: Register, days: Days, stands: Stands, index: int) -> list[_First]:
    """Trains that are still to go over line that this one wants, and are planned to do so before it."""
    mine = days.hops[index][stands.at[index]]
    found: list[_First] = []
    for other, hops in enumerate(days.hops):
        if other == index or register.trip(days.unit_ids[other]).astray:
            continue
        for place in range(_to_come(register, days, stands, other), len(hops)):
            hop = hops[place]
            if hop.departs_s >= mine.departs_s:
                break
            if hop.line & mine.line:
                found.append(_First(other, place, hop, _late_s(register, days, stands, other)))
                break
    return sorted(found, key=lambda first: first.hop.departs_s)


def _too_often(
    register: Register, days: Days, stands: Stands, index: int, order: _Solved | None
) -> list[_First]:
    """Trains that wait for line that this one wants, and were overtaken as often, or have waited as long as may be."""
    mine = days.hops[index][stands.at[index]]
    found: list[_First] = []
    for other, hops in enumerate(days.hops):
        at, trip = _to_come(register, days, stands, other), register.trip(days.unit_ids[other])
        if other == index or at == len(hops) or not _bound_reached(register, days, trip, hops[at], order):
            continue
        first = hops[at].line & mine.line and hops[at].departs_s >= mine.departs_s
        if first and _could_go(days, stands, other):
            found.append(_First(other, at, hops[at], _late_s(register, days, stands, other)))
    return found


def _bound_reached(
    register: Register, days: Days, trip: DayProgress, hop: PlannedMove, order: _Solved | None
) -> bool:
    """Whether a train that waits has the next turn: nobody else goes before it by the order of trains."""
    if trip.asked_s is None:
        return False
    often = trip.overtaken >= days.overtaken_max
    if BY_TIME and order is not None and order.answer is not None:
        return often and _held_s(register, trip, hop) >= days.hold_s_max
    return often


def _could_go(days: Days, stands: Stands, index: int) -> bool:
    """Whether nothing but the order of trains keeps a stock from its next move: nobody stands there, and all can finish
    afterwards.
    """
    if not GOES_FIRST:
        return True
    needs = stands.next_move(days, index).needs
    if any(held & needs for other, held in enumerate(stands.holds) if other != index):
        return False
    after = stands.after(days, index).trains(days)
    return not days.certificate or finishing_order(after, ORDER_STEPS).proof is CertificateProof.ORDER


def _held_s(register: Register, trip: DayProgress, hop: PlannedMove) -> float:
    """For how long the order of trains holds a train back."""
    return 0.0 if trip.held_s is None else register.now_s - max(trip.held_s, hop.departs_s)


def _late_s(register: Register, days: Days, stands: Stands, index: int) -> float:
    """How late a train is: it was when it left last, or its next departure is overdue."""
    hops, at = days.hops[index], stands.at[index]
    overdue_s = register.now_s - hops[at].departs_s if at < len(hops) else 0.0
    return max(0.0, register.trip(days.unit_ids[index]).late_s, overdue_s)


def _before(
    register: Register, days: Days, stands: Stands, index: int, first: _First, order: _Solved | None
) -> Precedence:
    """Whether the train goes before one that comes first by plan or as solved, or has waited longest."""
    other = register.trip(days.unit_ids[first.index])
    mine = days.hops[index][stands.at[index]]
    train, ahead, to = mine.train, first.hop.train, first.hop.section_id
    if why := _waited_enough(register, days, stands, index, ahead, order):
        return Precedence(first.index, True, f"order changed: {train} {why}")
    coming = _coming(days, stands, index, first)
    late = f"planned first; it is {_minutes(first.late_s)} min late"
    waits, goes = f"{train} waits for {ahead}", f"order changed: {train} goes before {ahead}"
    if coming is None:
        return Precedence(first.index, True, f"order changed: {ahead} cannot come before {train} has gone")
    bound = BOUNDED and _bound_reached(register, days, other, first.hop, order)
    if bound and _could_go(days, stands, first.index):
        often = f"before which {_gone(other.overtaken)}"
        why = f"{waits}, {often if other.overtaken else 'which has waited as long as it may'}"
    elif order is not None and order.is_first(first, index):
        why = f"{waits}: {order.cost()}"
    elif order is not None:
        return Precedence(first.index, True, f"{goes}, {late}: {order.cost()}")
    elif first.late_s < days.late_s:
        why = f"{waits}, {late}, threshold {_minutes(days.late_s)}"
    elif days.order is OrderRule.PLANNED:
        return Precedence(first.index, True, f"{goes}, {late}")
    else:
        return _least_delay(register, days, stands, index, first, coming, late)
    return Precedence(first.index, False, why, to)


def _waited_enough(
    register: Register, days: Days, stands: Stands, index: int, ahead: str, order: _Solved | None
) -> str:
    """Why the train waits no longer for its turn, whoever is planned first; empty: it may have to."""
    trip = register.trip(days.unit_ids[index])
    hop = days.hops[index][stands.at[index]]
    held_s = _held_s(register, trip, hop)
    if BOUNDED and held_s >= days.hold_s_max:
        return f"has waited {_minutes(held_s)} min for {ahead}, the most it may"
    if BOUNDED and _bound_reached(register, days, trip.asks(register.now_s), hop, order):
        return f"goes before {ahead}: {_gone(trip.overtaken)} before it"
    return ""


def _coming(days: Days, stands: Stands, index: int, first: _First) -> tuple[int, ...] | None:
    """Moves after which the other has gone, who is in its way moving on; None where that is the train that stays."""
    at, holds = list(stands.at), list(stands.holds)
    moves: list[int] = []
    wanted = [first.index]
    while at[first.index] <= first.place:
        mover = wanted[-1]
        if at[mover] == len(days.moves[mover]):
            return None
        begins = at[mover] == stands.at[mover]
        move = stands.next_move(days, mover) if begins else days.moves[mover][at[mover]]
        in_the_way = next((i for i, held in enumerate(holds) if i != mover and held & move.needs), None)
        if in_the_way is None:
            holds[mover] = move.keeps
            at[mover] += 1
            moves.append(mover)
            if len(wanted) > 1:
                wanted.pop()
        elif in_the_way == index or in_the_way in wanted:
            return None
        else:
            wanted.append(in_the_way)
    return tuple(moves)


def _least_delay(
    register: Register,
    days: Days,
    stands: Stands,
    index: int,
    first: _First,
    coming: tuple[int, ...],
    late: str,
) -> Precedence:
    """The order with less delay for all trains, each played through as its trains would then finish."""
    train, ahead = days.hops[index][stands.at[index]].train, first.hop.train
    going = delay_s(register, days, stands, (index,))
    holding = delay_s(register, days, stands, coming)
    goes = going is not None and (holding is None or going <= holding - GAIN_S)
    cost = ""
    if going is not None and holding is not None:
        chosen, other = (going, holding) if goes else (holding, going)
        cost = f": {_minutes(chosen)} min late in all, the other way {_minutes(other)}"
    if goes:
        return Precedence(first.index, True, f"order changed: {train} goes before {ahead}, {late}{cost}")
    return Precedence(first.index, False, f"{train} waits for {ahead}, {late}{cost}", first.hop.section_id)


def delay_s(register: Register, days: Days, stands: Stands, begins: Sequence[int]) -> float | None:
    """All delay at the ends of trains due within `AHEAD_S`, s, if these moves come first; None: not all finish so."""
    moves = played_through(register, days, stands, begins)
    if moves is None:
        return None
    until_s = register.now_s + AHEAD_S
    delay_s = 0.0
    for move in moves:
        hops = days.hops[move.stock]
        hop, following = hops[move.place], move.place + 1
        if hop.arrives_s < until_s and (following == len(hops) or hops[following].train != hop.train):
            delay_s += max(0.0, move.comes_s - hop.arrives_s)
    return delay_s


class PlayedMove(NamedTuple):
    """A move of a stock, by its place in its day, and when it then leaves and comes, s since midnight."""

    stock: int
    place: int
    leaves_s: float
    comes_s: float


def played_through(
    register: Register,
    days: Days,
    stands: Stands,
    begins: Sequence[int] = (),
) -> list[PlayedMove] | None:
    """All moves still to be made, in blocks and minutes, if these come first; None: not all finish so."""
    after = stands
    for mover in begins:
        after = after.after(days, mover)
    found = finishing_order(after.trains(days), ORDER_STEPS)
    if found.proof is not CertificateProof.ORDER:
        return None
    at = list(stands.at)
    ready_s = [_ready_s(register, days, stands, index) for index in range(len(at))]
    holds = list(stands.holds)
    free_s: dict[int, float] = {}
    moves: list[PlayedMove] = []
    for mover in (*begins, *found.order):
        hop = days.hops[mover][at[mover]]
        leaves_s = max(ready_s[mover], hop.departs_s, *(free_s.get(b, -inf) for b in bits_of(hop.move.needs)))
        comes_s = leaves_s + hop.arrives_s - hop.departs_s
        free_s.update(dict.fromkeys(bits_of(hop.move.needs | holds[mover]), comes_s))
        holds[mover] = hop.move.keeps
        ready_s[mover] = comes_s + hop.stays_s
        moves.append(PlayedMove(mover, at[mover], leaves_s, comes_s))
        at[mover] += 1
    return moves


def _ready_s(register: Register, days: Days, stands: Stands, index: int) -> float:
    """When a stock can make its next move: it is on its way there, as late as it left, or waits."""
    return max(register.now_s, could_leave_s(days, stands, index, register.trip(days.unit_ids[index])))


def _gone(trains: int) -> str:
    return "1 train has gone" if trains == 1 else f"{trains} trains have gone"


def _minutes(time_s: float) -> int:
    return int(time_s // 60.0)
