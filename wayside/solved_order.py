"""What is best for all trains, as a process beside the manager finds it (`[dispatch] order = "optimal"`).

Asked is what the manager knows and nothing else: the planned times of the moves, how late each train was when it left
last, what each holds, and for how long one is due that has not asked. Whether the train that asks goes now is asked for
each train alone and played through (`plan.dispatching.chances`). Where tracks may be changed, an order of all is solved
instead; there who is overdue is expected after as long again. The moves are those that are planned to begin in the next
two hours: at that time of the plan all trains stand where they have room. Where trains have gone out of their turn and
could not all come to these places, further moves are asked for, with which they can.
"""

from __future__ import annotations

import math
from collections import Counter
from functools import partial
from typing import Final

from msgspec.structs import replace

from wayside.actions import Show
from wayside.certificate import CertificateProof, finishing_order
from wayside.config import DispatcherMeans
from wayside.journeys import Days, PlannedMove, Stands, could_leave_s, overdue_s
from wayside.moves import Move
from wayside.order_question import ALL, LastOrder, OrderAnswer, OrderMove, OrderQuestion, OrderTrain, OrderWay
from wayside.register import Register
from wayside.said import OrderLacking

AHEAD_S: Final = 2 * 3600.0  # assumed: how far ahead delays are compared
WORK_MAX: Final = 0.04  # assumed: of the solver's counted work, some 0.3 s of a processor
CHOICE_AHEAD_S: Final = 2400.0  # assumed: further ahead tracks are as planned, or as they were changed
ORDERS_MAX: Final = 6  # assumed: lost orders are given again; trains are not sent to and fro
ASKED_EVERY_S: Final = 60.0  # assumed: who asks for a route asks again every few seconds
STANDS_AGAIN: Final = 1.0  # assumed: who has stood for so long will stand for as long again
EXTENDS = True  # off: who is asked about ends at a time of the plan, whether all can stand there or not
HEARS = True  # off: an order is kept for its minute, whoever has asked meanwhile
STANDS_ON = True  # off: who is overdue counts as ready this second, however long it has been


def with_order(
    register: Register, days: Days, stands: Stands, index: int
) -> tuple[Register, tuple[Show, ...]]:
    """The register with an order for who asks, of this minute, made since who was overdue asked; and what is shown."""
    asks = ALL if DispatcherMeans.CHANGE_TRACK in days.may else index
    last = register.solved.get(asks)
    young = last is not None and register.now_s < last.made_s + ASKED_EVERY_S
    if last is not None and young and not _has_news(register, days, stands, last):
        return register, ()
    question = replace(question_of(register, days, stands), asks=asks, late_s=math.ceil(days.late_s))
    answer = register.plan.solver(question)
    if not _of_these(question, answer):
        answer = OrderAnswer(lacking="the solver's order is not of the moves asked for")
    said = {each.answer.lacking for each in register.solved.values()}
    shows = (Show(OrderLacking(why=answer.lacking)),) if answer.lacking and answer.lacking not in said else ()
    awaited = tuple(index for index, train in enumerate(question.trains) if train.stood_s)
    made = LastOrder(register.now_s, stands.at, answer, awaited)
    return replace(register, solved={**register.solved, asks: made}), shows


def _has_news(register: Register, days: Days, stands: Stands, last: LastOrder) -> bool:
    """Whether a train asks, or was let on, that was overdue when the order was made, and so expected later; or one has
    gone that was waited for.
    """
    chosen = () if last.answer.otherwise_s is None else last.answer.order
    return HEARS and (
        any(stands.at[index] != last.at[index] for index in {*last.awaited, *chosen})
        or any(register.trip(days.unit_ids[index]).asked_s is not None for index in last.awaited)
    )


def _held(register: Register, days: Days) -> dict[str, int]:
    """What each stock with a day holds."""
    held: dict[str, int] = dict.fromkeys(days.unit_ids, 0)
    for section_id, unit_id in register.holders.items():
        if unit_id in held:
            held[unit_id] |= days.bits[section_id]
    return held


def _of_these(question: OrderQuestion, answer: OrderAnswer) -> bool:
    """Whether an order has no other moves than were asked for."""
    moves = [len(train.moves) for train in question.trains]
    return all(0 <= k < len(moves) and n <= moves[k] for k, n in Counter(answer.order).items())


def question_of(register: Register, days: Days, stands: Stands) -> OrderQuestion:
    """The question as things are."""
    held = _held(register, days)
    ahead = moves_ahead(register, days, stands)
    trains = (
        _train(register, days, stands, index, held[unit_id], ahead[index])
        for index, unit_id in enumerate(days.unit_ids)
    )
    last = register.solved.get(ALL)
    order = () if last is None else tuple(index for index, _ in last.left(stands.at))
    ends = () if last is None or not days.may else last.ends_left(stands.at)
    return OrderQuestion(tuple(trains), order, math.ceil(AHEAD_S), WORK_MAX, ends)


def moves_ahead(register: Register, days: Days, stands: Stands) -> list[int]:
    """How many of its next moves each stock is asked about: all that are planned to begin in time, and as many more as
    an order for the day has before the last of these, where after these alone they could not all stand.
    """
    in_time = stands.trains(days, register.now_s + AHEAD_S)
    planned = [len(train.ahead) for train in in_time]
    if not EXTENDS or finishing_order(in_time).proof is CertificateProof.ORDER:
        return planned
    if (kept := register.kept) is not None and kept.finishes_from(stands):
        order = kept.order
    else:
        order = finishing_order(stands.trains(days)).order
    made, left = [0] * len(planned), sum(planned)
    for index in order:
        if not left:
            break
        left -= made[index] < planned[index]
        made[index] += 1
    return planned if left else made


def _train(register: Register, days: Days, stands: Stands, index: int, held: int, count: int) -> OrderTrain:
    now_s, at = register.now_s, stands.at[index]
    trip, hops = register.trip(days.unit_ids[index]), days.hops[index]
    keeps = _sections(days, stands.holds[index])
    if trip.astray:
        return OrderTrain((), 0, (), 0, ())
    comes_s, stands_s = 0, could_leave_s(days, stands, index, trip)
    if at and trip.asked_s is None:
        comes_s = max(0, math.ceil(hops[at - 1].arrives_s + trip.late_s - now_s))
    stood_s = 0.0
    if STANDS_ON:
        stood_s = overdue_s(days, stands, index, trip, held, now_s)
        stands_s = max(stands_s, now_s + STANDS_AGAIN * stood_s if stood_s else stands_s)
    ready_s = math.ceil(stands_s - now_s) - comes_s if stands_s > now_s + comes_s else 0
    ahead = hops[at : at + count]
    moves = tuple(
        _move(
            days,
            hop,
            hop.move if place else stands.next_move(days, index),
            now_s,
            counts=place + 1 == len(ahead) or ahead[place + 1].train != hop.train,
        )
        for place, hop in enumerate(ahead)
    )
    if DispatcherMeans.CHANGE_TRACK in days.may:
        moves = _with_others(register, days, index, at, moves)
    return OrderTrain(_sections(days, held), comes_s, keeps, ready_s, moves, math.ceil(stood_s))


def _with_others(
    register: Register, days: Days, index: int, at: int, moves: tuple[OrderMove, ...]
) -> tuple[OrderMove, ...]:
    """The moves with all ways to make those that are near: from each track where the one before may end."""
    trip, found = register.trip(days.unit_ids[index]), list[OrderMove]()
    here: tuple[str, ...] = ()
    for place, move in enumerate(moves, at):
        hop = days.hops[index][place]
        route = days.ways.routes.get(hop.route_id)
        if route is None:
            here = (hop.section_id,)
            found.append(move)
            continue
        fixed = hop.departs_s >= register.now_s + CHOICE_AHEAD_S
        fixed = fixed or (place == at and (trip.own_way or trip.orders >= ORDERS_MAX))
        there = (
            hop.section_id,
            *(() if fixed else filter(partial(_leads_on, days, index, place), hop.others)),
        )
        turned = (
            hop if (a, b) == (route.from_section, hop.section_id) else days.ways.turned(hop, a, b)
            for a in here or (route.from_section,)
            for b in there
        )
        others = tuple(_way(days, each) for each in turned if each is not None and each is not hop)
        found.append(replace(move, here=_number(hop.start), others=others))
        here = there
    return tuple(found)


def _leads_on(days: Days, index: int, place: int, section_id: str) -> bool:
    """Whether a move may end there: the one after it can begin there."""
    return days.with_track(index, place, section_id) is not None


def _way(days: Days, hop: PlannedMove) -> OrderWay:
    needs, keeps = _sections(days, hop.move.needs), _sections(days, hop.move.keeps)
    return OrderWay(_number(hop.start), needs, keeps)


def _number(section: int) -> int:
    return section.bit_length() - 1


def _move(days: Days, hop: PlannedMove, move: Move, now_s: float, *, counts: bool) -> OrderMove:
    return OrderMove(
        _sections(days, move.needs),
        _sections(days, move.keeps),
        max(0, math.ceil(hop.departs_s - now_s)),
        math.ceil(hop.arrives_s - hop.departs_s),
        math.ceil(hop.stays_s),
        math.ceil(hop.arrives_s - now_s),
        counts,
    )


def _sections(days: Days, bits: int) -> tuple[int, ...]:
    """By number; what waits outside a portal is no section."""
    return tuple(number for number in range(len(days.bits)) if bits >> number & 1)
