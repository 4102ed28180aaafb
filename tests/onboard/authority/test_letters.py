"""Between machine and telegrams: which telegram answers what, whose token is newer, whose capability goes along."""

from typing import Final

import pytest
from msgspec.structs import replace

from network.model import Position
from onboard import notes
from onboard.authority import records as sym
from onboard.authority.letters import Letter, Letters
from onboard.authority.records import (
    Commit,
    OpenRequest,
    Renew,
    RequestKind,
    SendClaim,
    SendCommand,
    SendRequest,
    Take,
    TakeBackOrdered,
    TrackChangeOrdered,
    TrainEndOrdered,
)
from onboard.plan import PointsNeeded
from radio import messages as radio
from radio.envelope import Received
from tests.onboard.duty.stage import SECTIONS

UNIT, MANAGER, TERMINAL = "V1", "BM", "A-E"
P5: Final = PointsNeeded("P5", Position.NORMAL, "5", TERMINAL)
P6: Final = PointsNeeded("P6", Position.REVERSE, "5", "A-F")
FIVE, SEVEN = radio.Capability(TERMINAL, "5", b"five"), radio.Capability("B-W", "7", b"seven")
OTHER: Final = radio.Capability("A-F", "5", b"other")
ROUTE: Final = SendRequest(OpenRequest(RequestKind.ROUTE, "3>8", SECTIONS))
REPORT: Final = SendRequest(OpenRequest(RequestKind.REPORT, section_ids=("7", "8")))


def heard(
    message: radio.AnyMessage, correlation: int = 0, source: str = MANAGER, fresh: bool = True
) -> Received:
    return Received(source, 1, 0, fresh, correlation, 0.0, None, 0, message)


def grant(token: int = 20, *capabilities: radio.Capability) -> radio.RouteGranted:
    return radio.RouteGranted("3>8", SECTIONS, token, capabilities or (FIVE, SEVEN))


def proof(token: int = 20, **shown: object) -> radio.PointsProof:
    fields = {"position": Position.NORMAL, "locked": True, "detected": True} | shown
    return radio.PointsProof("P5", token=token, **fields)  # type: ignore[arg-type]


@pytest.fixture
def letters() -> Letters:
    """Signed on with token 10, by its first request."""
    letters = Letters(UNIT, MANAGER)
    letters.keep(Renew(RequestKind.SIGN_ON))
    letters.read(heard(radio.SignOnAccepted(("3",), 10, None, ()), correlation=1))
    letters.keep(Take(("3",)))
    return letters


@pytest.fixture
def holding(letters: Letters) -> Letters:
    """Granted its route with token 20, by its second request."""
    letters.keep(Renew(RequestKind.ROUTE))
    letters.read(heard(grant(), correlation=2))
    letters.keep(Take(SECTIONS))
    return letters


# what is said ---------------------------------------------------------------------------------------------------


def test_each_request_goes_out_as_its_telegram(letters: Letters) -> None:
    for ask in (RequestKind.ROUTE, RequestKind.REPORT, RequestKind.SIGN_OFF):
        letters.keep(Renew(ask))
    assert letters.write(ROUTE) == Letter(MANAGER, radio.RouteRequest(UNIT, "3>8", SECTIONS, 10), 2)
    assert letters.write(REPORT) == Letter(MANAGER, radio.HoldingReport(("7", "8"), 10), 3)
    assert letters.write(SendRequest(OpenRequest(RequestKind.SIGN_OFF))) == Letter(
        MANAGER, radio.SignOff(UNIT, 10), 4
    )
    swept = SendRequest(replace(REPORT.request, swept=("5", "6")))
    assert letters.write(swept) == Letter(MANAGER, radio.HoldingReport(("7", "8"), 10, ("5", "6")), 3)


@pytest.mark.parametrize("section_ids", [("3",), None])
def test_a_sign_on_says_what_it_claims(section_ids: tuple[str, ...] | None) -> None:
    letters = Letters(UNIT, MANAGER)
    letters.keep(Renew(RequestKind.SIGN_ON))
    request = OpenRequest(RequestKind.SIGN_ON, section_ids=section_ids)
    assert letters.write(SendRequest(request)) == Letter(MANAGER, radio.SignOn(UNIT, section_ids), 1)


def test_a_request_repeated_keeps_its_correlation_and_a_new_one_has_a_greater(letters: Letters) -> None:
    letters.keep(Renew(RequestKind.ROUTE))
    first = letters.write(ROUTE)
    assert letters.write(ROUTE) == first
    letters.keep(Renew(RequestKind.ROUTE))
    assert letters.write(ROUTE).correlation > first.correlation


def test_a_query_is_answered_with_its_own_correlation(letters: Letters) -> None:
    assert letters.read(heard(radio.ClaimQuery(), correlation=77)) == sym.QueryHeard()
    assert letters.write(SendClaim(("3",))) == Letter(MANAGER, radio.Claim(("3",), 10), 77)
    assert letters.write(SendClaim(("3",), leaving=True)).message == radio.LeavingClaim(("3",), 10)
    assert letters.write(SendClaim(None)) == Letter(MANAGER, radio.Claim(None, 0), 77)


def test_a_command_carries_token_and_capability_of_its_section(holding: Letters) -> None:
    holding.keep(Commit(P5))
    command = radio.PointsCommand("P5", Position.NORMAL, "5", 20, b"five")
    assert holding.write(SendCommand(P5)) == Letter(TERMINAL, command, 3)
    assert holding.write(SendCommand(P5)) == Letter(TERMINAL, command, 3)


def test_each_terminal_of_a_section_gets_its_own_capability(letters: Letters) -> None:
    letters.read(heard(grant(20, FIVE, OTHER)))
    letters.keep(Take(SECTIONS))
    for needed, mac in ((P5, b"five"), (P6, b"other")):
        letters.keep(Commit(needed))
        message = letters.write(SendCommand(needed)).message
        assert isinstance(message, radio.PointsCommand)
        assert message.mac == mac


def test_a_renewed_grant_takes_the_place_of_token_and_capability(holding: Letters) -> None:
    """The terminal's old capability is gone where the new telegram has none for it."""
    holding.keep(Commit(P5))
    holding.read(heard(grant(30, SEVEN)))
    holding.keep(Take(SECTIONS))
    bound = holding.write(SendCommand(P5)).message
    assert isinstance(bound, radio.PointsCommand)
    assert (bound.token, bound.mac) == (20, b"five")  # until it is commanded anew
    holding.keep(Commit(P5))
    anew = holding.write(SendCommand(P5)).message
    assert isinstance(anew, radio.PointsCommand)
    assert (anew.token, anew.mac) == (30, b"")


def test_the_answer_to_a_claim_renews_only_where_it_brings_a_capability(holding: Letters) -> None:
    holding.read(heard(radio.SignOnAccepted(("3", *SECTIONS), 25, None, (SEVEN,))))
    holding.keep(Take(()))
    assert holding.token == 25
    tokens = []
    for needed in (P5, PointsNeeded("P7", Position.NORMAL, "7", "B-W")):
        holding.keep(Commit(needed))
        message = holding.write(SendCommand(needed)).message
        assert isinstance(message, radio.PointsCommand)
        tokens.append((message.token, message.mac))
    assert tokens == [(20, b"five"), (25, b"seven")]


# what is heard --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("correlation", "answers"), [(2, True), (1, False), (0, False), (3, False)])
def test_a_grant_answers_only_the_request_open(letters: Letters, correlation: int, answers: bool) -> None:
    """Correlation 1 was that of the sign-on."""
    letters.keep(Renew(RequestKind.ROUTE))
    event = letters.read(heard(grant(), correlation))
    assert event == sym.GrantHeard("3>8", SECTIONS, ("5", "7"), answers=answers, fresh=True, newer=True)


def test_an_answer_to_an_older_request_of_the_same_kind_is_none(letters: Letters) -> None:
    letters.keep(Renew(RequestKind.ROUTE))
    letters.keep(Renew(RequestKind.ROUTE))
    for correlation, answers in ((2, False), (3, True)):
        event = letters.read(heard(grant(), correlation))
        assert isinstance(event, sym.GrantHeard)
        assert event.answers is answers


def test_before_the_first_request_nothing_is_an_answer() -> None:
    letters = Letters(UNIT, MANAGER)
    event = letters.read(heard(radio.SignOnAccepted(("3",), 10, None, ()), correlation=0))
    assert event == sym.SignOnHeard(("3",), (), answers=False, newer=True)


@pytest.mark.parametrize(("token", "newer"), [(9, False), (10, False), (11, True)])
def test_a_token_is_newer_only_if_it_is_greater(letters: Letters, token: int, newer: bool) -> None:
    letters.keep(Renew(RequestKind.ROUTE))
    letters.keep(Renew(RequestKind.REPORT))
    assert letters.read(heard(grant(token), 2)) == sym.GrantHeard(
        "3>8", SECTIONS, ("5", "7"), answers=True, fresh=True, newer=newer
    )
    confirmed = radio.HoldingConfirmed(("3",), token)
    assert letters.read(heard(confirmed, 3)) == sym.ConfirmationHeard(("3",), answers=True, newer=newer)
    accepted = radio.SignOnAccepted(("3",), token, None, (FIVE,))
    assert letters.read(heard(accepted, 9)) == sym.SignOnHeard(("3",), ("5",), answers=False, newer=newer)


def test_a_token_that_was_not_taken_changes_nothing(letters: Letters) -> None:
    """Only the machine says that it is taken: a grant that fits nothing leaves no trace."""
    letters.read(heard(grant(99), 7))
    assert letters.token == 10
    letters.keep(Commit(P5))
    message = letters.write(SendCommand(P5)).message
    assert isinstance(message, radio.PointsCommand)
    assert (message.token, message.mac) == (0, b"")


def test_a_grant_from_before_this_boot_is_not_fresh(letters: Letters) -> None:
    letters.keep(Renew(RequestKind.ROUTE))
    event = letters.read(heard(grant(), 2, fresh=False))
    assert isinstance(event, sym.GrantHeard)
    assert not event.fresh


@pytest.mark.parametrize(
    ("reason", "lost_sight"),
    [
        (reason, reason in (radio.RefusalReason.NOT_SIGNED_ON, radio.RefusalReason.STALE_TOKEN))
        for reason in radio.RefusalReason
    ],
)
def test_a_refusal_says_why_and_whether_the_manager_lost_sight(
    letters: Letters, reason: radio.RefusalReason, lost_sight: bool
) -> None:
    letters.keep(Renew(RequestKind.ROUTE))
    letters.keep(Renew(RequestKind.SIGN_OFF))
    why = reason.name.lower().replace("_", " ")
    assert letters.read(heard(radio.RouteRefused("3>8", reason, "6", "V2"), 2)) == sym.RefusalHeard(
        RequestKind.ROUTE, "3>8", f"{why}: section 6 of V2", lost_sight, answers=True
    )
    refused = letters.read(heard(radio.SignOffRefused(reason), 3))
    assert isinstance(refused, sym.RefusalHeard)
    assert (refused.ask, refused.lost_sight, refused.answers) == (RequestKind.SIGN_OFF, lost_sight, True)
    assert letters.read(heard(radio.SignOnRefused(reason), 4)) == sym.RefusalHeard(
        RequestKind.SIGN_ON, "", why, lost_sight, answers=False
    )


def test_a_sign_off_is_accepted_only_in_answer(letters: Letters) -> None:
    letters.keep(Renew(RequestKind.SIGN_OFF))
    assert letters.read(heard(radio.SignOffAccepted(), 2)) == sym.SignOffHeard(answers=True)
    assert letters.read(heard(radio.SignOffAccepted(), 1)) == sym.SignOffHeard(answers=False)


@pytest.mark.parametrize(("token", "mine"), [(20, True), (19, False), (21, False)])
def test_a_proof_is_mine_only_under_the_token_commanded(holding: Letters, token: int, mine: bool) -> None:
    holding.keep(Commit(P5))
    answer = heard(proof(token), holding.numbers.correlation, source=TERMINAL)
    assert holding.read(answer) == sym.ProofHeard("P5", TERMINAL, "normal", mine)
    refused = radio.PointsRefused("P5", radio.PointsRefusalReason.OLD_TOKEN, token)
    assert holding.read(heard(refused, source=TERMINAL)) == sym.PointsDenialHeard(
        "P5", TERMINAL, "old token", mine, stale=True
    )


@pytest.mark.parametrize("reason", radio.PointsRefusalReason)
def test_a_refusal_of_the_grant_is_told_from_one_of_the_points(
    holding: Letters, reason: radio.PointsRefusalReason
) -> None:
    """What another grant could mend is stale; that the points lie under a train or are broken, it could not."""
    holding.keep(Commit(P5))
    event = holding.read(heard(radio.PointsRefused("P5", reason, 20), source=TERMINAL))
    assert isinstance(event, sym.PointsDenialHeard)
    grants = (radio.PointsRefusalReason.BAD_CAPABILITY, radio.PointsRefusalReason.OLD_TOKEN)
    assert event.stale is (reason in grants)


def test_a_proof_that_answers_the_command_before_it_was_given_anew_is_not_mine(holding: Letters) -> None:
    holding.keep(Commit(P5))
    late = heard(proof(20), holding.numbers.correlation, source=TERMINAL)
    holding.keep(Commit(P5))
    assert holding.read(late) == sym.ProofHeard("P5", TERMINAL, "normal", mine=False)


def test_a_proof_of_points_never_commanded_is_nobodys(holding: Letters) -> None:
    assert holding.read(heard(proof(), source=TERMINAL)) == sym.ProofHeard(
        "P5", TERMINAL, "normal", mine=False
    )


@pytest.mark.parametrize("lacking", [{"locked": False}, {"detected": False}, {"position": None}])
def test_only_what_is_detected_and_locked_is_a_position(holding: Letters, lacking: dict[str, object]) -> None:
    holding.keep(Commit(P5))
    event = holding.read(heard(proof(**lacking), holding.numbers.correlation, source=TERMINAL))
    assert event == sym.ProofHeard("P5", TERMINAL, None, mine=True)


def test_what_is_contested_is_heard_with_whatever_says_so(letters: Letters) -> None:
    letters.keep(Renew(RequestKind.REPORT))
    assert letters.read(heard(radio.Contested(("3",)))) == sym.ContestHeard(("3",))
    confirmed = radio.HoldingConfirmed(("3",), 10, ("3",))
    assert letters.read(heard(confirmed, 2)) == sym.ConfirmationHeard(
        ("3",), answers=True, newer=False, contested=("3",)
    )


def test_what_must_be_swept_is_heard_with_what_is_granted(letters: Letters) -> None:
    letters.keep(Renew(RequestKind.ROUTE))
    granted = letters.read(heard(radio.RouteGranted("3>8", SECTIONS, 20, (FIVE,), ("6",)), 2))
    assert isinstance(granted, sym.GrantHeard)
    accepted = letters.read(heard(radio.SignOnAccepted(("3", "6"), 20, None, (), ("6",)), 9))
    assert isinstance(accepted, sym.SignOnHeard)
    assert granted.on_sight == accepted.on_sight == ("6",)


def test_an_order_to_another_track_counts_for_the_request_outstanding(letters: Letters) -> None:
    letters.keep(Renew(RequestKind.ROUTE))
    order = radio.TrackOrdered("3>8", "3>9")
    for correlation, answers in ((2, True), (1, False)):
        read = letters.read(heard(order, correlation))
        assert read == TrackChangeOrdered("3>8", "3>9", answers)


def test_an_order_to_end_the_train_counts_for_the_request_outstanding(letters: Letters) -> None:
    letters.keep(Renew(RequestKind.ROUTE))
    for correlation, answers in ((2, True), (1, False)):
        read = letters.read(heard(radio.TrainOrdered("3>8", "2M"), correlation))
        assert read == TrainEndOrdered("3>8", "2M", answers)


def test_a_report_of_a_train_that_has_ended_names_the_next(holding: Letters) -> None:
    holding.keep(Renew(RequestKind.REPORT))
    request = sym.OpenRequest(RequestKind.REPORT, "2M", ("3",), True, "", ("5",))
    letter = holding.write(sym.SendRequest(request))
    assert letter.message == radio.NextTrainReport(("3",), 20, ("5",), "2M")


def test_a_route_is_wanted_back_under_the_newest_token(holding: Letters) -> None:
    for token, newest in ((20, True), (19, False), (21, False)):
        read = holding.read(heard(radio.RouteTakenBack("3>8", token, 30.0)))
        assert read == TakeBackOrdered("3>8", newest, 30.0)


def test_a_refused_order_is_told_to_the_manager(letters: Letters) -> None:
    reason = radio.OrderRefusalReason.UNKNOWN_TRACK
    letter = letters.write(sym.SendRefusal("3>8", reason))
    assert letter.message == radio.OrderRefused("3>8", reason)


def test_a_restarted_peer_is_heard(letters: Letters) -> None:
    assert letters.read(heard(radio.Restarted())) == sym.PeerRestarted()


@pytest.mark.parametrize(
    "message",
    [
        radio.RouteRequest("V2", "3>8", SECTIONS),
        radio.HoldingReport((), 99),
        radio.SignOn("V2", ("3",)),
        radio.SignOff("V2", 1),
        radio.Claim(("3",), 99),
        radio.PointsCommand("P5", Position.REVERSE, "5", 20, b""),
    ],
)
def test_what_is_for_others_means_nothing_to_a_unit(letters: Letters, message: radio.AnyMessage) -> None:
    assert letters.read(heard(message)) is None


# what is written down -------------------------------------------------------------------------------------------


def test_the_journal_gets_the_token_that_belongs_to_a_line(holding: Letters) -> None:
    holding.keep(Commit(P5))
    holding.read(heard(grant(30, SEVEN)))
    holding.keep(Take(SECTIONS))
    held = notes.Holds(section_ids=SECTIONS, token=0)
    assert holding.with_token(held) == notes.Holds(section_ids=SECTIONS, token=30)
    shown = notes.Proven(points_id="P5", position=Position.NORMAL, token=0)
    assert holding.with_token(shown) == notes.Proven(points_id="P5", position=Position.NORMAL, token=20)
    seen = notes.Proven(points_id="P7", position=Position.NORMAL, token=0, by_crew=True)
    assert holding.with_token(seen) == notes.Proven(
        points_id="P7", position=Position.NORMAL, token=30, by_crew=True
    )
    assert holding.with_token(notes.Moving()) == notes.Moving()
