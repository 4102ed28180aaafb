"""Legs moved against each other: known answers on the line made by hand, and what only a wrong model allows."""

import math
from dataclasses import replace
from itertools import combinations

import pytest

from network.model import Direction
from plan.moving import bounds as moving_bounds
from plan.moving.bounds import LegBounds, MoveTerms, bounds_of
from plan.moving.model import FoundMoves, MovingModel
from plan.moving.proof import MoveBound
from study.capacity.legs import SetLeg, legs_of
from study.capacity.occupation import TOUCH_S, Occupation, OccupationPart, Slice
from tests.plan.test_proofs import CROSS
from tests.study.capacity.hand_made import FREE_S, SET_S, Made, held, legs

WORK = 1.0
BEYOND = held("Q.1", "d", 600, 610, stays=True)
PAIR = (Made("1", Direction.DOWN, 0.0), Made("2", Direction.UP, 0.0))


def as_soon_as_can_be(bounds: LegBounds, period_s: float | None = None) -> FoundMoves:
    """No leg sooner than planned; the sum of all moves the least."""
    period = None if period_s is None else round(period_s / bounds.terms.tick_s)
    between = [(0, round(10_000.0 / bounds.terms.tick_s))] * len(bounds.legs)
    model = MovingModel(bounds, between if period is None else bounds.in_a_period(period), period)
    model.model.minimize(sum(model.moves))
    return model.solve(WORK)


def moved(trains: tuple[SetLeg, ...], found: FoundMoves, tick_s: float) -> list[SetLeg]:
    assert found.moves is not None
    return [
        replace(
            leg,
            start=leg.start and leg.start.moved(by * tick_s),
            occupations=tuple(o.moved(by * tick_s) for o in leg.occupations),
        )
        for leg, by in zip(trains, found.moves, strict=True)
    ]


def test_the_second_of_two_that_meet_waits_in_the_loop() -> None:
    """Down comes to the loop at 300, up at 180 + 30 + 240 = 450; one waits there until the other is out of its way."""
    trains = legs(list(PAIR))
    found = as_soon_as_can_be(bounds_of(trains, MoveTerms()))
    assert found.proven
    # Down leaves the loop when S2 is free and set: (450 + FREE_S) + SET_S - 360; its two last legs move.
    assert found.cost == 10 * 2 * round(450.0 + FREE_S + SET_S - 360.0)


def test_no_two_trains_are_in_one_section() -> None:
    trains = legs([*PAIR, Made("3", Direction.DOWN, 100.0), Made("4", Direction.UP, 700.0)])
    found = as_soon_as_can_be(bounds_of(trains, MoveTerms()))
    assert found.proven
    sections = [
        (o, leg.stock_id)
        for leg in moved(trains, found, 0.1)
        for o in leg.occupations
        if "." not in o.section_id
    ]
    for (one, mine), (other, its) in combinations(sections, 2):
        if one.section_id == other.section_id and mine != its:
            assert one.end_s <= other.begin_s + TOUCH_S or other.end_s <= one.begin_s + TOUCH_S


def test_where_sections_are_anybodys_nobody_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(moving_bounds, "EXCLUSIVE", False)
    assert as_soon_as_can_be(bounds_of(legs(list(PAIR)), MoveTerms())).cost == 0


@pytest.mark.parametrize("tick_s", [0.1, 1.0])
def test_a_difference_that_is_no_tick_is_the_next_one_above(tick_s: float) -> None:
    """Down trains 120 s apart; each has S1 and the loop for SET_S + 300 + 60 + FREE_S. With 0.01 s between them."""
    trains = legs([Made("1", Direction.DOWN, 0.0), Made("3", Direction.DOWN, 120.0)])
    exact = as_soon_as_can_be(bounds_of(trains, MoveTerms(tick_s)))
    above = as_soon_as_can_be(bounds_of(trains, MoveTerms(tick_s, buffer_s=0.01)))
    assert exact.moves is not None and above.moves is not None
    at = next(i for i, leg in enumerate(trains) if leg.number == "3")
    assert exact.moves[at] == round((SET_S + 300.0 + 60.0 + FREE_S - 120.0) / tick_s)
    assert above.moves[at] == exact.moves[at] + 1


def test_a_stand_is_no_longer_than_it_may() -> None:
    """In the loop down would have to wait 115 s longer than planned; where it may not, up sets out later."""
    trains = legs(list(PAIR))
    found = as_soon_as_can_be(bounds_of(trains, MoveTerms(longer_s=0.0)))
    assert found.proven and found.moves is not None
    of_train = {n: {m for leg, m in zip(trains, found.moves, strict=True) if leg.number == n} for n in "12"}
    assert all(len(moves) == 1 for moves in of_train.values())
    assert any(moves != {0} for moves in of_train.values())


def least_period_s(trains: tuple[SetLeg, ...]) -> int:
    """By trying all whole seconds."""
    bounds = bounds_of(trains, MoveTerms(1.0, periodic=True))
    return next(
        period_s for period_s in range(1, 2000) if as_soon_as_can_be(bounds, period_s).moves is not None
    )


def test_the_least_interval_of_a_line_with_one_loop() -> None:
    """Beyond the loop a train each way has S2, M and S3: a down train and then an up train, each for 10 s before it
    starts until 15 s after it has come: 2 (10 + 240 + 30 + 180 + 15) s.
    """
    assert least_period_s(legs(list(PAIR))) == 2 * (SET_S + 240 + 30 + 180 + FREE_S)


def test_a_period_in_which_a_section_does_not_hold_both_is_impossible() -> None:
    bounds = bounds_of(legs(list(PAIR)), MoveTerms(1.0, periodic=True))
    assert as_soon_as_can_be(bounds, 2 * 325 - 1).impossible


def of_hand(*occupations: Occupation) -> tuple[SetLeg, ...]:
    return legs_of(list(occupations), lambda section: "." in section)


def test_a_train_that_passes_waits_not_at_all() -> None:
    way = of_hand(held("X", "d", 0, 90), held("P.1", "d", 90, 100), held("Y", "d", 100, 200), BEYOND)
    assert {MoveBound(0, 1, 0), MoveBound(1, 0, 0)} <= set(bounds_of(way, MoveTerms(1.0)).always)


def test_a_set_comes_back_after_it_has_left() -> None:
    """It is in the portal P.1 at 10 s, and comes from P.2 at 500 s."""
    way = of_hand(
        *(held("X", "d", 0, 10), held("P.1", "d", 10, 20)),
        *(held("P.2", "d", 490, 500), held("Y", "d", 500, 600), BEYOND),
    )
    assert MoveBound(0, 1, 10 - 490) in bounds_of(way, MoveTerms(1.0)).always


def test_who_stood_there_when_the_day_began_goes_first() -> None:
    """It leaves its track at 100 s, and another's way onto it is set at 150 s."""
    ready = Occupation(
        "P.1", "a", "a", Direction.DOWN, (Slice(OccupationPart.READY, 0.0, 100.0),), -math.inf, 100.0
    )
    both = of_hand(
        *(ready, held("X", "a", 100, 200), held("Q.1", "a", 200, 210, stays=True)),
        *(held("Y", "u", 50, 150, down=False), held("P.1", "u", 150, 160, down=False, stays=True)),
    )
    number = {leg.stock_id: at for at, leg in enumerate(both)}
    bounds = bounds_of(both, MoveTerms(1.0))
    assert MoveBound(number["a"], number["u"], 100 - 150, "P.1") in bounds.always
    assert bounds.either == ()


def test_sections_between_which_no_trains_can_cross_are_one_question() -> None:
    """Down has X until 30 s and Y until 50, up both from 10 s, Y until 50 and X until 70: 40 s, or 70 the other way."""
    ends = held("P.1", "d", 50, 60, stays=True), held("P.2", "u", 70, 80, down=False, stays=True)
    both = of_hand(
        *(held("X", "d", 0, 30), held("Y", "d", 0, 50), ends[0]),
        *(held("Y", "u", 10, 50, down=False), held("X", "u", 10, 70, down=False), ends[1]),
    )
    (either,) = bounds_of(both, MoveTerms(1.0)).either
    first = {both[bound.before].stock_id: bound.least for bound in (either.one_first, either.other_first)}
    assert first == {"d": 40, "u": 70}


def test_sections_between_which_trains_can_cross_are_two_questions() -> None:
    assert len(bounds_of(CROSS, MoveTerms(1.0)).either) == 2
