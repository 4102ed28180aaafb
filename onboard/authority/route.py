"""Asking for routes (閉そく要求機能, Sugiyama et al. 2017, table 1).

Invariant: a route is asked for one at a time and held only by a grant to the request outstanding, to this boot, under
a token greater than any known before; then it is held whole, or its beginning, and the rest is asked for again.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from msgspec.structs import replace

from onboard import notes
from onboard.authority.records import (
    AskRoute,
    Authority,
    GiveBack,
    GrantHeard,
    OpenRequest,
    RefusalHeard,
    Renew,
    RequestKind,
    Take,
    Write,
)
from onboard.authority.report import dropped
from onboard.authority.tables import Result, SignOnStanding, Table, closed, holds, opened, refused, report_now


def ask(state: Authority, event: AskRoute) -> Result:
    """Requests the route, one at a time, with the same correlation until it is answered."""
    if state.open(RequestKind.ROUTE) is not None:
        return state, ()
    return opened(state, OpenRequest(RequestKind.ROUTE, event.route_id, event.section_ids))


def granted(state: Authority, event: GrantHeard) -> Result:
    """Only to the request outstanding, of this boot, with a greater token: holds them, and asks for the rest."""
    request = state.open(RequestKind.ROUTE)
    if request is None or not (event.fresh and event.answers and event.newer):
        return state, ()
    wanted = request.section_ids or ()
    rest = wanted[len(event.section_ids) :]
    if event.route_id != request.subject or (*event.section_ids, *rest) != wanted:
        return state, ()
    state, actions = closed(state, RequestKind.ROUTE)
    if rest:
        state, renewed = opened(state, replace(request, section_ids=rest))
        state, waits = refused(state, replace(request, section_ids=rest), "the rest is not free")
        actions = (*renewed, *waits)
    added = tuple(s for s in event.section_ids if s not in state.held)
    held = (*state.held, *added)
    regranted = set(event.section_ids)
    commandable = tuple(
        s for s in held if s in event.commandable or (s in state.commandable and s not in regranted)
    )
    # What the crew saw while another could throw the points is no proof any more.
    proven = tuple(
        needed
        for needed in state.proven
        if state.holds(needed.section_id) and needed.section_id not in regranted - {*event.commandable}
    )
    unswept = (*(s for s in state.unswept if s not in regranted), *event.on_sight)
    state = replace(state, held=held, commandable=commandable, proven=proven, unswept=unswept)
    note = Write(notes.RouteHeld(route_id=event.route_id, token=0))
    return state, (*actions, Take(event.section_ids), note, holds(state))


def route_refused(state: Authority, event: RefusalHeard) -> Result:
    """To the request outstanding: asks again, as a new request; reports first if the manager has lost sight of it."""
    request = state.open(RequestKind.ROUTE)
    if (
        request is None
        or event.ask is not RequestKind.ROUTE
        or not event.answers
        or event.subject != request.subject
    ):
        return state, ()
    waiting, actions = refused(state, request, event.why)
    actions = (Renew(RequestKind.ROUTE), *actions)
    if event.why != request.refusal:
        actions = (*actions, Write(notes.RouteDenied(route_id=request.subject, why=event.why)))
    if event.lost_sight and state.open(RequestKind.REPORT) is None:
        waiting, more = report_now(waiting)
        actions = (*actions, *more)
    return waiting, actions


def give_back(state: Authority, event: GiveBack) -> Result:
    """Drops a route not entered and the request still open, then reports what is left."""
    given, first = dropped(state, event.section_ids)
    if state.open(RequestKind.ROUTE) is None:
        return given, first
    # Its answer fits nothing, and the report frees what it may have given.
    given, second = closed(given, RequestKind.ROUTE)
    given, third = report_now(given, event.next_train)
    return given, (*first, *second, *third)


TABLE: Final[Table] = MappingProxyType(
    {
        (SignOnStanding.ON_LINE, AskRoute): ask,
        (SignOnStanding.ON_LINE, GrantHeard): granted,
        (SignOnStanding.ON_LINE, GiveBack): give_back,
    }
)
