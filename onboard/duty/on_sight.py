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
from onboard.authority.records import Ask, BeginOnLine, CheckedByCrew, FoundAt, Throw, Withdrawn
from onboard.duty.records import (
    AtMark,
    EndOfHeld,
    Finished,
    NotAtMark,
    Order,
    Phase,
    PointsSeen,
    PointsWrong,
    PositionLost,
    SwitchedOn,
)
from onboard.duty.turn import Turn


def switched_on(turn: Turn, event: SwitchedOn) -> None:
    """Forgets position and holdings, signs on with 'I do not know' (in its portal: with that), and runs on sight."""
    turn.set(phase=Phase.ON_SIGHT, at=event.stands_at or 0, stands_at=event.stands_at)
    turn.note(notes.MissionBegun(train=turn.plan.number, direction=turn.plan.direction))
    turn.note(notes.UnitRestarted(epoch=event.epoch))
    if event.stands_at is None:
        turn.set(may_ask=True, may_leave=True)
    else:
        turn.schedule(turn.now_s, event.stands_at)
    if turn.state.place.stands:
        turn.await_release()
    # That it stands in a portal the crew can see; anywhere else only the manager knows what it holds.
    in_portal = event.stands_at == 0 and turn.plan.enters
    turn.authority(BeginOnLine((turn.plan.spans[0].section_id,) if in_portal else None))


def lose(turn: Turn, _event: PositionLost) -> None:
    """Stops by the emergency brake, then runs on sight to a tag."""
    state = turn.state
    stands_at = state.at if state.phase is Phase.STANDING else None
    turn.set(phase=Phase.ON_SIGHT, stands_at=stands_at, unable=None)
    lose_elsewhere(turn, _event)


def lose_elsewhere(turn: Turn, _event: PositionLost) -> None:
    """Keeps its phase; the emergency stop is acknowledged after a time. Throws still open are given up."""
    under_way = {command.needed.section_id for command in turn.state.authority.commands}
    if under_way:  # the front may be anywhere, so on them too
        turn.authority(Withdrawn(tuple(sorted(under_way))))
    if turn.state.place.stands:
        turn.await_release()


def not_at_mark(turn: Turn, _event: NotAtMark) -> None:
    """Its position is wrong: goes on on sight, to the mark by the driver's eye."""
    give_up_position(turn)
    turn.set(at=max(turn.state.at - 1, 0), stands_at=None, may_leave=True)


def not_in_its_portal(turn: Turn, event: NotAtMark) -> None:
    """Signing off, it stands short of its mark: goes on on sight, unless the manager has been asked already."""
    if turn.state.authority.open(Ask.SIGN_OFF) is None:
        not_at_mark(turn, event)


def give_up_position(turn: Turn) -> None:
    """The position is of no use where the train stands: goes on on sight from here."""
    turn.actions.append(Order.LOSE)
    turn.set(place=replace(turn.state.place, known=False, emergency=True))
    lose(turn, PositionLost())


def points_seen(turn: Turn, event: PointsSeen) -> None:
    """Counts the points as proven."""
    turn.authority(CheckedByCrew(event.points))


def points_wrong(turn: Turn, event: PointsWrong) -> None:
    """Commands the points, if it holds their section."""
    turn.authority(Throw((event.points,)))


def at_mark(turn: Turn, event: AtMark) -> None:
    """Has arrived by the crew's eye, with its whole train (到着確認): what is surely behind is given back."""
    turn.set(stands_at=event.stop, at=event.stop)
    turn.schedule(turn.now_s + turn.dwell_s(event.stop), event.stop)
    stop = turn.stop(event.stop)
    turn.note(notes.Arrived(station=stop.place, error_m=None))
    turn.give_back_behind(stop.clear)


def end_of_held(turn: Turn, event: EndOfHeld) -> None:
    """Asks for the route that leads on from where its driver sees the train stand."""
    turn.ask(turn.plan.leg_at(event.span))


def at_mark_unawares(turn: Turn, event: AtMark) -> None:
    """Its position is wrong: it has arrived by the driver's eye, and goes on on sight from there."""
    give_up_position(turn)
    at_mark(turn, event)


def recovered(turn: Turn) -> bool:
    """On sight: whether normal running goes on, a tag having told the position and the manager the holdings."""
    state = turn.state
    on_line = state.authority.on_line
    if state.place.known and on_line and contradicts_register(turn):
        give_up_position(turn)
        return False
    if state.place.known and on_line and (found := found_elsewhere(turn)):
        turn.authority(FoundAt(found))
        return False
    if state.place.known and on_line:
        resume(turn)
        return True
    claim_place(turn)
    if state.stands_at is not None and state.stands_at == len(turn.plan.stops) - 1:
        if on_line:
            turn.set(phase=Phase.FINISHED)
            turn.actions.append(Finished(turn.plan.number))
        return False
    if state.stands_at is not None and on_line:
        turn.ask(turn.plan.leg_at(turn.stop(state.stands_at).span))
    return False


def contradicts_register(turn: Turn) -> bool:
    """Found by what does not tell tracks apart, it may stand where the register does not have it: on another track."""
    place = turn.state.place
    under = turn.plan.spans[place.clear : place.perhaps]
    return place.untold and not all(turn.state.authority.holds(span.section_id) for span in under)


def found_elsewhere(turn: Turn) -> tuple[str, ...]:
    """Where the train may be, if its front is surely in a section that it does not hold; else nothing."""
    place, spans = turn.state.place, turn.plan.spans
    surely = spans[place.sure - 1 : place.sure] if place.sure else ()
    if all(turn.state.authority.holds(span.section_id) for span in surely):
        return ()
    return tuple(span.section_id for span in spans[place.clear : place.perhaps])


def claim_place(turn: Turn) -> None:
    """Claims where it may stand, a tag having told that: the manager has said that it does not know either."""
    state, place = turn.state, turn.state.place
    request = state.authority.open(Ask.SIGN_ON)
    if place.known and request is not None and request.section_ids is None and request.refusal:
        under = turn.plan.spans[place.clear : place.perhaps]
        turn.authority(BeginOnLine(tuple(span.section_id for span in under)))


def resume(turn: Turn) -> None:
    """Everything is known again: which stop comes next follows from the position."""
    plan, state = turn.plan, turn.state
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
        turn.schedule(turn.now_s, at)
    turn.set(
        at=at,
        stands_at=None,
        phase=Phase.STANDING if stands else Phase.RUNNING,
        entered=state.entered | behind,
        sweeps=bool(state.authority.unswept),  # on sight already, it need not stop before what must be swept
    )
    turn.want(tuple(needed for span in ahead[: between + 1] for needed in span.points))
    turn.note(notes.Resumed(next_target=at + 1))
    if stands and at > 0 and state.stands_at != at:  # it came here while it did not know
        turn.note(notes.Arrived(station=turn.stop(at).place, error_m=None))
    turn.actions.append(Order.RESUME)


MAY_LOSE: Final = (Phase.STANDING, Phase.RUNNING)
