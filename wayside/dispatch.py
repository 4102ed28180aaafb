"""Whether a route that is free is granted now: by the certificate that all trains can still finish, and by the order of
trains. Off unless the manager's fixed data say otherwise; then who asks first has it.

Invariant: what is granted is granted only if the register has it free; nothing here adds to that. With the certificate,
from a state in which there is an order by which all can finish, no grant leads to one without: where none is known, and
it is not proven that there is none, nothing is granted. The train that is first in the order known is always let on, so
somebody can always move; a search that ran out has more steps each time, until people are told. Nobody is held by the
order of trains for longer than `hold_s_max`, nor when more than `overtaken_max` trains were let on before it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf
from typing import Final

from msgspec.structs import replace

from network.clock import clock
from radio.messages import RefusalReason, RouteRequest
from wayside.actions import Show
from wayside.certificate import STEPS_MAX, CertificateAnswer, CertificateProof, finishing_order, follows
from wayside.config import OrderRule
from wayside.journeys import DayProgress, Days, LastCertificate, LastSearch, Stands, next_hop
from wayside.moves import Train
from wayside.order import is_disturbed, turn_of
from wayside.order_question import ALL, LastOrder, OrderAnswer
from wayside.parts import free_part
from wayside.places import stands_of
from wayside.register import Against, Register
from wayside.said import Certified, HeldBack, NoOrderKnown, OrderChanged
from wayside.solved_order import with_order
from wayside.unanswered import in_doubt

NEAR_STEPS: Final = 200  # assumed: tried before looking further ahead than the present trains
SEARCHES_EVERY_S: Final = (
    60.0  # assumed: a day without an order is looked at again, what persons do may change it
)
SHORTER_STEPS: Final = 500  # assumed: moves tried for each part of a day that has no order
MORE_STEPS: Final = 2  # a search that ran out has so many times the steps when it is asked again
LAST_STEPS: Final = 16 * STEPS_MAX  # assumed: about a second; who has not found it by then tells people
LOOKED_BACK: Final = 40  # assumed: moves of the order looked at for the one that lets a train on


@dataclass(frozen=True, slots=True)
class DispatchRequest:
    """What a unit asks for: a route, or else a portal by which to come onto the line."""

    unit_id: str
    route_id: str = ""
    portal: str = ""


def weigh_request(
    register: Register, asked: DispatchRequest, against: Against | None
) -> tuple[Register, Against | None, tuple[Show, ...]]:
    """The register with what is known of the days; why not now, if so, and what the journal is told.

    `against` is what the register has against the request: then the unit only counts as waiting.
    """
    days = register.days
    if days is None or asked.unit_id not in days.index:
        return register, against, ()
    index = days.index[asked.unit_id]
    trip = register.trip(asked.unit_id)
    if trip.astray:  # a day is known again from the first move that is its own
        trip = replace(trip, astray=False)
        register = register.with_trip(asked.unit_id, trip)
    stands = stands_of(register, days)
    place = next_hop(days, index, stands.at[index], asked.route_id, asked.portal)
    if place is None:
        astray = replace(trip, astray=True, done=max(trip.done, 0))
        return register.with_trip(asked.unit_id, astray), against, ()
    if against is not None:
        return register.with_trip(asked.unit_id, trip.asks(register.now_s)), against, ()
    if place != stands.at[index]:
        stands = replace(stands, at=(*stands.at[:index], place, *stands.at[index + 1 :]))
    return _Weighing(register, days, stands, index).done()


def part_to_grant(
    register: Register, unit_id: str, message: RouteRequest, against: Against | None
) -> tuple[str, ...]:
    """The part of a way that is free where another holds the rest; empty: nothing but the whole may be granted."""
    parts = register.days is not None and register.days.parts
    if not parts or against is None or against[0] is not RefusalReason.HELD:
        return ()
    return free_part(register, unit_id, register.plan.routes[message.route_id], message.section_ids)


def weigh_part(
    register: Register, asked: DispatchRequest, part: tuple[str, ...]
) -> tuple[Register, tuple[str, ...], tuple[Show, ...]]:
    """The register with a part of a route counted as the unit's; no part where it is not proven that all can then
    finish, or another is to go first.

    Its move is still to be made, from there: a train that waits on open line stands in others' way.
    """
    if not set(part).difference(register.held_by(asked.unit_id)):
        return register, part, ()  # what it has already, as its answer may have been lost
    days = register.days
    if days is None or not days.parts or asked.unit_id not in days.index:
        return register, (), ()
    index, trip = days.index[asked.unit_id], register.trip(asked.unit_id)
    stands = stands_of(register, days)
    place = next_hop(days, index, stands.at[index], asked.route_id, "")
    if trip.astray or place is None or place != stands.at[index]:
        return register, (), ()
    has = 0
    for section_id in {*register.held_by(asked.unit_id), *part}:
        has |= days.bits[section_id]
    after = Stands(stands.at, (*stands.holds[:index], has, *stands.holds[index + 1 :]))
    found = finishing_order(after.trains(days), STEPS_MAX)
    if found.proof is not CertificateProof.ORDER or in_doubt(register, days, after, index) is not None:
        return register, (), ()
    register, waits, shown = _Weighing(register, days, stands, index).by_order()
    if waits is not None:
        return register, (), shown
    trip = register.trip(asked.unit_id)
    asked_s = register.now_s if trip.asked_s is None else trip.asked_s
    register = register.with_trip(asked.unit_id, replace(trip, part=True, done=place, asked_s=asked_s))
    kept = LastCertificate(after.at, after.holds, found.order)
    return replace(register, kept=kept, sought=None), part, shown


def order_now(
    register: Register, days: Days, stands: Stands, index: int
) -> tuple[Register, LastOrder | None, tuple[Show, ...]]:
    """The order of all trains that is given for the day, or as it is best now; None: there is none to go by."""
    if days.given:
        return register, LastOrder(0.0, (0,) * len(days.unit_ids), OrderAnswer(days.given)), ()
    if days.order is not OrderRule.OPTIMAL or not is_disturbed(register, days, stands, index):
        return register, None, ()
    asking = register.asking(days.unit_ids[index])
    register, shows = with_order(asking, days, stands, index)
    return register, register.solved.get(index, register.solved.get(ALL)), shows


class _Weighing:
    """One request that the register has nothing against."""

    def __init__(self, register: Register, days: Days, stands: Stands, index: int) -> None:
        self._register = register
        self._days = days
        self._stands = stands
        self._index = index
        self._unit_id = days.unit_ids[index]
        self._trip = register.trip(self._unit_id)
        self._trains = stands.trains(days)
        self._until_s = inf
        self._shows: list[Show] = []

    def done(self) -> tuple[Register, Against | None, tuple[Show, ...]]:
        """The answer."""
        against, after = self._certified() if self._days.certificate else (None, None)
        if against is None:
            against = self._in_doubt() or self._by_order()
        if against is None:
            self._granted(after)
        return self._register, against, tuple(self._shows)

    def by_order(self) -> tuple[Register, Against | None, tuple[Show, ...]]:
        """The answer by the order of trains alone, the register as it is but for what waits."""
        against = self._by_order()
        return self._register, against, tuple(self._shows)

    # the certificate ------------------------------------------------------------------------------------------

    def _certified(self) -> tuple[Against | None, CertificateAnswer | None]:
        """Why not now, if so; and an order for afterwards, None where it is proven that there is none to be kept."""
        before = self._before()
        if before is None:
            sought = self._register.sought
            unknown = sought is not None and sought.found.proof is CertificateProof.UNKNOWN
            return (self._not_known(sought.found) if sought is not None and unknown else None), None
        after = self._after(before)
        return (None if after.proof is CertificateProof.ORDER else self._no_way_on(before, after)), after

    def _before(self) -> tuple[int, ...] | None:
        """An order in which all can finish as things are; the one of the last certificate where that still leads on."""
        register, stands = self._register, self._stands
        kept, sought = register.kept, register.sought
        leads = kept is not None and kept.leads_from(stands)
        again = sought is not None and (sought.at, sought.holds) == (stands.at, stands.holds)
        if kept is not None and kept.finishes_from(stands):
            return self._known(kept)
        if sought is not None and (again or leads) and sought.lasts(register.now_s):
            return self._known(kept) if kept is not None and leads else None
        steps = STEPS_MAX
        if sought is not None and again and sought.found.proof is CertificateProof.UNKNOWN:
            steps = min(MORE_STEPS * sought.steps, LAST_STEPS)
        found = finishing_order(self._trains, steps)
        if found.proof is CertificateProof.ORDER:
            kept = LastCertificate(stands.at, stands.holds, found.order)
            self._register = replace(register, kept=kept, sought=None)
            return found.order
        shorter, proof = self._shorter(steps) if found.proof is CertificateProof.NONE else (None, found.proof)
        if shorter is None or (kept is not None and leads and kept.until_s > shorter.until_s):
            shorter = kept if leads else None
        if shorter is None:
            found = replace(found, proof=proof)
        again_s = register.now_s + SEARCHES_EVERY_S
        if (
            found.proof is CertificateProof.UNKNOWN
        ):  # with more steps as soon as anybody asks; after the last, when things change
            again_s = register.now_s if steps < LAST_STEPS else inf
        said = "" if sought is None else sought.said
        sought = LastSearch(stands.at, stands.holds, found, steps, again_s, said)
        self._register = replace(register, kept=shorter, sought=sought)
        self._no_order_known(sought, None if shorter is None else shorter.until_s)
        return None if shorter is None else self._known(shorter)

    def _known(self, kept: LastCertificate) -> tuple[int, ...]:
        """The order; in one of a part of the day, a train that goes on beyond it comes after all that is in it."""
        self._until_s = kept.until_s
        if kept.until_s == inf:
            return kept.order
        order = kept.order if self._index in kept.order else (*kept.order, self._index)
        places = zip(self._stands.holds, self._days.moves, self._stands.at, strict=True)
        self._trains = [
            Train(held, moves[done : done + order.count(index)])
            for index, (held, moves, done) in enumerate(places)
        ]
        return order

    def _shorter(self, steps: int) -> tuple[LastCertificate | None, CertificateProof]:
        """An order of all that is planned to begin until then: looked for from the end of the day in growing strides,
        then between the last two. None: what the search for the shortest part has shown.
        """
        days, stands = self._days, self._stands
        places = zip(days.moves, stands.at, strict=True)
        times = sorted({move.due_s for moves, done in places for move in moves[done:]})
        kept, proof = None, CertificateProof.NONE
        # Before the first time nothing is planned, and the whole day has no order.
        good, bad, tried = 0, len(times), 0
        while bad - good > 1:
            middle = (good + bad) // 2 if good else max(1, bad - 1 - tried * tried // 8)
            found = finishing_order(
                stands.trains(days, times[middle]), steps if middle == 1 else SHORTER_STEPS
            )
            if found.proof is CertificateProof.ORDER:
                kept, good = LastCertificate(stands.at, stands.holds, found.order, times[middle]), middle
            else:
                bad, tried, proof = middle, tried + 1, found.proof
        return kept, proof

    def _no_order_known(self, sought: LastSearch, until_s: float | None) -> None:
        """Shown once for each circle of trains, and once when people have to help."""
        circle = sought.found.circle
        units = tuple(self._days.unit_ids[index] for index in circle)
        why = f"{sought.found.proof.value}: {', '.join(map(self._where, circle))}"
        if until_s is not None:
            why += f"; of what is planned before {clock(until_s)} all can be run"
        elif sought.found.proof is CertificateProof.UNKNOWN:
            why += "; nothing is granted until one is known"
            if sought.again_s == inf:
                why += f", and after {sought.steps} steps it is looked for no more until something changes: people must"
        if sought.said != why:
            self._shows.append(Show(NoOrderKnown(unit_ids=units, why=why)))
            self._register = replace(self._register, sought=replace(sought, said=why))

    def _not_known(self, found: CertificateAnswer) -> Against:
        """Refused: nobody knows whether all can finish, whoever goes next."""
        other = next(index for index in found.circle if index != self._index)
        section_id = self._next_section(other)
        other_id = self._days.unit_ids[other]
        trains = " and ".join(map(self._train, found.circle))
        why = f"{self._where(self._index)} waits: it is not known in which order {trains} can all finish"
        self._held_back(why, other_id, section_id, certificate=True)
        return RefusalReason.NO_WAY_ON, section_id, other_id

    def _after(self, before: tuple[int, ...]) -> CertificateAnswer:
        """An order in which all can finish once this is granted: as near to the one before as there is."""
        mine = before.index(self._index)
        ahead = (self._index, *before[:mine])
        if follows(self._trains, ahead):  # afterwards all is as in the order before
            return CertificateAnswer(CertificateProof.ORDER, (*before[:mine], *before[mine + 1 :]))
        stands = self._stands.after(self._days, self._index)
        trains = stands.trains(self._days)
        if self._until_s < inf:
            trains = [
                Train(train.holds, train.ahead[: before.count(index) - (index == self._index)])
                for index, train in enumerate(trains)
            ]
        rest = (*before[:mine], *before[mine + 1 :])
        near = mine + len(trains)
        while near < len(rest):  # it is enough to come to where the order before comes, too
            counts = [rest[:near].count(index) for index in range(len(trains))]
            few = [Train(t.holds, t.ahead[:count]) for t, count in zip(trains, counts, strict=True)]
            found = finishing_order(few, NEAR_STEPS)
            if found.proof is CertificateProof.ORDER:
                return CertificateAnswer(CertificateProof.ORDER, (*found.order, *rest[near:]))
            near *= 4
        return finishing_order(trains, STEPS_MAX)

    def _no_way_on(self, before: tuple[int, ...], after: CertificateAnswer) -> Against:
        """Refused: behind which train it waits, and where that will have come when it is let on."""
        mine = before.index(self._index)
        first = max(1, mine - LOOKED_BACK)
        lets_on = next(
            (
                k
                for k in range(first, mine + 1)
                if follows(self._trains, (*before[:k], self._index, *before[k:mine]))
            ),
            mine,
        )
        circle = [index for index in after.circle if index != self._index]
        other, moves = (
            (before[lets_on - 1], before[:lets_on].count(before[lets_on - 1])) if lets_on else (circle[0], 0)
        )
        hop = self._days.hops[other][max(0, self._stands.at[other] + moves - 1)]
        proof = "" if after.proof is CertificateProof.NONE else " as far as could be looked"
        stuck = " and ".join(map(self._train, [self._index, *circle]))
        why = (
            f"{self._where(self._index)} waits for {self._train(other)} to come to {hop.section_id}: if it went now,"
            f" {stuck} could not all finish{proof}"
        )
        other_id = self._days.unit_ids[other]
        self._held_back(why, other_id, hop.section_id, certificate=True)
        return RefusalReason.NO_WAY_ON, hop.section_id, other_id

    def _in_doubt(self) -> Against | None:
        """Refused: not all could finish if a train did as it was ordered, and it has not answered."""
        other = in_doubt(self._register, self._days, self._stands.after(self._days, self._index), self._index)
        if other is None:
            return None
        other_id, section_id = self._days.unit_ids[other], self._next_section(other)
        why = f"{self._where(self._index)} waits until {self._train(other)} has answered what it was ordered"
        self._held_back(why, other_id, section_id, certificate=True)
        return RefusalReason.NO_WAY_ON, section_id, other_id

    # the order of trains --------------------------------------------------------------------------------------

    def _by_order(self) -> Against | None:
        if not self._days.given and self._days.order is OrderRule.FIRST_COME:
            return None
        turn = turn_of(self._register, self._days, self._stands, self._index, self._order())
        if turn is None:
            return None
        other_id = self._days.unit_ids[turn.other]
        if turn.goes:
            if turn.why and self._trip.said != turn.why:
                self._shows.append(Show(OrderChanged(unit_id=self._unit_id, other_id=other_id, why=turn.why)))
            return None
        if self._trip.held_s is None:
            self._trip = replace(self._trip, held_s=self._register.now_s)
        self._held_back(turn.why, other_id, turn.section_id)
        return RefusalReason.NOT_ITS_TURN, turn.section_id, other_id

    def _order(self) -> LastOrder | None:
        self._register, order, shows = order_now(self._register, self._days, self._stands, self._index)
        self._shows += shows
        return order

    # what follows ---------------------------------------------------------------------------------------------

    def _held_back(self, why: str, other_id: str, section_id: str, *, certificate: bool = False) -> None:
        """It counts as waiting; the journal is told when the reason changes."""
        if self._trip.said != why:
            note = HeldBack(
                unit_id=self._unit_id,
                other_id=other_id,
                section_id=section_id,
                certificate=certificate,
                why=why,
            )
            self._shows.append(Show(note))
        self._trip = replace(self._trip.asks(self._register.now_s), said=why)
        self._register = self._register.with_trip(self._unit_id, self._trip)

    def _granted(self, after: CertificateAnswer | None) -> None:
        """The move counts as made; trains that wait for the same line were overtaken."""
        register, days, index = self._register, self._days, self._index
        place = self._stands.at[index]
        hop = days.hops[index][place]
        late_s, again = max(0.0, register.now_s - hop.departs_s), self._trip.done == place + 1
        made = DayProgress(place + 1, late_s, granted_s=register.now_s)
        if again:  # it had given it back: it is not asked for it, or overtaken, without end
            made = replace(made, orders=self._trip.orders, overtaken=self._trip.overtaken)
        register = register.with_trip(self._unit_id, made)
        for other, unit_id in enumerate(days.unit_ids):
            trip = register.trips.get(unit_id)
            at = self._stands.at[other]
            if other == index or trip is None or at == len(days.hops[other]):
                continue
            if trip.asked_s is None and trip.back_s <= register.now_s:
                continue
            if days.hops[other][at].line & hop.line:
                register = register.with_trip(unit_id, replace(trip, overtaken=trip.overtaken + 1))
        kept = None
        if after is not None and after.proof is CertificateProof.ORDER:
            stands = self._stands.after(days, index)
            kept = LastCertificate(stands.at, stands.holds, after.order, self._until_s)
            self._shows.append(Show(self._certificate(after.order)))
        self._register = replace(register, kept=kept)

    def _certificate(self, rest: Sequence[int]) -> Certified:
        order = (self._index, *rest)
        moves = tuple(self._moves(order))
        return Certified(unit_id=self._unit_id, moves=moves, beyond=len(order) - len(moves))

    def _moves(self, order: Sequence[int]) -> Iterator[str]:
        """Moves of the order, until all that are on the line have ended their present trains."""
        days, at = self._days, list(self._stands.at)
        left = {index: self._to_the_end(index) for index, held in enumerate(self._stands.holds) if held}
        left[self._index] = self._to_the_end(self._index)
        open_moves = sum(left.values())
        for index in order:
            if not open_moves:
                return
            hop = days.hops[index][at[index]]
            at[index] += 1
            if left.get(index, 0):
                left[index] -= 1
                open_moves -= 1
            yield f"{days.unit_ids[index]} {hop.section_id}"

    def _to_the_end(self, index: int) -> int:
        """How many moves the present train of a stock still has; none where it has ended and the next has not begun."""
        hops, at = self._days.hops[index], self._stands.at[index]
        if at == len(hops) or (index != self._index and at and hops[at - 1].train != hops[at].train):
            return 0
        train = hops[at].train
        return sum(hop.train == train for hop in hops[at:])

    def _next_section(self, index: int) -> str:
        hops, at = self._days.hops[index], self._stands.at[index]
        return hops[min(at, len(hops) - 1)].section_id

    def _train(self, index: int) -> str:
        hops, at = self._days.hops[index], self._stands.at[index]
        return hops[min(at, len(hops) - 1)].train if hops else self._days.unit_ids[index]

    def _where(self, index: int) -> str:
        hops, at = self._days.hops[index], self._stands.at[index]
        if at < len(hops) and not hops[at].route_id:
            return f"{self._train(index)} outside {hops[at].section_id}"
        bits = self._days.bits.items()
        place = hops[at - 1].section_id if at else next((s for s, bit in bits if bit == hops[0].start), "")
        return f"{self._train(index)} at {place}"
