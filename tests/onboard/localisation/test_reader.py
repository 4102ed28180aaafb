"""The tag telegram and the vote: section 6.1.3 of Sugiyama, Fukuda and Kitano, and what a CRC must do."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.localisation.reader import (
    CHECK_STRINGS,
    CRC_OFFSET,
    CRC_POLYNOMIAL,
    REFUSED,
    IdAgreement,
    Judgement,
    crc8,
    decode,
    encode,
    item_id,
    item_word,
    judge,
)

IDS = np.arange(1 << 16)
ids = st.integers(0, 0xFFFF)
A, B, N = 7, 9, None


def words_of_weight(polynomial: int) -> Counter[int]:
    """Weights of all multiples of x^8 + `polynomial` below x^24, by adding up shifted generators."""
    words = np.zeros(1, dtype=np.int64)
    for shift in range(16):
        words = np.concatenate([words, words ^ ((polynomial | 0x100) << shift)])
    return Counter(np.bitwise_count(words).tolist())


@given(ids, st.integers(0, 2**64 - 1))
def test_a_telegram_says_its_id_twice(tag_id: int, serial: int) -> None:
    telegram = encode(tag_id, serial)
    assert telegram.bit_length() <= 128
    assert decode(telegram) == (tag_id, tag_id)


def test_other_bits_are_kept_out_of_the_users_64() -> None:
    assert encode(5, 0) ^ encode(5, 2**64 - 1) == 0xFFFFFFFF << 96 | 0xFFFFFFFF


@pytest.mark.parametrize(("tag_id", "serial"), [(-1, 0), (1 << 16, 0), (0, 1 << 64), (0, -1)])
def test_what_does_not_fit_is_refused(tag_id: int, serial: int) -> None:
    with pytest.raises(ValueError, match="does not fit"):
        encode(tag_id, serial)


def test_a_telegram_has_128_bits() -> None:
    with pytest.raises(ValueError, match="128 bits"):
        decode(1 << 128)


def test_the_polynomial_is_the_best_of_all_for_24_bits() -> None:
    ranks = {}
    for polynomial in range(1, 256, 2):
        weights = words_of_weight(polynomial)
        distance = min(w for w in weights if w > 0)
        ranks[polynomial] = (-distance, weights[distance])
    assert ranks[CRC_POLYNOMIAL] == min(ranks.values()) == (-4, 29)


def test_crc_is_the_remainder_plus_the_constant() -> None:
    weights = Counter(int(i << 8 | crc8(i) ^ CRC_OFFSET).bit_count() for i in IDS.tolist())
    assert weights == words_of_weight(CRC_POLYNOMIAL)


@given(ids, st.integers(0, 1), st.sets(st.integers(0, 31), min_size=1, max_size=3))
def test_up_to_three_errors_in_an_item_are_found(tag_id: int, place: int, errors: set[int]) -> None:
    telegram = encode(tag_id)
    for bit in errors:
        telegram ^= 1 << (64 - 32 * place + bit)
    assert decode(telegram)[place] is None
    assert decode(telegram)[1 - place] == tag_id


@given(ids, st.integers(0, 2**64 - 1), st.integers(1, 7))
def test_a_telegram_read_early_or_late_is_refused(tag_id: int, serial: int, shift: int) -> None:
    telegram = encode(tag_id, serial)
    assert decode(telegram >> shift) == (None, None)
    assert decode(telegram << shift & (1 << 128) - 1) == (None, None)


def test_no_id_survives_a_shift_of_three_bits_by_its_crc_alone() -> None:
    for tag_id in range(0, 1 << 16, 7):
        for shift in (1, 2, 3):
            for moved in (encode(tag_id) >> shift, encode(tag_id) << shift):
                for place in (64, 32):
                    word = moved >> place & 0xFFFFFF
                    assert item_id(CHECK_STRINGS[0] << 24 | word, CHECK_STRINGS[0]) == REFUSED


@pytest.mark.parametrize("check", CHECK_STRINGS)
def test_check_strings_differ_from_themselves_when_moved(check: int) -> None:
    moved = [((check >> s ^ check) & (0xFF >> s)).bit_count() for s in range(1, 8)]
    assert moved == [3, 3, 3, 3, 1, 1, 1]


def test_an_item_in_the_others_place_is_refused() -> None:
    assert item_id(item_word(A, CHECK_STRINGS[0]), CHECK_STRINGS[1]) == REFUSED


@pytest.mark.parametrize(
    ("items", "expected"),
    [
        ([A] * 12, Judgement(A, 8)),
        ([A, N, N, A, N, N, N, A, N, N, N, N], Judgement(A, 8)),  # three of the first eight
        ([A, A, N, N, N, N, N, N, N, A, N, N], Judgement(None, 12)),  # the first two have left when it comes
        ([N, N, A, A, N, N, N, N, N, A, N, N], Judgement(A, 10)),  # one telegram further on
        ([N, N, N, N, A, N, N, N, A, N, N, A], Judgement(A, 12)),
        ([A, A, A, B, B, B, N, N], Judgement(None, 8)),  # two ids: neither
        ([A, A, A, B, B, B, N, N, B, N], Judgement(B, 10)),  # and on, until one of them is left
        ([A, A, B, B, N, N, N, N, N, N, N, N], Judgement(None, 12)),
        ([N] * 12, Judgement(None, 12)),
        ([A, N, A, A, N, N], Judgement(A, 6)),  # one tag at 100 km/h: one window
        ([A, N, A], Judgement(None, 3)),
        ([], Judgement(None, 0)),
    ],
)
def test_the_vote(items: list[int | None], expected: Judgement) -> None:
    assert judge(items) == expected


@given(
    st.lists(st.sampled_from([None, 1, 2, 3]), max_size=24),
    st.builds(IdAgreement, st.integers(1, 8), st.integers(1, 4), st.integers(1, 2)),
)
def test_the_vote_agrees_with_counting(items: list[int | None], rule: IdAgreement) -> None:
    window = min(rule.window_items, len(items))
    expected = Judgement(None, len(items))
    for first in range(0, len(items) - window + 1, rule.step_items):
        votes = Counter(i for i in items[first : first + window] if i is not None)
        winners = [i for i, n in votes.items() if n >= rule.agree]
        if len(winners) == 1:
            expected = Judgement(winners[0], first + window)
            break
    assert judge(items, rule) == expected
