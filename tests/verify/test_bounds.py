"""The search for runs that leave their bounds: it finds what a mend was for when that is switched off."""

from functools import cache

import pytest

from papers.joint_faults import FAILS, Trouble, carried_in
from papers.position_fusion import FORGIVING, JOINT
from tests.nightly import others_nightly
from verify.evidence.bounds import Candidate, Searched, TriedRun, in_words, search, try_out

SEED = 2
# a slice, and 10,000 runs in parts by night
SEARCHES = ((2026, 14), *((seed, 1000) for seed in range(2026, 2036)))


@cache
def searched(seed: int, runs: int) -> tuple[Searched, list[TriedRun]]:
    """With the nearest so far after each run."""
    nearest: list[TriedRun] = []
    return search(seed, runs, JOINT, watch=lambda _count, best: nearest.append(best)), nearest


def test_it_finds_a_reflection_in_a_slide_when_receivers_forgive_it_and_not_otherwise() -> None:
    found = search(SEED, 40, FORGIVING, until_broken=True)
    assert found.broken
    first = found.broken[0]
    words = " ".join(in_words(SEED, first))
    assert "gnss_reflections" in words
    assert "slippery" in words
    assert not try_out(SEED, first.candidate, JOINT).broken


@pytest.mark.parametrize(("seed", "runs"), others_nightly(SEARCHES, SEARCHES[:1], columns=True))
def test_no_searched_run_leaves_its_bounds(seed: int, runs: int) -> None:
    found, nearest = searched(seed, runs)
    assert found.runs == runs
    assert not found.broken, in_words(seed, found.broken[0])
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
    assert search(2026, 14, JOINT).nearest == searched(2026, 14)[0].nearest
