"""Room for more: what fits into a gap by hand, and nothing that is put in overlaps anything."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Direction
from study.capacity import room
from study.capacity.room import OccupiedSpans, PathSearch, fill_period, place
from tests.study.capacity.hand_made import Made, legs
from tests.study.capacity.test_compression import days

DOWN, UP = Direction.DOWN, Direction.UP
STANDARD = [legs([Made("+", way, 0.0)]) for way in (DOWN, UP)]
# A down train is through after 300 + 60 + 240 + 30 + 180 s.
THROUGH_S = 810.0


def taken_by(made: list[Made]) -> OccupiedSpans:
    return OccupiedSpans.of_occupations(o for leg in legs(made) for o in leg.held)


def overlaps(taken: OccupiedSpans) -> int:
    """Overlapping neighbours; what a leg starts in is the end of the one before it, so it counts once."""
    spans = [sorted(set(spans)) for spans in taken.spans.values()]
    return sum(b[0] < a[1] - 1e-6 for one in spans for a, b in pairwise(one))


def test_a_train_waits_in_the_loop_for_the_one_that_comes() -> None:
    """The up train frees S2 at 450 + 15; let in 10 s before it starts, the down train leaves L at 475, not at 360."""
    taken = taken_by([Made("1", UP, 10_000.0)])
    placed = place(STANDARD[0], 10_000.0, taken, PathSearch())
    assert placed is not None
    assert placed.waits_s == pytest.approx(475.0 - 360.0)
    assert placed.arrives_s == pytest.approx(10_000.0 + THROUGH_S + 115.0)
    assert place(STANDARD[0], 10_000.0, taken, PathSearch(wait_s_max=114.0)) is None
    assert place(STANDARD[0], 10_000.0, taken, PathSearch(wait_s_max=145.0, buffer_s=31.0)) is None


def test_as_many_fit_one_after_another_as_the_closest_section_lets_in() -> None:
    """Down trains alone: M.1 lets one in every 295 s, L.1 every 10 + 300 + 60 + 15 s; on whole minutes every 420 s."""
    found = fill_period(STANDARD[:1], (0.0, 3600.0), taken_by([]), PathSearch(wait_s_max=0.0))
    assert [p.departs_s for p in found] == [420.0 * i for i in range(7)]
    assert found[-1].arrives_s == 6 * 420.0 + THROUGH_S


@given(days(), st.sampled_from([0.0, 30.0]), st.booleans())
def test_nothing_overlaps_what_is_put_in(made: list[Made], buffer_s: float, both: bool) -> None:
    taken = taken_by(made)
    before = overlaps(taken)
    fill_period(STANDARD if both else STANDARD[:1], (0.0, 12_000.0), taken, PathSearch(buffer_s=buffer_s))
    assert overlaps(taken) == before


def free(*_: object) -> None:
    """Whatever is asked for is free."""


def test_without_looking_they_overlap(monkeypatch: pytest.MonkeyPatch) -> None:
    taken = taken_by([Made("1", UP, 1000.0)])
    monkeypatch.setattr(room.OccupiedSpans, "until_s", free)
    placed = place(STANDARD[0], 1000.0, taken, PathSearch())
    assert placed is not None
    room.take_sections(placed, taken)
    assert overlaps(taken) > 0
