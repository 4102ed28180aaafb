"""The duty of an on-board unit: what it does next on its way through a train number's plan.

Invariant: in every phase something is outstanding, a timer runs, or the duty is over; the train goes nowhere that its
authority has not opened, and gives back nothing that its safe rear has not left.

A pure machine: `step(plan, parameters, state, event, place, now_s) -> (state, actions)`. `TABLE` is the whole of it:
what it does not name is refused and changes nothing. After every event `settle` draws what follows from the state as
it is then. Sugiyama et al. 2017, section 2.2, 4.4 and table 1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Final

import msgspec
from msgspec.structs import replace

from network.model import TagPurpose
from onboard import notes
from onboard.authority.records import (
    BeginOnLine,
    EndOnLine,
    RepeatDue,
    RequestKind,
    TakeBackOrdered,
    TakenOff,
    Throw,
    TrackChangeOrdered,
    TrainEndOrdered,
    TurnedBack,
    Withdrawn,
)
from onboard.duty import fitness, on_sight, orders
from onboard.duty.arrival import clear_behind, confirm, releases_at_each
from onboard.duty.duty_step import Action, DutyStep
from onboard.duty.entering import ask_beyond, ask_leave
from onboard.duty.fitness import way_is_free
from onboard.duty.records import (
    ABLE,
    ASK,
    AT_A_MARK,
    LEAVE,
    RELEASE,
    AtMark,
    Begin,
    ChangeEnds,
    DrivingOrder,
    DutyPhase,
    DutyState,
    EndOfHeld,
    EntryAllowed,
    Event,
    Finished,
    FoundByOtherSensor,
    Leave,
    LeftLine,
    Looked,
    MarkRelation,
    NoSuchWay,
    NotAtMark,
    OffTheLine,
    PlaceInJoints,
    PointsSeen,
    PointsWrong,
    PositionLost,
    SetBack,
    Stopped,
    SwitchedOn,
    TagBelieved,
    TagReached,
    TakeUpWay,
    TelegramHeard,
    TimerDue,
    VehicleChecked,
    WheelsTurning,
)
from onboard.duty.shown import to_confirm
from onboard.duty.stop_limit import (
    NOT_PROVEN,
    entered_on_proof,
    points_perhaps_under,
    stop_limit,
)
from onboard.duty_parameters import DutyParameters
from onboard.plan import DutyPlan, PlanTag

Handler = Callable[[DutyStep, Any], None]


def step(
    plan: DutyPlan,
    parameters: DutyParameters,
    state: DutyState,
    event: Event,
    place: PlaceInJoints,
    now_s: float,
) -> tuple[DutyState, tuple[Action, ...]]:
    """Next state and what to do. An event that does not fit the phase changes nothing but what is due anyway."""
    duty = DutyStep(plan, parameters, now_s, state if state.place == place else replace(state, place=place))
    handler = TABLE.get((state.phase, type(event)))
    if handler is not None:
        handler(duty, event)
    settle(duty)
    return duty.state, tuple(duty.actions)


# what people do -------------------------------------------------------------------------------------------------


def begin(duty: DutyStep, event: Begin) -> None:
    """Takes up the train where its stock stands; stock that comes onto the line signs on first."""
    plan = event.plan
    fresh = DutyState(place=duty.state.place, authority=duty.state.authority, released=duty.state.released)
    duty.state = fresh
    duty.note(notes.MissionBegun(train=plan.number, direction=plan.direction))
    duty.schedule(duty.now_s, 0)
    if duty.state.place.emergency:
        duty.await_release()
    if event.signs_on:
        duty.set(phase=DutyPhase.SIGNING_ON)
        duty.authority(BeginOnLine((plan.spans[0].section_id,), plan.enters))
    elif duty.state.place.known:
        duty.set(phase=DutyPhase.STANDING)
    else:
        duty.set(phase=DutyPhase.ON_SIGHT, stands_at=0)


def change_ends(duty: DutyStep, _event: ChangeEnds) -> None:
    """What was behind is ahead; the next train number follows."""
    duty.authority(TurnedBack())
    duty.note(notes.ChangedEnds())


def leave(duty: DutyStep, _event: Leave) -> None:
    """Signs off at the portal."""
    duty.set(phase=DutyPhase.SIGNING_OFF)
    duty.authority(EndOnLine())


def off_the_line(duty: DutyStep, _event: OffTheLine) -> None:
    """Has left: holds nothing any more, and says so when it is asked."""
    duty.set(phase=DutyPhase.GONE)
    duty.authority(TakenOff())


# what localisation and driving report ------------------------------------------------------------------------------


def tag_passed(duty: DutyStep, event: TagBelieved) -> None:
    """Gives back what it proves to be behind (①, or each); at ④, or the next, throws the arrival points."""
    if event.found:
        duty.note(notes.PositionFound())
    passed = duty.plan.tags[: event.tag + 1]
    proved = max(duty.state.proved, passed[-1].clear)
    duty.set(proved=proved)
    if passed[-1].purpose is TagPurpose.ARRIVAL or releases_at_each(duty, event):
        duty.set(freed=proved)
    look_ahead(duty, passed)


def tag_reached(duty: DutyStep, event: TagReached) -> None:
    """Throws and asks for what lies ahead as at the tag; gives nothing back, since no fix proves that it is passed."""
    look_ahead(duty, duty.plan.tags[: event.tag + 1])


def found(duty: DutyStep, _event: FoundByOtherSensor) -> None:
    """Another sensor, or the driver's eye, gives the position: the same as by a tag."""
    duty.note(notes.PositionFound())


def look_ahead(duty: DutyStep, passed: tuple[PlanTag, ...]) -> None:
    """What a train that has come to the last of these tags wants of what lies ahead."""
    plan = duty.plan
    last = max((i for i, tag in enumerate(passed) if tag.purpose is TagPurpose.APPROACH), default=None)
    if last is not None and not any(tag.purpose is TagPurpose.ARRIVAL for tag in passed[last:]):
        duty.want(plan.arrival_points(passed[last]))
        ask_beyond(duty, plan.track_ahead(passed[last]))  # not beyond a track that this tag stands in
    elif passed[-1].purpose is TagPurpose.POSITION:
        ask_beyond(duty, plan.track_behind_joint(passed[-1]))


def started(duty: DutyStep, _event: WheelsTurning) -> None:
    """Notes that the wheels turn."""
    duty.note(notes.Moving())


def stopped(duty: DutyStep, event: Stopped) -> None:
    """At or beyond its mark it has arrived; short of it, it asks for what it lacks to go on."""
    emergency_stopped(duty, event)
    state, plan = duty.state, duty.plan
    if event.how is MarkRelation.SHORT:
        duty.note(notes.StoppedShort(short_m=round(-event.away_m, 2), why=state.limit.why))
        duty.ask(plan.leg_at(state.place.here))
        return
    if event.how is MarkRelation.BEYOND:  # no train sets back here: it counts as arrived, as far as it went
        duty.note(notes.Overran(beyond_m=round(event.away_m, 2)))
    duty.set(at=state.at + 1, phase=DutyPhase.STANDING)
    duty.schedule(duty.now_s + duty.dwell_s(state.at + 1), state.at + 1)
    duty.note(notes.Arrived(station=duty.stop(state.at + 1).place, error_m=round(event.away_m, 3)))


def emergency_stopped(duty: DutyStep, _event: Stopped) -> None:
    """After an emergency stop the driver's acknowledgement is awaited."""
    if duty.state.place.emergency:
        duty.await_release()


def looked(duty: DutyStep, _event: Looked) -> None:
    """Sends what is due where the radio reaches again, frees what the safe rear has left."""
    duty.say_what_waits()


# time and radio ----------------------------------------------------------------------------------------------------


def timer_due(duty: DutyStep, event: TimerDue) -> None:
    """A route may be asked for, the train may leave or sees whether it can, an emergency stop is acknowledged, or a
    request is due again.
    """
    match event.timer:
        case timer if timer == ASK:
            duty.set(may_ask=True)
        case timer if timer == LEAVE:
            duty.set(may_leave=True)
        case timer if timer == ABLE:
            fitness.look_again(duty)
        case timer if timer == RELEASE and duty.state.must_stand and not on_sight.hears_nothing(duty):
            duty.await_release()  # not before register and unit agree
        case timer if timer == RELEASE and not fitness.acknowledged(duty):
            pass
        case timer if timer == RELEASE:
            place = msgspec.structs.replace(duty.state.place, emergency=False)
            duty.set(released=True, place=place)
            duty.note(notes.EmergencyReleased())
            duty.actions.append(DrivingOrder.RELEASE)
        case timer:
            duty.authority(RepeatDue(timer))


def heard(duty: DutyStep, event: TelegramHeard) -> None:
    """As the tables of the authority say; with a route granted, its departure points are to be thrown."""
    asked = duty.state.authority.open(RequestKind.ROUTE)
    remember_entered(duty)
    on_sight.heard(duty)
    orders.hear(duty, event.event)
    leg = next((x for x in duty.plan.legs if asked is not None and x.route_id == asked.subject), None)
    now = duty.state.authority.open(RequestKind.ROUTE)
    if leg is not None and asked is not None and (now is None or now.section_ids != asked.section_ids):
        duty.want(duty.plan.departure_points(leg.from_section))
        if asked.section_ids == leg.to_enter:
            ask_beyond(duty, next(s for s in duty.plan.spans if s.section_id == leg.section_ids[-1]))


# what follows from the state as it is ------------------------------------------------------------------------------


def settle(duty: DutyStep) -> None:
    """What follows from the state as it is now, whatever has led to it."""
    phase = duty.state.phase
    if phase in (DutyPhase.OFF, DutyPhase.LEAVING, DutyPhase.GONE):
        return
    react(duty)
    if phase is DutyPhase.SIGNING_ON and duty.state.authority.on_line:
        if duty.state.place.known:
            duty.set(phase=DutyPhase.STANDING)
        else:  # lost while it signed on: only a tag can tell it again
            duty.set(phase=DutyPhase.ON_SIGHT, stands_at=duty.state.at)
        duty.actions.append(EntryAllowed(duty.plan.number))
        phase = duty.state.phase
    if phase is DutyPhase.SIGNING_OFF and not duty.state.authority.on_line:
        duty.set(phase=DutyPhase.LEAVING)
        duty.actions.append(LeftLine(duty.plan.number))
        return
    if phase is DutyPhase.SIGNING_OFF and duty.state.authority.open(RequestKind.SIGN_OFF) is None:
        duty.authority(EndOnLine())  # once nothing but the portal is held
    if phase is DutyPhase.ON_SIGHT and not on_sight.recovered(duty):
        react(duty)
        return
    if duty.state.place.known and duty.state.phase in _BY_POSITION:
        clear_behind(duty)
        remember_entered(duty)
        withdraw_throws(duty)
        throw_wanted(duty)
    begin_or_end_sweep(duty)
    set_limit(duty)
    fitness.examine(duty)
    if duty.state.phase is DutyPhase.STANDING:
        stand(duty)
    elif duty.state.phase is DutyPhase.RUNNING and duty.state.place.stands:
        held_up(duty)


def react(duty: DutyStep) -> None:
    """Register and unit contradict each other: stops by the emergency brake (section 5); once they agree, goes on."""
    mismatch = bool(duty.state.authority.mismatch)
    if mismatch is duty.state.halted:
        on_sight.seek_radio(duty)
        return
    duty.set(halted=mismatch, seeks_radio=False, listens=False)
    if mismatch:
        duty.actions.append(DrivingOrder.STOP)
        duty.set(place=msgspec.structs.replace(duty.state.place, emergency=True))
        if duty.state.place.stands:
            duty.await_release()


def begin_or_end_sweep(duty: DutyStep) -> None:
    """From a stand the train goes on on sight through what must be swept, until its front has left all of it.

    The rest it goes as any other: what lies behind its front it has run through, though it gives it back later.
    """
    state = duty.state
    left = {span.section_id for span in duty.plan.spans[: front_has_left(state)]}
    to_sweep = any(section_id not in left for section_id in state.authority.unswept)
    sweeps = to_sweep and (state.sweeps or state.place.stands)
    if sweeps is not state.sweeps:
        duty.set(sweeps=sweeps)


def front_has_left(state: DutyState) -> int:
    """How many spans of the plan, from its beginning, the front has surely left."""
    return max(state.place.sure - 1, 0) if state.place.known else 0


def held_up(duty: DutyStep) -> None:
    """Stands short of its mark: asks for the way ahead; where it may stand upon points unproven, goes on on sight."""
    state = duty.state
    limit, place = state.limit, state.place
    if not place.known or limit.before is None:
        return
    if state.may_ask:
        duty.ask(duty.plan.leg_at(place.here))
    if limit.why == NOT_PROVEN and place.perhaps > limit.joint:
        on_sight.give_up_position(duty)
    elif limit.why == NOT_PROVEN and not state.halted:
        duty.want(duty.plan.spans[limit.joint].points)
        throw_wanted(duty)


def remember_entered(duty: DutyStep) -> None:
    """Points that the train has come onto by their proof, before anything can withdraw it."""
    state = duty.state
    if state.place.known:
        entered = entered_on_proof(duty.plan, state.authority, state.place.sure)
        if not entered <= state.entered:
            duty.set(entered=state.entered | entered)


def withdraw_throws(duty: DutyStep) -> None:
    """No points are asked to move once the front may have come onto them."""
    sections = points_perhaps_under(duty.plan, duty.state.authority, duty.state.place.perhaps)
    if sections:
        duty.authority(Withdrawn(tuple(sorted(sections))))


def throw_wanted(duty: DutyStep) -> None:
    """Command what is wanted and neither proven nor under way: anew, too, when a proof was withdrawn."""
    state = duty.state
    if not state.wanted:
        return
    ahead = {span.section_id for span in duty.plan.spans[state.place.perhaps :]}
    wanted = tuple(needed for needed in state.wanted if needed.section_id in ahead)
    if wanted != state.wanted:
        duty.set(wanted=wanted)
    under_way = {*state.authority.proven, *(command.needed for command in state.authority.commands)}
    missing = tuple(needed for needed in wanted if needed not in under_way)
    if missing:
        duty.authority(Throw(missing))
        ask_leave(duty, missing)


def set_limit(duty: DutyStep) -> None:
    """The stop limit by what is held and proven."""
    state = duty.state
    within, left = state.place.perhaps if state.seeks_radio else None, front_has_left(state)
    limit = stop_limit(
        duty.plan, state.authority, state.entered, sweeps=state.sweeps, left=left, within=within
    )
    if limit == state.limit:
        return
    duty.set(limit=limit)
    piece, kilometrage_m = duty.plan.joint(limit.joint)
    duty.note(
        notes.LimitSet(
            kilometrage_m=round(kilometrage_m, 1), piece_id=piece, before=limit.before, why=limit.why
        )
    )


def stand(duty: DutyStep) -> None:
    """At a stop: ask for the next route in time, leave when the time has come and the way is free."""
    state = duty.state
    if state.at + 1 >= len(duty.plan.stops):
        if state.authority.open(RequestKind.REPORT) is None and not to_confirm(duty.plan, state):
            duty.set(phase=DutyPhase.FINISHED)
            duty.actions.append(Finished(duty.plan.number))
        return
    if state.may_ask and state.unable is None:  # it would hold what it cannot use
        duty.ask(duty.plan.leg_at(duty.stop(state.at).span))
        throw_departure(duty)
    perhaps_upon = duty.state.limit.why == NOT_PROVEN and state.place.perhaps > duty.state.limit.joint
    if state.may_leave and perhaps_upon and not state.halted:
        on_sight.give_up_position(duty)  # it would wait for points that nobody throws under it
    elif state.may_leave and state.unable is None and not state.place.unsure and way_is_free(duty):
        duty.set(phase=DutyPhase.RUNNING)
        duty.note(notes.Departs(station=duty.stop(state.at).place))
        duty.actions.append(DrivingOrder.DEPART)


def throw_departure(duty: DutyStep) -> None:
    """Who holds its whole route and was not granted it at this stop (the register gave it back after a boot before the
    portal) throws its departure points, for it asks for nothing.
    """
    state, leg = duty.state, duty.leg_from_stop(duty.state.at)
    if leg is None or state.limit.why != NOT_PROVEN or state.halted:
        return
    if state.authority.open(RequestKind.ROUTE) is None and all(map(state.authority.holds, leg.section_ids)):
        points = duty.plan.departure_points(leg.from_section)
        if not {*state.wanted, *state.authority.proven}.issuperset(points):
            duty.want(points)
            throw_wanted(duty)


_BY_POSITION: Final = (*AT_A_MARK, DutyPhase.RUNNING, DutyPhase.SIGNING_ON)
_MAY_SET_BACK: Final = (DutyPhase.STANDING, DutyPhase.RUNNING)
_ON_THE_LINE: Final = (
    DutyPhase.SIGNING_ON,
    DutyPhase.STANDING,
    DutyPhase.RUNNING,
    DutyPhase.ON_SIGHT,
    DutyPhase.FINISHED,
    DutyPhase.SIGNING_OFF,
)

TABLE: Final[Mapping[tuple[DutyPhase, type[Event]], Handler]] = MappingProxyType(
    {
        **dict.fromkeys(((p, Begin) for p in (DutyPhase.OFF, DutyPhase.FINISHED, DutyPhase.GONE)), begin),
        (DutyPhase.OFF, SwitchedOn): on_sight.switched_on,
        (DutyPhase.FINISHED, ChangeEnds): change_ends,
        (DutyPhase.FINISHED, Leave): leave,
        (DutyPhase.OFF, OffTheLine): on_sight.booted_off_the_line,
        (DutyPhase.LEAVING, OffTheLine): off_the_line,
        **dict.fromkeys(((p, SetBack) for p in _MAY_SET_BACK), orders.set_back),
        **dict.fromkeys(
            ((p, SetBack) for p in _ON_THE_LINE if p not in _MAY_SET_BACK), orders.set_back_refused
        ),
        (DutyPhase.STANDING, TrackChangeOrdered): orders.change_track,
        (DutyPhase.STANDING, TrainEndOrdered): orders.end_train,
        (DutyPhase.STANDING, TakeUpWay): orders.take_up,
        (DutyPhase.STANDING, NoSuchWay): orders.no_such_way,
        (DutyPhase.STANDING, TakeBackOrdered): orders.take_back,
        **dict.fromkeys(
            (
                (p, ordered)
                for ordered in (TrackChangeOrdered, TrainEndOrdered)
                for p in _ON_THE_LINE
                if p is not DutyPhase.STANDING
            ),
            orders.no_other_track,
        ),
        **dict.fromkeys(
            ((p, TakeBackOrdered) for p in _ON_THE_LINE if p is not DutyPhase.STANDING),
            orders.nothing_to_take_back,
        ),
        (DutyPhase.ON_SIGHT, PointsSeen): on_sight.points_seen,
        (DutyPhase.ON_SIGHT, PointsWrong): on_sight.points_wrong,
        (DutyPhase.ON_SIGHT, AtMark): on_sight.at_mark,
        (DutyPhase.ON_SIGHT, EndOfHeld): on_sight.end_of_held,
        (DutyPhase.RUNNING, AtMark): on_sight.at_mark_unawares,
        **dict.fromkeys(((p, AtMark) for p in AT_A_MARK), confirm),
        **dict.fromkeys(
            ((p, NotAtMark) for p in (DutyPhase.STANDING, DutyPhase.FINISHED)), on_sight.not_at_mark
        ),
        (DutyPhase.SIGNING_OFF, NotAtMark): on_sight.not_in_its_portal,
        **dict.fromkeys(((p, TagBelieved) for p in _ON_THE_LINE), tag_passed),
        **dict.fromkeys(((p, TagReached) for p in _ON_THE_LINE), tag_reached),
        **dict.fromkeys(((p, FoundByOtherSensor) for p in _ON_THE_LINE), found),
        **dict.fromkeys(((p, PositionLost) for p in on_sight.MAY_LOSE), on_sight.lose),
        **dict.fromkeys(
            ((p, PositionLost) for p in _ON_THE_LINE if p not in on_sight.MAY_LOSE), on_sight.lose_elsewhere
        ),
        (DutyPhase.RUNNING, WheelsTurning): started,
        (DutyPhase.RUNNING, Stopped): stopped,
        **dict.fromkeys(
            ((p, Stopped) for p in _ON_THE_LINE if p is not DutyPhase.RUNNING), emergency_stopped
        ),
        **dict.fromkeys(((p, Looked) for p in _ON_THE_LINE), looked),
        **dict.fromkeys(((p, VehicleChecked) for p in _ON_THE_LINE), fitness.checked),
        **dict.fromkeys(((p, TimerDue) for p in _ON_THE_LINE), timer_due),
        **dict.fromkeys(((p, TelegramHeard) for p in DutyPhase), heard),
    }
)
