"""Where units contradict each other or persons were wrong: who is told, what is granted, what must be swept."""

from typing import Final

import pytest

from radio.messages import (
    Claim,
    ClaimQuery,
    Contested,
    HoldingConfirmed,
    HoldingReport,
    RefusalReason,
    RouteGranted,
    RouteRefused,
    RouteRequest,
    SignOn,
    SignOnAccepted,
    SignOnRefused,
)
from tests.wayside.manager_desk import CONFIG, KEYS, Desk, defined
from wayside.actions import Send
from wayside.acts import ASKED_IN_VAIN
from wayside.block_manager import step
from wayside.register import UnitStanding, start
from wayside.said import ConfirmOutside, Contradicted, Freed, Refused, Swept, TakeBack

# contradictions -------------------------------------------------------------------------------------------------


def disputed() -> Desk:
    """u1 holds B and C, u2 claims C and D."""
    desk = defined(u1=("B", "C"))
    assert desk.hear("u2", Claim(("C", "D"), 0)) == SignOnRefused(RefusalReason.HELD, "C", "u1")
    assert desk.standing("u2") is UnitStanding.DISPUTED
    return desk


def test_at_a_dispute_the_other_holder_is_told_at_once() -> None:
    desk = disputed()
    assert desk.unasked == [("u1", Contested(("C",)))]
    assert desk.kinds == [Contradicted, Refused]


def test_a_disputed_unit_blocks_the_line() -> None:
    desk = disputed()
    desk.enter("u3", "P0")
    request = RouteRequest("u3", "in", ("A", "B"))
    assert desk.hear("u3", request) == RouteRefused("in", RefusalReason.UNDEFINED, None, "u2")
    assert desk.hear("u3", SignOn("u3", ("P9",))) == SignOnRefused(RefusalReason.UNDEFINED, None, "u2")


def test_a_dispute_is_told_again_as_long_as_it_lasts_and_both_are_asked_or_told() -> None:
    desk = disputed()
    assert desk.ask(10.0) == [("u2", ClaimQuery()), ("u1", Contested(("C",)))]
    assert desk.ask(10.1) == []
    assert desk.ask(15.0) == [("u2", ClaimQuery()), ("u1", Contested(("C",)))]


def test_every_answer_to_a_report_says_what_is_contested() -> None:
    desk = disputed()
    token = desk.register.unit("u1").token
    assert desk.hear("u1", HoldingReport(("B", "C"), token)) == HoldingConfirmed(("B", "C"), token, ("C",))
    assert desk.hear("u1", HoldingReport(("B", "C"), token + 1)) == HoldingConfirmed(
        ("B", "C"), token, ("C",)
    )
    # What it gives back is contested no more, and the other's claim fits.
    assert desk.hear("u1", HoldingReport(("B",), token)) == HoldingConfirmed(("B",), token)
    assert isinstance(desk.hear("u2", Claim(("C", "D"), 0)), SignOnAccepted)
    assert desk.register.holders == {"B": "u1", "C": "u2", "D": "u2"}
    assert desk.ask(20.0) == []


def test_the_dispute_is_over_when_the_other_claims_less() -> None:
    desk = disputed()
    assert isinstance(desk.hear("u2", Claim(("D",), 0)), SignOnAccepted)
    token = desk.register.unit("u1").token
    assert desk.hear("u1", HoldingReport(("B", "C"), token)) == HoldingConfirmed(("B", "C"), token)
    assert desk.register.defined


def test_whom_persons_had_outside_and_who_holds_nothing_is_outside_when_it_claims_no_more() -> None:
    desk = defined(u1=("B", "C"))
    desk.hear("u2", Claim(("C",), 0))
    assert desk.standing("u2") is UnitStanding.DISPUTED
    desk.hear("u2", Claim((), 0))
    assert desk.standing("u2") is UnitStanding.OUTSIDE


def test_a_unit_that_reports_more_than_the_register_has_is_asked_for_its_claim() -> None:
    """It stops at the answer, which has less; what it claims is added, or disputed."""
    desk = defined(u1=("B",), u2=("E",))
    token = desk.register.unit("u1").token
    assert desk.hear("u1", HoldingReport(("B", "E"), token)) == HoldingConfirmed(("B",), token)
    assert desk.unasked == [("u1", ClaimQuery())]
    assert isinstance(desk.hear("u1", Claim(("B", "E"), token)), SignOnRefused)
    assert desk.unasked == [("u2", Contested(("E",)))]


# silent units and what must be swept ---------------------------------------------------------------------------


def swept_line() -> Desk:
    """u2 was on the line and fell silent; two persons say that it left by P9, so what it held must be swept."""
    desk = defined(u1=("B",), u2=("C", "D", "E"))
    for times in range(2):
        for person in ("Sato", "Mori"):
            desk.act(ConfirmOutside("u2", person, "P9"))
        for _ in range(ASKED_IN_VAIN * (1 - times)):
            desk.ask(desk.now_s + 10.0)
    assert desk.standing("u2") is UnitStanding.OUTSIDE
    assert desk.register.unswept == {"C", "D", "E"}
    return desk


OVER: Final = RouteRequest("u1", "over", ("C", "D", "E"))


def over(desk: Desk) -> RouteGranted:
    """What u1 is granted over what must be swept."""
    granted = desk.hear("u1", OVER)
    assert isinstance(granted, RouteGranted)
    return granted


def test_what_must_be_swept_is_granted_on_sight_only() -> None:
    desk = swept_line()
    assert over(desk).on_sight == ("C", "D", "E")
    assert desk.register.unswept == {"C", "D", "E"}  # a grant sweeps nothing


def test_a_unit_that_claims_or_signs_on_learns_what_of_it_must_be_swept() -> None:
    desk = swept_line()
    desk.hear("u1", OVER)
    for message in (Claim(("B",), 0), SignOn("u1", None)):
        accepted = desk.hear("u1", message)
        assert isinstance(accepted, SignOnAccepted)
        assert accepted.on_sight == ("C", "D", "E")


def test_swept_is_what_its_holder_reports_as_swept() -> None:
    desk = swept_line()
    desk.hear("u1", HoldingReport(("D", "E"), over(desk).token, ("C",)))
    assert desk.kinds == [Swept, Freed]
    assert desk.register.unswept == {"D", "E"}


def test_swept_is_nothing_that_the_unit_does_not_hold() -> None:
    desk = swept_line()
    token = desk.register.unit("u1").token
    desk.hear("u1", HoldingReport(("B",), token, ("C", "D", "E")))
    assert Swept not in desk.kinds
    assert desk.register.unswept == {"C", "D", "E"}


@pytest.mark.parametrize(("token_error", "epoch"), [(1, 1), (-1, 1), (0, 2)])
def test_swept_is_nothing_by_an_old_report(token_error: int, epoch: int) -> None:
    desk = swept_line()
    desk.hear("u1", HoldingReport(("E",), over(desk).token + token_error, ("C", "D")), epoch=epoch)
    assert desk.register.unswept == {"C", "D", "E"}


def test_passed_without_a_sweep_it_must_still_be_swept() -> None:
    desk = swept_line()
    desk.hear("u1", HoldingReport(("E",), over(desk).token))
    assert desk.kinds == [Freed]
    assert desk.register.unswept == {"C", "D", "E"}


def test_a_word_taken_back_stops_whoever_holds_what_the_unit_may_be_in() -> None:
    desk = swept_line()
    desk.hear("u1", OVER)
    desk.register, actions = step(desk.register, TakeBack("u2", "Abe"), desk.now_s)
    said = [(action.destination, action.message) for action in actions if isinstance(action, Send)]
    assert said == [("u1", Contested(("C", "D", "E")))]
    assert desk.hear("u1", OVER, correlation=2) == RouteRefused("over", RefusalReason.UNDEFINED, None, "u2")
    assert ("u1", Contested(("C", "D", "E"))) in desk.ask(desk.now_s + 10.0)
    # It speaks: in its portal it is nobody's hazard.
    assert isinstance(desk.hear("u2", Claim(("P9",), 1)), SignOnAccepted)
    token = desk.register.unit("u1").token
    report = HoldingReport(("B", "C", "D", "E"), token)
    assert desk.hear("u1", report) == HoldingConfirmed(report.section_ids, token, (), ("C", "D", "E"))


def test_a_silent_units_fresh_claim_against_what_was_granted_since_stops_the_other() -> None:
    """Two persons agreed on the same wrong word: u2 stands in C, where u1 now runs on sight."""
    desk = swept_line()
    desk.hear("u1", OVER)
    assert desk.hear("u2", Claim(("C",), 1)) == SignOnRefused(RefusalReason.HELD, "C", "u1")
    assert desk.unasked == [("u1", Contested(("C",)))]
    assert desk.hear("u1", OVER, correlation=2) == RouteRefused("over", RefusalReason.UNDEFINED, None, "u2")


@pytest.mark.parametrize(
    ("epoch", "ledger", "unswept", "after"),
    [
        (1, None, (), set()),  # the first start
        (2, ("u1",), ("C", "D"), {"C", "D"}),  # kept
        (2, ("u1",), (), set()),
        (2, None, (), {"A", "B", "C", "D", "E"}),  # lost with the ledger
    ],
)
def test_what_must_be_swept_is_kept_over_a_restart_and_all_where_it_was_lost(
    epoch: int, ledger: tuple[str, ...] | None, unswept: tuple[str, ...], after: set[str]
) -> None:
    assert start(CONFIG, epoch, KEYS, ledger, unswept).unswept == after
