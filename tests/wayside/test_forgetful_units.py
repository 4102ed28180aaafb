"""Units that say they are outside, or that they do not know, against what the manager knew of them."""

import pytest

from radio.messages import (
    Claim,
    ClaimQuery,
    Contested,
    HoldingReport,
    RefusalReason,
    RouteGranted,
    RouteRequest,
    SignOn,
    SignOnAccepted,
    SignOnRefused,
)
from tests.wayside import manager_desk
from tests.wayside.reentry_desk import HELD, Desk
from wayside import reentry
from wayside.register import Register, UnitStanding
from wayside.said import (
    BarUnit,
    ConfirmHolding,
    ConfirmOutside,
    Contradicted,
    Freed,
    TakeBack,
    ToBeSwept,
    UnbarUnit,
)

BACK = RouteRequest("u2", "back", ("D", "C", "B"))
NEEDED = SignOnRefused(RefusalReason.CLAIM_NEEDED)


def forgetful() -> Desk:
    """u1, which was on the line, says that it is outside; the others have spoken."""
    desk = Desk()
    desk.claim("u2", "u3")
    assert isinstance(desk.hear("u1", Claim((), 0), epoch=2), SignOnAccepted)
    return desk


def test_an_empty_claim_of_one_that_was_on_the_line_is_shown_and_the_line_is_swept() -> None:
    desk = forgetful()
    assert "it may have been on the line, and says that it is outside" in desk.why
    assert "u1" in desk.register.ledger  # a second restart must not take its word alone
    assert ToBeSwept in desk.accept()
    assert desk.register.unswept == {"A", "B", "C", "D"}
    assert "u1" not in desk.register.ledger
    granted = desk.hear("u2", BACK)
    assert isinstance(granted, RouteGranted)
    assert granted.on_sight == BACK.section_ids


def test_without_the_rule_it_would_be_granted_as_any_other(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reentry, "cannot_be_outside", lambda *_: False)
    desk = forgetful()
    desk.accept()
    granted = desk.hear("u2", BACK)
    assert isinstance(granted, RouteGranted)
    assert not granted.on_sight


def test_one_person_who_says_by_which_portal_it_left_spares_the_sweep() -> None:
    desk = forgetful()
    desk.act(ConfirmOutside("u1", "Mori", "P0"))
    assert ToBeSwept not in desk.accept()
    assert not desk.register.unswept
    assert desk.register.defined


def test_one_person_who_names_no_portal_does_not() -> None:
    desk = forgetful()
    desk.act(ConfirmOutside("u1", "Mori", ""))
    assert "by which portal" in desk.why
    assert ToBeSwept in desk.accept()


def test_the_word_of_one_that_was_not_on_the_line_needs_nothing() -> None:
    desk = Desk()
    desk.claim(*HELD, "u4")
    assert Contradicted not in [type(note) for note in desk.notes]
    assert ToBeSwept not in desk.accept()


def test_one_that_does_not_know_says_nothing() -> None:
    """The picture lacks it; nothing that it then hears is an acceptance."""
    desk = Desk()
    desk.claim("u2", "u3")
    assert desk.hear("u1", Claim(None, 0), epoch=2) == NEEDED
    desk.accept()
    assert "unit u1" in desk.why
    assert not desk.register.defined


def test_two_persons_speak_for_one_that_does_not_know() -> None:
    """Its crew never enters a train number: its answers do not take what people say of it away."""
    desk = manager_desk.defined(u1=("B", "C"))
    for person in ("Sato", "Mori"):
        desk.act(ConfirmOutside("u1", person, "P0"))
    for count in range(1, 5):
        assert ("u1", ClaimQuery()) in desk.ask(60.0 * count)
        desk.register, _ = manager_desk.step(
            desk.register, manager_desk.Heard("u1", 2, True, 0, Claim(None, 0)), desk.now_s
        )
    assert Freed in desk.act(ConfirmOutside("u1", "Sato", "P0"))
    assert desk.standing("u1") is UnitStanding.OUTSIDE
    assert desk.register.unswept == {"B", "C"}


@pytest.mark.parametrize("answers", [True, False])
def test_one_that_was_not_told_what_it_holds_and_was_spoken_for_is_told_what_persons_said(
    *, answers: bool
) -> None:
    """Its sign-on was taken and the answer lost; before it has answered a question, a word of it may be an old one."""
    desk = manager_desk.defined(u1=("B", "C"))
    signs_on = SignOn("u1", None)
    assert isinstance(desk.hear("u1", signs_on, epoch=2), SignOnAccepted)  # it does not hear this
    for person in ("Sato", "Mori"):
        desk.act(BarUnit("u1", person))
        desk.act(ConfirmHolding("u1", ("B", "C"), person))
    for person in ("Sato", "Mori"):
        desk.act(UnbarUnit("u1", person))
    assert desk.standing("u1") is UnitStanding.BY_HAND
    assert desk.hear("u1", signs_on, epoch=2) == ClaimQuery()
    if answers:
        event = manager_desk.Heard("u1", 2, True, 0, Claim(None, 0))
        desk.register, _ = manager_desk.step(desk.register, event, desk.now_s)
        accepted = desk.hear("u1", signs_on, epoch=2)
        assert isinstance(accepted, SignOnAccepted)
        assert accepted.section_ids == ("B", "C")
    else:
        assert desk.hear("u1", signs_on, epoch=2) == ClaimQuery()


def test_an_empty_claim_frees_nothing_of_a_unit_that_is_on_the_line() -> None:
    desk = manager_desk.defined(u1=("B", "C"))
    desk.hear("u1", Claim((), 0), epoch=2)
    assert desk.kinds[0] is Contradicted
    assert desk.register.held_by("u1") == ("B", "C")


# who counts as outside signs on and does not know what it holds ---------------------------------------------------


def on_the_line_after_all() -> manager_desk.Desk:
    """u2 runs in B and C; u1, which signed off, or so the register has it, does not know what it holds."""
    desk = manager_desk.defined(u2=("B", "C"))
    assert desk.hear("u1", SignOn("u1", None), epoch=2) == NEEDED
    return desk


def test_it_stops_every_train_on_the_line() -> None:
    desk = on_the_line_after_all()
    assert desk.kinds[:2] == [Contradicted, ToBeSwept]
    assert desk.unasked == [("u2", Contested(("B", "C")))]
    assert desk.standing("u1") is UnitStanding.UNKNOWN
    assert not desk.register.defined
    assert "u1" in desk.register.ledger


def test_who_was_stopped_hears_what_it_must_sweep() -> None:
    desk = on_the_line_after_all()
    asked = [unit_id for unit_id, message in desk.ask(100.0) if message == ClaimQuery()]
    assert asked == ["u1", "u2"]
    accepted = desk.hear("u2", Claim(("B", "C"), desk.register.unit("u2").token))
    assert isinstance(accepted, SignOnAccepted)
    assert accepted.on_sight == ("B", "C")


def test_its_own_claim_ends_it() -> None:
    desk = on_the_line_after_all()
    assert isinstance(desk.hear("u1", SignOn("u1", ("E",)), epoch=2), SignOnAccepted)
    assert desk.register.defined
    assert not desk.register.contested("u2")
    report = HoldingReport(("B", "C"), desk.register.unit("u2").token)
    assert desk.hear("u2", report).contested == ()  # type: ignore[union-attr]


def test_two_persons_end_it() -> None:
    desk = on_the_line_after_all()
    for person in ("Sato", "Mori"):
        desk.act(ConfirmOutside("u1", person, "P0"))
    assert desk.standing("u1") is UnitStanding.OUTSIDE
    assert desk.register.defined


def test_before_its_crew_says_anything_that_it_does_not_know_changes_nothing() -> None:
    desk = manager_desk.defined(u2=("B", "C"))
    before = desk.register
    event = manager_desk.Heard("u1", 2, True, 0, Claim(None, 0))
    after, actions = manager_desk.step(before, event, 0.0)
    assert (after, actions) == (before, ())


def test_taken_back_and_outside_by_its_own_word_the_line_is_swept() -> None:
    desk = manager_desk.defined(u2=("B", "C"))
    desk.act(ConfirmOutside("u1", "Sato"))
    desk.act(TakeBack("u1", "Sato"))
    assert desk.standing("u1") is UnitStanding.UNKNOWN
    desk.hear("u1", Claim((), 0))
    assert ToBeSwept in desk.kinds
    register: Register = desk.register
    assert register.unswept == {"A", "D", "E"}
