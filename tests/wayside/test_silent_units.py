"""Units that stay silent when the line is restored: where they stand, and what must then be swept (4.4 (4))."""

import pytest

from radio.messages import (
    Claim,
    ClaimQuery,
    HoldingConfirmed,
    HoldingReport,
    RouteGranted,
    RouteRequest,
    SignOnAccepted,
    SignOnRefused,
)
from tests.wayside.manager_desk import defined
from tests.wayside.reentry_desk import HELD, Desk
from wayside import reentry
from wayside.config import ReentryMode
from wayside.register import ReentryStage, UnitStanding
from wayside.said import (
    AcceptPicture,
    ConfirmHolding,
    ConfirmOutside,
    EnterSection,
    TakeBack,
    TakenBack,
    ToBeSwept,
)

MODES = pytest.mark.parametrize("mode", ReentryMode)


def silent(mode: ReentryMode, unit_id: str = "u1") -> Desk:
    """All but one have spoken; by hand every section is entered as it is."""
    desk = Desk(mode)
    desk.claim(*(HELD.keys() - {unit_id}))
    if mode is ReentryMode.BY_HAND:
        desk.enter()
    return desk


@MODES
def test_a_silent_unit_in_a_station_counts_by_two_persons_word_and_the_line_is_swept(
    mode: ReentryMode,
) -> None:
    """But for what units that speak hold, and portals."""
    desk = silent(mode)
    for person in ("Sato", "Mori"):
        desk.act(ConfirmHolding("u1", ("A", "B"), person))
    assert ToBeSwept in desk.accept()
    assert desk.register.defined
    assert desk.register.unit("u1").standing is UnitStanding.BY_HAND
    assert desk.register.held_by("u1") == ("A", "B")
    assert desk.register.unswept == {"A", "B", "C", "D"}


@MODES
def test_a_silent_unit_on_open_line_is_vouched_for_by_nobody(mode: ReentryMode) -> None:
    desk = silent(mode)
    for person in ("Sato", "Mori", "Abe"):
        desk.act(ConfirmHolding("u1", ("B", "C"), person))
    desk.accept()
    assert not desk.register.defined
    assert "u1" in reentry.missing(desk.register).unit_ids
    for person in ("Sato", "Mori", "Abe"):  # brought into the station
        desk.act(ConfirmHolding("u1", ("B",), person))
    if mode is ReentryMode.BY_HAND:
        for section_id in ("A", "C"):
            desk.act(EnterSection(section_id, None, "Sato"))
    desk.accept()
    assert desk.register.defined
    assert desk.register.held_by("u1") == ("B",)


@MODES
@pytest.mark.parametrize(
    ("places", "defined"),
    [
        (("P0", "P0"), True),
        (("P0", "P9"), False),
        (("P0", ""), False),
        (("", ""), False),
        (("B", "B"), False),
        (("P0", "P9", "P9"), False),
    ],
)
def test_a_silent_unit_has_left_by_the_portal_that_all_name(
    places: tuple[str, ...], defined: bool, mode: ReentryMode
) -> None:
    desk = Desk(mode)
    desk.claim("u2", "u3")
    if mode is ReentryMode.BY_HAND:
        desk.enter({"A": None, "B": None})
    for person, place in zip(("Sato", "Mori", "Abe"), places, strict=False):
        desk.act(ConfirmOutside("u1", person, place))
    desk.accept()
    assert desk.register.defined is defined
    if defined:
        assert desk.register.unit("u1").standing is UnitStanding.OUTSIDE
        assert desk.register.unswept == {"A", "B", "C", "D"}


def test_a_corrected_portal_counts() -> None:
    desk = silent(ReentryMode.ASSISTED)
    for person, place in (("Sato", "P9"), ("Mori", "P0"), ("Sato", "P0")):
        desk.act(ConfirmOutside("u1", person, place))
    desk.accept()
    assert desk.register.defined


def test_where_every_unit_on_the_line_spoke_nothing_is_to_be_swept() -> None:
    desk = Desk()
    desk.claim(*HELD)
    desk.act(ConfirmOutside("u4", "Sato"))  # never signed on: nothing was ever granted to it
    desk.accept()
    assert desk.register.defined
    assert desk.register.unswept == frozenset()


@MODES
def test_words_of_a_silent_unit_are_taken_back_before_they_are_in_force(mode: ReentryMode) -> None:
    desk = silent(mode)
    for person in ("Sato", "Mori"):
        desk.act(ConfirmHolding("u1", ("A", "B"), person))
    desk.act(TakeBack("u1", "Mori"))
    desk.accept()
    assert not desk.register.defined


def test_taken_back_after_an_acceptance_that_is_over_too() -> None:
    desk = Desk(ReentryMode.BY_HAND)
    desk.enter()
    desk.accept()
    assert reentry.stage(desk.register) is ReentryStage.ACCEPTED
    assert desk.act(TakeBack("u1", "Sato"))[0] is TakenBack
    assert desk.register.reentry.accepted_by == ""


def test_two_persons_who_agree_on_the_same_wrong_word_stop_trains_and_no_grant_is_given() -> None:
    """u1 stands in B; Sato and Mori say that it left by P0. u2 comes on sight, u1 speaks: u2 is told to stop."""
    desk = Desk()
    desk.claim("u2", "u3")
    for person in ("Sato", "Mori"):
        desk.act(ConfirmOutside("u1", person, "P0"))
    desk.accept()
    back = RouteRequest("u2", "back", ("D", "C", "B"))
    granted = desk.hear("u2", back)
    assert isinstance(granted, RouteGranted)
    assert granted.on_sight == ("D", "C", "B")
    refused = desk.hear("u1", Claim(HELD["u1"], 7))
    assert isinstance(refused, SignOnRefused)
    assert ("u2", ("B",)) in desk.contested
    assert desk.check_no_grant_takes_what_a_train_holds() == 0


def test_an_acceptance_dies_with_a_new_contradiction() -> None:
    """Of the picture that the person saw: with the contradiction gone it must be accepted again."""
    desk = Desk(ReentryMode.BY_HAND)
    desk.enter()
    desk.accept()
    desk.hear("u2", Claim(("B", "E"), 7))
    assert desk.register.reentry.accepted_by == ""
    desk.hear("u2", Claim(("E",), 7))
    desk.hear("u2", HoldingReport(("E",), 7))
    desk.claim(*HELD)
    assert not desk.register.defined
    desk.act(AcceptPicture("Sato"))
    assert desk.register.defined


def test_who_was_spoken_for_hears_of_its_token_from_the_answer_to_its_claim_and_from_nothing_else() -> None:
    """What the points showed it before does not count under that; so until it has heard it, it is only asked again."""
    desk, held = defined(u1=("B",)), ("B", "C", "D", "E")
    granted = desk.hear("u1", RouteRequest("u1", "over", held[1:]))
    assert isinstance(granted, RouteGranted)
    for now_s in (10.0, 20.0, 30.0):
        for person in ("Sato", "Mori"):
            desk.act(ConfirmHolding("u1", ("B",), person))
        desk.ask(now_s)
    desk.act(ConfirmHolding("u1", ("B",), "Sato"))
    assert desk.standing("u1") is UnitStanding.BY_HAND
    accepted = desk.hear("u1", Claim(held, granted.token))
    assert isinstance(accepted, SignOnAccepted)
    assert accepted.token > granted.token
    for asks in (HoldingReport(held, granted.token), RouteRequest("u1", "over", held[1:])):
        assert desk.hear("u1", asks) == ClaimQuery()
    assert desk.hear("u1", Claim(held, granted.token)) == accepted
    unheard = desk.register
    asks_on = RouteRequest("u1", "over", held[1:], accepted.token)
    assert isinstance(desk.hear("u1", asks_on), RouteGranted)
    desk.register = unheard
    for token in (accepted.token, granted.token):  # the second was under way
        confirmed = desk.hear("u1", HoldingReport(held, token))
        assert confirmed == HoldingConfirmed(held, accepted.token, on_sight=("C", "D", "E"))
