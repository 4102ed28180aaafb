"""Running on sight (非常運転): a unit that was switched on again or lost its position, until all is known again.

Invariant: without a position nothing is freed and nothing thrown but by the crew's eye; normal running begins again
only when a tag has told the position and the manager what is held (4.4 (3), table 3); where another sensor or the
driver's eye has told it, which do not tell tracks apart, only where that is what the manager has.
"""

from __future__ import annotations

from typing import Final

from msgspec.structs import replace

from network.model import SectionKind
from onboard import notes
from onboard.authority.records import (
    BeginOnLine,
    CheckedByCrew,
    FoundAt,
    GiveBack,
    RequestKind,
    TakenOff,
    Throw,
    Withdrawn,
)
from onboard.duty import records
from onboard.duty.arrival import beyond_gap, elsewhere
from onboard.duty.duty_step import DutyStep
from onboard.duty.entering import ask_leave


def switched_on(duty: DutyStep, event: records.SwitchedOn) -> None:
    """Forgets position and holdings, signs on with 'I do not know' (in its portal: with that), and runs on sight."""
    duty.set(phase=records.DutyPhase.ON_SIGHT, at=event.stands_at or 0, stands_at=event.stands_at)
    duty.note(notes.MissionBegun(train=duty.plan.number, direction=duty.plan.direction))
    duty.note(notes.UnitRestarted(epoch=event.epoch))
    if event.stands_at is None:
        duty.set(may_ask=True, may_leave=True)
    else:
        duty.schedule(duty.now_s, event.stands_at)
        duty.set(freed=behind_by_eye(duty, event.stands_at))
    if duty.state.place.stands:
        duty.await_release()
    # That it stands in a portal the crew can see; anywhere else only the manager knows what it holds.
    in_portal = event.stands_at == 0 and duty.plan.enters
    duty.authority(BeginOnLine((duty.plan.spans[0].section_id,) if in_portal else None))


def booted_off_the_line(duty: DutyStep, _event: records.OffTheLine) -> None:
    """Its power failed before it was told that its train had left: it holds nothing, and says so when it is asked."""
    duty.authority(TakenOff())


def lose(duty: DutyStep, _event: records.PositionLost) -> None:
    """Stops by the emergency brake, then runs on sight to a tag."""
    state = duty.state
    stands_at = state.at if state.phase is records.DutyPhase.STANDING else None
    duty.set(phase=records.DutyPhase.ON_SIGHT, stands_at=stands_at, unable=None)
    lose_elsewhere(duty, _event)


def lose_elsewhere(duty: DutyStep, _event: records.PositionLost) -> None:
    """Keeps its phase; the emergency stop is acknowledged after a time. Throws still open are given up, and what
    waited for the radio is tried: no place tells any more where it reaches.
    """
    under_way = {command.needed.section_id for command in duty.state.authority.commands}
    if under_way:  # the front may be anywhere, so on them too
        duty.authority(Withdrawn(tuple(sorted(under_way))))
    duty.say_what_waits()
    if duty.state.place.stands:
        duty.await_release()


def not_at_mark(duty: DutyStep, _event: records.NotAtMark) -> None:
    """Its position is wrong: goes on on sight, to the mark by the driver's eye."""
    give_up_position(duty)
    duty.set(at=max(duty.state.at - 1, 0), stands_at=None, may_leave=True)


def not_in_its_portal(duty: DutyStep, event: records.NotAtMark) -> None:
    """Signing off, it stands short of its mark: goes on on sight, unless the manager has been asked already."""
    if duty.state.authority.open(RequestKind.SIGN_OFF) is None:
        not_at_mark(duty, event)


def give_up_position(duty: DutyStep) -> None:
    """The position is of no use where the train stands: goes on on sight from here."""
    duty.actions.append(records.DrivingOrder.LOSE)
    duty.set(place=replace(duty.state.place, known=False, covered=True, emergency=True))
    lose(duty, records.PositionLost())


def points_seen(duty: DutyStep, event: records.PointsSeen) -> None:
    """Counts the points as proven; before those that it may not come into yet, it asks for leave."""
    if event.under or not ask_leave(duty, (event.points,)):
        duty.authority(CheckedByCrew(event.points))


def points_wrong(duty: DutyStep, event: records.PointsWrong) -> None:
    """Commands the points, if it holds their section; asks for leave where it has none."""
    if not ask_leave(duty, (event.points,)):
        duty.authority(Throw((event.points,)))


def at_mark(duty: DutyStep, event: records.AtMark) -> None:
    """Has arrived by the crew's eye, with its whole train (到着確認): what is surely behind is given back."""
    duty.set(stands_at=event.stop, at=event.stop)
    duty.schedule(duty.now_s + duty.dwell_s(event.stop), event.stop)
    stop = duty.stop(event.stop)
    duty.note(notes.Arrived(station=stop.place, error_m=None))
    duty.give_back_behind(stop.clear)
    give_back_elsewhere(duty)


def give_back_elsewhere(duty: DutyStep) -> None:
    """Its crew sees the whole train at a mark, so that it lies nowhere off its path."""
    if off_path := elsewhere(duty):
        duty.authority(GiveBack(off_path))


def end_of_held(duty: DutyStep, event: records.EndOfHeld) -> None:
    """Asks for the route that leads on from where its driver sees the train stand; what it holds beyond a gap is
    given back.
    """
    sections = [span.section_id for span in duty.plan.spans]
    if useless := beyond_gap(sections, duty.state.authority.held, event.span):
        duty.authority(GiveBack(useless))
    duty.ask(duty.plan.leg_at(event.span), event.span)


def at_mark_unawares(duty: DutyStep, event: records.AtMark) -> None:
    """Its position is wrong: it has arrived by the driver's eye, and goes on on sight from there."""
    give_up_position(duty)
    at_mark(duty, event)


def recovered(duty: DutyStep) -> bool:
    """On sight: whether normal running goes on, a tag having told the position and the manager the holdings."""
    state = duty.state
    on_line = state.authority.on_line
    if state.place.known and on_line and contradicts_register(duty):
        give_up_position(duty)
        return False
    if state.place.known and on_line and (found := found_elsewhere(duty)):
        duty.authority(FoundAt(found))
        return False
    if state.place.known and on_line:
        resume(duty)
        return True
    claim_place(duty)
    if state.stands_at is not None and on_line:
        duty.give_back_behind(min(state.freed, duty.stop(state.stands_at).clear))
        give_back_elsewhere(duty)
    if state.stands_at is not None and state.stands_at == len(duty.plan.stops) - 1:
        if on_line:
            duty.set(phase=records.DutyPhase.FINISHED)
            duty.actions.append(records.Finished(duty.plan.number))
        return False
    if state.stands_at is not None and on_line:
        duty.ask(duty.plan.leg_at(duty.stop(state.stands_at).span))
    return False


def seek_radio(duty: DutyStep) -> None:
    """A train halted where no radio reaches would never hear that it may go on: it runs on sight, no further than the
    end of the section that it stands in, until it hears something.
    """
    state = duty.state
    if state.phase is records.DutyPhase.ON_SIGHT:
        return  # by what it hears
    on_its_way = state.halted and state.phase in MAY_LOSE and state.place.known
    seeks = on_its_way and (state.seeks_radio or (state.place.stands and not state.place.covered))
    if seeks is not state.seeks_radio:
        duty.set(seeks_radio=seeks)


def heard(duty: DutyStep) -> None:
    """The radio reaches it, wherever it thinks that it is: what waits for that can be said."""
    if not duty.state.place.covered:
        duty.set(place=replace(duty.state.place, covered=True))
    if duty.state.seeks_radio and duty.state.phase is records.DutyPhase.ON_SIGHT:
        duty.await_release()  # so that it listens again
    if duty.state.seeks_radio or duty.state.listens:
        duty.set(seeks_radio=False, listens=False)


def hears_nothing(duty: DutyStep) -> bool:
    """Whether a train halted on sight, whose driver may acknowledge its stop, has heard nothing since it was asked
    last: no place tells it where the radio reaches. It goes on to there, by its crew's eye within the section.
    """
    if duty.state.phase is records.DutyPhase.ON_SIGHT:
        duty.set(seeks_radio=duty.state.listens, listens=not duty.state.listens)
    return duty.state.seeks_radio


def behind_by_eye(duty: DutyStep, stop: int) -> int:
    """Spans that are surely behind a train of which its crew says, as it switches its unit on, that it stands there."""
    return duty.stop(stop).clear


def contradicts_register(duty: DutyStep) -> bool:
    """Found by what does not tell tracks apart, it may stand where the register does not have it: on another track."""
    place = duty.state.place
    under = duty.plan.spans[place.clear : place.perhaps]
    return place.untold and not all(duty.state.authority.holds(span.section_id) for span in under)


def found_elsewhere(duty: DutyStep) -> tuple[str, ...]:
    """Where the train may be, if its front is surely in a section that it does not hold; else nothing."""
    place, spans = duty.state.place, duty.plan.spans
    surely = spans[place.sure - 1 : place.sure] if place.sure else ()
    if all(duty.state.authority.holds(span.section_id) for span in surely):
        return ()
    return tuple(span.section_id for span in spans[place.clear : place.perhaps])


def claim_place(duty: DutyStep) -> None:
    """Claims where it may stand, a tag having told that: the manager has said that it does not know either."""
    state, place = duty.state, duty.state.place
    request = state.authority.open(RequestKind.SIGN_ON)
    if place.known and request is not None and request.section_ids is None and request.refusal:
        under = duty.plan.spans[place.clear : place.perhaps]
        duty.authority(BeginOnLine(tuple(span.section_id for span in under)))


def resume(duty: DutyStep) -> None:
    """Everything is known again: which stop comes next follows from the position."""
    plan, state = duty.plan, duty.state
    place, last = state.place, len(plan.stops) - 1
    at = max(state.at, place.passed)
    # Beyond the last mark there is nowhere further to go: it counts as arrived, as far as it went.
    stands = place.stands and at in (place.near, last)
    if not stands:  # beyond the last mark, that one is still to be reached
        at = min(at, last - 1)
    ahead = [s for s in plan.spans[place.here + 1 :] if state.authority.holds(s.section_id)]
    between = next((i for i, s in enumerate(ahead) if s.kind is SectionKind.BETWEEN), len(ahead))
    # It was running on proofs when it lost its memory: those under the train have done their work.
    behind = frozenset(span.section_id for span in plan.spans[: place.sure])
    if stands and state.stands_at != at:
        duty.schedule(duty.now_s, at)
    duty.set(
        at=at,
        stands_at=None,
        phase=records.DutyPhase.STANDING if stands else records.DutyPhase.RUNNING,
        entered=state.entered | behind,
        sweeps=bool(state.authority.unswept),  # on sight already, it need not stop before what must be swept
    )
    duty.want(tuple(needed for span in ahead[: between + 1] for needed in span.points))
    duty.note(notes.Resumed(next_target=at + 1))
    if stands and at > 0 and state.stands_at != at:  # it came here while it did not know
        duty.note(notes.Arrived(station=duty.stop(at).place, error_m=None))
    duty.actions.append(records.DrivingOrder.RESUME)


MAY_LOSE: Final = (records.DutyPhase.STANDING, records.DutyPhase.RUNNING)
