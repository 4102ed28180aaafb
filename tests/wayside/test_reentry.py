"""Re-entry after the manager lost its memory: what persons and units say, what stops each wrong entry."""

from collections.abc import Mapping

import pytest

from radio.envelope import CLOCK_SKEW_MAX_S
from radio.messages import (
    Claim,
    ClaimQuery,
    HoldingReport,
    RefusalReason,
    RouteRefused,
    RouteRequest,
    SignOff,
    SignOffAccepted,
    SignOn,
    SignOnAccepted,
    SignOnRefused,
)
from tests.wayside.reentry_desk import HELD, KEYS, SECTIONS, Desk, config_of
from wayside import reentry
from wayside.actions import Send, Show
from wayside.acts import Act
from wayside.block_manager import Heard, step
from wayside.config import ReentryMode
from wayside.reentry import PictureClash
from wayside.register import ReentryStage, UnitStanding, start
from wayside.said import (
    AcceptPicture,
    BoundaryPassed,
    ConfirmHolding,
    ConfirmOutside,
    Contradicted,
    EnterSection,
    Outside,
    PictureChanged,
    Refused,
    WordTaken,
)

MODES = pytest.mark.parametrize("mode", ReentryMode)


@MODES
def test_claims_and_one_person_define_the_line(mode: ReentryMode) -> None:
    desk = Desk(mode)
    desk.claim(*HELD)
    assert desk.check_no_grant_takes_what_a_train_holds() == 0
    if mode is ReentryMode.BY_HAND:
        assert desk.accept() == [Refused]
        assert desk.why.startswith("Sato: not complete: section P0, section A")
        desk.enter()
    assert desk.accept() == [Outside, PictureChanged]  # u4: silent, never signed on
    assert desk.register.defined
    assert desk.register.holders == {"A": "u1", "B": "u1", "E": "u2", "P9": "u3"}
    assert desk.check_no_grant_takes_what_a_train_holds() > 0
    assert desk.register.reentry.defined_s == desk.now_s


def test_the_picture_may_be_accepted_by_hand_before_the_units_speak() -> None:
    desk = Desk(ReentryMode.BY_HAND)
    desk.enter()
    assert desk.accept() == [PictureChanged]
    assert reentry.stage(desk.register) is ReentryStage.ACCEPTED
    assert desk.register.undefined_because_of() == ("u1", "u2", "u3", "u4")
    for unit_id in HELD:
        assert not desk.register.defined
        desk.claim(unit_id)
    assert desk.register.defined


# the wrong entries of section 4.4 (4) --------------------------------------------------------------------------

LEFT_OUT: Mapping[str, str | None] = {"A": None}  # only where it stands is entered, as section 5 warns
TRAIN_LEFT_OUT: Mapping[str, str | None] = {"A": None, "B": None}
SWAPPED: Mapping[str, str | None] = {"A": "u2", "B": "u2", "E": "u1"}
WRONG = pytest.mark.parametrize(
    "wrong", [LEFT_OUT, TRAIN_LEFT_OUT, SWAPPED], ids=["section left out", "train left out", "trains swapped"]
)


def enter_wrongly(desk: Desk, wrong: Mapping[str, str | None]) -> None:
    """The way of each mode: every section, or the units that have not spoken."""
    if desk.mode is ReentryMode.BY_HAND:
        desk.enter(wrong)
        return
    for unit_id in ("u1", "u2"):
        right = {section: unit for unit, held in HELD.items() for section in held}
        sections = tuple(section for section in SECTIONS if (right | dict(wrong)).get(section) == unit_id)
        outside = ConfirmOutside(unit_id, "Sato", "P0")
        desk.act(ConfirmHolding(unit_id, sections, "Sato") if sections else outside)


@MODES
@WRONG
def test_wrong_and_the_unit_silent_one_persons_word_is_not_enough(
    wrong: Mapping[str, str | None], mode: ReentryMode
) -> None:
    desk = Desk(mode)
    desk.claim("u3")
    enter_wrongly(desk, wrong)
    desk.accept()
    assert not desk.register.defined
    assert "u1" in reentry.missing(desk.register).unit_ids
    over = RouteRequest("u3", "up", ("E",))
    assert desk.hear("u3", over) == RouteRefused("up", RefusalReason.UNDEFINED, None, "u1")
    assert desk.check_no_grant_takes_what_a_train_holds() == 0


@MODES
@WRONG
def test_wrong_and_the_unit_restarted_too_a_claim_is_needed(
    wrong: Mapping[str, str | None], mode: ReentryMode
) -> None:
    desk = Desk(mode)
    desk.claim("u2", "u3") if wrong is not SWAPPED else desk.claim("u3")
    enter_wrongly(desk, wrong)
    desk.accept()
    assert desk.hear("u1", SignOn("u1", None), 2) == SignOnRefused(RefusalReason.CLAIM_NEEDED)
    assert not desk.register.defined
    assert desk.check_no_grant_takes_what_a_train_holds() == 0
    # A tag tells it where it stands, and that is what it claims.
    answer = desk.hear("u1", SignOn("u1", ("B",)), 2)
    assert isinstance(answer, SignOnRefused if wrong is SWAPPED else SignOnAccepted)
    assert desk.register.holders["B"] == "u1"


@MODES
@pytest.mark.parametrize("wrong", [LEFT_OUT, TRAIN_LEFT_OUT], ids=["section left out", "train left out"])
def test_left_out_and_the_unit_speaks_its_claim_is_added_and_shown(
    wrong: Mapping[str, str | None], mode: ReentryMode
) -> None:
    desk = Desk(mode)
    enter_wrongly(desk, wrong)
    desk.accept()
    desk.claim("u1")
    if mode is ReentryMode.BY_HAND:
        assert [type(note) for note in desk.notes].count(Contradicted) == len(wrong)
        assert PictureClash.ENTERED_FREE.value in desk.why
    desk.claim("u2", "u3")
    desk.define()
    assert desk.register.held_by("u1") == ("A", "B")
    assert desk.check_no_grant_takes_what_a_train_holds() > 0


@MODES
def test_swapped_and_the_units_speak_both_are_disputed_until_the_person_corrects(mode: ReentryMode) -> None:
    desk = Desk(mode)
    enter_wrongly(desk, SWAPPED)
    desk.accept()
    assert desk.hear("u1", Claim(("A", "B"), 7)) == SignOnRefused(RefusalReason.HELD, "A", "u2")
    assert Contradicted in [type(note) for note in desk.notes]
    assert desk.hear("u2", Claim(("E",), 7)) == SignOnRefused(RefusalReason.HELD, "E", "u1")
    desk.claim("u3")
    assert desk.accept() == [Refused]
    assert PictureClash.ENTERED_FOR_ANOTHER.value in desk.why
    assert desk.check_no_grant_takes_what_a_train_holds() == 0
    # A word against what a unit says is refused; its own word, or the section, is a correction.
    assert desk.act(ConfirmHolding("u1", ("E",), "Sato")) == [Refused]
    assert desk.act(ConfirmHolding("u1", ("A", "B"), "Sato"))[0] is WordTaken
    assert desk.act(EnterSection("E", "u2", "Sato"))[0] is WordTaken
    desk.claim("u1", "u2")
    desk.define()
    assert desk.check_no_grant_takes_what_a_train_holds() > 0


@MODES
@pytest.mark.parametrize("act", [EnterSection("B", "u1", "Sato"), AcceptPicture("Sato")])
def test_too_early_a_grant_of_the_boot_before_may_still_arrive(mode: ReentryMode, act: Act) -> None:
    desk = Desk(mode)
    age_max_s = desk.register.plan.telegram_age_max_s + CLOCK_SKEW_MAX_S
    desk.claim(*HELD)
    desk.now_s = age_max_s
    for entry in (act, ConfirmHolding("u1", ("B",), "Sato"), ConfirmOutside("u4", "Sato")):
        assert desk.act(entry) == [Refused]
        assert desk.why == "Sato: too early"
    assert desk.register.reentry.entries == {}
    desk.now_s = age_max_s + 0.1
    assert desk.act(ConfirmOutside("u4", "Sato")) == [WordTaken]


@MODES
def test_accepted_before_the_entries_it_is_refused_with_what_is_missing(mode: ReentryMode) -> None:
    desk = Desk(mode)
    assert desk.accept() == [Refused]
    assert "not complete" in desk.why
    assert ("section P0" in desk.why) is (mode is ReentryMode.BY_HAND)
    assert ("unit u1" in desk.why) is (mode is ReentryMode.ASSISTED)


# four eyes -----------------------------------------------------------------------------------------------------


@MODES
def test_two_persons_speak_for_a_silent_unit_which_then_learns_it(mode: ReentryMode) -> None:
    desk = Desk(mode)
    desk.claim("u2", "u3")
    if mode is ReentryMode.BY_HAND:
        desk.enter()
    else:
        assert desk.act(ConfirmHolding("u1", ("A", "B"), "Sato")) == [WordTaken]
    desk.accept()
    assert not desk.register.defined
    desk.act(ConfirmHolding("u1", ("A", "B"), "Mori"))
    desk.define()
    assert desk.register.unit("u1").standing is UnitStanding.BY_HAND
    accepted = desk.hear("u1", SignOn("u1", None), 2)
    assert isinstance(accepted, SignOnAccepted)
    assert accepted.section_ids == ("A", "B")


@MODES
def test_persons_who_differ_define_nothing(mode: ReentryMode) -> None:
    desk = Desk(mode)
    desk.claim("u2", "u3")
    enter_wrongly(desk, LEFT_OUT)
    desk.act(ConfirmHolding("u1", ("A", "B"), "Mori"))
    assert desk.accept() == [Refused]
    assert not desk.register.defined
    desk.act(ConfirmHolding("u1", ("A", "B"), "Sato"))
    desk.define()
    assert desk.register.held_by("u1") == ("A", "B")


@pytest.mark.parametrize("name", ["Sato", "sato", " SATO  "])
def test_one_person_is_not_two(name: str) -> None:
    desk = Desk()
    desk.claim("u2", "u3")
    desk.act(ConfirmHolding("u1", ("B",), "Sato"))
    desk.act(ConfirmHolding("u1", ("B",), name))
    assert desk.accept() == [Refused]


def test_the_ledger_blocks_outside_by_one_person_and_never_frees() -> None:
    desk = Desk()
    desk.claim("u2", "u3")
    assert desk.act(ConfirmOutside("u1", "Sato", "P0")) == [Refused]
    assert "a second person" in desk.why
    assert desk.accept() == [Refused]
    assert desk.act(ConfirmOutside("u1", "Mori", "P0")) == [WordTaken, PictureChanged]
    desk.define()
    assert desk.register.ledger == {"u2", "u3"}


def test_a_lost_ledger_counts_every_unit_as_on_the_line() -> None:
    desk = Desk(ledger=None)
    desk.claim(*HELD)
    assert desk.accept() == [Refused]
    assert "unit u4" in desk.why
    assert desk.act(ConfirmOutside("u4", "Sato")) == [Refused]
    desk.claim("u4")  # empty: it is off the line, in its own word
    desk.define()


def test_a_unit_that_was_heard_but_does_not_know_is_not_taken_as_outside() -> None:
    desk = Desk()
    desk.claim(*HELD)
    assert desk.hear("u4", SignOn("u4", None)) == SignOnRefused(RefusalReason.CLAIM_NEEDED)
    assert desk.accept() == [Refused]
    desk.act(ConfirmOutside("u4", "Sato"))
    desk.define()


def test_one_persons_entry_for_a_unit_off_the_line_blocks_too() -> None:
    desk = Desk()
    desk.claim(*HELD)
    desk.act(ConfirmHolding("u4", ("C",), "Sato"))
    assert desk.accept() == [Refused]
    desk.claim("u4")
    assert desk.accept() == [Refused]
    assert PictureClash.ENTERED_BUT_OUTSIDE.value in desk.why
    desk.act(ConfirmOutside("u4", "Sato"))
    desk.define()


# units and the picture -----------------------------------------------------------------------------------------


def test_trains_finish_within_what_they_hold_and_entries_follow() -> None:
    desk = Desk(ReentryMode.BY_HAND)
    desk.enter()
    desk.claim(*HELD)
    token = desk.register.unit("u1").token
    desk.hear("u1", HoldingReport(("B",), token))
    assert desk.hear("u3", SignOff("u3", desk.register.unit("u3").token)) == SignOffAccepted()
    desk.register, _ = step(desk.register, BoundaryPassed("P9"), desk.now_s)
    assert desk.accept()[-1] is PictureChanged
    assert desk.register.holders == {"B": "u1", "E": "u2"}


def test_what_was_entered_beyond_the_claim_is_held_until_the_unit_reports() -> None:
    desk = Desk(ReentryMode.BY_HAND)
    desk.enter({"C": "u1"})
    desk.claim(*HELD)
    desk.accept()
    assert desk.register.held_by("u1") == ("A", "B", "C")
    desk.hear("u1", HoldingReport(("A", "B"), desk.register.unit("u1").token))
    assert desk.register.held_by("u1") == ("A", "B")


def test_a_wish_where_the_unit_was_last_on_the_line_is_asked_about() -> None:
    desk = Desk()
    assert desk.hear("u3", SignOn("u3", ("P9",))) == ClaimQuery()
    assert desk.register.unit("u3").standing is UnitStanding.UNKNOWN
    # u4 never signed on: not even a claim makes a portal its own before the line is defined.
    assert desk.hear("u4", Claim(("P9",), 0)) == SignOnRefused(RefusalReason.UNDEFINED, None, "u1")
    assert desk.register.unit("u4").standing is UnitStanding.OUTSIDE


def test_two_units_that_claim_the_same_block_whatever_persons_say() -> None:
    desk = Desk()
    desk.claim(*HELD)
    desk.hear("u4", Claim(("B", "C"), 7))
    assert desk.accept() == [Refused]
    assert PictureClash.CLAIMED_TWICE.value in desk.why
    assert desk.act(ConfirmOutside("u4", "Sato")) == [Refused]
    assert not desk.register.defined


def test_an_entry_after_the_acceptance_takes_it_back() -> None:
    desk = Desk(ReentryMode.BY_HAND)
    desk.enter()
    desk.accept()
    desk.act(EnterSection("C", "u2", "Sato"))
    desk.claim(*HELD)
    assert not desk.register.defined
    desk.define()
    assert desk.act(EnterSection("C", None, "Sato")) == [Refused]
    assert desk.why == "Sato: nothing to restore"


def test_a_token_that_no_known_boot_gave_contradicts_its_unit_alone() -> None:
    register = start(config_of(ReentryMode.ASSISTED), 1, KEYS)
    for unit_id in ("u2", "u3"):
        register, _ = step(register, ConfirmOutside(unit_id, "Sato"), 0.0)
    never = (3 << 32) + 5
    register, actions = step(register, Heard("u1", 1, True, 1, Claim(("A", "B"), never)), 1.0)
    assert isinstance(actions[0], Show)
    assert isinstance(actions[0].note, Contradicted)
    assert register.held_by("u1") == ("A", "B"), "nobody knew better, so it may stand there"
    assert register.unit("u1").token == register.token_max, "the token is the manager's own"
    for claimed in ((), ("A", "B", "C"), None):
        after, actions = step(register, Heard("u2", 1, True, 1, Claim(claimed, 1 << 40)), 2.0)
        assert SignOnRefused(RefusalReason.UNKNOWN_TOKEN) in [
            a.message for a in actions if isinstance(a, Send)
        ]
        assert after == register
    after, _ = step(register, Heard("u4", 1, True, 1, Claim((), 1 << 60)), 3.0)
    assert (after.restoring, after.unit("u4").standing) == (False, UnitStanding.UNKNOWN)
    after, _ = step(after, ConfirmOutside("u4", "Sato", "P9"), 4.0)
    assert not after.defined, "it spoke, so one person's word does not suffice"
    after, _ = step(after, ConfirmOutside("u4", "Mori", "P9"), 5.0)
    assert after.defined


def test_claims_silences_and_contradictions_stand_side_by_side() -> None:
    desk = Desk()
    desk.claim("u2")
    desk.hear("u1", SignOn("u1", None), 2)
    desk.act(ConfirmHolding("u1", ("B", "A", "E"), "Sato"))
    seen = desk.register
    assert (seen.unit("u1").standing, seen.reentry.heard_s["u1"]) == (UnitStanding.UNKNOWN, 60.0)
    assert reentry.words_for(seen, "u1") == {"sato": {"A", "B", "E"}}
    assert seen.held_by("u2") == ("E",)
    assert [reentry.vouched(seen, unit_id) for unit_id in ("u2", "u3", "u4")] == [True, False, True]
    assert ("u3" in seen.ledger, "u4" in seen.ledger) == (True, False)
    assert (seen.holders["E"], seen.reentry.entries["E"]) == ("u2", {"sato": "u1"})
    assert (seen.defined, "C" in seen.holders) == (False, False)
    assert [(found.clash, found.section_id) for found in reentry.contradictions(seen)] == [
        (PictureClash.ENTERED_FOR_ANOTHER, "E")
    ]
    assert reentry.missing(seen).unit_ids == ("u1", "u3")
    assert (reentry.stage(seen), seen.reentry.inputs) == (ReentryStage.INCOMPLETE, {"sato": 1})


@pytest.mark.parametrize(
    "act",
    [
        EnterSection("nowhere", "u1", "Sato"),
        EnterSection("B", "ghost", "Sato"),
        EnterSection("B", "u1", " "),
        ConfirmHolding("u1", (), "Sato"),
        ConfirmHolding("u1", ("nowhere",), "Sato"),
        AcceptPicture(""),
    ],
)
def test_inputs_that_make_no_sense_are_refused_and_counted(act: Act) -> None:
    desk = Desk()
    assert desk.act(act) == [Refused]
    assert desk.register.reentry.entries == {}
    assert desk.register.inputs == 1


@pytest.mark.parametrize("claim", [Claim(("E",), 7), SignOn("u2", ("E",), 7)])
def test_what_persons_enter_beyond_a_units_claim_it_hears_of_until_it_has_given_it_back(
    claim: Claim | SignOn,
) -> None:
    """It has no reason to report by itself: one that has finished kept the line closed to others for ever. A sign-on
    that is repeated, found by `branchline verify explore 2/2/2/0 --trains 1`: its answer was lost, and nobody asked.
    """
    desk = Desk(ReentryMode.BY_HAND)
    desk.claim(*HELD)
    desk.enter({"D": "u2"})
    desk.accept()
    assert desk.register.held_by("u2") == ("D", "E")
    assert "u2" in desk.register.units_asked()
    for _ in range(2):  # the answer may be lost
        told = desk.hear("u2", claim)
        assert isinstance(told, SignOnAccepted)
        assert told.section_ids == ("D", "E")
        assert "u2" in desk.register.units_asked()
    desk.hear("u2", HoldingReport(("E",), desk.register.unit("u2").token))
    assert desk.register.held_by("u2") == ("E",)
    desk.hear("u2", Claim(("E",), 7))
    assert "u2" not in desk.register.units_asked()
