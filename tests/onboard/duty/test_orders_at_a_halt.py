"""A train that stands at a halt on open line, with a part of its route: nothing of that is changed under it."""

import pytest
from msgspec.structs import replace

from onboard.authority.records import Authority, Ordered, SendRefusal, TrackChangeOrdered, TrainEndOrdered
from onboard.duty.machine import step
from onboard.duty.records import DutyPhase, DutyState, TrainEndsHere, WayOrdered
from radio.messages import OrderRefusalReason
from tests.onboard.duty.stage import NOW_S, ON_6, PLAN, ROUTE_OPEN, TIMES, moved

IN_6 = 2  # span
HALT = replace(PLAN.stops[0], place="H", span=IN_6, clear=0)
WITH_HALT = replace(PLAN, stops=(PLAN.stops[0], HALT, PLAN.stops[1]))
AT_HALT = moved(ON_6, stands=True, near=1, passed=1)
HAS_A_PART = Authority(held=("6",), on_line=True, requests=(replace(ROUTE_OPEN, section_ids=("7", "8")),))
WAITS = DutyState(DutyPhase.STANDING, AT_HALT, HAS_A_PART, at=1, may_ask=True)


@pytest.mark.parametrize(
    "order",
    [TrackChangeOrdered("3>8", "3>9", answers=True), TrainEndOrdered("3>8", "T2", answers=True)],
    ids=["another track", "the end of its train"],
)
def test_what_is_ordered_of_a_route_that_it_is_on_is_refused(order: Ordered) -> None:
    """The route began at its station: its driver would take up a way that the unit does not."""
    state, actions = step(WITH_HALT, TIMES, WAITS, order, AT_HALT, NOW_S)
    assert SendRefusal("3>8", OrderRefusalReason.MAY_HAVE_ENTERED) in actions
    assert not any(isinstance(action, WayOrdered | TrainEndsHere) for action in actions)
    assert (state.ordered, state.next_train) == ("", "")
