"""Occupations: cut without gaps, the parts make up the whole, and two at a time are a conflict."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Direction
from study.capacity.occupation import COST_OF, Occupation, OccupationPart, Slice, by_section, conflicts_of


def occupied(stock: str, *instants_s: float, section: str = "s") -> Occupation:
    parts = list(OccupationPart)
    slices = tuple(Slice(parts[i % len(parts)], a, b) for i, (a, b) in enumerate(pairwise(instants_s)))
    return Occupation(section, stock, stock, Direction.DOWN, slices, instants_s[0], instants_s[-1])


def test_every_part_has_a_cost() -> None:
    assert set(COST_OF) == set(OccupationPart)


@given(st.lists(st.floats(0.0, 1e4), min_size=2, max_size=20, unique=True).map(sorted))
def test_the_parts_make_up_the_whole(instants_s: list[float]) -> None:
    one = occupied("a", *instants_s)
    whole_s = instants_s[-1] - instants_s[0]
    assert sum(one.of_part(part) for part in OccupationPart) == pytest.approx(whole_s)
    assert sum(one.costs_s().values()) == pytest.approx(one.length_s) == pytest.approx(whole_s)


@pytest.mark.parametrize(
    "slices",
    [
        (),
        (Slice(OccupationPart.RUN, 5.0, 4.0),),
        (Slice(OccupationPart.RUN, 1.0, 4.0), Slice(OccupationPart.LENGTH, 4.5, 5.0)),
    ],
    ids=["none", "backwards", "gap"],
)
def test_what_is_not_whole_is_refused(slices: tuple[Slice, ...]) -> None:
    with pytest.raises(ValueError, match="slice"):
        Occupation("s", "a", "1", Direction.UP, slices, 0.0, 1.0)


def test_two_stocks_at_one_time_are_a_conflict_and_one_stock_is_none() -> None:
    first, second = occupied("a", 0.0, 10.0), occupied("b", 8.0, 20.0)
    own, elsewhere = occupied("a", 9.0, 12.0), occupied("b", 0.0, 10.0, section="t")
    found = conflicts_of([second, elsewhere, first, own])
    assert [(c.section_id, c.first, c.second, c.overlap_s) for c in found] == [
        ("s", first, second, 2.0),
        ("s", second, own, 3.0),
    ]
    assert conflicts_of([first, second.moved(2.0)]) == ()
    assert list(by_section([second, first])["s"]) == [first, second]
