"""Proofs that legs do not fit: found where there are no moves, recounted, and refused where one number is another."""

import json
import re

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Direction
from plan.moving import bounds as moving_bounds
from plan.moving.bounds import MoveTerms, bounds_of
from plan.moving.model import MovingModel
from plan.moving.proof import (
    Circle,
    ExcludedPeriods,
    Impossibility,
    MoveBound,
    TwoCases,
    circles_of,
    proof_text,
)
from plan.moving.recount import Recount
from plan.moving.refutation import excluded_by, refutation_of
from plan.moving.stints import stints_of
from study.capacity.legs import SetLeg, legs_of
from tests.study.capacity.hand_made import FREE_S, SET_S, Made, held, legs

PAIR = legs([Made("1", Direction.DOWN, 0.0), Made("2", Direction.UP, 0.0)])
BEYOND_S = SET_S + 240.0 + 30.0 + 180.0 + FREE_S  # one train over S2, M and S3, beyond the loop
LOOP_S = SET_S + 300.0 + 60.0 + FREE_S  # one train on its track of the loop, from when it is let in over S1
WORK = 1.0


def proof_at(trains: tuple[SetLeg, ...], period: int) -> Impossibility | None:
    found = refutation_of(bounds_of(trains, MoveTerms(1.0, periodic=True)), period)
    if found is None:
        return None
    low, high = excluded_by(found)
    excluded = ExcludedPeriods(int(low), None if high == float("inf") else int(high), found)
    return Impossibility(1.0, Recount(trains, 1.0).names, (excluded,))


def test_beyond_the_loop_there_is_room_for_a_train_each_way_in_the_sum_of_both() -> None:
    """Not one circle: who is first on S2 and on S3 are two questions, and all other answers end in circles, too."""
    proof = proof_at(PAIR, round(2 * BEYOND_S) - 1)
    assert proof is not None
    assert proof.excluded[0].to_ticks == round(2 * BEYOND_S) - 1
    assert proof_at(PAIR, round(2 * BEYOND_S)) is None


def test_a_track_of_the_loop_is_one_circle_of_one_train() -> None:
    proof = proof_at(PAIR, round(LOOP_S) - 1)
    assert proof is not None
    (circle,) = circles_of(proof.excluded[0].because)
    assert excluded_by(circle)[1] >= LOOP_S - 1


def test_what_two_trains_need_of_a_section_is_one_circle_and_read_as_two_stints() -> None:
    """S1: 10 + 300 + 15 s each way. The up train cannot leave the loop for S1 while the other comes."""
    bounds = bounds_of(PAIR, MoveTerms(1.0, periodic=True))
    circle = refutation_of(bounds, 2 * 325 - 1)
    assert isinstance(circle, Circle)
    assert excluded_by(circle) == (0, 2 * 325 - 1)
    stints = stints_of(PAIR, circle, 1.0)
    assert sorted((s.takes, s.frees, s.length_s) for s in stints) == [("S1", "S1", 325.0)] * 2


def test_proofs_of_all_periods_are_recounted() -> None:
    for period in range(1, round(2 * BEYOND_S), 50):
        proof = proof_at(PAIR, period)
        assert proof is not None
        Recount(PAIR, 1.0).refuse(msgspec.json.decode(proof_text(proof), type=Impossibility))


@pytest.mark.parametrize("by", [-1, 1, 60])
def test_a_proof_with_one_number_changed_is_refused(by: int) -> None:
    proof = proof_at(PAIR, round(2 * BEYOND_S) - 1)
    assert proof is not None
    text = proof_text(proof)
    numbers = list(re.finditer(r"(?<=: )-?\d+(\.\d+)?", text))
    assert len(numbers) > 100
    for number in numbers:
        wrong = f"{text[: number.start()]}{json.loads(number[0]) + by}{text[number.end() :]}"
        with pytest.raises(ValueError):
            Recount(PAIR, 1.0).refuse(msgspec.json.decode(wrong, type=Impossibility))


def test_a_proof_with_a_case_left_out_is_refused() -> None:
    """Each circle of a tree alone rests on what was decided on the way to it."""
    proof = proof_at(PAIR, round(2 * BEYOND_S) - 1)
    assert proof is not None
    for circle in circles_of(proof.excluded[0].because):
        low, high = excluded_by(circle)
        alone = ExcludedPeriods(int(low), None if high == float("inf") else int(high), circle)
        with pytest.raises(ValueError, match="nothing says"):
            Recount(PAIR, 1.0).refuse(msgspec.structs.replace(proof, excluded=(alone,)))


def test_a_proof_is_of_its_legs_alone() -> None:
    others = legs([Made("1", Direction.DOWN, 0.0, throw_s=5.0), Made("2", Direction.UP, 0.0)])
    proof = proof_at(PAIR, 600)
    assert proof is not None
    with pytest.raises(ValueError, match="nothing says"):
        Recount(others, 1.0).refuse(proof)


@given(
    starts=st.lists(st.sampled_from([0.0, 37.0, 250.0, 600.0]), min_size=2, max_size=3),
    ways=st.lists(st.booleans(), min_size=3, max_size=3),
    loop=st.sampled_from(["L", "M"]),
    period=st.integers(300, 1600),
)
def test_there_is_a_proof_just_where_the_solver_finds_no_moves(
    starts: list[float], ways: list[bool], loop: str, period: int
) -> None:
    trains = legs(
        [
            Made(str(at), Direction.DOWN if down else Direction.UP, start_s, loop)
            for at, (start_s, down) in enumerate(zip(starts, ways, strict=False))
        ]
    )
    bounds = bounds_of(trains, MoveTerms(1.0, periodic=True))
    found = MovingModel(bounds, bounds.in_a_period(period), period).solve(WORK)
    proof = proof_at(trains, period)
    assert found.impossible is (proof is not None)
    assert (found.moves is None) is (proof is not None)
    if proof is not None:
        Recount(trains, 1.0).refuse(proof)


# Two trains that cross between sections X and Y, a hundred seconds long on their way: 20 s are enough for both.
CROSS = legs_of(
    [
        *(
            held("X", "d", 0.0, 10.0),
            held("Y", "d", 100.0, 110.0),
            held("P.1", "d", 110.0, 120.0, stays=True),
        ),
        held("Y", "u", 0.0, 10.0, down=False),
        *(held("X", "u", 100.0, 110.0, down=False), held("P.2", "u", 110.0, 120.0, down=False, stays=True)),
    ],
    lambda section: "." in section,
)
# One that passes P between its two legs; the second begins 190 s after the first.
PASSING = legs_of(
    [
        *(held("X", "d", 0.0, 190.0), held("P.1", "d", 190.0, 200.0)),
        *(held("Y", "d", 200.0, 300.0), held("Q.1", "d", 300.0, 310.0, stays=True)),
    ],
    lambda section: "." in section,
)
UP_FIRST_ON_X, DOWN_FIRST_ON_X = MoveBound(1, 0, 110, "X"), MoveBound(0, 1, -90, "X")
DOWN_FIRST_ON_Y = MoveBound(0, 1, 110, "Y")
NOT_SOONER, NOT_A_PERIOD_LATER = MoveBound(0, 1, 0), MoveBound(1, 0, 1, periods=1)
AGAIN = MoveBound(1, 0, 190), MoveBound(0, 1, -190, periods=-1)


def cases(one: MoveBound, other: MoveBound, rest: MoveBound, other_rest: MoveBound) -> TwoCases:
    return TwoCases(one, other, Circle((one, rest)), Circle((other, other_rest)))


FALSE = {
    "the circle of one that does not close": (
        CROSS, None, Circle((NOT_SOONER, MoveBound(0, 0, 10, "X", periods=1))), "does not close",
    ),
    "cases that leave some repetitions out": (
        CROSS, None, cases(UP_FIRST_ON_X, DOWN_FIRST_ON_X.later(-2), NOT_SOONER, NOT_A_PERIOD_LATER), "more cases",
    ),
    "cases of two sections between which trains can cross": (
        CROSS,
        None,
        cases(UP_FIRST_ON_X.later(1), DOWN_FIRST_ON_Y.later(-1), NOT_SOONER, NOT_A_PERIOD_LATER),
        "more cases",
    ),
    "a circle that adds up to nothing": (
        PASSING, None, Circle((NOT_SOONER, MoveBound(1, 0, 0))), "a circle of 0 ticks",
    ),
    "rounds of which some are left out": (
        PASSING, 1, cases(AGAIN[0], AGAIN[1].later(-1), NOT_SOONER, MoveBound(1, 0, 0)), "more cases",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FALSE)
def test_a_proof_of_what_is_not_so_is_refused(name: str) -> None:
    """Each number in it is right by itself, and it claims just what its circles would show."""
    trains, again, because, said = FALSE[name]
    low, high = excluded_by(because)
    excluded = ExcludedPeriods(int(low), None if high == float("inf") else int(high), because)
    recount = Recount(trains, 1.0, again)
    with pytest.raises(ValueError, match=said):
        recount.refuse(Impossibility(1.0, recount.names, (excluded,)))


def test_cases_that_are_all_are_taken() -> None:
    """As above, without what is wrong: 20 s are needed on X, and a round of 190 s fits no period above that."""
    circles = bounds_of(CROSS, MoveTerms(1.0, periodic=True))
    proof = refutation_of(circles, 19)
    assert proof is not None
    assert refutation_of(circles, 20) is None
    around = cases(*AGAIN, NOT_SOONER, MoveBound(1, 0, 0))
    for trains, again, because in ((CROSS, None, proof), (PASSING, 1, around)):
        low, high = excluded_by(because)
        excluded = ExcludedPeriods(int(low), None if high == float("inf") else int(high), because)
        recount = Recount(trains, 1.0, again)
        recount.refuse(Impossibility(1.0, recount.names, (excluded,)))


@pytest.mark.parametrize("excluded", [(), (ExcludedPeriods(0, 0, Circle((NOT_SOONER, NOT_A_PERIOD_LATER))),)])
def test_a_proof_that_excludes_nothing_is_none(excluded: tuple[ExcludedPeriods, ...]) -> None:
    recount = Recount(CROSS, 1.0)
    with pytest.raises(ValueError, match="excludes no interval"):
        recount.refuse(Impossibility(1.0, recount.names, excluded))


def test_a_proof_names_its_legs_and_its_ticks() -> None:
    proof = proof_at(PAIR, 600)
    assert proof is not None
    for other in (
        msgspec.structs.replace(proof, legs=proof.legs[::-1]),
        msgspec.structs.replace(proof, tick_s=2.0),
    ):
        with pytest.raises(ValueError, match="other legs"):
            Recount(PAIR, 1.0).refuse(other)


def test_parts_of_a_second_are_rounded_up_by_both() -> None:
    trains = legs([Made("1", Direction.DOWN, 0.0, throw_s=4.3), Made("2", Direction.UP, 0.0, throw_s=4.3)])
    proof = proof_at(trains, 600)
    assert proof is not None
    Recount(trains, 1.0).refuse(proof)


def test_a_stint_has_the_shortest_stand_in_seconds() -> None:
    """The down train on its track of the loop, where 40 s of its 60 are enough."""
    terms = MoveTerms(0.1, dwell_min_s=40.0, periodic=True)
    down = legs([Made("1", Direction.DOWN, 0.0)])
    circle = refutation_of(bounds_of(down, terms), round(10.0 * (LOOP_S - 20.0)) - 1)
    assert isinstance(circle, Circle)
    (stint,) = stints_of(down, circle, 0.1)
    assert (stint.direction, stint.takes, stint.frees) == (Direction.DOWN, "L.1", "L.1")
    assert stint.length_s == pytest.approx(LOOP_S - 20.0)


def test_where_sections_are_anybodys_nothing_is_impossible(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(moving_bounds, "EXCLUSIVE", False)
    assert proof_at(PAIR, 1) is None
