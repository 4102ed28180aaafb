"""What persons may enter while the line runs, and the table of all that they can enter."""

from __future__ import annotations

from itertools import product

import pytest

from radio.messages import Claim
from radio.noted import Noted
from wayside.actions import Show
from wayside.acts import LINE_ACTS, UNIT_ACTS, Act, Phase, person_key
from wayside.block_manager import Heard, step
from wayside.config import ManagerConfig, SectionEntry
from wayside.register import Register, Standing, start
from wayside.said import (
    AcceptPicture,
    ConfirmedByHand,
    ConfirmHolding,
    ConfirmOutside,
    Contradicted,
    EnterSection,
    Freed,
    Outside,
    Refused,
    WordTaken,
)

CONFIG = ManagerConfig(
    "line", "block-manager", ("u1", "u2"), tuple(SectionEntry(section) for section in "ABCE"), ()
)


class Desk:
    """A manager at its first start of the day, or after a restart; u2 holds E."""

    def __init__(self, standing: Standing = Standing.UNKNOWN, epoch: int = 1) -> None:
        self.register: Register = start(CONFIG, epoch, {}, ("u2",))
        self.why = ""
        self.claim("u2", "E")
        match standing:
            case Standing.OUTSIDE if epoch == 1:
                self.act(ConfirmOutside("u1", "Sato"))
            case Standing.OUTSIDE:
                self.claim("u1")
            case Standing.BY_HAND:
                self.act(ConfirmHolding("u1", ("A", "B"), "Sato"))
            case Standing.REPORTED:
                self.claim("u1", "A", "B")
            case Standing.DISPUTED:
                self.claim("u1", "A", "B", "E")
            case Standing.UNKNOWN:
                pass
        assert self.standing is standing

    @property
    def standing(self) -> Standing:
        return self.register.unit("u1").standing

    def claim(self, unit_id: str, *sections: str) -> None:
        self.register, _ = step(self.register, Heard(unit_id, 1, True, 1, Claim(sections, 0)), 0.0)

    def act(self, act: Act) -> list[type[Noted]]:
        self.register, actions = step(self.register, act, 60.0)
        notes = [action.note for action in actions if isinstance(action, Show)]
        self.why = "; ".join(note.why for note in notes if isinstance(note, Refused | Contradicted))
        return [type(note) for note in notes]


def test_the_tables_are_complete() -> None:
    assert set(UNIT_ACTS) == set(product(Phase, Standing, (ConfirmOutside, ConfirmHolding)))
    assert set(LINE_ACTS) == set(product(Phase, (EnterSection, AcceptPicture)))


UNKNOWN, OUTSIDE, BY_HAND = Standing.UNKNOWN, Standing.OUTSIDE, Standing.BY_HAND
REPORTED, DISPUTED = Standing.REPORTED, Standing.DISPUTED


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
    standing: Standing, outside: Standing, holding: Standing
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


@pytest.mark.parametrize(
    "standing", [UNKNOWN, OUTSIDE, REPORTED, DISPUTED]
)  # by hand comes when it is defined
@pytest.mark.parametrize("act", [ConfirmOutside("u1", "Sato"), ConfirmHolding("u1", ("A",), "Sato")])
def test_a_line_being_restored_takes_words_down_and_puts_none_in_force(standing: Standing, act: Act) -> None:
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
    desk = Desk(Standing.BY_HAND)
    for person in ("Sato", " sato"):
        assert desk.act(ConfirmHolding("u1", ("A",), person)) == [Refused]
    assert "a second person" in desk.why
    assert desk.register.held_by("u1") == ("A", "B")
    assert desk.act(ConfirmHolding("u1", ("A",), "Mori")) == [Freed, ConfirmedByHand]
    assert desk.register.held_by("u1") == ("A",)
    assert desk.act(ConfirmOutside("u1", "Mori")) == [Refused]
    assert desk.act(ConfirmHolding("u1", ("A",), "Sato")) == [ConfirmedByHand]  # not the same word
    assert desk.register.ledger == {"u1", "u2"}
    desk.act(ConfirmOutside("u1", "Mori"))
    assert desk.act(ConfirmOutside("u1", "Sato")) == [Freed, Outside]
    assert desk.register.ledger == {"u2"}


def test_a_unit_entered_by_hand_that_says_it_is_outside_is_for_two_persons_to_free() -> None:
    desk = Desk(Standing.BY_HAND)
    desk.claim("u1")
    assert desk.standing is Standing.BY_HAND
    assert desk.register.held_by("u1") == ("A", "B")
    desk.act(ConfirmOutside("u1", "Sato"))
    assert desk.act(ConfirmOutside("u1", "Mori")) == [Freed, Outside]


def test_a_word_that_waited_is_forgotten_when_the_unit_speaks() -> None:
    desk = Desk(Standing.BY_HAND)
    desk.act(ConfirmOutside("u1", "Sato"))
    assert desk.register.reentry.complete
    desk.claim("u1", "A", "B")
    assert not desk.register.reentry.complete


@pytest.mark.parametrize(("name", "key"), [("Sato", "sato"), (" Sato  Ken ", "sato ken"), ("  ", "")])
def test_who_it_is(name: str, key: str) -> None:
    assert person_key(name) == key
