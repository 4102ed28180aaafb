"""Trains ended where they stand, or left out, so that their set goes on as a later train of its own from there
(途中折返し, 運休), where `[dispatch]` allows it.

Invariant: an order is given only to a train that stands in its track and holds nothing else, if the day without what is
cut is proven to be one that all can finish, and costs less by the gain asked for, each train that is cut counting as
late as the scenario states. It counts as done when the unit reports it. Until then whatever is granted to others must
leave all able to finish whether it is done or not (`wayside.unanswered`).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Final

import msgspec
from msgspec.structs import replace

from radio.messages import NextTrainReport
from wayside.actions import Show
from wayside.config import OrderRule
from wayside.dispatch import DispatchRequest
from wayside.heard import Heard
from wayside.journeys import DayProgress, Days, Stands
from wayside.order import delay_s
from wayside.places import stands_of
from wayside.register import Register
from wayside.said import GoesOnAs, TrainCut
from wayside.solved_order import ORDERS_MAX, WORK_MAX, question_of

WEIGHED_EVERY_S: Final = 60.0  # assumed: who asks for a route asks again every few seconds
SHARE: Final = 0.5  # assumed: of the solver's work, for each of two more questions
TRAINS_MAX: Final = (
    2  # assumed: later trains of a set looked at; each further one leaves out a round trip more
)
WEIGHED = True  # off: a train is cut wherever that is allowed and it is late


class CutOrdered(msgspec.Struct, frozen=True):
    """The register with a train ordered to end where it stands, as which its set is to go on, and what the journal is
    told.
    """

    register: Register
    next_train: str
    shows: tuple[Show, ...]


class _Weighed(msgspec.Struct, frozen=True):
    """A cut, what all trains lose with it and without, and which trains it costs."""

    next_train: str
    trains: tuple[str, ...]
    with_it_s: float
    without_s: float


def cut_ordered(register: Register, asked: DispatchRequest) -> CutOrdered | None:
    """What a train is ordered that asks for its route late; None: to go on, or to wait."""
    days = register.days
    if days is None or not days.cuts.any or asked.unit_id not in days.index:
        return None
    index, trip = days.index[asked.unit_id], register.trip(asked.unit_id)
    stands = stands_of(register, days)
    if not _stands_there(register, days, stands, asked) or trip.astray or trip.whole or trip.part:
        return None
    if trip.next_train:  # it has not heard of it, or its answer is on the way
        return _again(register, asked.unit_id, trip)
    hop = days.hops[index][stands.at[index]]
    late = register.now_s >= hop.departs_s + days.late_s
    if not late or register.now_s < trip.cut_s + WEIGHED_EVERY_S:
        return None
    register = register.with_trip(asked.unit_id, replace(trip, cut_s=register.now_s))
    found = _best(register, days, stands, index)
    if found is None:
        return CutOrdered(register, "", ())
    trip = replace(register.trip(asked.unit_id), next_train=found.next_train, orders=trip.orders + 1)
    note = TrainCut(
        unit_id=asked.unit_id,
        trains=found.trains,
        next_train=found.next_train,
        why=_why(hop.begins_at, found),
    )
    return CutOrdered(register.with_trip(asked.unit_id, trip), found.next_train, (Show(note),))


def _stands_there(register: Register, days: Days, stands: Stands, asked: DispatchRequest) -> bool:
    """Whether a train asks at a stop for its next route, and holds nothing but its track."""
    index = days.index[asked.unit_id]
    place, hops = stands.at[index], days.hops[index]
    if place == len(hops) or hops[place].route_id != asked.route_id or not hops[place].begins_at:
        return False
    return stands.holds[index] == hops[place].start and len(register.held_by(asked.unit_id)) == 1


def _again(register: Register, unit_id: str, trip: DayProgress) -> CutOrdered:
    """The order given once more, or no more of it."""
    if trip.orders >= ORDERS_MAX:
        trip = replace(trip, next_train="", whole=True)
        return CutOrdered(register.with_trip(unit_id, trip), "", ())
    trip = replace(trip, orders=trip.orders + 1)
    return CutOrdered(register.with_trip(unit_id, trip), trip.next_train, ())


def _why(station: str, found: _Weighed) -> str:
    ended, rest = found.trains[0], found.trains[1:]
    cut = f"{ended} ends at {station} and its set goes on as {found.next_train}"
    others = f", without {' and '.join(rest)} as far as there" if rest else ""
    with_min, without_min = int(found.with_it_s // 60.0), int(found.without_s // 60.0)
    return f"{cut}{others}: {with_min} min late in all, as stated for what is cut, instead of {without_min}"


# what it is worth ---------------------------------------------------------------------------------------------


def _best(register: Register, days: Days, stands: Stands, index: int) -> _Weighed | None:
    """The cut that costs least, if it saves enough."""
    unit_id, place = days.unit_ids[index], stands.at[index]
    without_s = delay_s(register, days, stands, ())
    if without_s is None and WEIGHED:
        return None  # nobody knows how all can finish: no time to cut trains by what that costs
    found: list[_Weighed] = []
    for number in days.next_trains(index, place)[:TRAINS_MAX]:
        trains = days.trains_cut(index, place, number)
        after = register.with_cut(unit_id, place, number) if trains else None
        if after is None or after.days is None:
            continue
        lost_s = delay_s(after, after.days, stands, ())
        if lost_s is None:
            continue
        lost_s += _stated_s(register, days, index, place, trains)
        found.append(_Weighed(number, trains, lost_s, lost_s if without_s is None else without_s))
    best = min(found, key=lambda one: one.with_it_s, default=None)
    if best is None or not WEIGHED:
        return best
    if not _saves(best.with_it_s, best.without_s, days.cuts.gain_s):
        return None
    return _solved(register, days, stands, index, best) if days.order is OrderRule.OPTIMAL else best


def _saves(with_it_s: float, without_s: float, gain_s: float) -> bool:
    """Whether a cut saves what it must, and more than nothing."""
    return with_it_s < without_s and with_it_s <= without_s - gain_s


def _stated_s(register: Register, days: Days, index: int, place: int, trains: Sequence[str]) -> float:
    """What trains cost that are cut, s: each as stated, and the one that is ended no less than it is late now."""
    stated_s, late_s = days.cuts.late_s, register.now_s - days.hops[index][place].departs_s
    return max(stated_s, late_s) + stated_s * (len(trains) - 1)


def _solved(register: Register, days: Days, stands: Stands, index: int, found: _Weighed) -> _Weighed | None:
    """The same by the order of all trains with least delay, with it and without; None: it does not save enough."""
    unit_id = days.unit_ids[index]
    register = register.asking(unit_id)
    after = register.with_cut(unit_id, stands.at[index], found.next_train)
    if after is None or after.days is None:
        return None
    ways = ((register, days), (after, after.days))
    questions = (replace(question_of(r, d, stands), work_max=SHARE * WORK_MAX) for r, d in ways)
    without, with_it = map(register.plan.solver, questions)
    if without.lacking or with_it.lacking:
        return found
    with_it_s = with_it.delay_s + ceil(_stated_s(register, days, index, stands.at[index], found.trains))
    if not _saves(with_it_s, without.bound_s, days.cuts.gain_s):  # there may be a better order without it
        return None
    return replace(found, with_it_s=float(with_it_s), without_s=float(without.delay_s))


# what the unit does -------------------------------------------------------------------------------------------


def followed_cut(register: Register, unit_id: str, route_id: str) -> Register:
    """The register with a unit that asks for the route of the train that it was ordered to go on as: its report was
    lost with its boot.
    """
    trip, days = register.trip(unit_id), register.days
    if not trip.next_train or days is None or unit_id not in days.index:
        return register
    index = days.index[unit_id]
    place = stands_of(register, days).at[index]
    if place < len(days.hops[index]) and days.hops[index][place].route_id == route_id:
        return register
    after = _done(register, unit_id, trip.next_train)
    return register if after is None else after


def reported(register: Register, heard: Heard[NextTrainReport]) -> tuple[Register, tuple[Show, ...]]:
    """The register with a unit on its next train, as it has said under its newest grant; said again, nothing is new."""
    unit_id, train, days = heard.unit_id, heard.message.train, register.days
    unit = register.unit(unit_id)
    current = (heard.epoch, heard.message.token) == (unit.epoch, unit.token)
    if days is None or unit_id not in days.index or not current:
        return register, ()
    place = stands_of(register, days).at[days.index[unit_id]]
    hops = days.hops[days.index[unit_id]]
    if place < len(hops) and hops[place].train == train:
        return register, ()
    after = _done(register, unit_id, train)
    if after is None:  # of a train that is none of its own nobody knows where it goes
        after = register.with_trip(unit_id, replace(register.trip(unit_id), astray=True, next_train=""))
    return after, (Show(GoesOnAs(unit_id=unit_id, train=train)),)


def _done(register: Register, unit_id: str, train: str) -> Register | None:
    days = register.days
    if days is None:
        return None
    place = stands_of(register, days).at[days.index[unit_id]]
    after = register.with_cut(unit_id, place, train)
    return None if after is None else after.with_trip(unit_id, DayProgress(place))
