"""Parts of a way: a train follows another onto the open line, never against one, and only if all can then finish.

A (three tracks) |1|2|3| B (one track) |4| C (three tracks); the blocks 1 to 3 are one stretch.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import msgspec
import pytest

from plan.dispatching.asked import answer_to
from radio.messages import Claim, HoldingReport, RouteGranted, RouteRefused, RouteRequest, SignOn
from wayside import dispatch, parts, unanswered
from wayside.actions import Send
from wayside.block_manager import Heard, step
from wayside.config import (
    CutRules,
    DispatchEntry,
    JourneyMove,
    ManagerConfig,
    OrderRule,
    RouteEntry,
    SectionEntry,
    StockMoves,
)
from wayside.parts import free_part
from wayside.places import stands_of
from wayside.register import Register, UnitStanding, start
from wayside.said import LetGo, LetWait
from wayside.solved_order import question_of

OPEN: Final = ("1", "2", "3", "4")
SECTIONS: Final = tuple(
    SectionEntry(s, open_line=s in OPEN, hears=s in OPEN)
    for s in ("A1", "A2", "A3", "1", "2", "3", "B", "4", "C1", "C2", "C3", "D", "D1")
)
ROUTES: Final = {
    "A1>B": RouteEntry("A1>B", "A1", ("1", "2", "3", "B")),
    "A2>B": RouteEntry("A2>B", "A2", ("1", "2", "3", "B")),
    "A3>B": RouteEntry("A3>B", "A3", ("1", "2", "3", "B")),
    "B>C1": RouteEntry("B>C1", "B", ("4", "C1")),
    "B>C2": RouteEntry("B>C2", "B", ("4", "C2")),
    "B>C3": RouteEntry("B>C3", "B", ("4", "C3")),
    "B>A1": RouteEntry("B>A1", "B", ("3", "2", "1", "A1")),
    "C2>B": RouteEntry("C2>B", "C2", ("4", "B")),
    "D>A3": RouteEntry("D>A3", "D", ("D1", "A3"), ("D1",), ("1",)),  # whose overrun on A3 fouls block 1
}


def moves(unit_id: str, *route_ids: str, among: Mapping[str, RouteEntry] = ROUTES) -> StockMoves:
    found = (
        JourneyMove(
            unit_id, route_id, among[route_id].section_ids[-1], False, 100.0 * k, 100.0 * k + 60, 20.0
        )
        for k, route_id in enumerate(route_ids)
    )
    return StockMoves(unit_id, tuple(found))


class Line:
    """Units where they stand, and a manager that grants parts."""

    def __init__(
        self, stands: dict[str, str], *days: StockMoves, parts: bool = True, **order: object
    ) -> None:
        entry = DispatchEntry(certificate=True, journeys=days, parts=parts, **order)  # type: ignore[arg-type]
        config = ManagerConfig("line", "m", tuple(stands), SECTIONS, tuple(ROUTES.values()), dispatch=entry)
        self.register: Register = start(config, 1, {})
        self.count, self.now_s = 0, 10.0
        for unit_id, section_id in stands.items():
            self.hear(unit_id, SignOn(unit_id, (section_id,)))

    def hear(self, unit_id: str, message: SignOn | RouteRequest | HoldingReport | Claim) -> object:
        self.count += 1
        self.register, actions = step(self.register, Heard(unit_id, 1, True, self.count, message), self.now_s)
        return next(a.message for a in actions if isinstance(a, Send) and a.destination == unit_id)

    def ask(self, unit_id: str, route_id: str, *section_ids: str) -> tuple[str, ...]:
        """What is granted; nothing where it is refused."""
        wanted = section_ids or ROUTES[route_id].section_ids
        answer = self.hear(unit_id, RouteRequest(unit_id, route_id, wanted))
        assert isinstance(answer, RouteGranted | RouteRefused)
        return answer.section_ids if isinstance(answer, RouteGranted) else ()

    def keeps(self, unit_id: str, *section_ids: str) -> None:
        self.hear(unit_id, HoldingReport(section_ids, self.register.unit(unit_id).token))


FOLLOWING: Final = (moves("u1", "A1>B", "B>C1"), moves("u2", "A2>B", "B>C2"))


def following(*, parts: bool = True) -> Line:
    """u1 on its way in block 2, with block 1 given back; u2 behind it at A."""
    line = Line({"u1": "A1", "u2": "A2"}, *FOLLOWING, parts=parts)
    assert line.ask("u1", "A1>B") == ("1", "2", "3", "B")
    line.keeps("u1", "2", "3", "B")
    return line


def test_a_follower_has_the_blocks_that_are_free_and_later_the_rest() -> None:
    line = following()
    assert line.ask("u2", "A2>B") == ("1",)
    assert line.ask("u2", "A2>B") == ("1",)  # its answer may have been lost
    assert line.ask("u2", "A2>B", "2", "3", "B") == ()
    line.keeps("u1", "3", "B")
    line.keeps("u2", "1")
    assert line.ask("u2", "A2>B", "2", "3", "B") == ("2",)
    line.keeps("u2", "2")
    line.keeps("u1", "B")
    assert line.ask("u1", "B>C1") == ("4", "C1")
    line.keeps("u1", "C1")
    assert line.ask("u2", "A2>B", "3", "B") == ("3", "B")
    assert line.ask("u2", "B>C2") == ("4", "C2")


def test_no_part_is_granted_while_nobody_knows_what_another_holds() -> None:
    line = following()
    unit = msgspec.structs.replace(line.register.unit("u1"), standing=UnitStanding.UNKNOWN)
    line.register = line.register.with_unit("u1", unit)
    assert line.ask("u2", "A2>B") == ()


def test_no_part_ends_where_the_radio_does_not_reach() -> None:
    line = following()
    plan = replace(line.register.plan, hears=frozenset({"2", "3"}))
    line.register = msgspec.structs.replace(line.register, plan=plan)
    assert line.ask("u2", "A2>B") == ()


def test_no_part_is_granted_where_more_than_a_holder_is_against_it() -> None:
    line = following()
    defined, line.register = line.register, msgspec.structs.replace(line.register, restoring=True)
    assert line.ask("u2", "A2>B") == ()
    line.register = defined
    assert isinstance(line.hear("u2", RouteRequest("u2", "A9>B", ("1", "2"))), RouteRefused)


def test_without_the_rule_a_follower_waits_for_the_whole() -> None:
    assert following(parts=False).ask("u2", "A2>B") == ()


@pytest.mark.parametrize("granted", [None, "A1>B"])
def test_nobody_comes_against_a_train_into_its_stretch(
    granted: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """u1 holds block 1, u2 at B wants the other way; blocks 3 and 2 are free."""
    line = Line({"u1": "1", "u2": "B"}, moves("u1", "A1>B"), moves("u2", "B>A1"))
    line.register = line.register.with_unit(
        "u1", msgspec.structs.replace(line.register.unit("u1"), route_id=granted)
    )
    back = ROUTES["B>A1"]
    assert free_part(line.register, "u2", back, back.section_ids) == ()
    monkeypatch.setattr(parts, "_runs", lambda *_: True)
    assert free_part(line.register, "u2", back, back.section_ids) == ("3", "2")
    assert line.ask("u2", "B>A1") == ()  # nor does the certificate let it on


def test_a_part_is_not_granted_where_not_all_could_finish(monkeypatch: pytest.MonkeyPatch) -> None:
    """u1 is to come back from B, which has one track: u2 behind it would wait for B, and u1 for the blocks of u2."""
    line = Line({"u1": "A1", "u2": "A2"}, moves("u1", "A1>B", "B>A1"), moves("u2", "A2>B"))
    assert line.ask("u1", "A1>B") == ("1", "2", "3", "B")
    line.keeps("u1", "2", "3", "B")
    assert line.ask("u2", "A2>B") == ()
    monkeypatch.setattr(dispatch, "weigh_part", lambda register, _, part: (register, part, ()))
    assert line.ask("u2", "A2>B") == ("1",)


@pytest.mark.parametrize(("known", "part"), [(("u1", "u3"), ("1",)), (("u1",), ()), (("u3",), ())])
def test_each_train_in_the_stretch_is_known_to_run_this_way(
    known: tuple[str, ...], part: tuple[str, ...]
) -> None:
    line = Line({"u1": "3", "u2": "A2", "u3": "2"}, moves("u2", "A2>B"))
    for unit_id in known:
        unit = line.register.unit(unit_id)
        line.register = line.register.with_unit(unit_id, msgspec.structs.replace(unit, route_id="A1>B"))
    assert free_part(line.register, "u2", ROUTES["A2>B"], ROUTES["A2>B"].section_ids) == part


def test_where_nobody_is_on_the_way_a_train_comes_as_far_as_the_track_that_another_has() -> None:
    line = Line({"u1": "B", "u2": "A2"}, moves("u1", "B>C1"), moves("u2", "A2>B", "B>C2"))
    assert line.ask("u2", "A2>B") == ("1", "2", "3")


def test_a_part_is_granted_only_where_an_order_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search that runs out at once proves nothing."""
    line = following()
    monkeypatch.setattr(dispatch, "STEPS_MAX", -100)
    assert line.ask("u2", "A2>B") == ()


def test_what_lies_behind_a_train_on_its_way_is_free_for_the_next() -> None:
    """u1 in block 3, u2 with block 2 and block 1 given back, u3 into that: u2 needs block 1 no more."""
    line = Line({"u1": "A1", "u2": "A2", "u3": "A3"}, *FOLLOWING, moves("u3", "A3>B", "B>C3"))
    assert line.ask("u1", "A1>B")
    line.keeps("u1", "3", "B")
    assert line.ask("u2", "A2>B") == ("1", "2")
    line.keeps("u2", "2")
    assert line.ask("u3", "A3>B") == ("1",)
    days = line.register.plan.days
    assert days is not None
    question = question_of(line.register, days, stands_of(line.register, days))
    assert question.trains[1].moves[0].needs == tuple(list(days.bits).index(s) for s in ("2", "3", "B"))
    assert answer_to(question).lacking == ""


@pytest.mark.parametrize(
    ("holds", "at"), [(("2", "3", "B"), 1), (("2",), 0), (("A1",), 0), (("4", "C2"), 2), (("B",), 1)]
)
def test_a_train_on_its_way_has_its_place_in_its_day_though_the_memory_is_lost(
    holds: tuple[str, ...], at: int
) -> None:
    """It goes to C, and as another train back to A."""
    there, back = moves("u1", "A1>B", "B>C2"), moves("another", "A1>B", "A1>B", "C2>B", "B>A1")
    line = Line({"u1": "A1"}, msgspec.structs.replace(there, moves=there.moves + back.moves[2:]))
    register = msgspec.structs.replace(
        line.register, trips={}, trips_lost=True, holders=dict.fromkeys(holds, "u1")
    )
    days = register.plan.days
    assert days is not None
    assert stands_of(register, days).at == (at,)


OTHER_WAY: Final = (FOLLOWING[0], moves("u2", "A2>B", "B>C3"), moves("u3", "C2>B", "B>A1"))
IN_ORDER: Final = ("u1", "u1", "u3", "u3", "u2", "u2")


def test_a_part_is_not_granted_before_who_is_first_by_the_order() -> None:
    """u3 is to come from C between u1 and u2; u2 waits for it though block 1 is free, and not for ever."""
    for given, part in (((), ("1",)), (IN_ORDER, ())):
        line = Line({"u1": "A1", "u2": "A2", "u3": "C2"}, *OTHER_WAY, given=given, hold_s_max=300.0)
        assert line.ask("u1", "A1>B")
        line.keeps("u1", "2", "3", "B")
        assert line.ask("u2", "A2>B") == part
    line.now_s += 299.0
    assert line.ask("u2", "A2>B") == ()
    line.now_s += 1.0
    assert line.ask("u2", "A2>B") == ("1",)


def test_a_train_with_a_part_is_first_already() -> None:
    """By the plan u1, u2, u3: u3 follows u2, which has not all of its way."""
    days = (moves("u1", "A1>B", "B>C1"), moves("u2", "A2>B", "B>C2"), moves("u3", "A3>B", "B>C3"))
    days = tuple(
        msgspec.structs.replace(
            day, moves=tuple(msgspec.structs.replace(m, departs_s=m.departs_s + 10.0 * k) for m in day.moves)
        )
        for k, day in enumerate(days)
    )
    line = Line({"u1": "A1", "u2": "A2", "u3": "A3"}, *days, order=OrderRule.PLANNED)
    assert line.ask("u1", "A1>B")
    line.keeps("u1", "3", "B")
    assert line.ask("u3", "A3>B") == ()
    assert line.ask("u2", "A2>B") == ("1", "2")
    line.keeps("u2", "2")
    assert line.ask("u3", "A3>B") == ("1",)


def test_no_part_is_granted_into_the_overrun_of_a_train_that_comes_in() -> None:
    line = Line({"u1": "A1", "u2": "A2", "u3": "D"}, *FOLLOWING, moves("u3", "D>A3"))
    assert line.ask("u1", "A1>B")
    line.keeps("u1", "2", "3", "B")
    assert line.ask("u3", "D>A3") == ("D1", "A3")
    assert line.ask("u3", "D>A3", "D1", "A3") == ("D1", "A3")  # now it has leave to come in
    assert line.ask("u2", "A2>B") == ()
    line.keeps("u3", "A3")
    assert line.ask("u2", "A2>B") == ("1",)


def test_who_is_told_to_wait_is_granted_no_part() -> None:
    line = following()
    line.register, _ = step(line.register, LetWait("u2", "Sato", 300.0), line.now_s)
    assert line.ask("u2", "A2>B") == ()
    line.register, _ = step(line.register, LetGo("u2", "Sato"), line.now_s)
    assert line.ask("u2", "A2>B") == ("1",)


@pytest.mark.parametrize("either_way", [True, False])
def test_no_part_is_granted_against_a_train_that_may_turn_back(
    either_way: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """u1 at B was ordered to go back to A, not on to C, and has not answered; u2 would hold the blocks between."""
    monkeypatch.setattr(unanswered, "EITHER_WAY", either_way)
    there = moves("u1", "B>C2", "C2>B", "B>A1").moves
    numbered = zip(there, ("1", "1b", "1b"), "BCB", strict=True)
    day = tuple(msgspec.structs.replace(m, train=t, begins_at=s) for m, t, s in numbered)
    cuts = CutRules(turn_back_at=("B",))
    line = Line({"u1": "B", "u2": "A2"}, StockMoves("u1", day), moves("u2", "A2>B", "B>C3"), cuts=cuts)
    trip = msgspec.structs.replace(line.register.trip("u1"), next_train="1b")
    line.register = line.register.with_trip("u1", trip)
    assert line.ask("u2", "A2>B") == (() if either_way else ("1", "2", "3"))
