"""Headways: what a hand calculation gives, under the names of the trade, and the components make up the whole."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Direction
from study.capacity import claims as module
from study.capacity.headway import Headway, HeadwayKind, headways_of, visits_at
from study.capacity.legs import costs_between
from study.capacity.occupation import Occupation, OccupationCost, OccupationPart, Slice
from tests.study.capacity.hand_made import Made, legs
from tests.study.capacity.test_compression import days

TRACKS = {place: frozenset({f"{place}.1", f"{place}.2"}) for place in "ALMB"}
DOWN, UP = Direction.DOWN, Direction.UP


def between(place: str, *trains: Made, dwell_min_s: float = math.inf) -> dict[HeadwayKind, Headway]:
    """The headways of the first train to the second at a place."""
    visits = {visit.number: visit for visit in visits_at(legs(list(trains)), TRACKS[place])}
    one, other = (visits[train.number] for train in trains)
    return {found.kind: found for found in headways_of(one, other, dwell_min_s)}


def two(first: Direction, second: Direction, loop: str = "L", throw_s: float = 4.0) -> tuple[Made, Made]:
    return Made("1", first, 3600.0, loop, throw_s), Made("2", second, 7200.0, loop, throw_s)


@pytest.mark.parametrize(
    ("place", "trains", "kind", "section", "least_s"),
    [
        # run, stop at the next place, 15 until its track is free, and 10 for the second to be let in
        ("A", two(DOWN, DOWN, "M"), HeadwayKind.FOLLOWING, "L.1", 300.0 + 60.0 + 15.0 + 10.0),
        ("B", two(UP, UP, "M"), HeadwayKind.FOLLOWING, "M.2", 180.0 + 30.0 + 15.0 + 10.0),
        ("L", two(UP, DOWN), HeadwayKind.ARRIVAL_DEPARTURE, "S2", 15.0 + 10.0),
        ("L", two(DOWN, DOWN), HeadwayKind.DEPARTURE_ARRIVAL, "L.1", 15.0 + 10.0 + 300.0),
        ("L", two(DOWN, UP, "M"), HeadwayKind.DEPARTURE_ARRIVAL, "S2", 240.0 + 15.0 + 10.0 + 240.0),
        # M has one track: the first goes on to B before the second can leave B, which stands at M and comes to L
        ("L", two(DOWN, UP), HeadwayKind.DEPARTURE_ARRIVAL, "S3", 2 * (240.0 + 30.0 + 180.0) + 15.0 + 10.0),
        # from the same track: that is free 15 after the first has left, the second let in 10 before it leaves A,
        # where it comes from, 300 away, and stands 60
        ("L", two(DOWN, DOWN, "M"), HeadwayKind.FOLLOWING, "L.1", 15.0 + 10.0 + 300.0 + 60.0),
        # the same at M, and up at L
        ("M", two(DOWN, DOWN), HeadwayKind.FOLLOWING, "M.1", 15.0 + 10.0 + 240.0 + 30.0),
        ("L", two(UP, UP), HeadwayKind.FOLLOWING, "L.2", 15.0 + 10.0 + 240.0 + 60.0),
    ],
)
def test_by_hand(
    place: str, trains: tuple[Made, Made], kind: HeadwayKind, section: str, least_s: float
) -> None:
    found = between(place, *trains)[kind]
    assert found.section_id == section
    assert found.least_s == pytest.approx(least_s, abs=1e-9)
    assert found.first_s + found.second_s == pytest.approx(least_s, abs=1e-9)


def test_who_stands_longer_than_a_train_must_holds_up_nobody() -> None:
    found = between("A", *two(DOWN, DOWN, "M"), dwell_min_s=20.0)[HeadwayKind.FOLLOWING]
    assert found.least_s == pytest.approx(300.0 + 20.0 + 15.0 + 10.0)  # 20 of the 60 that it stands at L
    assert found.buffer_s == pytest.approx(7200.0 - 3600.0 - 345.0)


def test_without_the_way_in_two_trains_would_share_a_track(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "WAY_IN_COUNTS", False)
    found = between("M", *two(DOWN, DOWN))[HeadwayKind.FOLLOWING]
    assert found.least_s == pytest.approx(180.0 + 15.0 + 10.0)  # no more than S3


def test_a_train_that_overtakes_opens_the_way_and_one_that_is_overtaken_closes_up() -> None:
    """On two tracks: the second onto the other one, S1 freed, 310 s from let in to its arrival; then out after it."""
    one, other = Made("1", DOWN, 3600.0), Made("2", DOWN, 7200.0)
    found = between("L", one, Onto("2", DOWN, 7200.0))
    assert found[HeadwayKind.CLOSING_UP].least_s == pytest.approx(15.0 + 310.0)
    assert found[HeadwayKind.OPEN].least_s == pytest.approx(240.0 + 30.0 + 15.0 + 10.0)
    assert found[HeadwayKind.OPEN].section_id == "M.1"
    assert HeadwayKind.FOLLOWING not in found
    assert HeadwayKind.FOLLOWING in between("L", one, other)


class Onto(Made):
    """A down train on the other track of the loop."""

    def track(self, place: str) -> str:
        return "L.2" if place == "L" else super().track(place)


def test_which_component_costs_how_many_seconds() -> None:
    found = between("B", *two(UP, UP, "M"))[HeadwayKind.FOLLOWING]
    assert found.costs_s == pytest.approx(
        {
            OccupationCost.RADIO: 4.0 + 2.0 + 1.0 + 1.0 + 2.0,
            OccupationCost.POINTS: 4.0,
            OccupationCost.LOCALISATION: 6.0,
            OccupationCost.RULE: 0.0,
            OccupationCost.DRIVING: 180.0 + 5.0,
            OccupationCost.PEOPLE: 30.0,
            OccupationCost.CHARGING: 0.0,
        }
    )


def test_half_the_throw_moves_the_headway_by_what_the_parts_say() -> None:
    whole = between("B", *two(UP, UP, "M"))[HeadwayKind.FOLLOWING]
    half = between("B", *two(UP, UP, "M", throw_s=2.0))[HeadwayKind.FOLLOWING]
    assert whole.least_s - half.least_s == pytest.approx(whole.costs_s[OccupationCost.POINTS] / 2.0)


@given(days())
def test_components_make_up_every_headway_and_the_plan_keeps_it(made: list[Made]) -> None:
    for place, tracks in TRACKS.items():
        visits = visits_at(legs(made), tracks)
        for i, first in enumerate(visits):
            for second in visits[i + 1 :]:
                for one in headways_of(first, second):
                    assert sum(one.costs_s.values()) == pytest.approx(one.least_s, abs=1e-6), place


@given(st.floats(-50.0, 600.0), st.floats(-50.0, 600.0))
def test_costs_between_two_instants_make_up_the_time(from_s: float, to_s: float) -> None:
    one = Made("1", DOWN, 0.0).occupations()[3]
    there, back = (costs_between(one, *pair) for pair in ((from_s, to_s), (to_s, from_s)))
    assert sum(there.values()) == pytest.approx(to_s - from_s, abs=1e-9)
    assert all(there[cost] == pytest.approx(-back[cost], abs=1e-9) for cost in OccupationCost)


class ComesIn(Made):
    """A train that must have the points of the loop alone from 30 s before it is there until 2 s after."""

    def occupations(self) -> list[Occupation]:
        found = super().occupations()
        at = next(i for i, one in enumerate(found) if one.section_id.startswith("L."))
        comes_s = found[at].enters_s
        alone = Slice(OccupationPart.RUN, comes_s - 30.0, comes_s + 2.0)
        found.insert(
            at,
            Occupation(
                "L overlap", self.number, self.number, self.direction, (alone,), comes_s - 5.0, comes_s
            ),
        )
        return found


def test_of_two_that_come_in_against_each_other_one_must_stand_first() -> None:
    one, other = (ComesIn(made.number, made.direction, made.starts_s) for made in two(DOWN, UP))
    found = between("L", one, other)[HeadwayKind.COMING_IN]
    assert (found.section_id, found.least_s) == ("L overlap", pytest.approx(2.0 + 30.0, abs=1e-9))
    assert HeadwayKind.COMING_IN not in between("L", *two(DOWN, UP))
