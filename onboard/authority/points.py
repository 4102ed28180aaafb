"""Commanding points (進路構成機能, Sugiyama et al. 2017, table 1).

Invariant: points count as proven only while their section is held and by a proof for the position and token of the
unit's own command, or by the crew's eye; a proof that no longer holds is dropped at once.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from msgspec.structs import replace

from onboard import notes
from onboard.authority.records import (
    Action,
    Authority,
    CheckedByCrew,
    Commit,
    OpenCommand,
    PointsDenialHeard,
    ProofHeard,
    RequestKind,
    SetTimer,
    StopTimer,
    Throw,
    Withdrawn,
    Write,
)
from onboard.authority.tables import REFUSED_REPEAT_S, Result, SignOnStanding, Table, report_now
from onboard.plan import PointsNeeded


def throw(state: Authority, event: Throw) -> Result:
    """Commands points of sections held, with the capability of the grant, until they are proven."""
    under_way = {command.needed for command in state.commands} | set(state.proven)
    new = tuple(n for n in event.points if n.section_id in state.commandable and n not in under_way)
    commanded = replace(state, commands=(*state.commands, *(OpenCommand(needed) for needed in new)))
    return commanded, tuple(Commit(needed) for needed in new)


def checked_by_crew(state: Authority, event: CheckedByCrew) -> Result:
    """Counts these points as proven: the crew has seen how they lie."""
    needed = event.points
    if needed in state.proven:
        return state, ()
    return _proven(state, needed, by_crew=True)


def withdrawn(state: Authority, event: Withdrawn) -> Result:
    """Throws still open are given up: the front may have come onto those points."""
    gone = tuple(c for c in state.commands if c.needed.section_id in event.section_ids)
    kept = tuple(c for c in state.commands if c not in gone)
    unsaid = tuple(dict.fromkeys((*state.unsaid, *(c.needed for c in gone))))
    left = replace(state, commands=kept, unsaid=unsaid)
    return left, tuple(StopTimer(c.timer) for c in gone)


def proof(state: Authority, event: ProofHeard) -> Result:
    """Proven, if detected and locked as commanded, in answer to the command; a proof that no longer holds is dropped.

    A command whose proof is withdrawn is given anew, so that the terminal knows that this has been heard.
    """
    for needed in (*(c.needed for c in state.commands), *state.unsaid):
        if (needed.points_id, needed.terminal_id) != (event.points_id, event.terminal_id):
            continue
        if not event.mine:
            return state, ()
        if event.position != needed.position.value:
            return state, (Commit(needed),)
        return _proven(state, needed)
    return _lost(state, event)


def _proven(state: Authority, needed: PointsNeeded, *, by_crew: bool = False) -> Result:
    """They lie right: no command for them is open any more."""
    over = [c for c in state.commands if c.needed == needed]
    proven = replace(
        state,
        commands=tuple(c for c in state.commands if c not in over),
        unsaid=tuple(other for other in state.unsaid if other != needed),
        proven=(*state.proven, needed),
    )
    note = notes.Proven(points_id=needed.points_id, position=needed.position, token=0, by_crew=by_crew)
    return proven, (*(StopTimer(c.timer) for c in over), Write(note))


def _lost(state: Authority, event: ProofHeard) -> Result:
    shown = (event.points_id, event.terminal_id)
    lost = [n for n in state.proven if (n.points_id, n.terminal_id) == shown]
    if not lost or event.position == lost[0].position.value:
        return state, ()
    held = tuple(needed for needed in lost if state.holds(needed.section_id))
    kept = tuple(needed for needed in state.proven if needed not in lost)
    dropped = replace(state, proven=kept, unsaid=(*state.unsaid, *held))
    actions: tuple[Action, ...] = tuple(Commit(needed) for needed in held)
    return dropped, (*actions, Write(notes.ProofDropped(points_id=event.points_id)))


def denied(state: Authority, event: PointsDenialHeard) -> Result:
    """Commands again later; where its grant is not the newest one, it reports, so that the manager can say so."""
    commands: list[OpenCommand] = []
    actions: list[Action] = []
    for command in state.commands:
        needed = command.needed
        if (needed.points_id, needed.terminal_id) != (event.points_id, event.terminal_id) or not event.mine:
            commands.append(command)
            continue
        if command.refusal != event.why:
            actions.append(Write(notes.ThrowDenied(points_id=event.points_id, why=event.why)))
        commands.append(replace(command, sent=True, refusal=event.why))
        actions.append(SetTimer(command.timer, REFUSED_REPEAT_S))
    state = replace(state, commands=tuple(commands))
    if event.mine and event.stale and state.open(RequestKind.REPORT) is None:
        state, more = report_now(state)
        actions += more
    return state, tuple(actions)


TABLE: Final[Table] = MappingProxyType(
    {
        (SignOnStanding.ON_LINE, Throw): throw,
        (SignOnStanding.SIGNING_ON, CheckedByCrew): checked_by_crew,
        (SignOnStanding.ON_LINE, CheckedByCrew): checked_by_crew,
        (SignOnStanding.ON_LINE, Withdrawn): withdrawn,
        (SignOnStanding.SIGNING_ON, ProofHeard): proof,
        (SignOnStanding.ON_LINE, ProofHeard): proof,
        (SignOnStanding.ON_LINE, PointsDenialHeard): denied,
    }
)
