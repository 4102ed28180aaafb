"""What players make of orders that trains carry out only once the block manager has failed."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest

from simulation.procedure import Part, WorkingStep
from simulation.substitute.hops import Hop
from simulation.substitute.players import SubstitutePlayers
from simulation.substitute.work import Work, works_of
from simulation.substitute_settings import Substitute
from tests.simulation.substitute.test_book import HOP
from wayside.config import MANAGER_ID

SETTINGS = Substitute()
OTHER_TRACK = replace(HOP, section_ids=("S", "B.2"), after_block=("B.2",))
LATER = replace(HOP, stock_id="V2", train="T3", planned_s=600.0)
BEYOND = replace(HOP, block="S2", origin="B", destination="C", section_ids=("S2", "C.1"), planned_s=300.0)


def players(*hops: Hop) -> tuple[SubstitutePlayers, Work]:
    """Those who work a line by these ways, with HOP in the book of its section, and its points being set."""
    found = object.__new__(SubstitutePlayers)
    found._settings, found._hops, found.works = SETTINGS, hops, works_of(hops, SETTINGS)
    cast("Any", found).sight = SimpleNamespace(hops=hops)
    work = found.works[0]
    work.book = work.book.takes(HOP)
    work.row = next(row for row in work.rows if row.part is Part.TRAIN)
    return found, work


def ordered(found: SubstitutePlayers, *hops: Hop) -> None:
    cast("Any", found).sight = SimpleNamespace(hops=hops)
    found._follow_orders()


def test_a_train_got_ready_for_another_way_is_taken_up_anew() -> None:
    found, work = players(HOP, LATER)
    ordered(found, OTHER_TRACK, LATER)
    assert work.hops == [OTHER_TRACK, LATER]
    assert (work.book.hop, work.row) == (None, None)


def test_one_that_has_been_let_go_runs_on_by_the_way_it_was_let_go_by() -> None:
    found, work = players(HOP, LATER)
    work.book = replace(work.book, of_train=frozenset({WorkingStep.GO}))
    before = work.book, work.row
    ordered(found, OTHER_TRACK, LATER)
    assert work.hops == [OTHER_TRACK, LATER]
    assert (work.book, work.row) == before


@pytest.mark.parametrize("after", [(HOP, LATER), (HOP,), (HOP, replace(LATER, begins_in="A.2"))])
def test_a_train_whose_way_stays_goes_on_being_got_ready(after: tuple[Hop, ...]) -> None:
    found, work = players(HOP, LATER)
    before = work.book, work.row
    ordered(found, *after)
    assert work.hops == list(after)
    assert (work.book, work.row) == before


def test_a_section_into_which_no_train_goes_any_more_has_none_to_wait_for() -> None:
    found, _ = players(HOP, BEYOND)
    ordered(found, HOP)
    assert [(work.name, work.hops) for work in found.works] == [("S", [HOP]), ("S2", [])]


def test_orders_are_followed_whenever_all_look_round(monkeypatch: pytest.MonkeyPatch) -> None:
    found, work = players(HOP, LATER)
    nothing = SimpleNamespace(look=lambda _step: None)
    cast("Any", found)._wayside = SimpleNamespace(down={MANAGER_ID})
    cast("Any", found).drivers = cast("Any", found).persons = nothing
    monkeypatch.setattr(SubstitutePlayers, "_goes_on", lambda *_args, **_options: False)
    cast("Any", found).sight = SimpleNamespace(hops=(OTHER_TRACK, LATER))
    found.look(0)
    assert work.hops == [OTHER_TRACK, LATER]
