"""The block manager's rules one by one, and its tables walked.

The line, after figure 3: P0 (portal), A (points), B (track), C (between), D (points), E (track), P9 (portal).
"""

from itertools import product

import pytest

from radio.keys import capability_mac
from radio.messages import (
    AnyMessage,
    Claim,
    ClaimQuery,
    HoldingConfirmed,
    HoldingReport,
    LeavingClaim,
    NextTrainReport,
    OrderRefusalReason,
    OrderRefused,
    PointsProof,
    RefusalReason,
    RouteGranted,
    RouteRefused,
    RouteRequest,
    SignOff,
    SignOffAccepted,
    SignOffRefused,
    SignOn,
    SignOnAccepted,
    SignOnRefused,
)
from tests.wayside.manager_desk import CONFIG, KEYS, Desk, defined
from wayside import said
from wayside.actions import Send, Show
from wayside.block_manager import TELEGRAMS, AskUnits, Heard, step, wake_at_s
from wayside.register import UnitStanding

IN = RouteRequest("u1", "in", ("A", "B"))


def test_nothing_is_granted_while_anyone_is_unknown() -> None:
    desk = Desk()
    desk.enter("u1", "P0")
    desk.act(said.ConfirmOutside("u2", "Sato"))
    assert desk.hear("u1", IN) == RouteRefused("in", RefusalReason.UNDEFINED, None, "u3")
    desk.act(said.ConfirmHolding("u3", ("E",), "Sato"))
    assert isinstance(desk.hear("u1", IN), RouteGranted)


def test_a_route_is_granted_whole_with_capabilities_for_its_terminals() -> None:
    desk = defined(u1=("P0",))
    granted = desk.hear("u1", IN)
    assert isinstance(granted, RouteGranted)
    assert granted.section_ids == ("A", "B")
    assert granted.token >> 32 == desk.register.epoch
    (capability,) = granted.capabilities
    assert (capability.terminal_id, capability.section_id) == ("tA", "A")
    assert capability.mac == capability_mac(KEYS["tA"], "tA", "A", "u1", granted.token)
    assert desk.register.held_by("u1") == ("P0", "A", "B")
    assert desk.kinds == [said.Granted]


def test_a_route_is_not_granted_in_part() -> None:
    desk = defined(u1=("B",), u2=("E",))
    request = RouteRequest("u1", "over", ("C", "D", "E"))
    assert desk.hear("u1", request) == RouteRefused("over", RefusalReason.HELD, "E", "u2")
    assert desk.register.held_by("u1") == ("B",)


def test_the_same_request_again_gets_the_same_answer_and_changes_nothing() -> None:
    desk = defined(u1=("P0",))
    first = desk.hear("u1", IN, correlation=5)
    before = desk.register
    assert desk.hear("u1", IN, correlation=5) == first
    assert desk.register == before
    assert desk.kinds == []


def test_a_new_request_for_what_is_held_already_gets_a_greater_token() -> None:
    desk = defined(u1=("P0",))
    first, second = desk.hear("u1", IN, correlation=5), desk.hear("u1", IN, correlation=6)
    assert isinstance(first, RouteGranted)
    assert isinstance(second, RouteGranted)
    assert second.token > first.token


@pytest.mark.parametrize(
    ("request_", "reason"),
    [
        (RouteRequest("u1", "nowhere", ("A",)), RefusalReason.UNKNOWN_ROUTE),
        (RouteRequest("u1", "in", ("A",)), RefusalReason.UNKNOWN_ROUTE),
        (RouteRequest("u1", "over", ("C", "D", "E")), RefusalReason.NOT_CONNECTED),
        (RouteRequest("u1", "over", ("D", "E")), RefusalReason.NOT_CONNECTED),
        (RouteRequest("u1", "over", ()), RefusalReason.UNKNOWN_ROUTE),
        (RouteRequest("u2", "in", ("A", "B")), RefusalReason.WRONG_UNIT),
    ],
)
def test_requests_that_are_refused(request_: RouteRequest, reason: RefusalReason) -> None:
    desk = defined(u1=("P0",))
    before = desk.register
    answer = desk.hear("u1", request_)
    assert isinstance(answer, RouteRefused)
    assert answer.reason is reason
    assert desk.register == before


def test_a_train_on_its_way_is_granted_what_lies_ahead_whoever_is_behind_it() -> None:
    desk = defined(u1=("D",), u2=("C",))
    assert isinstance(desk.hear("u1", RouteRequest("u1", "over", ("C", "D", "E"))), RouteRefused)
    from_elsewhere = RouteRequest("u2", "over", ("E",))
    assert isinstance(desk.hear("u2", from_elsewhere), RouteRefused)
    granted = desk.hear("u1", RouteRequest("u1", "over", ("D", "E")))
    assert isinstance(granted, RouteGranted)
    assert granted.section_ids == ("D", "E")
    refused = defined(u1=("E",)).hear("u1", RouteRequest("u1", "over", ("D", "E")))
    assert isinstance(refused, RouteRefused)  # it is beyond where that begins
    assert refused.reason is RefusalReason.NOT_CONNECTED
    assert desk.register.held_by("u1") == ("D", "E")
    assert desk.register.held_by("u2") == ("C",)


def test_a_request_from_a_boot_that_has_not_signed_on() -> None:
    desk = defined(u1=("P0",))
    assert desk.hear("u1", IN, epoch=2) == RouteRefused("in", RefusalReason.NOT_SIGNED_ON)


def test_a_report_frees_what_it_no_longer_lists_and_a_lost_one_heals() -> None:
    desk = defined(u1=("P0",))
    granted = desk.hear("u1", IN)
    assert isinstance(granted, RouteGranted)
    # The report without P0 is lost; the next says all that is held, and frees both.
    confirmed = desk.hear("u1", HoldingReport(("B",), granted.token))
    assert confirmed == HoldingConfirmed(("B",), granted.token)
    assert desk.register.holders == {"B": "u1"}
    assert desk.kinds == [said.Freed]
    assert desk.hear("u1", HoldingReport(("B",), granted.token)) == confirmed
    assert desk.kinds == []


def test_a_report_from_before_the_last_grant_frees_nothing() -> None:
    desk = defined(u1=("P0",))
    old_token = desk.register.unit("u1").token
    granted = desk.hear("u1", IN)
    assert isinstance(granted, RouteGranted)
    expected = HoldingConfirmed(("P0", "A", "B"), granted.token)
    assert desk.hear("u1", HoldingReport(("P0",), old_token)) == expected
    assert desk.register.held_by("u1") == ("P0", "A", "B")


@pytest.mark.parametrize(("sections", "epoch"), [((), 1), (("B", "E"), 1), (("B",), 2)])
def test_reports_that_free_nothing(sections: tuple[str, ...], epoch: int) -> None:
    desk = defined(u1=("A", "B"), u2=("E",))
    before = desk.register
    report = HoldingReport(sections, desk.register.unit("u1").token)
    assert isinstance(desk.hear("u1", report, epoch=epoch), HoldingConfirmed)
    assert desk.register == before
    assert desk.kinds in ([said.Refused], [said.Contradicted])


def test_silence_frees_nothing() -> None:
    desk = defined(u1=("P0",))
    holders = desk.register.holders
    for day in range(1, 8):
        desk.register, _ = step(desk.register, AskUnits(), day * 86_400.0)
    assert desk.register.holders == holders


def test_a_restarted_manager_asks_until_everyone_is_known() -> None:
    desk = Desk(epoch=2)
    assert wake_at_s(desk.register) is not None
    desk.register, actions = step(desk.register, AskUnits(), -3600.0)  # a day may begin before midnight
    assert actions == tuple(Send(unit_id, ClaimQuery()) for unit_id in CONFIG.unit_ids)
    assert wake_at_s(desk.register) == -3595.0
    assert step(desk.register, AskUnits(), -3595.1) == (desk.register, ())
    for unit_id, sections in [("u1", ("A", "B")), ("u2", ()), ("u3", ("E",))]:
        desk.hear(unit_id, Claim(sections, 7))
    assert desk.register.undefined_because_of() == ()
    assert wake_at_s(desk.register) is None
    assert step(desk.register, AskUnits(), 1000.0) == (desk.register, ())
    assert desk.register.holders == {"A": "u1", "B": "u1", "E": "u3"}
    assert desk.standing("u2") is UnitStanding.OUTSIDE
    # Nothing is granted before a person has accepted what the claims show.
    request = RouteRequest("u1", "over", ("C", "D", "E"))
    assert desk.hear("u1", request) == RouteRefused("over", RefusalReason.UNDEFINED)


def test_a_claim_keeps_the_trains_token_and_later_ones_are_greater() -> None:
    desk = Desk(epoch=2)
    old_token = (1 << 32) + 40
    accepted = desk.hear("u1", Claim(("P0",), old_token))
    assert isinstance(accepted, SignOnAccepted)
    assert accepted.token == old_token
    for unit_id in ("u2", "u3"):
        desk.hear(unit_id, Claim((), 0))
    desk.now_s = 10.0
    assert desk.act(said.AcceptPicture("Sato")) == [said.PictureChanged]
    granted = desk.hear("u1", IN)
    assert isinstance(granted, RouteGranted)
    assert granted.token > old_token


def test_a_token_that_this_manager_never_gave_is_replaced() -> None:
    desk = Desk(epoch=2)
    accepted = desk.hear("u1", Claim(("P0",), 9 << 32))
    assert isinstance(accepted, SignOnAccepted)
    assert accepted.token == (2 << 32) + 1


@pytest.mark.parametrize(
    "message", [SignOn("u1", ("P0",)), SignOn("u1", ("B",)), Claim(("P0",), 3), HoldingReport(("P0",), 3)]
)
def test_a_claim_that_may_date_from_before_the_restart_is_asked_again(message: AnyMessage) -> None:
    desk = Desk(epoch=2)
    assert desk.hear("u1", message, fresh=False) == ClaimQuery()
    assert desk.standing("u1") is UnitStanding.UNKNOWN


def test_a_unit_that_started_again_learns_what_it_holds() -> None:
    desk = defined(u1=("P0",))
    granted = desk.hear("u1", IN)
    assert isinstance(granted, RouteGranted)
    accepted = desk.hear("u1", SignOn("u1", None), epoch=2, fresh=False)
    expected = SignOnAccepted(("P0", "A", "B"), granted.token, "in", granted.capabilities)
    assert accepted == expected
    assert desk.hear("u1", SignOn("u1", None), epoch=2) == expected
    # What the boot before sent counts no more.
    desk.hear("u1", HoldingReport(("B",), granted.token), epoch=1)
    assert desk.register.held_by("u1") == ("P0", "A", "B")


def test_a_request_of_a_new_boot_is_no_repetition_of_the_old_ones() -> None:
    """It numbers its requests anew: the same number is a new request, and gets a token of its own."""
    desk = defined(u1=("P0",))
    first = desk.hear("u1", IN, correlation=5)
    desk.hear("u1", SignOn("u1", None), epoch=2)
    again = desk.hear("u1", IN, epoch=2, correlation=5)
    assert isinstance(first, RouteGranted)
    assert isinstance(again, RouteGranted)
    assert again.token > first.token


def test_a_person_cannot_contradict_another_holder() -> None:
    desk = defined(u1=("A", "B"))
    assert desk.act(said.ConfirmHolding("u2", ("B",), "Sato")) == [said.Contradicted]
    assert desk.standing("u2") is UnitStanding.OUTSIDE


@pytest.mark.parametrize("sections", [(), ("nowhere",)])
def test_entries_by_hand_that_make_no_sense(sections: tuple[str, ...]) -> None:
    assert Desk().act(said.ConfirmHolding("u1", sections, "Sato")) == [said.Refused]


def test_a_unit_confirmed_outside_that_claims_the_line_is_believed_and_held() -> None:
    desk = defined()
    desk.hear("u1", Claim(("C",), 7))
    assert desk.register.held_by("u1") == ("C",)
    assert desk.kinds == [said.Accepted]


def test_entering_needs_a_free_portal() -> None:
    desk = defined(u2=("P0",))
    assert desk.hear("u1", SignOn("u1", ("P0",))) == SignOnRefused(RefusalReason.HELD, "P0", "u2")
    assert desk.standing("u1") is UnitStanding.OUTSIDE


def test_a_wish_to_enter_is_no_claim() -> None:
    # u2 may stand in P0 and be silent: u1 must not get it by wishing to enter there.
    desk = Desk(epoch=2)
    desk.hear("u3", Claim((), 0))
    desk.hear("u1", Claim((), 0))
    assert desk.hear("u1", SignOn("u1", ("P0",))) == SignOnRefused(RefusalReason.UNDEFINED, None, "u2")
    assert desk.standing("u1") is UnitStanding.OUTSIDE
    desk.hear("u2", Claim((), 0))
    desk.now_s = 10.0
    desk.act(said.AcceptPicture("Sato"))
    accepted = desk.hear("u1", SignOn("u1", ("P0",)))
    assert isinstance(accepted, SignOnAccepted)
    assert accepted.section_ids == ("P0",)


def test_a_unit_known_to_be_outside_enters_without_being_asked_first() -> None:
    desk = defined(u2=("P9",))
    refused = SignOnRefused(RefusalReason.HELD, "P9", "u2")
    assert desk.hear("u1", SignOn("u1", ("P9",)), fresh=False) == refused
    assert desk.register.undefined_because_of() == ()
    assert isinstance(desk.hear("u1", SignOn("u1", ("P0",)), fresh=False), SignOnAccepted)


def test_entering_again_takes_a_new_token() -> None:
    desk = defined(u1=("P0",))
    off = SignOff("u1", desk.register.unit("u1").token)
    desk.hear("u1", off)
    assert isinstance(desk.hear("u1", SignOn("u1", ("P0",))), SignOnAccepted)
    assert desk.register.unit("u1").token > off.token
    assert desk.hear("u1", off) == SignOffRefused(RefusalReason.STALE_TOKEN)


def test_claims_for_sections_that_do_not_exist() -> None:
    desk = Desk()
    refused = SignOnRefused(RefusalReason.UNKNOWN_SECTION, "nowhere")
    assert desk.hear("u1", Claim(("nowhere",), 0)) == refused


def test_a_claim_never_frees() -> None:
    desk = defined(u1=("A", "B"))
    accepted = desk.hear("u1", Claim(("B",), 0))
    assert isinstance(accepted, SignOnAccepted)
    assert accepted.section_ids == ("A", "B")
    desk = defined(u1=("A",))
    desk.hear("u1", Claim(("B",), 0))
    assert desk.register.units_asked() == ("u1",)  # until it has given A back


def test_signing_off_from_the_portal_and_again() -> None:
    desk = defined(u1=("P9",))
    off = SignOff("u1", desk.register.unit("u1").token)
    assert desk.hear("u1", off) == SignOffAccepted()
    assert desk.hear("u1", off) == SignOffAccepted()
    assert desk.standing("u1") is UnitStanding.LEAVING
    assert desk.register.holders == {"P9": "u1"}, "its train stands there, and may not have heard"
    assert desk.act(said.BoundaryPassed("P9")) == [said.Freed, said.Outside]
    assert desk.register.holders == {}
    assert desk.standing("u1") is UnitStanding.OUTSIDE
    assert desk.hear("u1", off) == SignOffAccepted()


@pytest.mark.parametrize(
    ("section", "token_error", "epoch", "name", "reason"),
    [
        ("B", 0, 1, "u1", RefusalReason.STILL_HOLDING),
        ("P9", 1, 1, "u1", RefusalReason.STALE_TOKEN),
        ("P9", 0, 2, "u1", RefusalReason.NOT_SIGNED_ON),
        ("P9", 0, 1, "u2", RefusalReason.WRONG_UNIT),
    ],
)
def test_sign_offs_that_are_refused(
    section: str, token_error: int, epoch: int, name: str, reason: RefusalReason
) -> None:
    desk = defined(u1=(section,))
    off = SignOff(name, desk.register.unit("u1").token + token_error)
    assert desk.hear("u1", off, epoch=epoch) == SignOffRefused(reason)
    assert desk.register.held_by("u1") == (section,)


def test_units_that_are_not_on_the_fleet_list_do_not_exist() -> None:
    desk = defined()
    before = desk.register
    assert desk.act(said.ConfirmOutside("ghost", "Sato")) == [said.Refused]
    event: Heard[AnyMessage] = Heard("ghost", 1, True, 1, SignOn("ghost", ("C",)))
    register, (action,) = step(before, event, 0.0)
    assert register == before
    assert isinstance(action, Show)


def test_the_register_cannot_hold_two_holders() -> None:
    register = defined(u1=("B",)).register
    with pytest.raises(ValueError, match="held by u1"):
        register.with_held("u2", ("B",))


def in_standing(standing: UnitStanding) -> Desk:
    """A desk on which u1 has the standing asked for."""
    desk = Desk()
    desk.enter("u2", "E")
    match standing:
        case UnitStanding.OUTSIDE:
            desk.act(said.ConfirmOutside("u1", "Sato"))
        case UnitStanding.BY_HAND:
            desk.act(said.ConfirmHolding("u1", ("B",), "Sato"))
        case UnitStanding.REPORTED:
            desk.enter("u1", "B")
        case UnitStanding.LEAVING:
            desk.enter("u1", "P9")
            desk.hear("u1", SignOff("u1", desk.register.unit("u1").token))
        case UnitStanding.DISPUTED:
            desk.hear("u1", Claim(("B", "E"), 0))
        case UnitStanding.UNKNOWN:
            pass
    assert desk.standing("u1") is standing
    return desk


MESSAGES: tuple[AnyMessage, ...] = (
    RouteRequest("u1", "over", ("C", "D", "E")),
    HoldingReport(("B",), 1),
    SignOn("u1", ("B",)),
    SignOff("u1", 1),
    Claim(("B",), 1),
    LeavingClaim(("B",), 1),
    OrderRefused("over", OrderRefusalReason.NOT_HELD),
    NextTrainReport(("B",), 1, (), "2M"),
)
EXPECTED = {
    (RouteRequest, UnitStanding.UNKNOWN): ClaimQuery,
    (RouteRequest, UnitStanding.OUTSIDE): RouteRefused,
    (RouteRequest, UnitStanding.BY_HAND): RouteRefused,
    (RouteRequest, UnitStanding.REPORTED): RouteRefused,  # u3 is unknown on this desk
    (RouteRequest, UnitStanding.LEAVING): RouteRefused,
    (RouteRequest, UnitStanding.DISPUTED): ClaimQuery,
    (HoldingReport, UnitStanding.REPORTED): HoldingConfirmed,
    (HoldingReport, UnitStanding.LEAVING): HoldingConfirmed,
    (NextTrainReport, UnitStanding.REPORTED): HoldingConfirmed,
    (NextTrainReport, UnitStanding.LEAVING): HoldingConfirmed,
    (SignOff, UnitStanding.OUTSIDE): SignOffAccepted,
}
NOTED = {(OrderRefused, UnitStanding.REPORTED), (OrderRefused, UnitStanding.LEAVING)}  # and not answered
OTHERWISE = {
    OrderRefused: ClaimQuery,
    HoldingReport: ClaimQuery,
    NextTrainReport: ClaimQuery,
    SignOn: SignOnAccepted,
    SignOff: SignOffRefused,
    Claim: SignOnAccepted,
    LeavingClaim: SignOnAccepted,
}


@pytest.mark.parametrize(("standing", "message"), list(product(UnitStanding, MESSAGES)))
def test_the_table_of_telegrams(standing: UnitStanding, message: AnyMessage) -> None:
    assert (standing, type(message)) in TELEGRAMS
    desk = in_standing(standing)
    before = desk.register.holders
    kind = type(message)
    if (kind, standing) in NOTED:
        desk.register, (shown,) = step(desk.register, Heard("u1", 1, True, 1, message), 0.0)
        assert shown == Show(said.NotDone(unit_id="u1", route_id="over", why="not held"))
    else:
        assert isinstance(desk.hear("u1", message), EXPECTED.get((kind, standing)) or OTHERWISE[kind])
    # No telegram of this walk may touch u2, and none may take a section from u1.
    assert desk.register.held_by("u2") == ("E",)
    assert before.items() <= desk.register.holders.items()


@pytest.mark.parametrize("standing", UnitStanding)
def test_messages_for_others_are_refused_in_every_standing(standing: UnitStanding) -> None:
    desk = in_standing(standing)
    event: Heard[AnyMessage] = Heard("u1", 1, True, 1, PointsProof("p", None, False, False, 1))
    register, (action,) = step(desk.register, event, 0.0)
    assert register == desk.register
    assert isinstance(action, Show)
    assert isinstance(action.note, said.Refused)


def test_the_table_is_complete() -> None:
    assert set(TELEGRAMS) == {(standing, type(message)) for standing in UnitStanding for message in MESSAGES}
