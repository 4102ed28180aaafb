"""The study of the order of trains: its table and its verdict follow from the days that are kept."""

import re

import pytest

from documents import studies
from documents.order_of_trains import PLAYED, OrderedDay, kept_days, less_lost, played, table, verdict

PAGE = (studies.FOLDER / "order-of-trains.md").read_text("utf-8")
KEPT = {name: kept_days(name) for name in PLAYED}


def test_the_table_is_that_of_the_kept_days() -> None:
    assert studies.blocks_in(PAGE)["orders"] == studies.block_text(table())


@pytest.mark.parametrize("name", PLAYED)
def test_the_days_are_those_that_the_page_names(name: str) -> None:
    seeds = [day.seed for day in KEPT[name]]
    assert seeds == list(range(seeds[0], seeds[0] + len(seeds)))
    assert re.search(rf"seeds {seeds[0]} to {seeds[-1]}\b", PAGE)


@pytest.mark.parametrize("name", PLAYED)
def test_the_same_rule_twice_shows_nothing(name: str) -> None:
    """On the same days there is no difference, and no interval of it; that of the first half of the days beside
    the other holds 0.
    """
    first = [day.first_come_min for day in KEPT[name]]
    same = less_lost([OrderedDay(0, lost, lost) for lost in first])
    assert (same.value, same.low, same.high) == (0.0, None, None)
    half = len(first) // 2
    others = less_lost(
        [OrderedDay(0, *pair) for pair in zip(first[:half], first[half : 2 * half], strict=True)]
    )
    assert others.low is not None
    assert others.high is not None
    assert others.low < 0.0 < others.high
    assert verdict(same) == verdict(others) == "not shown"


def test_a_kept_day_is_what_is_played() -> None:
    """One on which it once decided who asks first how sums of times were rounded: 8,397 min for 340."""
    (kept,) = (day for day in KEPT["blocks"] if day.seed == 1018)
    (again,) = played([kept.seed])
    assert again.pair == pytest.approx(kept.pair, abs=0.06)


@pytest.mark.nightly
def test_all_kept_days_are_what_is_played() -> None:
    for kept, again in zip(KEPT["blocks"], played([day.seed for day in KEPT["blocks"]]), strict=True):
        assert again.pair == pytest.approx(kept.pair, abs=0.06)
