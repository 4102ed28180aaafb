"""What keeps a train from running: the state of its vehicle and brakes (4.1.3 (2)), and a way that it cannot manage.

Invariant: no train departs while its vehicle is not in order; one on its way is stopped by the emergency brake, and
that is not released before the vehicle is in order again, the train stands and its driver acknowledges. None departs
to a stop that by its unit's own prediction it cannot reach: it says why, and looks again by a timer. On sight its crew
decides that; all that is left then is that it does not move off with its pantograph up (`onboard.motion`).
"""

from __future__ import annotations

from typing import Final

from onboard import notes
from onboard.duty.duty_step import DutyStep
from onboard.duty.records import DrivingOrder, DutyPhase, VehicleChecked
from onboard.duty.unable import NoCharge, Unable

ON_ITS_WAY: Final = (DutyPhase.RUNNING, DutyPhase.ON_SIGHT)
LOOKS_AGAIN_S: Final = 10.0  # assumed: often enough for a load, motors or a charge that change


def checked(duty: DutyStep, _event: VehicleChecked) -> None:
    """Says what is wrong with the vehicle, or that nothing is any more; on its way the train is stopped at once."""
    unfit = duty.state.place.unfit
    if not unfit:
        duty.note(notes.VehicleFit())
        return
    duty.note(notes.VehicleUnfit(why=unfit))
    if duty.state.phase in ON_ITS_WAY:
        duty.actions.append(DrivingOrder.STOP)
        if duty.state.place.stands:
            duty.await_release()


def acknowledged(duty: DutyStep) -> bool:
    """Whether the driver may acknowledge an emergency stop; with a vehicle that is not in order, only later."""
    if duty.state.place.unfit:
        duty.await_release()
    return not duty.state.place.unfit


def unable_now(duty: DutyStep) -> Unable | None:
    """What keeps a train from reaching its next stop, whose time to get ready at its stop has come."""
    state = duty.state
    due = state.may_ask or state.may_leave
    ready = state.phase is DutyPhase.STANDING and due and state.at + 1 < len(duty.plan.stops)
    why = state.place.unable if ready else None
    charges_on = _comes_down(why)
    return None if charges_on and not (state.may_leave and route_is_free(duty)) else why


def _comes_down(why: Unable | None) -> bool:
    """Whether a set has enough, and lowers its pantograph once its way is free: a part of its departure, no news."""
    return isinstance(why, NoCharge) and why.stays_up


def examine(duty: DutyStep) -> None:
    """Says that the train is unable to leave, and why, or that it is able again; unable, it looks again by a timer."""
    before, why = duty.state.unable, unable_now(duty)
    if why == before:
        return
    duty.set(unable=why)
    station = duty.stop(duty.state.at).place
    if why is not None and type(why) is not type(before) and not _comes_down(why):
        duty.note(notes.UnableToLeave(station=station, why=why.words))
    if why is not None and before is None:
        duty.timer("able", LOOKS_AGAIN_S)
    if why is None and duty.state.phase is DutyPhase.STANDING and not _comes_down(before):
        duty.note(notes.AbleToLeave(station=station))


def look_again(duty: DutyStep) -> None:
    """The timer of a train that is unable to leave: its place shows what is so now, and it runs as long as needed."""
    if unable_now(duty) is not None:
        duty.timer("able", LOOKS_AGAIN_S)


def way_is_free(duty: DutyStep) -> bool:
    """Its route is free, and no level crossing near by is without proof."""
    return route_is_free(duty) and not duty.state.place.crossing


def route_is_free(duty: DutyStep) -> bool:
    """The vehicle is in order and the stop limit beyond the train's track: no start towards points not proven."""
    limit, place = duty.state.limit, duty.state.place
    own = duty.stop(duty.state.at).span
    beyond = limit.joint > own + 1 or limit.before is None
    on_track = duty.leg_from_stop(duty.state.at) is not None
    way = limit.joint >= place.reach and (beyond or not on_track)
    return place.known and way and not place.unfit and not duty.state.must_stand
