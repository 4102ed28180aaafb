"""A unit that is mad or whose key is stolen: two persons bar it, and it stops the line no longer; nothing is freed."""

import pytest

from host.device import DeviceHost
from host.store import MemoryStore
from network.errors import InputError
from network.model import Position
from radio.envelope import CLOCK_SKEW_MAX_S, Endpoint
from radio.keys import capability_mac, key_ring
from radio.messages import (
    Claim,
    ClaimQuery,
    Contested,
    HoldingConfirmed,
    HoldingReport,
    PointsCommand,
    PointsRefusalReason,
    RefusalReason,
    RouteGranted,
    RouteRefused,
    RouteRequest,
    SignOn,
    SignOnAccepted,
    SignOnRefused,
)
from tests.wayside.manager_desk import CONFIG, Desk, defined
from wayside import acts, barring, block_manager, point_terminal, reentry
from wayside.barring import NO_BARS, Bars, bars_after_word
from wayside.config import PointsEntry, TerminalConfig
from wayside.point_terminal import Commanded, TerminalMemory
from wayside.register import Register, UnitStanding
from wayside.said import (
    Barred,
    BarUnit,
    BoundaryPassed,
    ConfirmedByHand,
    ConfirmHolding,
    ConfirmOutside,
    Freed,
    Outside,
    Refused,
    ToBeSwept,
    Unbarred,
    UnbarUnit,
)

ON_THE_AIR_S = CONFIG.telegram_age_max_s + CLOCK_SKEW_MAX_S
OVER = RouteRequest("u1", "over", ("C", "D", "E"))


def bar(desk: Desk, unit_id: str) -> None:
    assert desk.act(BarUnit(unit_id, "Sato")) == [Refused]
    assert desk.act(BarUnit(unit_id, "Mori")) == [Barred]
    desk.now_s += ON_THE_AIR_S + 0.1


def in_dispute() -> Desk:
    """u1 holds the line as far as E; u2, which stands in a depot, claims C of it."""
    desk = defined(u1=("B",))
    assert isinstance(desk.hear("u1", OVER), RouteGranted)
    desk.hear("u2", Claim(("C",), 0))
    assert desk.standing("u2") is UnitStanding.DISPUTED
    return desk


def test_two_different_persons_bar_and_unbar() -> None:
    one = bars_after_word(NO_BARS, "u1", "Sato", bar=True)
    assert bars_after_word(one, "u1", " sato ", bar=True) == one, "one person in two spellings is one"
    assert bars_after_word(one, "u1", "Sato", bar=False) == NO_BARS, "and may take the word back"
    both = bars_after_word(one, "u1", "Mori", bar=True)
    assert both == Bars(("u1",))
    assert bars_after_word(bars_after_word(both, "u1", "Mori", bar=False), "u1", "Sato", bar=True) == Bars(
        ("u1",), (("u1", "mori"),)
    )
    assert bars_after_word(bars_after_word(both, "u1", "Mori", bar=False), "u1", "Sato", bar=False) == NO_BARS
    assert bars_after_word(one, "u2", "Mori", bar=True).barred == (), "they must mean the same unit"


def test_a_false_claim_stops_the_line_until_its_unit_is_barred_and_two_persons_say_where_it_is() -> None:
    desk = in_dispute()
    assert desk.act(ConfirmOutside("u2", "Sato", "P9")) == [Refused]
    bar(desk, "u2")
    assert desk.standing("u2") is UnitStanding.UNKNOWN
    assert desk.register.contested("u1") == ("C",), "nobody has said yet that it is not there"
    assert not desk.register.defined
    assert ("u1", Contested(("C",))) in desk.ask(desk.now_s + 10.0), "and u1 is told again"
    assert desk.act(ConfirmOutside("u2", "Sato", "P9")) == [Refused]
    assert not desk.register.defined
    assert desk.act(ConfirmOutside("u2", "Mori", "P9")) == [ToBeSwept, Outside]
    assert desk.register.defined
    held = desk.register.held_by("u1")
    confirmed = desk.hear("u1", HoldingReport(held, desk.register.unit("u1").token))
    assert isinstance(confirmed, HoldingConfirmed)
    assert (confirmed.contested, confirmed.on_sight) == ((), ("C",)), (
        "should both be wrong, u1 stops before it"
    )


def test_nobody_speaks_for_it_while_what_it_was_last_told_may_be_on_the_air() -> None:
    """It was let into the portal, and may not have heard it yet: it shows nothing, is seen outside, and then comes in
    (`branchline verify explore 0/0/0/1` with bars).
    """
    desk = defined()
    desk.enter("u2", "P9")
    bar(desk, "u2")
    desk.now_s -= 0.1
    for person in ("Sato", "Mori"):
        assert desk.act(ConfirmOutside("u2", person, "P9")) == [Refused]
        assert desk.register.held_by("u2") == ("P9",)
    desk.now_s += 0.1
    assert desk.act(ConfirmOutside("u2", "Sato", "P9")) == [Refused], "alone"
    assert desk.act(ConfirmOutside("u2", "Mori", "P9")) == [Freed, Outside]


def test_where_it_stands_needs_two_persons_as_well() -> None:
    desk = in_dispute()
    bar(desk, "u2")
    assert desk.act(ConfirmHolding("u2", ("P0",), "Sato")) == [Refused]
    assert not desk.register.defined
    desk.act(ConfirmHolding("u2", ("P0",), "Mori"))
    assert desk.register.defined
    assert desk.register.held_by("u2") == ("P0",)


def test_two_persons_end_a_false_claim_of_a_train_on_open_line_if_it_keeps_what_it_holds() -> None:
    """Nothing is freed by that, so it need not stand in a station (drill test_3467: it had forgotten its route)."""
    desk = defined(u1=("B",), u2=("P0",))
    assert isinstance(desk.hear("u1", OVER), RouteGranted)
    held = desk.register.held_by("u1")
    desk.hear("u1", Claim((*held, "P0"), desk.register.unit("u1").token))
    bar(desk, "u1")
    assert desk.register.contested("u2") == ("P0",)
    for person in ("Sato", "Mori"):
        assert desk.act(ConfirmHolding("u1", ("C", "D", "E"), person)) == [Refused], "B would be freed"
    assert desk.act(ConfirmHolding("u1", held, "Sato")) == [Refused]
    assert not desk.register.defined
    assert desk.act(ConfirmHolding("u1", held, "Mori")) == [ConfirmedByHand]
    assert (desk.register.held_by("u1"), desk.register.contested("u2")) == (held, ())
    assert desk.register.defined


def test_one_in_dispute_that_has_started_again_and_does_not_know_is_spoken_for_without_a_bar() -> None:
    desk = in_dispute()
    assert desk.hear("u2", Claim(None, 0), epoch=2) == SignOnRefused(RefusalReason.CLAIM_NEEDED)
    assert desk.standing("u2") is UnitStanding.UNKNOWN
    assert desk.register.contested("u1") == ("C",), "nobody has said yet that it is not there"
    assert not desk.register.defined
    assert desk.act(ConfirmHolding("u2", ("P0",), "Sato")) == [Refused]
    assert desk.act(ConfirmHolding("u2", ("P0",), "Mori")) == [ToBeSwept, ConfirmedByHand]
    assert desk.register.defined
    accepted = desk.hear("u2", SignOn("u2", None), epoch=2)
    assert isinstance(accepted, SignOnAccepted)
    assert accepted.section_ids == ("P0",)


def test_and_while_the_line_is_restored_nothing_is_left_of_what_it_said() -> None:
    desk = Desk(epoch=2)
    desk.now_s = 60.0
    desk.hear("u1", Claim(("C",), 0))
    desk.hear("u2", Claim(("B", "C"), 0))
    assert (desk.standing("u2"), desk.register.held_by("u2")) == (UnitStanding.DISPUTED, ("B",))
    desk.hear("u2", SignOn("u2", None), epoch=2)
    assert (desk.standing("u2"), desk.register.held_by("u2")) == (UnitStanding.UNKNOWN, ())
    assert "u2" in desk.register.ledger
    assert not reentry.contradictions(desk.register)


def test_what_a_barred_unit_holds_stays_its_own_in_silence() -> None:
    desk = defined(u1=("B",), u2=("P0",))
    desk.hear("u1", OVER)
    bar(desk, "u1")
    before = desk.register.holders
    assert desk.standing("u1") is UnitStanding.BY_HAND
    assert desk.register.defined
    for epoch in (1, 2):
        for message in (Claim((), 0), SignOn("u1", None), HoldingReport(("E",), 1), Claim(("P9",), 1 << 40)):
            register, actions = block_manager.step(
                desk.register, block_manager.Heard("u1", epoch, True, 1, message), desk.now_s
            )
            assert register == desk.register
            assert [type(getattr(a, "note", a)) for a in actions] == [Refused]
    desk.ask(desk.now_s + 3600.0)
    assert desk.register.holders == before
    assert isinstance(desk.hear("u2", RouteRequest("u2", "in", ("A", "B"))), RouteRefused), (
        "B is not given away"
    )


def test_a_barred_train_that_is_counted_out_has_left() -> None:
    desk = defined(u1=("P9",))
    bar(desk, "u1")
    assert desk.act(BoundaryPassed("P9")) == [Freed, Outside]


def test_unbarred_it_is_asked_and_counts_again() -> None:
    desk = defined(u1=("B",))
    bar(desk, "u1")
    desk.act(UnbarUnit("u1", "Abe"))
    assert not desk.ask(desk.now_s + 10.0)
    assert desk.act(UnbarUnit("u1", "Sato")) == [Unbarred]
    assert ("u1", ClaimQuery()) in desk.ask(desk.now_s + 20.0)
    assert desk.hear("u1", HoldingReport(("B",), 1)) == ClaimQuery(), "of its old boot only a fresh claim"
    desk.hear("u1", Claim(("B",), 0))
    assert desk.standing("u1") is UnitStanding.REPORTED
    assert isinstance(desk.hear("u1", OVER, correlation=9), RouteGranted)


def test_while_the_line_is_restored_its_words_are_forgotten_too() -> None:
    desk = Desk(epoch=2)
    desk.now_s = 60.0
    desk.hear("u1", Claim(("C",), 0))
    bar(desk, "u1")
    assert desk.register.held_by("u1") == ()
    assert (desk.standing("u1"), "u1" in desk.register.ledger) == (UnitStanding.UNKNOWN, True)


def test_no_restart_forgets_a_bar() -> None:
    store = MemoryStore()
    ring = key_ring(b"m" * 32, CONFIG.device_id, CONFIG.unit_ids, ["tA", "tD"])
    unit = Endpoint(key_ring(b"m" * 32, "u1", [CONFIG.device_id]), 1)
    DeviceHost(CONFIG, ring, store).advance(0.0, [], [BarUnit("u1", "Sato"), BarUnit("u1", "Mori")])
    again = DeviceHost(CONFIG, ring, store)
    done = again.advance(1.0, [unit.seal(CONFIG.device_id, SignOn("u1", None), 1.0)])
    assert Refused(unit_id="u1", why="barred") in done.notes
    assert "u1" not in {destination for destination, _ in done.telegrams}
    with pytest.raises(InputError, match="barred units"):
        barring.bars_kept(b"\xff")


def test_a_terminal_obeys_a_barred_unit_no_more() -> None:
    key = b"k" * 32
    config = TerminalConfig("line", "tA", (PointsEntry("p", "A", 6.0),))
    terminal = point_terminal.start(config, key, TerminalMemory())
    order = PointsCommand("p", Position.NORMAL, "A", 7, capability_mac(key, "tA", "A", "u1", 7))
    assert point_terminal.refusal(terminal, "u1", order) is None
    for person in ("Sato", "Mori"):
        terminal, _ = point_terminal.step(terminal, BarUnit("u1", person), 0.0)
    assert point_terminal.refusal(terminal, "u1", order) is PointsRefusalReason.BARRED
    again = point_terminal.start(config, key, terminal.memory)
    assert point_terminal.refusal(again, "u1", order) is PointsRefusalReason.BARRED
    other = PointsCommand("p", Position.NORMAL, "A", 8, capability_mac(key, "tA", "A", "u2", 8))
    after, _ = point_terminal.step(again, Commanded("u2", 1, other), 1.0)
    assert after.memory.bars.barred == ("u1",), "what others command takes no bar away"


SWITCHES = {
    "two persons": (
        barring,
        "bars_after_word",
        lambda _, unit_id, __, *, bar: Bars((unit_id,) if bar else ()),
    ),
    "barring frees nothing": (
        acts,
        "_shut_out",
        lambda register, event: register.with_held(event.unit_id, ()),
    ),
    "what it claims stays contested": (acts, "_may_be_in", Register.held_by),
    "an end of a claim is no release": (acts, "_given_back", acts._freed),
    "one in dispute may forget": (reentry, "unheard", lambda register, _unit_id: register),
}
CHECKS = (
    test_a_false_claim_stops_the_line_until_its_unit_is_barred_and_two_persons_say_where_it_is,
    test_two_persons_end_a_false_claim_of_a_train_on_open_line_if_it_keeps_what_it_holds,
    test_one_in_dispute_that_has_started_again_and_does_not_know_is_spoken_for_without_a_bar,
    test_where_it_stands_needs_two_persons_as_well,
    test_what_a_barred_unit_holds_stays_its_own_in_silence,
)


@pytest.mark.parametrize("off", SWITCHES)
def test_what_is_switched_off_is_seen(off: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(*SWITCHES[off])
    failed = 0
    for check in CHECKS:
        try:
            check()
        except AssertionError:
            failed += 1
    assert failed
