"""The search for runs that leave their bounds: it finds what a mend was for when that is switched off."""

from functools import cache

import pytest

from papers.joint_faults import FAILS, Trouble, carried_in
from papers.position_fusion import FORGIVING, JOINT
from verify.evidence.bounds import Candidate, Searched, TriedRun, in_words, search, try_out

SEED = 2


@cache
def searched(runs: int) -> tuple[Searched, list[TriedRun]]:
    """With the nearest so far after each run."""
    nearest: list[TriedRun] = []
    return search(2026, runs, JOINT, watch=lambda _count, best: nearest.append(best)), nearest


def test_it_finds_a_reflection_in_a_slide_when_receivers_forgive_it_and_not_otherwise() -> None:
    found = search(SEED, 40, FORGIVING, until_broken=True)
    assert found.broken
    first = found.broken[0]
    words = " ".join(in_words(SEED, first))
    assert "gnss_reflections" in words
    assert "slippery" in words
    assert not try_out(SEED, first.candidate, JOINT).broken


@pytest.mark.parametrize(
    "runs", [pytest.param(14, id="slice"), pytest.param(10_000, id="all", marks=pytest.mark.nightly)]
)
def test_no_searched_run_leaves_its_bounds(runs: int) -> None:
    found, nearest = searched(runs)
    assert found.runs == runs
    assert not found.broken, in_words(2026, found.broken[0])
    assert any(tried.candidate.troubles for tried in nearest)
    for tried in nearest:
        known = {kind for sensor in carried_in(tried.candidate.number) for kind in FAILS.get(sensor, {})}
        assert {t.kind for t in tried.candidate.troubles} <= known | {"no_output", "gnss_frozen"}


def test_a_gyro_that_goes_bad_within_what_is_compared_moves_nothing() -> None:
    """Noise of 61 times what is stated in the newest metres, none in those before: on the mean it hardly shows."""
    worse = [
        Trouble("gyro_noise", None, 4235.0 + k, 7235.0 + k, "gyro_noise", {"factor": factor})
        for k, factor in ((0.0, 8.69), (73.0, 7.06))
    ]
    assert not try_out(40001, Candidate(105, tuple(worse)), JOINT).broken


def test_the_same_seed_gives_the_same_search() -> None:
    assert search(2026, 14, JOINT).nearest == searched(14)[0].nearest
