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
    Ask,
    BeginOnLine,
    Due,
    EndOnLine,
    GiveBack,
    TakenOff,
    Throw,
    TurnedBack,
    Withdrawn,
)
from onboard.authority.stop_limit import (
    NOT_PROVEN,
    entered_on_proof,
    points_perhaps_under,
    stop_limit,
)
from onboard.duty import fitness, on_sight
from onboard.duty.arrival import clear_behind, confirm
from onboard.duty.plan import Plan, Span, Tag
from onboard.duty.records import (
    ABLE,
    ASK,
    LEAVE,
    RELEASE,
    Accepted,
    AtMark,
    Begin,
    ChangeEnds,
    DutyState,
    EndOfHeld,
    Event,
    Finished,
    Found,
    Heard,
    How,
    Leave,
    LeftLine,
    Looked,
    NotAtMark,
    OffTheLine,
    Order,
    Phase,
    Place,
    PointsSeen,
    PointsWrong,
    PositionLost,
    SetBack,
    Started,
    Stopped,
    SwitchedOn,
    TagPassed,
    TagReached,
    TimerDue,
    VehicleChecked,
)
from onboard.duty.shown import AT_A_MARK, to_confirm
from onboard.duty.turn import Action, DutyParameters, Turn
from radio.table import Row, rows

Handler = Callable[[Turn, Any], None]


def step(
    plan: Plan, parameters: DutyParameters, state: DutyState, event: Event, place: Place, now_s: float
) -> tuple[DutyState, tuple[Action, ...]]:
    """Next state and what to do. An event that does not fit the phase changes nothing but what is due anyway."""
    turn = Turn(plan, parameters, now_s, state if state.place == place else replace(state, place=place))
    handler = TABLE.get((state.phase, type(event)))
    if handler is not None:
        handler(turn, event)
    settle(turn)
    return turn.state, tuple(turn.actions)


# what people do -------------------------------------------------------------------------------------------------


def begin(turn: Turn, event: Begin) -> None:
    """Takes up the train where its stock stands; stock that comes onto the line signs on first."""
    plan = event.plan
    fresh = DutyState(place=turn.state.place, authority=turn.state.authority, released=turn.state.released)
    turn.state = fresh
    turn.note(notes.MissionBegun(train=plan.number, direction=plan.direction))
    turn.schedule(turn.now_s, 0)
    if turn.state.place.emergency:
        turn.await_release()
    if event.signs_on:
        turn.set(phase=Phase.SIGNING_ON)
        turn.authority(BeginOnLine((plan.spans[0].section_id,), plan.enters))
    elif turn.state.place.known:
        turn.set(phase=Phase.STANDING)
    else:
        turn.set(phase=Phase.ON_SIGHT, stands_at=0)


def change_ends(turn: Turn, _event: ChangeEnds) -> None:
    """What was behind is ahead; the next train number follows."""
    turn.authority(TurnedBack())
    turn.note(notes.ChangedEnds())


def leave(turn: Turn, _event: Leave) -> None:
    """Signs off at the portal."""
    turn.set(phase=Phase.SIGNING_OFF)
    turn.authority(EndOnLine())


def off_the_line(turn: Turn, _event: OffTheLine) -> None:
    """Has left: holds nothing any more, and says so when it is asked."""
    turn.set(phase=Phase.GONE)
    turn.authority(TakenOff())


def set_back(turn: Turn, event: SetBack) -> None:
    """Standing surely short of it, gives the route ahead back and asks for none for a while."""
    state, plan = turn.state, turn.plan
    own, place = plan.stops[state.at].span, state.place
    if not place.known or not place.stands:
        turn.note(notes.GiveBackDenied(why="the train does not stand at a known place"))
        return
    if state.phase is Phase.STANDING and place.perhaps > own + 1:
        turn.note(notes.GiveBackDenied(why="the train may have entered the route"))
        return
    ahead = tuple(s.section_id for s in plan.spans[place.perhaps :] if state.authority.holds(s.section_id))
    if state.phase is Phase.STANDING:
        turn.schedule(turn.now_s + event.hold_s + turn.parameters.request_lead_s, state.at)
    else:
        turn.set(may_ask=turn.timer("ask", event.hold_s))
    turn.set(wanted=())
    turn.note(notes.GaveBack(section_ids=ahead))
    turn.authority(GiveBack(ahead))


def set_back_refused(turn: Turn, _event: SetBack) -> None:
    """Refused: only a train that stands, and knows where, can set back its route."""
    turn.note(notes.GiveBackDenied(why="the train does not stand at a known place"))


# what localisation and driving report ------------------------------------------------------------------------------


def tag_passed(turn: Turn, event: TagPassed) -> None:
    """At the arrival tag (①) gives back what it proves to be behind; at ④, or the next, throws the arrival points."""
    if event.found:
        turn.note(notes.PositionFound())
    passed = turn.plan.tags[: event.tag + 1]
    proved = max(turn.state.proved, passed[-1].clear)
    turn.set(proved=proved)
    if passed[-1].purpose is TagPurpose.ARRIVAL:
        turn.set(freed=proved)
    look_ahead(turn, passed)


def tag_reached(turn: Turn, event: TagReached) -> None:
    """Throws and asks for what lies ahead as at the tag; gives nothing back, since no fix proves that it is passed."""
    look_ahead(turn, turn.plan.tags[: event.tag + 1])


def found(turn: Turn, _event: Found) -> None:
    """Another sensor, or the driver's eye, has told the position: as for one that a tag has told."""
    turn.note(notes.PositionFound())


def look_ahead(turn: Turn, passed: tuple[Tag, ...]) -> None:
    """What a train that has come to the last of these tags wants of what lies ahead."""
    plan = turn.plan
    last = max((i for i, tag in enumerate(passed) if tag.purpose is TagPurpose.APPROACH), default=None)
    if last is not None and not any(tag.purpose is TagPurpose.ARRIVAL for tag in passed[last:]):
        turn.want(plan.arrival_points(passed[last]))
        ask_beyond(turn, plan.track_ahead(passed[last]))  # not beyond a track that this tag stands in
    elif passed[-1].purpose is TagPurpose.POSITION:
        ask_beyond(turn, plan.track_behind_joint(passed[-1]))


def ask_beyond(turn: Turn, track: Span | None) -> None:
    """A train that runs through a track asks for the route beyond it before it comes there."""
    if track is not None and not turn.plan.calls_at(track.section_id):
        turn.ask(turn.plan.leg_beyond(track.section_id))


def started(turn: Turn, _event: Started) -> None:
    """Notes that the wheels turn."""
    turn.note(notes.Moving())


def stopped(turn: Turn, event: Stopped) -> None:
    """At or beyond its mark it has arrived; short of it, it asks for what it lacks to go on."""
    emergency_stopped(turn, event)
    state, plan = turn.state, turn.plan
    if event.how is How.SHORT:
        turn.note(notes.StoppedShort(short_m=round(-event.away_m, 2), why=state.limit.why))
        turn.ask(plan.leg_at(state.place.here))
        return
    if event.how is How.BEYOND:  # no train sets back here: it counts as arrived, as far as it went
        turn.note(notes.Overran(beyond_m=round(event.away_m, 2)))
    turn.set(at=state.at + 1, phase=Phase.STANDING)
    turn.schedule(turn.now_s + turn.dwell_s(state.at + 1), state.at + 1)
    turn.note(notes.Arrived(station=turn.stop(state.at + 1).place, error_m=round(event.away_m, 3)))


def emergency_stopped(turn: Turn, _event: Stopped) -> None:
    """After an emergency stop the driver's acknowledgement is awaited."""
    if turn.state.place.emergency:
        turn.await_release()


def looked(turn: Turn, _event: Looked) -> None:
    """Sends what is due where the radio reaches again, frees what the safe rear has left."""
    if turn.state.authority.waits_for_radio:
        turn.authority(Due(None))


# time and radio ----------------------------------------------------------------------------------------------------


def timer_due(turn: Turn, event: TimerDue) -> None:
    """A route may be asked for, the train may leave or sees whether it can, an emergency stop is acknowledged, or a
    request is due again.
    """
    match event.timer:
        case timer if timer == ASK:
            turn.set(may_ask=True)
        case timer if timer == LEAVE:
            turn.set(may_leave=True)
        case timer if timer == ABLE:
            fitness.look_again(turn)
        case timer if timer == RELEASE and turn.state.halted:
            turn.await_release()  # not before register and unit agree
        case timer if timer == RELEASE and not fitness.acknowledged(turn):
            pass
        case timer if timer == RELEASE:
            place = msgspec.structs.replace(turn.state.place, emergency=False)
            turn.set(released=True, place=place)
            turn.note(notes.EmergencyReleased())
            turn.actions.append(Order.RELEASE)
        case timer:
            turn.authority(Due(timer))


def heard(turn: Turn, event: Heard) -> None:
    """As the tables of the authority say; with a route granted, its departure points are to be thrown."""
    asked = turn.state.authority.open(Ask.ROUTE)
    remember_entered(turn)
    turn.authority(event.event)
    leg = next((x for x in turn.plan.legs if asked is not None and x.route_id == asked.subject), None)
    if leg is not None and turn.state.authority.open(Ask.ROUTE) is None:
        turn.want(turn.plan.departure_points(leg.from_section))


# what follows from the state as it is ------------------------------------------------------------------------------


def settle(turn: Turn) -> None:
    """What follows from the state as it is now, whatever has led to it."""
    phase = turn.state.phase
    if phase in (Phase.OFF, Phase.LEAVING, Phase.GONE):
        return
    react(turn)
    if phase is Phase.SIGNING_ON and turn.state.authority.on_line:
        if turn.state.place.known:
            turn.set(phase=Phase.STANDING)
        else:  # lost while it signed on: only a tag can tell it again
            turn.set(phase=Phase.ON_SIGHT, stands_at=turn.state.at)
        turn.actions.append(Accepted(turn.plan.number))
        phase = turn.state.phase
    if phase is Phase.SIGNING_OFF and not turn.state.authority.on_line:
        turn.set(phase=Phase.LEAVING)
        turn.actions.append(LeftLine(turn.plan.number))
        return
    if phase is Phase.SIGNING_OFF and turn.state.authority.open(Ask.SIGN_OFF) is None:
        turn.authority(EndOnLine())  # once nothing but the portal is held
    if phase is Phase.ON_SIGHT and not on_sight.recovered(turn):
        react(turn)
        return
    if turn.state.place.known and turn.state.phase in _BY_POSITION:
        clear_behind(turn)
        remember_entered(turn)
        withdraw_throws(turn)
        throw_wanted(turn)
    begin_or_end_sweep(turn)
    set_limit(turn)
    fitness.examine(turn)
    if turn.state.phase is Phase.STANDING:
        stand(turn)
    elif turn.state.phase is Phase.RUNNING and turn.state.place.stands:
        held_up(turn)


def react(turn: Turn) -> None:
    """Register and unit contradict each other: stops by the emergency brake (section 5); once they agree, goes on."""
    mismatch = bool(turn.state.authority.mismatch)
    if mismatch is turn.state.halted:
        return
    turn.set(halted=mismatch)
    if mismatch:
        turn.actions.append(Order.STOP)
        turn.set(place=msgspec.structs.replace(turn.state.place, emergency=True))
        if turn.state.place.stands:
            turn.await_release()


def begin_or_end_sweep(turn: Turn) -> None:
    """From a stand the train goes on on sight through what must be swept, until its front has left all of it.

    The rest it goes as any other: what lies behind its front it has run through, though it gives it back later.
    """
    state = turn.state
    left = {span.section_id for span in turn.plan.spans[: front_has_left(state)]}
    to_sweep = any(section_id not in left for section_id in state.authority.unswept)
    sweeps = to_sweep and (state.sweeps or state.place.stands)
    if sweeps is not state.sweeps:
        turn.set(sweeps=sweeps)


def front_has_left(state: DutyState) -> int:
    """How many spans of the plan, from its beginning, the front has surely left."""
    return max(state.place.sure - 1, 0) if state.place.known else 0


def held_up(turn: Turn) -> None:
    """Stands short of its mark: asks for the way ahead; where it may stand upon points unproven, goes on on sight."""
    state = turn.state
    limit, place = state.limit, state.place
    if not place.known or limit.before is None:
        return
    if state.may_ask:
        turn.ask(turn.plan.leg_at(place.here))
    if limit.why == NOT_PROVEN and place.perhaps > limit.joint:
        on_sight.give_up_position(turn)
    elif limit.why == NOT_PROVEN and not state.halted:
        turn.want(turn.plan.spans[limit.joint].points)
        throw_wanted(turn)


def remember_entered(turn: Turn) -> None:
    """Points that the train has come onto by their proof, before anything can withdraw it."""
    state = turn.state
    if state.place.known:
        entered = entered_on_proof(turn.plan, state.authority, state.place.sure)
        if not entered <= state.entered:
            turn.set(entered=state.entered | entered)


def withdraw_throws(turn: Turn) -> None:
    """No points are asked to move once the front may have come onto them."""
    sections = points_perhaps_under(turn.plan, turn.state.authority, turn.state.place.perhaps)
    if sections:
        turn.authority(Withdrawn(tuple(sorted(sections))))


def throw_wanted(turn: Turn) -> None:
    """Command what is wanted and neither proven nor under way: anew, too, when a proof was withdrawn."""
    state = turn.state
    if not state.wanted:
        return
    ahead = {span.section_id for span in turn.plan.spans[state.place.perhaps :]}
    wanted = tuple(needed for needed in state.wanted if needed.section_id in ahead)
    if wanted != state.wanted:
        turn.set(wanted=wanted)
    under_way = {*state.authority.proven, *(command.needed for command in state.authority.commands)}
    missing = tuple(needed for needed in wanted if needed not in under_way)
    if missing:
        turn.authority(Throw(missing))


def set_limit(turn: Turn) -> None:
    """The stop limit by what is held and proven."""
    state = turn.state
    limit = stop_limit(
        turn.plan, state.authority, state.entered, sweeps=state.sweeps, left=front_has_left(state)
    )
    if limit == state.limit:
        return
    turn.set(limit=limit)
    piece, kilometrage_m = turn.plan.joint(limit.joint)
    turn.note(
        notes.LimitSet(
            kilometrage_m=round(kilometrage_m, 1), piece_id=piece, before=limit.before, why=limit.why
        )
    )


def stand(turn: Turn) -> None:
    """At a stop: ask for the next route in time, leave when the time has come and the way is free."""
    state = turn.state
    if state.at + 1 >= len(turn.plan.stops):
        if state.authority.open(Ask.REPORT) is None and not to_confirm(turn.plan, state):
            turn.set(phase=Phase.FINISHED)
            turn.actions.append(Finished(turn.plan.number))
        return
    if state.may_ask and state.unable is None:  # it would hold what it cannot use
        turn.ask(turn.plan.leg_at(turn.stop(state.at).span))
        throw_departure(turn)
    perhaps_upon = turn.state.limit.why == NOT_PROVEN and state.place.perhaps > turn.state.limit.joint
    if state.may_leave and perhaps_upon and not state.halted:
        on_sight.give_up_position(turn)  # it would wait for points that nobody throws under it
    elif state.may_leave and state.unable is None and way_is_free(turn):
        turn.set(phase=Phase.RUNNING)
        turn.note(notes.Departs(station=turn.stop(state.at).place))
        turn.actions.append(Order.DEPART)


def throw_departure(turn: Turn) -> None:
    """Who holds its whole route and was not granted it at this stop (the register gave it back after a boot before the
    portal) throws its departure points, for it asks for nothing.
    """
    state, leg = turn.state, turn.leg_from_stop(turn.state.at)
    if leg is None or state.limit.why != NOT_PROVEN or state.halted:
        return
    if state.authority.open(Ask.ROUTE) is None and all(map(state.authority.holds, leg.section_ids)):
        points = turn.plan.departure_points(leg.from_section)
        if not {*state.wanted, *state.authority.proven}.issuperset(points):
            turn.want(points)
            throw_wanted(turn)


def way_is_free(turn: Turn) -> bool:
    """The vehicle is in order and the stop limit beyond the train's track: no start towards points not proven."""
    limit, place = turn.state.limit, turn.state.place
    own = turn.stop(turn.state.at).span
    beyond = limit.joint > own + 1 or limit.before is None
    on_track = turn.leg_from_stop(turn.state.at) is not None
    way = limit.joint >= place.reach and (beyond or not on_track)
    return place.known and way and not place.unfit and not turn.state.halted


_BY_POSITION: Final = (*AT_A_MARK, Phase.RUNNING, Phase.SIGNING_ON)
_MAY_SET_BACK: Final = (Phase.STANDING, Phase.RUNNING)
_ON_THE_LINE: Final = (
    Phase.SIGNING_ON,
    Phase.STANDING,
    Phase.RUNNING,
    Phase.ON_SIGHT,
    Phase.FINISHED,
    Phase.SIGNING_OFF,
)

TABLE: Final[Mapping[tuple[Phase, type[Event]], Handler]] = MappingProxyType(
    {
        **dict.fromkeys(((p, Begin) for p in (Phase.OFF, Phase.FINISHED, Phase.GONE)), begin),
        (Phase.OFF, SwitchedOn): on_sight.switched_on,
        (Phase.FINISHED, ChangeEnds): change_ends,
        (Phase.FINISHED, Leave): leave,
        (Phase.LEAVING, OffTheLine): off_the_line,
        **dict.fromkeys(((p, SetBack) for p in _MAY_SET_BACK), set_back),
        **dict.fromkeys(((p, SetBack) for p in _ON_THE_LINE if p not in _MAY_SET_BACK), set_back_refused),
        (Phase.ON_SIGHT, PointsSeen): on_sight.points_seen,
        (Phase.ON_SIGHT, PointsWrong): on_sight.points_wrong,
        (Phase.ON_SIGHT, AtMark): on_sight.at_mark,
        (Phase.ON_SIGHT, EndOfHeld): on_sight.end_of_held,
        (Phase.RUNNING, AtMark): on_sight.at_mark_unawares,
        **dict.fromkeys(((p, AtMark) for p in AT_A_MARK), confirm),
        **dict.fromkeys(((p, NotAtMark) for p in (Phase.STANDING, Phase.FINISHED)), on_sight.not_at_mark),
        (Phase.SIGNING_OFF, NotAtMark): on_sight.not_in_its_portal,
        **dict.fromkeys(((p, TagPassed) for p in _ON_THE_LINE), tag_passed),
        **dict.fromkeys(((p, TagReached) for p in _ON_THE_LINE), tag_reached),
        **dict.fromkeys(((p, Found) for p in _ON_THE_LINE), found),
        **dict.fromkeys(((p, PositionLost) for p in on_sight.MAY_LOSE), on_sight.lose),
        **dict.fromkeys(
            ((p, PositionLost) for p in _ON_THE_LINE if p not in on_sight.MAY_LOSE), on_sight.lose_elsewhere
        ),
        (Phase.RUNNING, Started): started,
        (Phase.RUNNING, Stopped): stopped,
        **dict.fromkeys(((p, Stopped) for p in _ON_THE_LINE if p is not Phase.RUNNING), emergency_stopped),
        **dict.fromkeys(((p, Looked) for p in _ON_THE_LINE), looked),
        **dict.fromkeys(((p, VehicleChecked) for p in _ON_THE_LINE), fitness.checked),
        **dict.fromkeys(((p, TimerDue) for p in _ON_THE_LINE), timer_due),
        **dict.fromkeys(((p, Heard) for p in Phase), heard),
    }
)


def table_rows() -> tuple[Row, ...]:
    """The table as rows of text."""
    return rows(TABLE)
