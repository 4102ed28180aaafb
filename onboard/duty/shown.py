"""What a state of the duty means to the driving part and to the driver: the command, and what the train waits for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Final

from onboard.authority.records import RequestKind
from onboard.duty.entering import kept_until_stand
from onboard.duty.records import AT_A_MARK, DrivingCommand, DutyPhase, DutyState
from onboard.duty.stop_limit import cleared_sections, next_rear_span
from onboard.plan import DutyPlan

_IDLE: Final[Mapping[DutyPhase, str]] = MappingProxyType(
    {
        DutyPhase.OFF: "its next train",
        DutyPhase.STANDING: "departure time",
        DutyPhase.FINISHED: "its next train",
        DutyPhase.LEAVING: "its train to leave the line",
        DutyPhase.GONE: "its next train",
    }
)
_ASKS: Final = MappingProxyType(
    {RequestKind.SIGN_ON: "signing on", RequestKind.SIGN_OFF: "signing off", RequestKind.ROUTE: "route"}
)


def command_of(plan: DutyPlan, state: DutyState) -> DrivingCommand:
    """What the driving part is to do in a state."""
    on_sight_now = state.phase is DutyPhase.ON_SIGHT
    running = state.phase is DutyPhase.RUNNING
    at_end = state.stands_at == len(plan.stops) - 1
    freed = min(state.freed, kept_until_stand(plan, state))
    may_run = state.released and not at_end and (state.stands_at is None or state.may_leave)
    return DrivingCommand(
        drive=(running or (on_sight_now and may_run)) and not state.must_stand,
        on_sight=on_sight_now,
        at_mark=state.phase is DutyPhase.STANDING,
        target=state.at + 1 if running and state.at + 1 < len(plan.stops) else None,
        at=state.at,
        stands_at=state.stands_at,
        limit=state.limit,
        rear=None if on_sight_now else next_rear_span(plan, state.authority, freed),
        await_radio=state.authority.waits_for_radio,
        on_line=state.authority.on_line,
        held=state.authority.held,
        proven=state.authority.proven,
        waits_for=waits_for(plan, state),
        sweeps=state.sweeps or state.seeks_radio,
        within_section=on_sight_now and state.seeks_radio,
        confirm=to_confirm(plan, state),
        unable=state.unable,
    )


def to_confirm(plan: DutyPlan, state: DutyState) -> bool:
    """Whether only the driver's eye can tell where a train at a mark stands, or that what it holds is behind it."""
    if state.phase in AT_A_MARK and state.place.unsure:
        return True
    stands = state.phase in AT_A_MARK and state.authority.open(RequestKind.REPORT) is None
    return stands and bool(cleared_sections(plan, state.authority, plan.stops[state.at].clear))


def waits_for(plan: DutyPlan, state: DutyState) -> str:
    """What the train waits for, in words, for whoever looks on when nothing moves."""
    return next(_reasons(plan, state))


def _brakes(state: DutyState) -> Iterator[str]:
    """What holds a train whose vehicle is in order and whose route is free."""
    if state.place.crossing:
        yield f"level crossing {state.place.crossing} to be proved closed"
    if state.place.emergency:
        yield "release of the emergency brake"


def _reasons(plan: DutyPlan, state: DutyState) -> Iterator[str]:
    authority = state.authority
    if authority.mismatch:
        yield f"agreement with the block manager: {authority.mismatch}"
    for ask, what in _ASKS.items():
        request = authority.open(ask)
        if request is not None:
            yield (
                f"{what} {request.subject}".rstrip()
                + f": {request.refusal or 'no answer from the block manager'}"
            )
    for command in authority.commands:
        yield f"points {command.needed.points_id}: {command.refusal or 'not proven'}"
    if state.place.unfit:
        yield f"vehicle: {state.place.unfit}"
    yield from _brakes(state)
    if state.unable is not None:
        yield f"what takes it to {plan.stops[state.at + 1].place}: {state.unable.words}"
    if state.phase in AT_A_MARK and state.place.unsure:
        yield "the driver's word that it stands at its mark: its bounds leave that open"
    if to_confirm(plan, state):
        yield "the driver's confirmation that the whole train has arrived"
    if authority.open(RequestKind.REPORT) is not None and state.place.stands:
        yield "the block manager's confirmation of what is held"
    held_back = state.phase is DutyPhase.STANDING and state.may_leave
    if (state.phase is DutyPhase.RUNNING or held_back) and not state.may_ask:
        yield "the end of the hold on its route"
    ahead = min(state.at + 1, len(plan.stops) - 1)
    may_go_on = state.limit.before is None or state.limit.joint >= state.place.reach
    if state.phase is DutyPhase.RUNNING and (may_go_on or not state.place.stands):
        yield f"its run to {plan.stops[ahead].place}"
    yield _IDLE.get(
        state.phase, "nothing" if state.place.known else "a tag or another fix: its position is unknown"
    )
