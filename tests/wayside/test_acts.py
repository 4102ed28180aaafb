"""What persons may enter while the line runs, and the table of all that they can enter."""

from collections.abc import Callable
from itertools import product

import pytest

from radio.messages import (
    AnyMessage,
    Claim,
    ClaimQuery,
    HoldingConfirmed,
    HoldingReport,
    RouteRequest,
    SignOff,
    SignOn,
    SignOnAccepted,
)
from radio.noted import Noted
from wayside.actions import Action, Send, Show
from wayside.acts import ASKED_IN_VAIN, LINE_ACTS, UNIT_ACTS, Act, LineState, person_key
from wayside.block_manager import AskUnits, Heard, step, wake_at_s
from wayside.config import ManagerConfig, SectionEntry
from wayside.register import Register, UnitStanding, start
from wayside.said import (
    Accepted,
    AcceptPicture,
    ConfirmedByHand,
    ConfirmHolding,
    ConfirmOutside,
    Contradicted,
    EnterSection,
    Freed,
    Outside,
    Refused,
    TakeBack,
    TakenBack,
    ToBeSwept,
    WordTaken,
)

CONFIG = ManagerConfig(
    "line",
    "block-manager",
    ("u1", "u2"),
    (
        SectionEntry("P", portal=True),
        SectionEntry("A"),
        SectionEntry("B"),
        SectionEntry("C", open_line=True),
        SectionEntry("E"),
        SectionEntry("Q", portal=True),
    ),
    (),
)


class Desk:
    """A manager at its first start of the day, or after a restart; u2 holds E."""

    def __init__(self, standing: UnitStanding = UnitStanding.UNKNOWN, epoch: int = 1) -> None:
        self.register: Register = start(CONFIG, epoch, {}, ("u2",))
        self.why = ""
        self.now_s = 0.0
        self.noted: list[type[Noted]] = []
        self.claim("u2", "E")
        match standing:
            case UnitStanding.OUTSIDE if epoch == 1:
                self.act(ConfirmOutside("u1", "Sato"))
            case UnitStanding.OUTSIDE:
                self.claim("u1")
            case UnitStanding.BY_HAND:
                self.act(ConfirmHolding("u1", ("A", "B"), "Sato"))
            case UnitStanding.REPORTED:
                self.claim("u1", "A", "B")
            case UnitStanding.DISPUTED:
                self.claim("u1", "A", "B", "E")
            case UnitStanding.UNKNOWN:
                pass
        assert self.standing is standing

    @property
    def standing(self) -> UnitStanding:
        return self.register.unit("u1").standing

    def claim(self, unit_id: str, *sections: str) -> None:
        self.hear(Claim(sections, 0), unit_id)

    def hear(
        self, message: AnyMessage, unit_id: str = "u1", epoch: int = 1, fresh: bool = True
    ) -> list[AnyMessage]:
        """What is said to whoever, and `noted`."""
        heard = Heard(unit_id, epoch, fresh, 1, message)
        self.register, actions = step(self.register, heard, self.now_s)
        self.noted = self.kinds(actions)
        return [action.message for action in actions if isinstance(action, Send)]

    def act(self, act: Act) -> list[type[Noted]]:
        self.now_s = max(self.now_s, 60.0)
        self.register, actions = step(self.register, act, self.now_s)
        return self.kinds(actions)

    def kinds(self, actions: tuple[Action, ...]) -> list[type[Noted]]:
        notes = [action.note for action in actions if isinstance(action, Show)]
        self.why = "; ".join(note.why for note in notes if isinstance(note, Refused | Contradicted))
        return [type(note) for note in notes]

    def ask(self, times: int = 1) -> list[str]:
        """Time passes, and units in doubt are asked; who they are."""
        asked: list[str] = []
        for _ in range(times):
            due_s = wake_at_s(self.register)
            self.now_s = max(self.now_s, 0.0 if due_s is None else due_s)
            self.register, actions = step(self.register, AskUnits(), self.now_s)
            asked += [a.destination for a in actions if isinstance(a, Send) and a.message == ClaimQuery()]
        return asked

    def agree(self, act: Callable[[str], Act]) -> list[type[Noted]]:
        """Two persons say the same."""
        self.act(act("Sato"))
        return self.act(act("Mori"))


def test_the_tables_are_complete() -> None:
    assert set(UNIT_ACTS) == set(product(LineState, UnitStanding, (ConfirmOutside, ConfirmHolding, TakeBack)))
    assert set(LINE_ACTS) == set(product(LineState, (EnterSection, AcceptPicture)))


UNKNOWN, OUTSIDE, BY_HAND = UnitStanding.UNKNOWN, UnitStanding.OUTSIDE, UnitStanding.BY_HAND
REPORTED, DISPUTED = UnitStanding.REPORTED, UnitStanding.DISPUTED


@pytest.mark.parametrize(
    ("standing", "outside", "holding"),
    [
        (UNKNOWN, OUTSIDE, BY_HAND),
        (OUTSIDE, OUTSIDE, BY_HAND),
        (BY_HAND, BY_HAND, BY_HAND),
        (REPORTED, REPORTED, REPORTED),
        (DISPUTED, DISPUTED, DISPUTED),
    ],
)
def test_a_running_line_takes_one_word_only_where_it_adds(
    standing: UnitStanding, outside: UnitStanding, holding: UnitStanding
) -> None:
    desk = Desk(standing)
    before = desk.register.held_by("u1")
    kinds = desk.act(ConfirmOutside("u1", "Sato"))
    assert desk.standing is outside
    assert (Refused in kinds) is (standing in (BY_HAND, REPORTED, DISPUTED))
    assert desk.register.held_by("u1") == before
    desk = Desk(standing)
    kinds = desk.act(ConfirmHolding("u1", ("A", "B", "C"), "Sato"))
    assert desk.standing is holding
    assert (Refused in kinds) is (standing in (REPORTED, DISPUTED))


# by hand comes when it is defined
@pytest.mark.parametrize("standing", [UNKNOWN, OUTSIDE, REPORTED, DISPUTED])
@pytest.mark.parametrize("act", [ConfirmOutside("u1", "Sato"), ConfirmHolding("u1", ("A",), "Sato")])
def test_a_line_being_restored_takes_words_down_and_puts_none_in_force(
    standing: UnitStanding, act: Act
) -> None:
    desk = Desk(standing, epoch=2)
    before = (desk.register.holders, desk.register.units)
    kinds = desk.act(act)
    assert (desk.register.holders, desk.register.units) == before
    taken = standing is UNKNOWN or (standing is OUTSIDE and isinstance(act, ConfirmOutside))
    assert (WordTaken in kinds) is taken


@pytest.mark.parametrize("act", [EnterSection("A", "u1", "Sato"), AcceptPicture("Sato")])
def test_a_running_line_has_nothing_to_restore(act: Act) -> None:
    desk = Desk()
    before = desk.register
    assert desk.act(act) == [Refused]
    assert desk.register == before


def test_what_was_entered_by_hand_is_freed_by_two_persons_only() -> None:
    desk = Desk(UnitStanding.BY_HAND)
    for person in ("Sato", " sato"):
        assert desk.act(ConfirmHolding("u1", ("A",), person)) == [Refused]
    assert "a second person" in desk.why
    assert desk.register.held_by("u1") == ("A", "B")
    assert desk.act(ConfirmHolding("u1", ("A",), "Mori")) == [Freed, ToBeSwept, ConfirmedByHand]
    assert desk.register.held_by("u1") == ("A",)
    assert desk.act(ConfirmOutside("u1", "Mori", "P")) == [Refused]
    assert desk.act(ConfirmHolding("u1", ("A",), "Sato")) == [ConfirmedByHand]  # not the same word
    assert desk.register.ledger == {"u1", "u2"}
    desk.act(ConfirmOutside("u1", "Mori", "P"))
    assert desk.act(ConfirmOutside("u1", "Sato", "P")) == [Freed, ToBeSwept, Outside]
    assert desk.register.ledger == {"u2"}
    assert desk.register.unswept == {"A", "B"}


@pytest.mark.parametrize("place", ["", "A", "C", "nowhere"])
def test_of_a_unit_on_the_line_persons_must_say_by_which_portal_it_left(place: str) -> None:
    desk = Desk(UnitStanding.BY_HAND)
    before = desk.register
    for person in ("Sato", "Mori"):
        assert desk.act(ConfirmOutside("u1", person, place)) == [Refused]
    assert desk.why == "Mori: say by which portal it left the line"
    assert (desk.register.holders, desk.register.units) == (before.holders, before.units)


def test_two_persons_with_different_portals_do_not_agree() -> None:
    desk = Desk(UnitStanding.BY_HAND)
    for person, place in (("Sato", "P"), ("Mori", "Q"), ("Abe", "Q ")):
        assert desk.act(ConfirmOutside("u1", person, place)) == [Refused]
    assert desk.register.held_by("u1") == ("A", "B")
    assert desk.act(ConfirmOutside("u1", "Sato", "Q")) == [Freed, ToBeSwept, Outside]  # now as Mori


def test_of_a_unit_never_on_the_line_no_place_is_asked() -> None:
    desk = Desk()
    assert desk.act(ConfirmOutside("u1", "Sato", "A")) == [Refused]  # but none that is no portal is taken
    assert desk.act(ConfirmOutside("u1", "Sato")) == [Outside]


def test_a_silent_unit_is_never_freed_of_what_it_holds_into_open_line() -> None:
    """All trains in stations first (4.4 (4)): persons may add open line, but free nothing by it."""
    desk = Desk(UnitStanding.BY_HAND)
    assert desk.act(ConfirmHolding("u1", ("A", "B", "C"), "Sato")) == [ConfirmedByHand]
    assert desk.agree(lambda person: ConfirmHolding("u1", ("C",), person)) == [Refused]
    assert desk.why == "Mori: a silent unit must stand in a station"
    assert desk.register.held_by("u1") == ("A", "B", "C")
    assert desk.agree(lambda person: ConfirmHolding("u1", ("A",), person)) == [
        Freed,
        ToBeSwept,
        ConfirmedByHand,
    ]
    assert desk.register.unswept == {"B", "C"}


def test_portals_need_no_sweep() -> None:
    """Into a portal a driver sees."""
    desk = Desk()
    desk.act(ConfirmHolding("u1", ("P", "A"), "Sato"))
    desk.agree(lambda person: ConfirmOutside("u1", person, "P"))
    assert desk.register.unswept == {"A"}


# units that reported and fell silent ----------------------------------------------------------------------------


def outside(person: str) -> Act:
    return ConfirmOutside("u1", person, "P")


def test_a_unit_that_reported_is_asked_before_two_words_count() -> None:
    desk = Desk(UnitStanding.REPORTED)
    assert wake_at_s(desk.register) is None
    assert desk.act(outside("Sato")) == [Refused]
    assert "a second person" in desk.why
    assert desk.ask(ASKED_IN_VAIN) == ["u1"] * ASKED_IN_VAIN
    assert desk.act(outside("Sato")) == [Refused]  # one person, however often
    assert desk.act(outside("Mori")) == [Freed, ToBeSwept, Outside]
    assert desk.register.held_by("u1") == ()
    assert desk.register.unswept == {"A", "B"}
    assert desk.register.doubted == {}
    assert desk.ask() == ["u1"]  # it counts by persons' word alone, so it is asked all the same


@pytest.mark.parametrize("times", range(ASKED_IN_VAIN))
def test_two_words_do_not_count_while_it_is_still_being_asked(times: int) -> None:
    desk = Desk(UnitStanding.REPORTED)
    desk.agree(outside)
    desk.ask(times)
    assert desk.agree(outside) == [Refused]
    assert "still being asked" in desk.why
    assert desk.register.held_by("u1") == ("A", "B")
    desk.ask(ASKED_IN_VAIN - times)
    assert desk.act(outside("Sato")) == [Freed, ToBeSwept, Outside]


@pytest.mark.parametrize(
    "message",
    [
        Claim(("A", "B"), 0),
        HoldingReport(("A", "B"), 1),
        RouteRequest("u1", "R", ("C",)),
        SignOn("u1", ("A",)),
    ],
)
def test_a_unit_that_answers_voids_the_words(message: AnyMessage) -> None:
    desk = Desk(UnitStanding.REPORTED)
    desk.agree(outside)
    desk.ask(ASKED_IN_VAIN)
    desk.hear(message)
    assert desk.noted[0] is Refused
    assert "it speaks for itself" in desk.why
    assert desk.act(outside("Sato")) == [Refused]
    assert desk.register.held_by("u1") == ("A", "B")
    assert desk.register.doubted == {"u1": 0}  # asked anew


@pytest.mark.parametrize("message", [Claim((), 0), SignOn("u1", ("Q",))])
def test_a_unit_that_is_outside_frees_what_one_person_entered_for_it_wrongly(message: AnyMessage) -> None:
    """Taken back, and the unit says that it holds nothing: with two persons who say so it is held no more."""
    desk = Desk(UnitStanding.BY_HAND)
    desk.claim("u2", "E", "Q")  # where u1 may not enter
    desk.act(TakeBack("u1", "Sato"))
    desk.claim("u1")
    assert desk.noted == [Contradicted, Accepted]
    assert desk.register.held_by("u1") == ("A", "B")
    desk.agree(outside)
    for _ in range(ASKED_IN_VAIN):
        desk.ask()
        desk.hear(message)
        assert desk.register.held_by("u1") == ("A", "B")  # by its own word nothing is freed
    assert desk.act(outside("Sato")) == [Freed, ToBeSwept, Outside]


def test_words_of_a_unit_that_has_entered_since_count_no_more() -> None:
    desk = Desk(UnitStanding.BY_HAND)
    desk.act(TakeBack("u1", "Sato"))
    desk.claim("u1")
    desk.agree(outside)
    desk.ask(ASKED_IN_VAIN)
    assert SignOnAccepted in map(type, desk.hear(SignOn("u1", ("P",))))
    assert desk.act(outside("Sato")) == [Refused]
    assert "P" in desk.register.held_by("u1")


def test_where_it_stands_in_a_station_counts_too() -> None:
    desk = Desk(UnitStanding.REPORTED)
    desk.agree(lambda person: ConfirmHolding("u1", ("A",), person))
    desk.ask(ASKED_IN_VAIN)
    freed = desk.act(ConfirmHolding("u1", ("A",), "Sato"))
    assert freed == [Freed, ToBeSwept, ConfirmedByHand]
    assert desk.register.held_by("u1") == ("A",)
    assert desk.register.unswept == {"B"}


@pytest.mark.parametrize(
    ("act", "why"),
    [
        (ConfirmOutside("u1", "Sato"), "say by which portal it left the line"),
        (ConfirmOutside("u1", "Sato", "B"), "say by which portal it left the line"),
        (ConfirmHolding("u1", ("B", "C"), "Sato"), "a silent unit must stand in a station"),
        (ConfirmHolding("u1", ("B", "E"), "Sato"), "section E is held by u2"),
        (ConfirmHolding("u1", (), "Sato"), "an empty entry; confirm the unit as outside"),
        (ConfirmHolding("u1", ("nowhere",), "Sato"), "unknown section"),
    ],
)
def test_words_of_a_unit_that_reported_that_make_no_sense(act: Act, why: str) -> None:
    desk = Desk(UnitStanding.REPORTED)
    before = desk.register
    assert desk.act(act) == [Refused]
    assert desk.why == f"Sato: {why}"
    assert desk.register == before


def spoken_for() -> Desk:
    """u1 reported, fell silent, and two persons say that it left by P; its telegrams may still be on the air."""
    desk = Desk(UnitStanding.REPORTED)
    desk.agree(outside)
    desk.ask(ASKED_IN_VAIN)
    desk.act(outside("Sato"))
    assert desk.standing is UnitStanding.OUTSIDE
    return desk


@pytest.mark.parametrize("fresh", [False, True])
@pytest.mark.parametrize(
    "message",
    [SignOn("u1", ("P",)), SignOff("u1", 1), HoldingReport(("A", "B"), 1), RouteRequest("u1", "R", ("C",))],
)
def test_what_a_boot_says_that_persons_spoke_for_is_challenged(message: AnyMessage, fresh: bool) -> None:
    desk = spoken_for()
    before = desk.register
    assert desk.hear(message, fresh=fresh) == [ClaimQuery()]
    assert desk.register == before


def test_its_claim_counts_only_if_it_is_fresh() -> None:
    desk = spoken_for()
    assert desk.hear(Claim(("A", "B"), 1), fresh=False) == [ClaimQuery()]
    assert desk.standing is UnitStanding.OUTSIDE
    (accepted,) = desk.hear(Claim(("A", "B"), 1))
    assert isinstance(accepted, SignOnAccepted)
    assert accepted.section_ids == ("A", "B")
    assert desk.standing is UnitStanding.REPORTED
    assert isinstance(desk.hear(HoldingReport(("A", "B"), accepted.token))[0], HoldingConfirmed)


def test_its_next_boot_speaks_for_itself() -> None:
    desk = spoken_for()
    (accepted,) = desk.hear(SignOn("u1", ("P",)), epoch=2)
    assert isinstance(accepted, SignOnAccepted)
    assert desk.standing is UnitStanding.REPORTED


# taking back ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("standing", [OUTSIDE, BY_HAND])
def test_what_persons_said_is_taken_back_by_any_one_of_them(standing: UnitStanding) -> None:
    """It is unknown again, so nothing is granted, and it is asked; a word on it needs a second person from then on."""
    desk = Desk(standing)
    held = desk.register.held_by("u1")
    assert desk.register.defined
    assert desk.act(TakeBack("u1", "Abe")) == [TakenBack]
    assert desk.standing is UnitStanding.UNKNOWN
    assert not desk.register.defined
    assert desk.register.held_by("u1") == held
    assert desk.register.ledger == {"u1", "u2"}
    assert desk.ask() == ["u1"]
    assert desk.act(outside("Sato")) == [Refused]
    assert not desk.register.defined
    assert Outside in desk.act(outside("Mori"))
    assert desk.register.defined


def test_taken_back_its_own_word_counts_again() -> None:
    desk = Desk(UnitStanding.OUTSIDE)
    desk.act(TakeBack("u1", "Abe"))
    desk.claim("u1", "A", "B")
    assert desk.standing is UnitStanding.REPORTED
    assert desk.register.defined


def test_taken_back_a_boot_that_persons_spoke_for_still_needs_its_claim() -> None:
    desk = spoken_for()
    desk.act(TakeBack("u1", "Abe"))
    assert desk.hear(SignOn("u1", ("P",))) == [ClaimQuery()]
    assert desk.hear(Claim(("A", "B"), 1), fresh=False) == [ClaimQuery()]
    assert desk.standing is UnitStanding.UNKNOWN


def test_what_a_unit_said_itself_no_person_takes_back() -> None:
    desk = Desk()
    desk.claim("u1")
    assert desk.standing is UnitStanding.OUTSIDE
    before = desk.register
    assert desk.act(TakeBack("u1", "Abe")) == [Refused]
    assert desk.why == "Abe: it has said so itself"
    assert desk.register == before


@pytest.mark.parametrize("standing", [UNKNOWN, REPORTED, DISPUTED])
def test_where_no_word_counts_there_is_nothing_to_take_back(standing: UnitStanding) -> None:
    desk = Desk(standing)
    holders, units = desk.register.holders, desk.register.units
    assert desk.act(TakeBack("u1", "Abe")) == [Refused]
    assert desk.why == "Abe: no word of a person counts for it"
    assert (desk.register.holders, desk.register.units) == (holders, units)


def test_a_first_word_that_waits_is_taken_back_by_who_said_it() -> None:
    desk = Desk(UnitStanding.REPORTED)
    desk.act(outside("Sato"))
    desk.ask(ASKED_IN_VAIN)
    desk.act(TakeBack("u1", "Sato"))
    assert desk.act(outside("Mori")) == [Refused]
    assert "a second person" in desk.why
    assert desk.register.held_by("u1") == ("A", "B")


@pytest.mark.parametrize("standing", [UNKNOWN, OUTSIDE, REPORTED, DISPUTED])
def test_of_a_line_being_restored_a_person_takes_back_their_own_words(standing: UnitStanding) -> None:
    desk = Desk(standing, epoch=2)
    for person in ("Sato", "Mori"):
        desk.act(EnterSection("C", "u1", person))
    assert desk.act(TakeBack("u1", "Sato"))[0] is TakenBack
    assert desk.register.reentry.entries == {"C": {"mori": "u1"}}
    assert desk.standing is standing


def test_a_unit_entered_by_hand_that_says_it_is_outside_is_for_two_persons_to_free() -> None:
    desk = Desk(UnitStanding.BY_HAND)
    desk.claim("u1")
    assert desk.standing is UnitStanding.BY_HAND
    assert desk.register.held_by("u1") == ("A", "B")
    assert desk.agree(outside) == [Freed, ToBeSwept, Outside]


def test_a_word_that_waited_is_forgotten_when_the_unit_speaks() -> None:
    desk = Desk(UnitStanding.BY_HAND)
    desk.act(outside("Sato"))
    assert desk.register.reentry.complete
    desk.claim("u1", "A", "B")
    assert not desk.register.reentry.complete


@pytest.mark.parametrize(("name", "key"), [("Sato", "sato"), (" Sato  Ken ", "sato ken"), ("  ", "")])
def test_who_it_is(name: str, key: str) -> None:
    assert person_key(name) == key
