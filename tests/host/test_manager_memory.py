"""What a manager knows of its day after a power cut: a train with a part of its way still has it."""

from typing import Final

import pytest

from host import device
from host.device import DeviceHost
from host.store import MemoryStore
from radio.envelope import Endpoint, Received
from radio.keys import key_ring
from radio.messages import AnyMessage, Claim, HoldingReport, RouteGranted, RouteRefused, RouteRequest, SignOn
from tests.host.one_unit import MASTER
from tests.wayside.test_parts import ROUTES, SECTIONS, moves
from wayside.config import MANAGER_ID, DispatchEntry, ManagerConfig, RouteEntry
from wayside.said import AcceptPicture

# The leader goes from A by B to C; the follower came from B, and goes after it; the third comes against both.
STANDS: Final = {"leader": "A2", "follower": "B", "third": "C1"}
MORE: Final = {
    "C1>B": RouteEntry("C1>B", "C1", ("4", "B")),
    "B>A2": RouteEntry("B>A2", "B", ("3", "2", "1", "A2")),
}
ALL: Final = ROUTES | MORE
DAYS: Final = (
    moves("leader", "A2>B", "B>C2", among=ALL),
    moves("follower", "B>A1", "A1>B", "B>C3", among=ALL),
    moves("third", "C1>B", "B>A2", among=ALL),
)
CONFIG: Final = ManagerConfig(
    "line",
    MANAGER_ID,
    tuple(STANDS),
    SECTIONS,
    tuple(ALL.values()),
    dispatch=DispatchEntry(certificate=True, journeys=DAYS, parts=True),
)


class Line:
    """A manager that can be started again, and the units that speak to it."""

    def __init__(self) -> None:
        self.store = MemoryStore()
        self.units = {unit_id: Endpoint(key_ring(MASTER, unit_id, [MANAGER_ID]), 1) for unit_id in STANDS}
        self.now_s = 0.0
        self.token = dict.fromkeys(STANDS, 0)
        self.start()
        for unit_id, section_id in STANDS.items():
            self.say(unit_id, SignOn(unit_id, (section_id,)))

    def start(self) -> None:
        keys = key_ring(MASTER, MANAGER_ID, list(STANDS), [])
        self.host = DeviceHost(CONFIG, keys, self.store)
        self.say(None)

    def say(self, unit_id: str | None, message: AnyMessage | None = None) -> list[AnyMessage]:
        """What is answered; every unit hears what is said to it."""
        self.now_s += 10.0
        sealed = [self.units[unit_id].seal(MANAGER_ID, message, self.now_s, 1)] if unit_id and message else []
        answers: list[AnyMessage] = []
        for to, data in self.host.advance(self.now_s, sealed).telegrams:
            opened = self.units[to].open(data, self.now_s)
            if to == unit_id and isinstance(opened, Received):
                answers.append(opened.message)
        return answers

    def asks(self, unit_id: str, route_id: str, *section_ids: str) -> tuple[str, ...]:
        """What is granted; nothing where it is refused."""
        request = RouteRequest(unit_id, route_id, section_ids or ALL[route_id].section_ids)
        (answer,) = (a for a in self.say(unit_id, request) if isinstance(a, RouteGranted | RouteRefused))
        if isinstance(answer, RouteRefused):
            return ()
        self.token[unit_id] = answer.token
        return answer.section_ids

    def keeps(self, unit_id: str, *section_ids: str) -> None:
        self.say(unit_id, HoldingReport(section_ids, self.token[unit_id]))


def behind_the_leader() -> Line:
    """The follower at A1 with block 1, behind the leader."""
    line = Line()
    assert line.asks("follower", "B>A1")
    line.keeps("follower", "A1")
    assert line.asks("leader", "A2>B")
    line.keeps("leader", "2", "3", "B")
    assert line.asks("follower", "A1>B") == ("1",)
    return line


def after_a_power_cut() -> Line:
    """The follower behind the leader; then the manager starts again, and all say what they hold."""
    line = behind_the_leader()
    line.start()
    for unit_id, held in {"leader": ("2", "3", "B"), "follower": ("1", "A1"), "third": ("C1",)}.items():
        line.say(unit_id, Claim(held, line.token[unit_id]))
        line.say(unit_id, Claim(held, line.token[unit_id]))  # the first may be from before the start
    line.host.advance(line.now_s, [], [AcceptPicture("Sato")])
    assert line.asks("leader", "B>C2")
    line.keeps("leader", "C2")
    return line


def test_nobody_is_let_against_a_part_that_was_granted_before_the_cut() -> None:
    line = after_a_power_cut()
    assert line.asks("third", "C1>B") == ()
    assert line.asks("follower", "A1>B", "2", "3", "B") == ("2", "3", "B")
    line.keeps("follower", "B")
    assert line.asks("follower", "B>C3")
    line.keeps("follower", "C3")
    assert line.asks("third", "C1>B")
    assert line.asks("third", "B>A2")


def test_a_manager_that_forgets_it_lets_both_stand_against_each_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(device, "PARTS_KEPT", False)
    line = after_a_power_cut()
    assert line.asks("third", "C1>B")
    assert line.asks("follower", "A1>B", "2", "3", "B") == ()
    assert line.asks("third", "B>A2") == ()


def test_a_train_in_its_part_is_on_its_way_and_not_back_where_it_came_from() -> None:
    """It has given its track back, and stands in block 1, through which it came to A before."""
    line = behind_the_leader()
    line.keeps("follower", "1")
    assert line.asks("leader", "B>C2")
    line.keeps("leader", "C2")
    assert line.asks("third", "C1>B") == ()
    assert line.asks("follower", "A1>B", "2", "3", "B") == ("2", "3", "B")
