"""The state of the vehicle and its brakes in the duty (4.1.3 (2)).

Invariant: no train departs while its vehicle is not in order; one on its way is stopped by the emergency brake, and
that is not released before the vehicle is in order again, the train stands and its driver acknowledges.
"""

from __future__ import annotations

from typing import Final

from onboard import notes
from onboard.duty.records import Order, Phase, VehicleChecked
from onboard.duty.turn import Turn

ON_ITS_WAY: Final = (Phase.RUNNING, Phase.ON_SIGHT)


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
