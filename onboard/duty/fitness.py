"""What keeps a train from running: the state of its vehicle and brakes (4.1.3 (2)), and a way that it cannot manage.

Invariant: no train departs while its vehicle is not in order; one on its way is stopped by the emergency brake, and
that is not released before the vehicle is in order again, the train stands and its driver acknowledges. None departs
to a stop that by its unit's own prediction it cannot reach: it says why, and looks again by a timer. On sight its crew
decides that; all that is left then is that it does not move off with its pantograph up (`onboard.motion`).
"""

from __future__ import annotations

from typing import Final

from onboard import notes
from onboard.duty.records import Order, Phase, VehicleChecked
from onboard.duty.turn import Turn
from onboard.duty.unable import Unable

ON_ITS_WAY: Final = (Phase.RUNNING, Phase.ON_SIGHT)
LOOKS_AGAIN_S: Final = 10.0  # assumed: often enough for a load, motors or a charge that change


def checked(turn: Turn, _event: VehicleChecked) -> None:
    """Says what is wrong with the vehicle, or that nothing is any more; on its way the train is stopped at once."""
    unfit = turn.state.place.unfit
    if not unfit:
        turn.note(notes.VehicleFit())
        return
    turn.note(notes.VehicleUnfit(why=unfit))
    if turn.state.phase in ON_ITS_WAY:
        turn.actions.append(Order.STOP)
        if turn.state.place.stands:
            turn.await_release()


def acknowledged(turn: Turn) -> bool:
    """Whether the driver may acknowledge an emergency stop; with a vehicle that is not in order, only later."""
    if turn.state.place.unfit:
        turn.await_release()
    return not turn.state.place.unfit


def unable_now(turn: Turn) -> Unable | None:
    """What keeps a train from reaching its next stop, whose time to get ready at its stop has come."""
    state = turn.state
    due = state.may_ask or state.may_leave
    ready = state.phase is Phase.STANDING and due and state.at + 1 < len(turn.plan.stops)
    return state.place.unable if ready else None


def examine(turn: Turn) -> None:
    """Says that the train is unable to leave, and why, or that it is able again; unable, it looks again by a timer."""
    before, why = turn.state.unable, unable_now(turn)
    if why == before:
        return
    turn.set(unable=why)
    station = turn.stop(turn.state.at).place
    if why is not None and type(why) is not type(before):
        turn.note(notes.UnableToLeave(station=station, why=why.words))
    if why is not None and before is None:
        turn.timer("able", LOOKS_AGAIN_S)
    if why is None and turn.state.phase is Phase.STANDING:
        turn.note(notes.AbleToLeave(station=station))


def look_again(turn: Turn) -> None:
    """The timer of a train that is unable to leave: its place shows what is so now, and it runs as long as needed."""
    if unable_now(turn) is not None:
        turn.timer("able", LOOKS_AGAIN_S)
