"""What can happen to a unit and its train besides telegrams: its crew, the train's movement, timers, its power.

The crew is truthful and takes any time. An emergency brake brings the train to a stand where it is: how far that takes
it is a matter of metres, not of this model.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from onboard.authority.records import Authority, RequestKind
from onboard.duty import records
from onboard.duty.arrival import beyond_gap
from onboard.duty.shown import command_of
from verify.explored_line import END, TERMINALS, UnwishedFor, mask_of
from verify.happening import Guard, GuardKind, Happening
from verify.on_air import InAir
from verify.thirds import PLACES_A_SPAN
from verify.train import ExploredTrain, TrainPlace, TrainState

TrainEvent = Happening[TrainState, InAir]
HOLD_S: Final = 60.0  # for which no route is asked for: a timer, which runs out when it likes


def events(model: ExploredTrain, state: TrainState) -> tuple[TrainEvent, ...]:
    """All that can happen next; what changes nothing and says nothing is left out."""
    if not state.power:
        return (TrainEvent("power is back", _booted(state)),)
    found = (
        *_people(model, state),
        *_movement(model, state),
        *_timers(model, state),
        *_troubles(model, state),
    )
    return tuple(e for e in found if e.state != state or e.sends)


def _took(model: ExploredTrain, state: TrainState, event: records.Event, name: str = "") -> TrainEvent:
    after, sends = model.take(state, event)
    return TrainEvent(name or type(event).__name__, after, sends)


def _command(model: ExploredTrain, state: TrainState) -> records.DrivingCommand:
    return command_of(model.plan(state), state.duty)


def _booted(state: TrainState) -> TrainState:
    """A new boot: only what the unit kept is left, that it may be on the line."""
    unsure = state.duty.authority.perhaps_on_line
    return TrainState(
        place=state.place,
        epoch=state.epoch + 1,
        duty=records.DutyState(authority=Authority(unsure=unsure)),
        plan=state.plan,
        spot=state.spot,
        known=state.place is TrainPlace.WAITING,
        emergency=state.place is TrainPlace.ON_LINE,
        tags_read=state.tags_read,
        keys=state.keys,
    )


def _people(model: ExploredTrain, state: TrainState) -> Iterator[TrainEvent]:
    phase, plan = state.duty.phase, model.plan(state)
    match state.place, phase:
        case TrainPlace.OUTSIDE, _:
            yield _took(
                model, state._replace(place=TrainPlace.WAITING), records.Begin(model.plans[0], signs_on=True)
            )
        case TrainPlace.WAITING, records.DutyPhase.OFF:
            yield _took(model, state, records.Begin(plan, signs_on=True))
        case TrainPlace.WAITING, _ if state.may_enter:
            yield TrainEvent("enters", state._replace(place=TrainPlace.ON_LINE, may_enter=False))
        case TrainPlace.ON_LINE, records.DutyPhase.OFF:
            stands_at = {0: 0, END: 1}.get(state.spot)
            yield _took(model, state, records.SwitchedOn(plan, stands_at))
        case TrainPlace.ON_LINE, records.DutyPhase.FINISHED if state.plan == 0 and state.spot == END:
            turned, sends = model.take(state, records.ChangeEnds())
            back = turned._replace(plan=1, spot=0, moves=False, tags_read=0)
            begun = _took(model, back, records.Begin(model.plans[1], signs_on=False), "ChangeEnds")
            yield begun._replace(sends=(*sends, *begun.sends))
        case TrainPlace.ON_LINE, records.DutyPhase.FINISHED if state.plan == 1 and state.spot == END:
            yield _took(model, state, records.Leave())
        case TrainPlace.ON_LINE, records.DutyPhase.LEAVING if state.may_leave:
            gone = state._replace(place=TrainPlace.GONE, may_leave=False)
            yield TrainEvent("passes the boundary", gone, left=True)
        case TrainPlace.GONE, records.DutyPhase.LEAVING | records.DutyPhase.OFF:
            yield _took(model, state, records.OffTheLine())
        case _:
            pass
    if state.place is TrainPlace.ON_LINE and not state.moves:
        yield from _eyes(model, state)


def _eyes(model: ExploredTrain, state: TrainState) -> Iterator[TrainEvent]:
    """What the crew of a train that stands sees and says."""
    command, duty, plan = _command(model, state), state.duty, model.plan(state)
    if command.confirm:
        at_mark = state.spot == plan.stops[duty.at].span * PLACES_A_SPAN
        yield _took(model, state, records.AtMark(duty.at) if at_mark else records.NotAtMark())
    if duty.phase is not records.DutyPhase.ON_SIGHT or state.known:
        return
    ahead = state.spot // PLACES_A_SPAN + 1
    if ahead < len(plan.spans):
        for needed in plan.spans[ahead].points:
            at = TERMINALS.index(needed.terminal_id)
            lies, wrong = (Guard(k, at, needed.position) for k in (GuardKind.LIES, GuardKind.LIES_NOT))
            if needed not in duty.authority.proven and duty.authority.holds(needed.section_id):
                seen = _took(model, state._replace(keys=state.keys | {at}), records.PointsSeen(needed))
                yield seen._replace(guard=lies, locks=(at,))
                yield _took(model, state, records.PointsWrong(needed))._replace(guard=wrong)
    if state.spot == END and duty.stands_at != 1:
        yield _took(model, state, records.AtMark(1))
    sections = [span.section_id for span in plan.spans]
    lacks = ahead < len(sections) and sections[ahead] not in duty.authority.held
    asks = duty.authority.open(RequestKind.ROUTE) is None and sections[-1] not in duty.authority.held
    if asks or (lacks and beyond_gap(sections, duty.authority.held, ahead - 1)):
        yield _took(model, state, records.EndOfHeld(state.spot // PLACES_A_SPAN))


def _may_go_on(model: ExploredTrain, state: TrainState) -> bool:
    """Whether the next joint is free: by the stop limit, or on sight within what is held, by the crew's eye."""
    plan, duty = model.plan(state), state.duty
    if state.spot == END:
        return False
    if state.spot % PLACES_A_SPAN == 2:
        return True
    joint = state.spot // PLACES_A_SPAN + 1
    if state.known and duty.phase is not records.DutyPhase.ON_SIGHT:
        return duty.limit.joint > joint
    span = plan.spans[joint]
    if duty.seeks_radio:
        return False
    return duty.authority.holds(span.section_id) and all(n in duty.authority.proven for n in span.points)


def _movement(model: ExploredTrain, state: TrainState) -> Iterator[TrainEvent]:
    if state.place is not TrainPlace.ON_LINE:
        return
    command, unread = _command(model, state), model.meets_tag(state)
    if not state.moves:
        short_of_mark = state.spot == END and state.duty.phase is records.DutyPhase.RUNNING
        if command.drive and not state.emergency and (_may_go_on(model, state) or short_of_mark or unread):
            yield _took(model, state._replace(moves=True), records.WheelsTurning())
        return
    if state.emergency:
        stood = state._replace(moves=False)
        yield _took(
            model,
            stood,
            records.Stopped(
                records.MarkRelation.AT if state.spot == END else records.MarkRelation.SHORT, -1.0
            ),
        )
    elif unread:
        read = records.TagBelieved(state.tags_read, found=not state.known)
        yield _took(model, state._replace(known=True, tags_read=state.tags_read + 1), read)
    else:
        yield from _runs(model, state, on_sight=command.on_sight or command.sweeps)


def _runs(model: ExploredTrain, state: TrainState, *, on_sight: bool) -> Iterator[TrainEvent]:
    plan, part = model.plan(state), state.spot % PLACES_A_SPAN
    go_on = _may_go_on(model, state)
    if go_on or (part == 0 and state.spot != END):  # the bounds may pass a joint that the front does not
        on = state._replace(spot=state.spot + 1)
        unlocks: tuple[int, ...] = ()
        if part == 2 and state.keys and "X" in plan.spans[state.spot // PLACES_A_SPAN].section_id:
            unlocks, on = tuple(sorted(state.keys)), on._replace(keys=frozenset())
        ran = _took(model, on, records.Looked())._replace(unlocks=unlocks)
        if part == 1 and on_sight:  # its driver stops before another train
            ahead = plan.spans[state.spot // PLACES_A_SPAN + 1].section_id
            ran = ran._replace(guard=Guard(GuardKind.FREE, mask_of((ahead,))))
        yield ran
    if not go_on:
        how = records.MarkRelation.AT if state.spot == END else records.MarkRelation.SHORT
        yield _took(model, state._replace(moves=False), records.Stopped(how, 0.0))


def _timers(model: ExploredTrain, state: TrainState) -> Iterator[TrainEvent]:
    for timer in sorted(state.timers):
        due = _took(model, state._replace(timers=state.timers - {timer}), records.TimerDue(timer))
        yield due._replace(name=f"timer {timer.name} {timer.of}".rstrip())


def _troubles(model: ExploredTrain, state: TrainState) -> Iterator[TrainEvent]:
    if state.place is not TrainPlace.OUTSIDE:
        off = _booted(state)._replace(power=False, epoch=state.epoch)
        yield TrainEvent("power fails", off, trouble=UnwishedFor.POWER)
    if state.place is not TrainPlace.ON_LINE:
        return
    if not state.moves and state.duty.phase in (records.DutyPhase.STANDING, records.DutyPhase.RUNNING):
        yield _took(model, state, records.SetBack(HOLD_S))._replace(trouble=UnwishedFor.SET_BACK)
    if state.known and state.duty.phase is not records.DutyPhase.OFF:
        lost = state._replace(known=False, emergency=True)
        yield _took(model, lost, records.PositionLost())._replace(trouble=UnwishedFor.SENSOR)
