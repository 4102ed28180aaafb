"""The exact figures against enumeration, the binomial law and the reader's own code."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from onboard.localisation.reader import CRC_POLYNOMIAL, IdAgreement, decode, encode, judge
from papers.tag_scheme import (
    OUTCOMES,
    PaperTraffic,
    Scheme,
    any_rule_probabilities,
    outcome_probabilities,
    passage_failure,
    settled,
)
from papers.tag_trials import clopper_pearson, trials, weighted_trials
from radio.chance import generator
from simulation.sensors.tag_air import BIT_ERROR_RATES, Channel, shifted_words

PAPER = Scheme("paper")
TAG_ID = 0x2C9A
VOTES = np.array(OUTCOMES, dtype=np.int64)
RIGHTS, WRONGS = np.ascontiguousarray(VOTES[:, 0]), np.ascontiguousarray(VOTES[:, 1])


def weight_counts() -> list[int]:
    """How many words of the 24-bit code have each weight, by adding up shifted generators."""
    words = np.zeros(1, dtype=np.int64)
    for shift in range(16):
        words = np.concatenate([words, words ^ ((CRC_POLYNOMIAL | 0x100) << shift)])
    return [int(n) for n in np.bincount(np.bitwise_count(words), minlength=25)]


def test_the_papers_line_has_6000_passages_a_day() -> None:
    assert PaperTraffic().passages_per_day == 6000.0
    assert PaperTraffic().passages_per_h == 300.0


def test_table_7_has_three_telegrams_at_100_and_two_at_130() -> None:
    assert {v: len(rates) for v, rates in BIT_ERROR_RATES.items()} == {40: 9, 60: 6, 80: 4, 100: 3, 130: 2}


def test_a_misread_head_shifts_the_telegram() -> None:
    channel = Channel((0.1,), head_bits=4, shift_bits_max=2)
    assert channel.shift_probability(0.1) == pytest.approx(1.0 - 0.9**4)
    assert channel.shifts() == (0, -1, -2, 1, 2)
    assert channel.shift_probabilities()[0] == pytest.approx([0.9**4, *[(1.0 - 0.9**4) / 4] * 4])
    assert Channel((0.1,), shift_bits_max=0).shift_probabilities() == pytest.approx(1.0)


@given(st.integers(0, 0xFFFF), st.integers(0, 2**64 - 1), st.integers(-9, 9))
def test_a_shift_moves_the_telegrams_bits(tag_id: int, serial: int, shift: int) -> None:
    telegram = encode(tag_id, serial)
    words = tuple(telegram >> place & 0xFFFFFFFF for place in (96, 64, 32, 0))
    moved = telegram << shift if shift >= 0 else telegram >> -shift
    assert shifted_words((words[0], words[1], words[2], words[3]), shift) == (
        moved >> 64 & 0xFFFFFFFF,
        moved >> 32 & 0xFFFFFFFF,
    )
    assert decode(telegram) == (tag_id, tag_id)


@pytest.mark.parametrize("p", [1.2e-3, 0.05])
def test_wrong_items_follow_the_weights_of_the_code(p: float) -> None:
    scheme = Scheme("one", tags=1, ids_per_telegram=1, rule=IdAgreement(1, 1, 1))
    outcomes = outcome_probabilities(scheme, Channel((p,), shift_bits_max=0), TAG_ID)
    assert outcomes[0, 1] == pytest.approx((1.0 - p) ** 32)
    wrong = sum(n * p**w * (1.0 - p) ** (32 - w) for w, n in enumerate(weight_counts()) if w > 0)
    assert outcomes[0, 2].sum() == pytest.approx(wrong, rel=1e-12)


def test_outcomes_of_a_telegram_are_complete() -> None:
    outcomes = outcome_probabilities(PAPER, Channel((0.03, 0.2)), TAG_ID)
    assert outcomes.min() >= 0.0
    assert outcomes.sum(axis=1) == pytest.approx(1.0)
    assert not outcomes[:, [2, 3, 5], TAG_ID].any()


def test_both_items_of_a_telegram_are_lost_in_one_shift() -> None:
    channel = Channel((0.01,), shift_factor=1.0)
    right_twice = outcome_probabilities(PAPER, channel, TAG_ID)[0, 4, 0]
    assert right_twice == pytest.approx(0.99**4 * 0.99**64, rel=1e-6)


@given(st.integers(0, 2**32 - 1), st.integers(1, 3), st.integers(1, 5), st.integers(1, 4))
def test_windows_are_followed_as_the_reader_judges(
    seed: int, agree: int, telegrams: int, window: int
) -> None:
    probabilities = np.random.default_rng(seed).dirichlet(np.ones(len(OUTCOMES)), size=telegrams)
    expected: dict[int | None, float] = {1: 0.0, 2: 0.0, None: 0.0}
    for passage in product(range(len(OUTCOMES)), repeat=telegrams):
        items: list[int | None] = []
        for outcome in passage:
            right, wrong = OUTCOMES[outcome]
            items += [1] * right + [2] * wrong + [None] * (2 - right - wrong)
        found = judge(items, IdAgreement(2 * window, agree, 2)).tag_id
        expected[found] += float(np.prod(probabilities[np.arange(telegrams), list(passage)]))
    exact = settled(probabilities, 1, window, agree, RIGHTS, WRONGS)
    assert exact == pytest.approx((expected[1], expected[2], expected[None]), abs=1e-12)


def test_one_window_without_shifts_is_binomial() -> None:
    failure = passage_failure(PAPER, Channel((0.02, 0.02), shift_bits_max=0), TAG_ID)
    assert failure.safe_side == pytest.approx(float(binom.cdf(2, 8, 0.98**32)), rel=1e-9)


def test_any_rule_bounds_the_readers_rule() -> None:
    for rates in BIT_ERROR_RATES.values():
        failure = passage_failure(PAPER, Channel(rates), TAG_ID)
        assert 0.0 < failure.unsafe <= failure.unsafe_any_rule
        assert failure.safe_side_at_most == failure.safe_side + failure.unsafe_any_rule


def test_two_equal_wrong_items_without_vote_order_follow_the_binomial() -> None:
    p = 0.1
    scheme = Scheme("any two", tags=1, ids_per_telegram=1, rule=IdAgreement(4, 2, 1))
    outcomes = outcome_probabilities(scheme, Channel((p,) * 4, shift_bits_max=0), TAG_ID)
    weights = weight_counts()
    expected = sum(n * binom.sf(1, 4, p**w * (1.0 - p) ** (32 - w)) for w, n in enumerate(weights) if w > 0)
    assert any_rule_probabilities(scheme, outcomes).sum() == pytest.approx(expected, rel=1e-6)


def test_a_rule_must_move_by_one_telegram() -> None:
    with pytest.raises(ValueError, match="one telegram"):
        passage_failure(Scheme("odd", ids_per_telegram=1), Channel((0.01,)), TAG_ID)


def test_clopper_pearson_without_hits() -> None:
    estimate = clopper_pearson(0, 100, 0.95)
    assert (estimate.value, estimate.low) == (0.0, 0.0)
    assert estimate.high == pytest.approx(1.0 - 0.025**0.01)
    assert clopper_pearson(100, 100, 0.95).high == 1.0
    assert clopper_pearson(1, 10, 0.95).low == pytest.approx(1.0 - 0.975**0.1)  # any hit: 1 - (1 - p)^10
    assert clopper_pearson(9, 10, 0.95).high == pytest.approx(0.975**0.1)  # no miss: p^10


def test_clean_telegrams_always_give_the_right_id() -> None:
    counts = trials(generator(1, "test"), Channel((1e-12,) * 3), TAG_ID, 2, IdAgreement(), 1000)
    assert (counts.wrong, counts.none) == (0, 0)


@pytest.mark.parametrize("shift_factor", [0.0, 1.0, 3.0])
def test_played_passages_agree_with_the_exact_figures(shift_factor: float) -> None:
    channel = Channel((0.05, 0.02, 0.05), shift_factor=shift_factor)
    counts = trials(generator(2, "test"), channel, TAG_ID, 2, IdAgreement(), 100_000)
    estimate = clopper_pearson(counts.none, counts.trials, 0.999)
    assert estimate.holds(passage_failure(PAPER, channel, TAG_ID).safe_side)


@pytest.mark.parametrize("shift_bits_max", [4, 12])
def test_weighted_passages_agree_with_the_exact_figures(shift_bits_max: int) -> None:
    channel = Channel((0.03, 0.01), shift_bits_max=shift_bits_max)
    shares = any_rule_probabilities(PAPER, outcome_probabilities(PAPER, channel, TAG_ID))
    game = channel, TAG_ID, 2, IdAgreement(), shares / shares.sum(), 400_000
    estimate, one = (weighted_trials(generator(3, "test"), *game, within) for within in (0.999, 0.6827))
    sigmas = (estimate.high - estimate.value) / (one.high - one.value)
    assert sigmas == pytest.approx(3.29, rel=1e-3)
    assert estimate.high < 2.0 * estimate.value
    assert estimate.holds(passage_failure(PAPER, channel, TAG_ID).unsafe)
