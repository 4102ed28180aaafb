"""Giving sections back (閉そく解放): a full report of what is held, repeated until the register has the same.

Invariant: a section is dropped here before it is said, and only when the safe rear has left it or the train stands
surely short of it; a lost report heals with the next one, since each says all that is held.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from msgspec.structs import replace

from onboard.authority import tables
from onboard.authority.records import Action, Authority, Cleared, ConfirmationHeard, RequestKind, StopTimer


def cleared(state: Authority, event: Cleared) -> tables.Result:
    """Drops sections with their proofs and commands, then reports what is left until that is confirmed."""
    run_through = tuple(s for s in event.section_ids if s in state.unswept and state.holds(s))
    return dropped(replace(state, swept=(*state.swept, *run_through)), event.section_ids)


def dropped(state: Authority, section_ids: tuple[str, ...]) -> tables.Result:
    """Without these sections, and with a report that says so; the same where none of them is held."""
    kept = tuple(held for held in state.held if held not in section_ids)
    if kept == state.held:
        return state, ()
    gone = [c for c in state.commands if c.needed.section_id in section_ids]
    left = replace(
        state,
        held=kept,
        commandable=tuple(s for s in state.commandable if s in kept),
        proven=tuple(needed for needed in state.proven if needed.section_id not in section_ids),
        commands=tuple(c for c in state.commands if c not in gone),
        unsaid=tuple(needed for needed in state.unsaid if needed.section_id not in section_ids),
        unswept=tuple(s for s in state.unswept if s not in section_ids),
    )
    left, actions = tables.report_now(left)
    return left, (*(StopTimer(c.timer) for c in gone), *actions, tables.holds(left))


def confirmed(state: Authority, event: ConfirmationHeard) -> tables.Result:
    """To its last report: done if the register has the same, with nothing contested; a greater token is taken.

    If it has less, or some of it is contested, the train is stopped, and it is reported again. What must be passed on
    sight is as the manager says.
    """
    request = state.open(RequestKind.REPORT)
    if request is None or not event.answers:
        return state, ()
    actions: tuple[Action, ...] = ()
    state = replace(state, unswept=tuple(s for s in event.on_sight if state.holds(s)))
    contested, held = ", ".join(event.contested), set(state.held)
    if contested or not held <= set(event.section_ids):
        why = f"contested: {contested}" if contested else "the register has less"
        state, actions = tables.disagrees(state, why)
        state, more = tables.refused(state, request, why)
        actions = (*actions, *more)
    elif set(event.section_ids) == held:
        state, actions = tables.closed(state, RequestKind.REPORT)
        state, more = tables.agrees(replace(state, swept=()))
        actions = (*actions, *more)
    elif event.newer:  # refused for its token: the same report again under the newer one
        state = tables.changed(state, replace(request, sent=False))
    if not event.newer:
        return state, actions
    state, more = tables.take_newer(state)
    return state, (*actions, *more)


TABLE: Final[tables.Table] = MappingProxyType(
    {
        (tables.SignOnStanding.ON_LINE, Cleared): cleared,
        (tables.SignOnStanding.ON_LINE, ConfirmationHeard): confirmed,
        (tables.SignOnStanding.SIGNING_OFF, ConfirmationHeard): confirmed,
    }
)
