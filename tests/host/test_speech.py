"""A mad unit claims besides what it holds what a fault has it claim, and says nothing else that is not so."""

from typing import Final

import pytest

from host.speech import Speech
from host.store import MemoryStore, commission
from host.unit import HostedUnit, UnitConfig
from onboard.authority.records import Authority, OpenRequest, RequestKind
from onboard.duty.records import DutyState, PlaceInJoints
from onboard.duty_parameters import DutyParameters
from onboard.unit import Report
from radio.envelope import Endpoint, Received
from radio.keys import key_ring
from radio.messages import AnyMessage, Claim, ClaimQuery, LeavingClaim
from tests.radio.test_messages import EXAMPLES

CONFIG: Final = UnitConfig("line", "u1", "block-manager", DutyParameters(20.0, 45.0, 30.0))
SANE, MAD = Report(PlaceInJoints()), Report(PlaceInJoints(), claims_besides=("X",))
STANDING: Final = Authority(held=("C",), on_line=True)


class Cab:
    """A unit in the middle of its duty, and the manager that hears it."""

    def __init__(self, authority: Authority) -> None:
        store = MemoryStore()
        commission(store)
        self.manager = Endpoint(key_ring(b"m" * 32, "block-manager", ["u1"]), 1)
        self.unit = HostedUnit(CONFIG, key_ring(b"m" * 32, "u1", ["block-manager"]), store)
        self.unit._unit.state = DutyState(authority=authority)

    def says(self, report: Report, *, asked: bool = False) -> list[AnyMessage]:
        telegrams = [self.manager.seal("u1", ClaimQuery(), 2.0)] if asked else []
        heard = [self.manager.open(t.data, 2.0) for t in self.unit.advance(2.0, telegrams, report).telegrams]
        return [opened.message for opened in heard if isinstance(opened, Received)]


@pytest.mark.parametrize(("authority", "held"), [(STANDING, ("C",)), (Authority(), ())])
def test_it_claims_unasked_as_that_begins_then_when_asked_until_it_is_over(
    authority: Authority, held: tuple[str, ...]
) -> None:
    cab = Cab(authority)
    assert cab.says(MAD) == [Claim((*held, "X"), 0)]
    assert cab.says(MAD) == []
    assert cab.says(MAD, asked=True) == [Claim((*held, "X"), 0)]
    assert cab.says(SANE) == []
    assert cab.says(SANE, asked=True) == [Claim(held, 0)]


@pytest.mark.parametrize(
    "authority",
    [
        Authority(unsure=True),
        Authority(requests=(OpenRequest(RequestKind.SIGN_ON, section_ids=None, sent=True),)),
    ],
)
def test_where_it_does_not_know_what_it_holds_it_tells_no_lie_of_where_its_train_stands(
    authority: Authority,
) -> None:
    cab = Cab(authority)
    assert cab.says(MAD) == []
    assert cab.says(MAD, asked=True) == [Claim(None, 0)]


@pytest.mark.parametrize("message", EXAMPLES, ids=lambda message: type(message).__name__)
def test_what_a_sane_unit_says_leaves_its_host_as_it_is(message: AnyMessage) -> None:
    """By its type too: a claim of one that has signed off is another than that of one on the line."""
    speech = Speech(key_ring(b"m" * 32, "u1", ["block-manager"]), 1)
    opened = Endpoint(key_ring(b"m" * 32, "block-manager", ["u1"]), 1).open(
        speech.seal("block-manager", message, 1.0), 1.0
    )
    assert isinstance(opened, Received)
    assert (type(opened.message), opened.message) == (type(message), message)


def test_one_that_has_signed_off_says_so_when_it_is_asked_sane_or_mad() -> None:
    cab = Cab(Authority(held=("P",), leaving=True))
    assert cab.says(SANE, asked=True) == [LeavingClaim(("P",), 0)]
    assert LeavingClaim(("P", "X"), 0) in cab.says(MAD, asked=True)


def test_what_it_holds_anyway_it_claims_once() -> None:
    cab = Cab(STANDING)
    assert cab.says(Report(PlaceInJoints(), claims_besides=("C",))) == [Claim(("C",), 0)]
