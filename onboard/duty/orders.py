"""What a crew or the dispatcher wants otherwise than planned: a route set back (進路取消), another track at the next
station (着発線変更), a train ended where it stands (途中折返し, 運休), a route taken back so that others go first.

Invariant: only a train that stands at a stop, surely short of what lies ahead, does any of it; what it holds under and
behind it stays as it is. All of it only gives up: the way that follows is asked for and granted like any other.
"""

from __future__ import annotations

from onboard import notes
from onboard.authority.records import (
    Event,
    GiveBack,
    GrantHeard,
    RequestKind,
    SendRefusal,
    TakeBackOrdered,
    TrackChangeOrdered,
    TrainEndOrdered,
)
from onboard.duty.duty_step import DutyStep
from onboard.duty.records import (
    DutyPhase,
    DutyState,
    NoSuchWay,
    SetBack,
    TakeUpWay,
    TrainEndsHere,
    WayOrdered,
)
from onboard.plan import DutyPlan
from radio.messages import OrderRefusalReason

ONCE = True  # off: an order that answers no open request, as an old or doubled one, is done all the same
SHORT_OF_IT = True  # off: a route is given back wherever the train stands


def set_back(duty: DutyStep, event: SetBack) -> None:
    """Standing surely short of it, gives the route ahead back and asks for none for a while."""
    state, place = duty.state, duty.state.place
    if not place.known or not place.stands:
        duty.note(notes.GiveBackDenied(why="the train does not stand at a known place"))
        return
    if state.phase is DutyPhase.STANDING and may_have_entered(duty):
        duty.note(notes.GiveBackDenied(why="the train may have entered the route"))
        return
    if state.phase is DutyPhase.STANDING:
        duty.schedule(duty.now_s + event.hold_s + duty.parameters.request_lead_s, state.at)
    else:
        duty.set(may_ask=duty.timer("ask", event.hold_s))
    _give_back_ahead(duty)


def set_back_refused(duty: DutyStep, _event: SetBack) -> None:
    """Refused: only a train that stands, and knows where, can set back its route."""
    duty.note(notes.GiveBackDenied(why="the train does not stand at a known place"))


def may_have_entered(duty: DutyStep) -> bool:
    """Whether the front of a train at a stop may be beyond the section where it stands."""
    return SHORT_OF_IT and duty.state.place.perhaps > duty.stop(duty.state.at).span + 1


def _give_back_ahead(duty: DutyStep) -> None:
    ahead = duty.plan.spans[duty.state.place.perhaps :]
    given = tuple(s.section_id for s in ahead if duty.state.authority.holds(s.section_id))
    duty.set(wanted=())
    duty.note(notes.GaveBack(section_ids=given))
    duty.authority(GiveBack(given))


# the dispatcher -------------------------------------------------------------------------------------------------


def change_track(duty: DutyStep, event: TrackChangeOrdered) -> None:
    """To the request outstanding: has the driver take up the way ordered; not once the front may have left."""
    if _can_be_done(duty, event):
        duty.set(ordered=event.instead)
        duty.actions.append(WayOrdered(event.route_id, event.instead))


def end_train(duty: DutyStep, event: TrainEndOrdered) -> None:
    """To the request outstanding: has the driver end the train here; not once the front may have left."""
    if _can_be_done(duty, event):
        duty.set(next_train=event.train)
        duty.actions.append(TrainEndsHere(event.train))


def hear(duty: DutyStep, event: Event) -> None:
    """A telegram for the authority; a grant not while the driver takes up what was ordered, which gives it up."""
    if not (isinstance(event, GrantHeard) and _takes_up(duty.state)):
        duty.authority(event)


def _takes_up(state: DutyState) -> bool:
    """Whether the driver has been told of an order, and has yet to say what came of it."""
    return state.phase is DutyPhase.STANDING and bool(state.ordered or state.next_train)


def _can_be_done(duty: DutyStep, event: TrackChangeOrdered | TrainEndOrdered) -> bool:
    """Whether an order answers the request outstanding, of a train surely short of its route; the other is refused."""
    request = duty.state.authority.open(RequestKind.ROUTE)
    answers = event.answers and request is not None and request.subject == event.route_id
    if (ONCE and not answers) or _takes_up(duty.state):
        return False
    leg = duty.leg_from_stop(duty.state.at)  # none at a halt on the way, and the part behind it has been run
    begins = leg is not None and leg.route_id == event.route_id
    if not begins or may_have_entered(duty) or not duty.state.place.known:
        refuse(duty, event.route_id, OrderRefusalReason.MAY_HAVE_ENTERED)
        return False
    return True


def leads_on(plan: DutyPlan, state: DutyState, way: DutyPlan) -> bool:
    """Whether a way may be taken up for a plan: it is the one ordered, and the same as far as the train may be."""
    same, at = state.place.perhaps, state.at
    leg = None if at >= len(way.stops) else way.leg_beyond(way.spans[way.stops[at].span].section_id)
    if state.next_train:
        as_ordered = leg is None and len(way.stops) == at + 1
    else:
        as_ordered = bool(state.ordered) and leg is not None and leg.route_id == state.ordered
    return (
        as_ordered
        and state.phase is DutyPhase.STANDING
        and state.authority.open(RequestKind.ROUTE) is not None
        and (way.number, way.spans[:same], way.stops[: at + 1])
        == (plan.number, plan.spans[:same], plan.stops[: at + 1])
    )


def take_up(duty: DutyStep, _event: TakeUpWay) -> None:
    """Gives up its request, reports what it holds, and asks for the way ordered, or is at its end."""
    state = duty.state
    request = state.authority.open(RequestKind.ROUTE)
    if state.next_train:
        place = duty.stop(state.at).place
        duty.note(notes.EndedEarly(train=duty.plan.number, station=place, next_train=state.next_train))
    else:
        was = "" if request is None else request.subject
        duty.note(notes.WayChanged(route_id=was, instead=state.ordered))
    duty.set(ordered="", next_train="", wanted=())
    duty.authority(GiveBack((), state.next_train))


def no_such_way(duty: DutyStep, _event: NoSuchWay) -> None:
    """Says that it has no such way or train, and goes on asking for its own."""
    state = duty.state
    request = state.authority.open(RequestKind.ROUTE)
    duty.set(ordered="", next_train="")
    if request is None:
        return
    if state.ordered:
        refuse(duty, request.subject, OrderRefusalReason.UNKNOWN_TRACK)
    elif state.next_train:
        refuse(duty, request.subject, OrderRefusalReason.UNKNOWN_TRAIN)


def take_back(duty: DutyStep, event: TakeBackOrdered) -> None:
    """Of the route granted last, not entered yet: gives it back and asks for none for a while; else says why not."""
    state = duty.state
    leg = None if state.at + 1 >= len(duty.plan.stops) else duty.leg_from_stop(state.at)
    holds = leg is not None and any(map(state.authority.holds, leg.section_ids))
    given_up = leg is None or leg.route_id != event.route_id or _takes_up(state)
    if given_up or not event.newest or not holds:
        refuse(duty, event.route_id, OrderRefusalReason.NOT_HELD)
    elif not state.place.known or not state.place.stands or may_have_entered(duty):
        refuse(duty, event.route_id, OrderRefusalReason.MAY_HAVE_ENTERED)
    else:
        duty.set(may_ask=duty.timer("ask", event.hold_s))
        _give_back_ahead(duty)


def no_other_track(duty: DutyStep, event: TrackChangeOrdered | TrainEndOrdered) -> None:
    """Refused: only a train that stands at a stop changes its way, or ends early."""
    if event.answers:
        refuse(duty, event.route_id, OrderRefusalReason.NOT_AT_A_STOP)


def nothing_to_take_back(duty: DutyStep, event: TakeBackOrdered) -> None:
    """Refused: only a train that stands at a stop gives its route back."""
    refuse(duty, event.route_id, OrderRefusalReason.NOT_AT_A_STOP)


def refuse(duty: DutyStep, route_id: str, reason: OrderRefusalReason) -> None:
    """Says that an order is not done, and why."""
    duty.note(notes.OrderDenied(route_id=route_id, why=reason.name.lower().replace("_", " ")))
    duty.actions.append(SendRefusal(route_id, reason))
