"""A way that the dispatcher orders: taken up only if it is the one ordered, and the same as far as the train may be."""

import pytest
from msgspec.structs import replace

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.timetable import load_timetable
from onboard.duty import orders
from onboard.duty.machine import step
from onboard.duty.orders import leads_on
from onboard.duty.records import DutyPhase
from onboard.mission import on_tracks, plan_mission
from onboard.plan import DutyPlan, plan_of
from tests.onboard.duty.rows_orders import ORDERED, ORDERS
from tests.onboard.duty.stage import HOLDS_3, NOW_S, PLAN, TIMES, moved


def way(track: str, start: str = "3") -> DutyPlan:
    line = load_line(shipped_line("rtri_test_line"))
    train = load_timetable(shipped_timetable("rtri_test_line"), line).trains["T1"]
    tracks = {"B": track} if start == "3" else {"A": "2", "B": track}
    return plan_of(plan_mission(line, on_tracks(train, tracks), start, None, None), 40.0)


def test_the_way_ordered_is_taken_up() -> None:
    assert leads_on(PLAN, ORDERED, way("2"))
    assert [span.section_id for span in way("2").spans] == ["3", "5", "6", "7", "9"]


@pytest.mark.parametrize(
    ("state", "other"),
    [
        (replace(ORDERED, ordered=""), way("2")),  # nothing is ordered
        (ORDERED, way("1")),  # another than is ordered
        (ORDERED, way("2", start="4")),  # from another track than that under the train
        (ORDERED, replace(way("2"), number="T9")),
        (replace(ORDERED, phase=DutyPhase.RUNNING), way("2")),
        (replace(ORDERED, authority=HOLDS_3), way("2")),  # its request was answered meanwhile
        # it may be on the points already
        (replace(ORDERED, place=moved(ORDERED.place, perhaps=4)), way("2")),
    ],
)
def test_no_other_is(state: orders.DutyState, other: DutyPlan) -> None:
    assert not leads_on(PLAN, state, other)


@pytest.mark.parametrize(
    ("switch", "row"),
    [
        ("ONCE", "another track, to a request that was answered before"),
        ("ONCE", "another track for a route that is held by now"),
        ("SHORT_OF_IT", "no other track once the front may have left"),
        ("SHORT_OF_IT", "none is taken back that the front may have entered"),
    ],
)
def test_a_rule_switched_off_is_found(switch: str, row: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(orders, switch, False)
    state, event, place, after, actions = ORDERS[row]
    assert step(PLAN, TIMES, state, event, place, NOW_S) != (after, actions)
