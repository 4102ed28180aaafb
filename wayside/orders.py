"""What the dispatcher orders besides letting trains wait (`[dispatch] may`): a train that asks for its route to another
track of the next station; from a train that does not leave, its route back.

Invariant: an order is given only if what it is for can be granted at once, by register, certificate and order of
trains, with the order done. Nothing counts as done before the unit does it: it asks for the other route, and the proof
is made anew, or it reports that it has given its own back, and can have it again; so a lost order changes nothing. A
move has `ORDERS_MAX` orders at most.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import Final

import msgspec
from msgspec.structs import replace

from radio.messages import OrderRefused, RefusalReason, RouteTakenBack, TrackOrdered, TrainOrdered
from wayside.actions import Action, Send, Show
from wayside.certificate import STEPS_MAX, CertificateProof, finishing_order
from wayside.config import DispatcherMeans
from wayside.cutting import cut_ordered
from wayside.dispatch import DispatchRequest, order_now, weigh_request
from wayside.heard import Heard
from wayside.journeys import DayProgress, Days, LastCertificate, Stands
from wayside.order import BOUNDED, cost_of, would_starve
from wayside.order_question import ALL
from wayside.places import stands_of
from wayside.reentry import Step
from wayside.register import Against, Register
from wayside.said import NotDone, RouteAskedBack, TrackChanged
from wayside.solved_order import ORDERS_MAX, STANDS_AGAIN

TAKEN_BACK_AFTER_S: Final = 60.0  # assumed: who has not left by then may be unable to
HOLD_S: Final = 30.0  # assumed: time enough for the other to ask again and be let on
BY_PROOF = True  # off: a track is changed without asking whether all can then finish


class Decision(msgspec.Struct, frozen=True):
    """A request decided: why not now, if so, and what is ordered instead; or what to do besides."""

    register: Register
    against: Against | None
    order: TrackOrdered | TrainOrdered | None = None
    actions: tuple[Action, ...] = ()


def followed(register: Register, unit_id: str, route_id: str) -> tuple[Register, str]:
    """The register with the track to which a unit now wants to go as that of its day; or the route that it is to ask
    for instead, where others were let on meanwhile and not all could finish any more.
    """
    days = register.days
    if days is None or DispatcherMeans.CHANGE_TRACK not in days.may or unit_id not in days.index:
        return register, ""
    index = days.index[unit_id]
    place = stands_of(register, days).at[index]
    route = days.ways.routes.get(route_id)
    if route is None or place == len(days.hops[index]) or days.hops[index][place].route_id == route_id:
        return register, ""
    here = days.ways.routes.get(days.hops[index][place].route_id)
    if here is None or here.from_section != route.from_section:
        return register, ""
    changed = register.with_track(unit_id, place, route.section_ids[-1])
    if changed is None:
        return register, ""
    if (after := _proven(changed)) is not None:
        return after, ""
    before = None if not BY_PROOF or register.trip(unit_id).own_way else _proven(register)
    return (changed, "") if before is None else (before, here.route_id)


def _proven(register: Register) -> Register | None:
    """The register with an order in which all can finish; None: none is known."""
    if register.days is None:
        return None
    stands = stands_of(register, register.days)
    kept = register.kept
    if kept is not None and kept.finishes_from(stands):
        return register
    found = finishing_order(stands.trains(register.days), STEPS_MAX)
    if found.proof is not CertificateProof.ORDER:
        return None
    return replace(register, kept=LastCertificate(stands.at, stands.holds, found.order), sought=None)


def decide(register: Register, asked: DispatchRequest, against: Against | None) -> Decision:
    """Whether a request is granted now, by the register (`against`), certificate and order; else what is ordered."""
    days = register.days
    if days is None or not (days.may or days.cuts.any) or asked.unit_id not in days.index:
        register, against, shows = weigh_request(register, asked, against)
        return Decision(register, against, actions=shows)
    may_go = against is None or against[0] is RefusalReason.HELD
    if may_go and (cut := cut_ordered(register, asked)) is not None:
        register = cut.register
        if cut.next_train:
            order = TrainOrdered(asked.route_id, cut.next_train)
            return Decision(register, (RefusalReason.NOT_ITS_TURN, None, None), order, cut.shows)
    ordering = _Ordering(register, days, asked)
    if against is None and (decision := ordering.by_order_of_all()) is not None:
        return decision
    register, after, shows = weigh_request(ordering.register, asked, against)
    if after is None:
        return Decision(register, None, actions=shows)
    ordering = _Ordering(register, days, asked)
    found = ordering.by_what_is_free(after) or ordering.takes_back(after)
    if found is None:
        return Decision(register, after, actions=shows)
    return replace(found, actions=(*shows, *found.actions))


def _without_route(register: Register, unit_id: str) -> Register | None:
    """The register as if a unit had given back the route granted last; None: it has not the whole of it any more."""
    days = register.days
    if days is None:
        return None
    index = days.index[unit_id]
    place = stands_of(register, days).at[index] - 1
    hop = days.hops[index][place] if place >= 0 else None
    route = None if hop is None else days.ways.routes.get(hop.route_id)
    if route is None or set(register.held_by(unit_id)) != {route.from_section, *route.section_ids}:
        return None
    trip = replace(register.trip(unit_id), done=place)
    back = register.with_held(unit_id, (route.from_section,)).with_trip(unit_id, trip)
    return replace(back, kept=None, sought=None)


def refused(register: Register, heard: Heard[OrderRefused]) -> Step:
    """What was ordered is not done: the unit is not asked for that again on this move."""
    unit_id, message = heard.unit_id, heard.message
    why = message.reason.name.lower().replace("_", " ")
    note = Show(NotDone(unit_id=unit_id, route_id=message.route_id, why=why))
    trip, days = register.trip(unit_id), register.days
    if days is None or unit_id not in days.index or trip.astray:
        return register, (note,)
    index = days.index[unit_id]
    place = stands_of(register, days).at[index]
    asks = place < len(days.hops[index]) and days.hops[index][place].route_id == message.route_id
    if asks and trip.next_train:
        trip = replace(trip, next_train="", whole=True)
    else:
        trip = replace(trip, own_way=True) if asks else replace(trip, keeps=True, back_s=-inf)
    return register.with_trip(unit_id, trip), (note,)


class _Ordering:
    """One request, and what could be ordered for it."""

    def __init__(self, register: Register, days: Days, asked: DispatchRequest) -> None:
        self.register = register
        self._days = days
        self._asked = asked
        self._index = days.index[asked.unit_id]
        self._trip = register.trip(asked.unit_id)
        self._stands: Stands = stands_of(register, days)
        self._place = self._stands.at[self._index]

    # another track ----------------------------------------------------------------------------------------------

    def _may_change(self) -> bool:
        hops = self._days.hops[self._index]
        return (
            DispatcherMeans.CHANGE_TRACK in self._days.may
            and not self._trip.astray
            and not self._trip.own_way
            and self._trip.orders < ORDERS_MAX
            and self._place < len(hops)
            and hops[self._place].route_id == self._asked.route_id
            and bool(hops[self._place].others)
        )

    def by_order_of_all(self) -> Decision | None:
        """To the track that the order of least delay has for it, if that can be had now."""
        if not self._may_change():
            return None
        self.register, order, shows = order_now(self.register, self._days, self._stands, self._index)
        if order is None or order.answer.lacking:
            return None
        end = order.end_of(self._index, self._place)
        hop = self._days.hops[self._index][self._place]
        track = next((s for s in hop.others if end is not None and self._days.bits[s] == 1 << end), None)
        if track is None:
            return None
        found = self._changed(track, cost_of(order.answer))
        return None if found is None else replace(found, actions=(*shows, *found.actions))

    def by_what_is_free(self, against: Against) -> Decision | None:
        """To another track, where its own is not to be had and no order of all trains says how to go."""
        reason, section_id, holder = against
        if reason not in (RefusalReason.HELD, RefusalReason.NO_WAY_ON) or not self._may_change():
            return None
        solved = self.register.solved.get(ALL)
        if (
            solved is not None
            and not solved.answer.lacking
            and solved.end_of(self._index, self._place) is not None
        ):
            return None
        why = f"{section_id} is held by {holder}"
        if reason is RefusalReason.NO_WAY_ON:
            why = f"by its own track it would wait for {holder} to come to {section_id}"
        if BOUNDED and would_starve(self.register, self._days, self._stands, self._index):
            return None
        hop = self._days.hops[self._index][self._place]
        return next((d for track in hop.others if (d := self._changed(track, why)) is not None), None)

    def _changed(self, track: str, why: str) -> Decision | None:
        """The order to go to that track; None where it could not go there now."""
        unit_id = self._asked.unit_id
        changed = self.register.with_track(unit_id, self._place, track)
        if changed is None or changed.days is None:
            return None
        hop, to = self._days.hops[self._index][self._place], changed.days.hops[self._index][self._place]
        route = changed.days.ways.routes[to.route_id]
        if changed.other_holder(unit_id, route.section_ids) is not None:
            return None
        if not self._can_go(changed, DispatchRequest(unit_id, to.route_id)):
            return None
        trip = replace(self._trip, orders=self._trip.orders + 1)
        note = TrackChanged(
            unit_id=unit_id,
            section_id=track,
            why=f"{hop.train} goes to {track} instead of {hop.section_id}: {why}",
        )
        shows = () if note.why == self._trip.said else (Show(note),)
        register = self.register.with_trip(unit_id, replace(trip, said=note.why))
        against = (RefusalReason.HELD, hop.section_id, None)
        return Decision(register, against, TrackOrdered(self._asked.route_id, to.route_id), shows)

    def _can_go(self, register: Register, asked: DispatchRequest) -> bool:
        """Whether that would be granted then, and it is proven for as much of the day as now that all can finish."""
        if not BY_PROOF:
            return True
        kept, sought = self.register.kept, self.register.sought
        least_s = inf if sought is None else -inf if kept is None else kept.until_s
        after, against, _ = weigh_request(register, asked, None)
        proven = after.kept is not None and after.kept.until_s >= least_s
        return against is None and proven

    # a route back -----------------------------------------------------------------------------------------------

    def takes_back(self, against: Against) -> Decision | None:
        """From the train that has the line and does not leave, if this one can then go at once."""
        reason, _, holder = against
        days = self._days
        if DispatcherMeans.TAKE_BACK not in days.may or reason is not RefusalReason.HELD:
            return None
        if holder is None or holder not in days.index:
            return None
        index = days.index[holder]
        trip, place = self.register.trip(holder), self._stands.at[index] - 1
        if place < 0 or not self._stays(trip, index, place):
            return None
        hop, request, now_s = days.hops[index][place], self._asked, self.register.now_s
        stood_s = now_s - max(trip.granted_s, hop.departs_s)
        trip = replace(trip, orders=trip.orders + 1, back_s=now_s + max(HOLD_S, STANDS_AGAIN * stood_s))
        back = _without_route(self.register.with_trip(holder, trip), holder)
        wanted = days.ways.routes[request.route_id].section_ids if request.route_id else (request.portal,)
        if back is None or back.other_holder(request.unit_id, wanted) is not None:
            return None
        if not self._can_go(back, request):
            return None
        train = next(self._trains_of(self._index, self._place), request.unit_id)
        stood_min = int(stood_s // 60.0)
        why = f"{hop.train} is to give its route back to {train} if it has not left, {stood_min} min after it could"
        note = RouteAskedBack(unit_id=holder, other_id=request.unit_id, route_id=hop.route_id, why=why)
        shows = (Show(note),) if trip.orders == 1 else ()
        token = self.register.unit(holder).token
        order = Send(holder, RouteTakenBack(hop.route_id, token, HOLD_S))
        return Decision(self.register.with_trip(holder, trip), against, actions=(*shows, order))

    def _stays(self, trip: DayProgress, index: int, place: int) -> bool:
        """Whether a stock was let on some time ago, as far as is known has not left, and may be overtaken once more."""
        hop, days = self._days.hops[index][place], self._days
        since_s = max(trip.granted_s, hop.departs_s)
        return (
            self.register.unit(days.unit_ids[index]).route_id == hop.route_id
            and self.register.now_s >= since_s + TAKEN_BACK_AFTER_S
            and not trip.keeps
            and not trip.astray
            and trip.orders < ORDERS_MAX
            and trip.overtaken < days.overtaken_max
        )

    def _trains_of(self, index: int, place: int) -> Iterator[str]:
        yield from (hop.train for hop in self._days.hops[index][place:])
