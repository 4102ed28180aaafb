"""What lies between a tag (地上子) and the reader: a passage's telegrams with their bit errors and shifts, by speed.

Sugiyama, Fukuda and Kitano, section 6: the rates of table 7, two tags side by side, two items a telegram. Line runs
that ask for bits and the analysis of `branchline reproduce sugiyama-tags` play the same passages.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.localisation.reader import (
    CHECK_STRINGS,
    PAPER_RULE,
    REFUSED,
    WORD_BITS,
    WORD_MASK,
    item_id,
    item_word,
    judged_windows,
)
from vehicle.compiled import compiled

# Table 7: bit-error rate of each telegram from the first within one tag's range, by speed in km/h
BIT_ERROR_RATES: Final[Mapping[int, tuple[float, ...]]] = {
    40: (1.0e-2, 1.3e-3, 5.8e-4, 3.4e-4, 2.0e-4, 2.7e-4, 7.6e-4, 5.5e-3, 3.6e-2),
    60: (6.0e-3, 4.9e-4, 3.9e-4, 5.6e-4, 2.5e-3, 3.9e-2),
    80: (3.1e-3, 4.6e-4, 5.1e-4, 7.2e-3),
    100: (1.2e-3, 1.2e-4, 1.4e-3),
    130: (9.1e-4, 9.9e-4),
}
TAGS_PAPER: Final = 2  # side by side at each place
CHECKS: Final = np.array(CHECK_STRINGS, dtype=np.int64)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Channel:
    """What the air does to the telegrams of one tag: bit errors, and shifts by 1 to `shift_bits_max` bits.

    A head of `head_bits` bits with any of them wrong is taken to be found too early or too late, by each distance
    alike; a shift's probability is thus 1 - (1 - p)^head_bits at the telegram's own bit-error rate p, times
    `shift_factor` (at most 1 in all).
    """

    bit_error_rates: tuple[float, ...]
    head_bits: int = 4
    shift_bits_max: int = 4
    shift_factor: float = 1.0

    def shift_probability(self, bit_error_rate: float) -> float:
        """Probability that a telegram is read shifted."""
        misread = -math.expm1(self.head_bits * math.log1p(-bit_error_rate))
        return min(1.0, self.shift_factor * misread)

    def shifts(self) -> tuple[int, ...]:
        """The shifts in bits, 0 first; negative: the telegram is read too early."""
        distances = range(1, self.shift_bits_max + 1)
        return (0, *(-s for s in distances), *distances)

    def shift_probabilities(self) -> Floats:
        """Probability of each of `shifts`, one row a telegram."""
        one = [self.shift_probability(p) for p in self.bit_error_rates]
        count = 2 * self.shift_bits_max
        return np.array([[1.0 - q, *[q / count] * count] if count else [1.0] for q in one])

    def with_errors(self, factor: float) -> Channel:
        """The same channel with all bit-error rates times `factor`, at most one half."""
        rates = tuple(min(0.5, factor * p) for p in self.bit_error_rates)
        return Channel(rates, self.head_bits, self.shift_bits_max, self.shift_factor)


@cache
def channel_at(speed_mps: float, factor: float) -> Channel:
    """The channel of a speed by table 7, all rates times `factor`: that of the next higher speed in the table.

    A faster train reads fewer telegrams, so this is the worse one; above 130 km/h that of 130.
    """
    speeds_kmh = sorted(BIT_ERROR_RATES)
    reached = next((kmh for kmh in speeds_kmh if kmh >= speed_mps * 3.6), speeds_kmh[-1])
    return Channel(BIT_ERROR_RATES[reached]).with_errors(factor)


def shifted_words(words: tuple[int, int, int, int], shift: int) -> tuple[int, int]:
    """The two item words as read `shift` bits too late (negative: too early) from a telegram's four words."""
    bits = 0
    for word in words:
        bits = bits << WORD_BITS | word
    bits = bits << shift if shift >= 0 else bits >> -shift
    return bits >> 2 * WORD_BITS & WORD_MASK, bits >> WORD_BITS & WORD_MASK


def received_words(channel: Channel, tag_id: int) -> Ints:
    """Both item words of a telegram as they are read at each of the channel's shifts, without errors."""
    first, second = (int(item_word(tag_id, check)) for check in CHECK_STRINGS)
    return np.array(
        [shifted_words((0, first, second, 0), shift) for shift in channel.shifts()], dtype=np.int64
    )


@compiled
def error_pattern(rng: np.random.Generator, bit_error_rate: float) -> int:
    """Independent errors in 32 bits, drawn by the distance to the next error."""
    scale = 1.0 / np.log1p(-bit_error_rate)
    pattern = bit = 0
    while True:
        gap = np.log(1.0 - rng.random()) * scale
        if not gap < WORD_BITS - bit:  # without errors it is no number
            return pattern
        bit += int(gap)
        pattern |= 1 << bit
        bit += 1


@compiled
def drawn_index(rng: np.random.Generator, cumulative: Floats) -> int:
    """An index drawn by its cumulative probability."""
    value = rng.random()
    low, high = 0, len(cumulative) - 1
    while low < high:
        middle = (low + high) // 2
        if cumulative[middle] > value:
            high = middle
        else:
            low = middle + 1
    return low


@compiled
def receive(
    rng: np.random.Generator, received: Ints, shift_cumulative: Floats, bit_error_rates: Floats, items: Ints
) -> None:
    """Fill `items` with the ids of one passage's data items, in order of reading; REFUSED where the check fails.

    `received` (shifts, items of a telegram): the words without errors. As many tags are passed as `items` has room for.
    """
    for telegram in range(len(items) // 2):
        place = telegram % len(bit_error_rates)
        shift = drawn_index(rng, shift_cumulative[place])
        for i in range(2):
            word = received[shift, i] ^ error_pattern(rng, bit_error_rates[place])
            items[2 * telegram + i] = item_id(word, CHECKS[i])


def read_bits(rng: np.random.Generator, tag_id: int, channel: Channel) -> int | None:
    """The id that the reader makes of one passage over tags that say `tag_id`; None if it believes none."""
    items = np.empty(2 * TAGS_PAPER * len(channel.bit_error_rates), dtype=np.int64)
    receive(
        rng,
        received_words(channel, tag_id),
        np.cumsum(channel.shift_probabilities(), axis=1),
        np.array(channel.bit_error_rates),
        items,
    )
    found, _ = judged_windows(items, PAPER_RULE.window_items, PAPER_RULE.agree, PAPER_RULE.step_items)
    return None if found == REFUSED else int(found)
