"""Proofs that legs do not fit: found where there are no moves, recounted, and refused where one number is another."""

from __future__ import annotations

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
from plan.moving.proof import Circle, ExcludedPeriods, Impossibility, circles_of, proof_text
from plan.moving.recount import Recount
from plan.moving.refutation import excluded_by, refutation_of
from plan.moving.stints import stints_of
from study.capacity.legs import SetLeg
from tests.study.capacity.hand_made import FREE_S, SET_S, Made, legs

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


def test_where_sections_are_anybodys_nothing_is_impossible(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(moving_bounds, "EXCLUSIVE", False)
    assert proof_at(PAIR, 1) is None
