"""Where register and unit contradict each other (情報の不一致, Sugiyama et al. 2017, section 5): the train is stopped.

Invariant: a contradiction once known stays until the manager's answer to the unit's newest word has neither less than
the unit holds nor anything contested; telegrams about it only restrict, so that a lost one gives nothing away.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from msgspec.structs import replace

from onboard.authority import route, sign_on
from onboard.authority.records import (
    Authority,
    BeginOnLine,
    ContestHeard,
    FoundAt,
    RefusalHeard,
    RequestKind,
    SignOnHeard,
)
from onboard.authority.tables import Result, SignOnStanding, Table, disagrees, report_now


def contested(state: Authority, event: ContestHeard) -> Result:
    """The train is stopped: another claims, or may be in, what the unit holds."""
    return disagrees(state, f"contested: {', '.join(event.section_ids)}")


def found_at(state: Authority, event: FoundAt) -> Result:
    """It stands in a section that it does not hold: the train is stopped, and signs on again with where it is."""
    where = ", ".join(section for section in event.section_ids if not state.holds(section))
    claiming, actions = sign_on.begin(replace(state, on_line=False), BeginOnLine(event.section_ids))
    stopped, more = disagrees(claiming, f"found in what it does not hold: {where}")
    return stopped, (*actions, *more)


def refused_on_line(state: Authority, event: RefusalHeard) -> Result:
    """Its claim: the train is stopped. Its route: asks again, and reports first if the manager has lost sight of it."""
    if event.ask is RequestKind.SIGN_ON:
        return disagrees(state, f"claim refused: {event.why}")
    return route.route_refused(state, event)


def refused_signing_on(state: Authority, event: RefusalHeard) -> Result:
    """Its sign-on: asks again. If that says where it stands, which is no wish to enter, the train is stopped."""
    request = state.open(RequestKind.SIGN_ON)
    waiting, actions = sign_on.sign_on_refused(state, event)
    if not actions or state.entering or request is None or not request.section_ids:
        return waiting, actions
    stopped, more = disagrees(waiting, f"claim refused: {event.why}")
    return stopped, (*actions, *more)


def refused_signing_off(state: Authority, event: RefusalHeard) -> Result:
    """Its claim: the train is stopped. Its sign-off: asks again."""
    if event.ask is RequestKind.SIGN_ON:
        return disagrees(state, f"claim refused: {event.why}")
    return sign_on.sign_off_refused(state, event)


def claim_accepted(state: Authority, event: SignOnHeard) -> Result:
    """To a claim: takes a greater token, never sections; if it has less than the unit holds, the train is stopped.

    If it has more, as persons have entered for the unit or as it claimed falsely, that is given back by a report; but
    all of a route that the unit asks for may have been granted, and not heard yet.
    """
    taken, actions = sign_on.claim_accepted(state, event)
    held, has = set(state.held), set(event.section_ids)
    asked = taken.open(RequestKind.ROUTE)
    granted = asked is not None and has.issuperset(asked.section_ids or ())
    if held and held < has and not granted and taken.open(RequestKind.REPORT) is None:
        reporting, more = report_now(taken)
        return reporting, (*actions, *more)
    if held <= has:
        return taken, actions
    stopped, more = disagrees(taken, "the register has less")
    return stopped, (*actions, *more)


TABLE: Final[Table] = MappingProxyType(
    {
        (SignOnStanding.SIGNING_ON, ContestHeard): contested,
        (SignOnStanding.ON_LINE, ContestHeard): contested,
        (SignOnStanding.ON_LINE, FoundAt): found_at,
        (SignOnStanding.SIGNING_OFF, ContestHeard): contested,
        (SignOnStanding.SIGNING_ON, RefusalHeard): refused_signing_on,
        (SignOnStanding.ON_LINE, RefusalHeard): refused_on_line,
        (SignOnStanding.SIGNING_OFF, RefusalHeard): refused_signing_off,
        (SignOnStanding.ON_LINE, SignOnHeard): claim_accepted,
        (SignOnStanding.SIGNING_OFF, SignOnHeard): claim_accepted,
    }
)
