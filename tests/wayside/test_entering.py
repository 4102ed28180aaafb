"""Leave to come in: who has it keeps out whom, what a restart forgets, and that nobody waits for it for ever."""

import random

import pytest
from msgspec.structs import replace

from radio.messages import Claim, RefusalReason, RouteGranted, RouteRefused, RouteRequest, SignOnAccepted
from tests.wayside.entering_line import STANDS, Play, can_finish, config_of, random_case
from wayside import entering
from wayside.actions import Send
from wayside.block_manager import Heard, step
from wayside.certificate import CertificateProof, finishing_order
from wayside.places import stands_of
from wayside.register import UNKNOWN_UNIT, Register, start

MEET = [["0.1", "1.1", "2.1"], ["2.2", "1.2", "0.2"]]
WHOLE = {"u0": ("0E", "0-1", "1W", "1.1"), "u1": ("2W", "1-2", "1E", "1.2")}
ENTRY = {"u0": ("1W", "1.1"), "u1": ("1E", "1.2")}
ROUTE = {"u0": "0.1>1.1", "u1": "2.2>1.2"}


def _meeting() -> Play:
    """Two trains on their way to station 1, each with its whole route and no leave to come in."""
    play = Play(config_of([2, 2, 2], MEET), MEET)
    assert play.acts(0)
    assert play.acts(1)
    return play


def _ask(
    register: Register, unit_id: str, sections: tuple[str, ...], correlation: int = 7
) -> tuple[Register, object]:
    asked = RouteRequest(unit_id, ROUTE[unit_id], sections)
    register, actions = step(register, Heard(unit_id, 1, True, correlation, asked), 0.0)
    return register, next(a.message for a in reversed(actions) if isinstance(a, Send))


def test_a_grant_of_the_whole_route_has_no_capability_for_the_arrival_points() -> None:
    play = Play(config_of([2, 2, 2], MEET), MEET)
    register, granted = _ask(play.register, "u0", WHOLE["u0"])
    assert isinstance(granted, RouteGranted)
    assert granted.section_ids == WHOLE["u0"]
    assert [c.section_id for c in granted.capabilities] == ["0E"]
    assert register.held_by("u0") == ("0.1", "1.1", "0E", "1W", "0-1")


def test_leave_is_the_capability_and_the_other_waits_until_the_first_has_given_its_points_back() -> None:
    play = _meeting()
    register, granted = _ask(play.register, "u0", ENTRY["u0"])
    assert isinstance(granted, RouteGranted)
    assert [c.section_id for c in granted.capabilities] == ["1W"]
    register, refused = _ask(register, "u1", ENTRY["u1"])
    assert refused == RouteRefused(ROUTE["u1"], RefusalReason.OVERLAP, "1E", "u0")
    play.register, play.leave = register, {0}
    assert not play.acts(1)
    assert play.acts(0)  # stands, and gives back all but its track
    assert play.acts(1)


def test_without_the_rule_both_come_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(entering, "EXCLUDES", False)
    play = _meeting()
    register, granted = _ask(play.register, "u0", ENTRY["u0"])
    _, other = _ask(register, "u1", ENTRY["u1"])
    assert isinstance(granted, RouteGranted)
    assert isinstance(other, RouteGranted)


def test_asked_again_under_the_same_number_it_is_answered_alike() -> None:
    register, first = _ask(_meeting().register, "u0", ENTRY["u0"])
    _, again = _ask(register, "u0", ENTRY["u0"])
    assert again == first


def test_nobody_goes_out_over_points_into_which_another_may_overrun() -> None:
    """u1 stands on the second track of station 1 and would leave over the points beyond the first, where u0 comes.

    Who has leave first keeps the other out: u0 with its leave to come in, or u1 while it may be on the points.
    """
    ways = [["0.1", "1.1"], ["1.2", "2.2"]]
    for moves in ((0, 0, 1, 0, 1), (1, 0, 0, 1, 0)):
        play = Play(config_of([2, 2, 2], ways), ways)
        assert [play.acts(train) for train in moves] == [True, True, False, True, True]


def test_a_unit_that_boots_on_its_way_is_given_no_leave_by_signing_on() -> None:
    play = _meeting()
    held = play.register.held_by("u0")
    _, actions = step(play.register, Heard("u0", 1, True, 3, Claim(held, 0)), 0.0)
    (accepted,) = (
        a.message for a in actions if isinstance(a, Send) and isinstance(a.message, SignOnAccepted)
    )
    assert "1W" not in [c.section_id for c in accepted.capabilities]


def test_what_a_unit_does_not_claim_it_is_known_to_have_leave_for_no_more_nor_to_lack_it() -> None:
    """Else points that another overruns on would count as free, because it once had no leave for them."""
    before = replace(UNKNOWN_UNIT, leave=frozenset({"1W", "1.1"}), without_leave=frozenset({"1E", "0E"}))
    after = entering.carried_over(before, UNKNOWN_UNIT, ("1W", "0E"))
    assert (after.leave, after.without_leave) == ({"1W"}, {"0E"})


def test_after_a_restart_who_may_have_leave_keeps_the_other_out_until_it_asks() -> None:
    """The manager knows nothing then: both may be coming in, so neither is let in; who asks says that it is not."""
    before = _meeting().register
    register = start(
        config_of([2, 2, 2], MEET), 1, {f"{k}{end}": b"k" * 32 for k in range(3) for end in "WE"}
    )
    for unit_id in ("u0", "u1"):
        claim = Claim(before.held_by(unit_id), 0)
        register, _ = step(register, Heard(unit_id, 1, True, 0, claim), 0.0)
    register, first = _ask(register, "u0", ENTRY["u0"])
    assert first == RouteRefused(ROUTE["u0"], RefusalReason.OVERLAP, "1W", "u1")
    register, second = _ask(register, "u1", ENTRY["u1"])
    assert isinstance(second, RouteGranted)  # u0 has said that it has none
    _, third = _ask(register, "u0", ENTRY["u0"], correlation=8)
    assert third == RouteRefused(ROUTE["u0"], RefusalReason.OVERLAP, "1W", "u1")


@pytest.mark.parametrize("seed", range(80))
def test_a_certificate_holds_where_trains_need_leave(seed: int) -> None:
    """Its search knows whole moves alone; a search of everything, with leave asked and waited for, says the same."""
    tracks, ways = random_case(random.Random(seed))
    play, last = Play(config_of(tracks, ways), ways), len(tracks) - 1
    days = play.register.plan.days
    assert days is not None
    found = finishing_order(stands_of(play.register, days).trains(days))
    begun = tuple((0, STANDS) for _ in ways)
    assert (found.proof is CertificateProof.ORDER) is can_finish(ways, begun, last, {})


@pytest.mark.parametrize("seed", range(80))
def test_whatever_comes_in_which_order_everybody_gets_in(seed: int) -> None:
    chance = random.Random(seed)
    tracks, ways = random_case(chance)
    play = Play(config_of(tracks, ways), ways)
    if not can_finish(ways, tuple((0, STANDS) for _ in ways), len(tracks) - 1, {}):
        return
    while open_ := [n for n in range(len(ways)) if not play.done(n)]:
        chance.shuffle(open_)
        assert any(play.acts(n) for n in open_)
        for one in play.leave:
            mine = play.route(one)
            for other in play.leave - {one}:
                assert set(mine.overlap).isdisjoint(play.route(other).section_ids)
