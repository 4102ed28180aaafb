"""Compression: the hand calculation of docs/capacity.md, and what holds of any day."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Direction
from study.capacity import compression
from study.capacity.compression import Compressed, ContradictionError, StandingRule, compressed
from study.capacity.cut import PartKind
from study.capacity.legs import SetLeg, legs_of
from study.capacity.limits import LIMITS, TrafficKind
from study.capacity.line_capacity import Period, Rate
from study.capacity.occupation import OccupationCost, conflicts_of
from tests.study.capacity.hand_made import Made, day, held, legs

LOW = {"L": frozenset({"S1"}), "M": frozenset({"S1", "L.1", "S2"})}
HIGH = {"L": frozenset({"S2", "M.1", "S3"}), "M": frozenset({"S3"})}
WHOLE = frozenset({"S1", "S2", "S3", *(f"{place}.{n}" for place in "ALMB" for n in (1, 2))})


@pytest.mark.parametrize(
    ("loop", "low_s", "high_s", "whole_s"),
    [("L", 1950.0, 2460.0, 3340.0), ("M", 3210.0, 1230.0, 3330.0)],
    ids=["loop at L", "loop moved to M"],
)
def test_six_trains_by_hand(loop: str, low_s: float, high_s: float, whole_s: float) -> None:
    trains = legs(day(loop))
    found = [compressed(trains, part).occupied_s for part in (LOW[loop], HIGH[loop], WHOLE)]
    assert found == pytest.approx([low_s, high_s, whole_s], abs=0.05)


def test_the_throw_counts_as_often_as_a_train_is_let_in() -> None:
    slow, quick = (compressed(legs(day("L", throw_s)), LOW["L"]) for throw_s in (4.0, 2.0))
    assert slow.occupied_s - quick.occupied_s == pytest.approx(6 * 2.0)
    assert slow.costs_s()[OccupationCost.POINTS] == pytest.approx(6 * 4.0)
    assert quick.costs_s()[OccupationCost.POINTS] == pytest.approx(6 * 2.0)


def pushed(trains: tuple[SetLeg, ...], found: Compressed, part: frozenset[str]) -> int:
    """How many conflicts the trains have in a part when each leg has moved as it was."""
    moved = [
        one.moved(by_s)
        for leg, by_s in zip(found.legs, found.moves_s, strict=True)
        for one in leg.occupations
        if one.section_id in part and one is not leg.end
    ]
    return len(conflicts_of(moved))


@st.composite
def days(draw: st.DrawFn) -> list[Made]:
    """Any trains with the line for themselves, or two that meet in the loop."""
    loop, at_s, made = draw(st.sampled_from("LM")), 0.0, list[Made]()
    down, up = day(loop)[:2]
    for number in range(draw(st.integers(1, 5))):
        at_s += draw(st.floats(1900.0, 4000.0))
        way = draw(st.sampled_from([*Direction, None]))
        throw_s = draw(st.sampled_from([0.0, 4.0]))
        if way is None:
            meets_s = at_s + up.starts_s - down.starts_s
            made.append(Made(f"{number}d", Direction.DOWN, at_s, loop, throw_s))
            made.append(Made(f"{number}u", Direction.UP, meets_s, loop, throw_s))
        else:
            made.append(Made(str(number), way, at_s, loop, throw_s))
    return made


@given(days(), st.sampled_from([*LOW.values(), *HIGH.values(), WHOLE]), st.sampled_from(StandingRule))
def test_no_two_trains_overlap_and_the_chain_is_whole(
    made: list[Made], part: frozenset[str], stops: StandingRule
) -> None:
    trains = legs(made)
    found = compressed(trains, part, stops)
    assert pushed(trains, found, part) == 0
    assert sum(link.length_s for link in found.chain) == pytest.approx(found.occupied_s)
    assert sum(found.costs_s().values()) == pytest.approx(found.occupied_s)
    first_s = min(o.begin_s for leg in trains for o in leg.occupations if o.section_id in part)
    assert found.begins_s <= first_s
    again = compressed(legs([replace(one, starts_s=one.starts_s + 777.0) for one in made]), part, stops)
    assert again.occupied_s == pytest.approx(found.occupied_s)


def nothing(*_: object) -> list[object]:
    return []


def test_without_the_order_of_trains_they_overlap(monkeypatch: pytest.MonkeyPatch) -> None:
    trains = legs(day("L"))
    monkeypatch.setattr(compression, "_in_turn", nothing)
    found = compressed(trains, WHOLE)
    assert pushed(trains, found, WHOLE) > 0
    assert found.occupied_s < 3340.0


def test_trains_that_each_come_after_the_other_are_named() -> None:
    """Both keep their stops in the loop, and are there at times at which neither can get on."""
    one, other = (replace(train, throw_s=9.5) for train in day("M")[:2])
    with pytest.raises(ContradictionError, match="wait") as caught:
        compressed(legs([one, other]), WHOLE)
    assert set(caught.value.numbers) == {"1", "2"}


def test_a_part_without_trains_takes_no_time() -> None:
    found = compressed(legs(day("L")), frozenset({"elsewhere"}))
    assert (found.occupied_s, found.chain, found.section_id) == (0.0, (), "")


def test_the_section_held_longest_decides_and_not_the_one_held_last() -> None:
    """S1 for 300 s; S2 for 150 s, and to the end: after 300 s the same train could come again."""
    found = compressed(
        legs_of([held("S1", "1", 0.0, 300.0), held("S2", "1", 250.0, 400.0)], lambda one: "." in one), WHOLE
    )
    assert (found.occupied_s, found.section_id) == (300.0, "S1")


@pytest.mark.parametrize(("trains", "more"), [(4, 2), (8, 4), (0, 0)])
def test_a_rate_by_hand(trains: int, more: int) -> None:
    """Half an hour of an hour of the peak, limit 75 %: 66.7 % are consumed, and half as many trains again may come."""
    half = Compressed((), (), 0.0, 1800.0, ())
    part: Any = SimpleNamespace(name="", kind=PartKind.LINE, section_ids=())
    period = Period("", 0.0, 3600.0, peak=True)
    row = Rate(part, period, trains, half, LIMITS[TrafficKind.MIXED], StandingRule.KEPT).as_dict()
    assert (row["consumed_percent"], row["trains_below_limit"]) == (66.7, more)


def test_what_was_held_and_never_entered_is_no_leg() -> None:
    """A train that stands at its portal for ever holds its route."""
    waits = replace(held("S1", "1", 0.0, 100.0), enters_s=math.inf, leaves_s=math.inf)
    found = legs_of([waits, held("S2", "2", 200.0, 300.0)], lambda section: "." in section)
    assert [leg.number for leg in found] == ["2"]
