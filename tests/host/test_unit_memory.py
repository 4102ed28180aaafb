"""What a unit keeps over a power cut: whether it may be on the line; and what it says of itself after a boot."""

from typing import Final

import pytest

from host.store import Durable, MemoryStore, commission
from host.unit import HostedUnit, UnitConfig
from onboard.authority import machine, sign_on
from onboard.authority.records import Authority, OpenRequest, QueryHeard, RequestKind
from onboard.authority.tables import SignOnStanding
from onboard.duty.records import DutyState, PlaceInJoints
from onboard.duty_parameters import DutyParameters
from onboard.unit import Report
from radio.envelope import Endpoint, Received
from radio.keys import key_ring
from radio.messages import AnyMessage, Claim, ClaimQuery

MASTER: Final = b"m" * 32
CONFIG: Final = UnitConfig("line", "u1", "block-manager", DutyParameters(20.0, 45.0, 30.0))
NOWHERE: Final = Report(PlaceInJoints())


class Cab:
    """A unit's store, its boots, and the manager's end of the radio."""

    def __init__(self) -> None:
        self.store = MemoryStore()
        commission(self.store)
        self.unit = self.boot()

    def boot(self) -> HostedUnit:
        self.manager = Endpoint(key_ring(MASTER, "block-manager", ["u1"]), 1)
        self.unit = HostedUnit(CONFIG, key_ring(MASTER, "u1", ["block-manager"]), self.store)
        return self.unit

    def becomes(self, authority: Authority) -> None:
        """As it is in the middle of its duty."""
        self.unit._unit.state = DutyState(authority=authority)
        self.unit.advance(1.0, (), NOWHERE)

    def asked(self) -> AnyMessage:
        """What it answers the manager's question."""
        query = self.manager.seal("u1", ClaimQuery(), 2.0)
        (answer,) = self.unit.advance(2.0, [query], NOWHERE).telegrams
        opened = self.manager.open(answer.data, 2.0)
        assert isinstance(opened, Received)
        return opened.message


@pytest.mark.parametrize(
    ("authority", "on_line"),
    [
        (Authority(held=("C",), on_line=True), True),
        (Authority(held=("C",), requests=(OpenRequest(RequestKind.SIGN_ON, section_ids=("C",)),)), True),
        (Authority(requests=(OpenRequest(RequestKind.SIGN_ON, section_ids=None),)), True),
        (Authority(held=("P",), on_line=True, requests=(OpenRequest(RequestKind.SIGN_OFF),)), True),
        (Authority(entering=True, requests=(OpenRequest(RequestKind.SIGN_ON, section_ids=("P",)),)), False),
        (Authority(), False),
    ],
)
def test_after_a_boot_it_claims_nothing_only_if_it_was_surely_off_the_line(
    authority: Authority, on_line: bool
) -> None:
    cab = Cab()
    cab.becomes(authority)
    for _ in range(2):  # that its crew has not come yet does not make it forget
        cab.boot()
        assert cab.asked() == Claim(None if on_line else (), 0)


def test_signed_off_it_is_off_the_line_after_the_next_boot_too() -> None:
    cab = Cab()
    cab.becomes(Authority(held=("P",), on_line=True))
    cab.becomes(Authority())
    cab.boot()
    assert cab.asked() == Claim((), 0)


def test_it_is_kept_before_anything_leaves_the_unit(monkeypatch: pytest.MonkeyPatch) -> None:
    """And once, not with every telegram."""
    saved: list[Durable] = []
    cab = Cab()
    save = cab.store.save
    monkeypatch.setattr(cab.store, "save", lambda durable: saved.append(durable) or save(durable))
    cab.unit._unit.state = DutyState(authority=Authority(held=("C",), on_line=True))
    query = cab.manager.seal("u1", ClaimQuery(), 1.0)
    assert cab.unit.advance(1.0, [query], NOWHERE).telegrams
    cab.unit.advance(2.0, (), NOWHERE)
    assert len(saved) == 1


@pytest.mark.parametrize("spare", [None, b"no record of a unit"])
def test_one_that_lost_what_it_kept_may_be_on_the_line(spare: bytes | None) -> None:
    cab = Cab()
    cab.store.save(Durable(4, spare=spare, commissioned=1))
    cab.boot()
    assert cab.asked() == Claim(None, 0)


def test_commissioned_again_it_may_be_on_the_line() -> None:
    cab = Cab()
    commission(cab.store, 2)
    cab.boot()
    assert cab.asked() == Claim(None, 0)


def test_without_that_answer_it_would_say_that_it_holds_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    table = {**machine.TABLE, (SignOnStanding.OFF_LINE, QueryHeard): sign_on.queried}
    monkeypatch.setattr(machine, "TABLE", table)
    cab = Cab()
    cab.becomes(Authority(held=("C",), on_line=True))
    cab.boot()
    assert cab.asked() == Claim((), 0)
