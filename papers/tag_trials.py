"""Monte-Carlo of tag (地上子) passages with the reader's own code, to confirm the exact figures.

`trials` plays passages as they come. `weighted_trials` makes rare wrong ids frequent: a wrong id is drawn with
the share `shares` gives it, then telegrams are shifted and items are turned into that id, or spoiled, far more
often than in the air; each passage counts with the ratio of its probability in the air to that in the game
(importance sampling), so the mean is unbiased whatever the shares.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.stats import beta, norm

from onboard.localisation.reader import REFUSED, WORD_BITS, IdAgreement, item_id, item_word, judged_windows
from simulation.sensors.tag_air import (
    CHECKS,
    Channel,
    Floats,
    Ints,
    drawn_index,
    error_pattern,
    receive,
    received_words,
)
from vehicle.compiled import compiled

# the game of `weighted_trials`
TURNED: Final = 0.25  # share of items made the wrong id
SPOILED: Final = 0.25  # share of items given errors at
SPOILED_RATE: Final = 1.0 / 32.0  # this bit-error rate
SHIFTED: Final = 0.1  # share of telegrams whose shift is drawn from all alike


@dataclass(frozen=True, slots=True)
class Counts:
    """What so many passages gave."""

    trials: int
    wrong: int
    none: int


@dataclass(frozen=True, slots=True)
class ProbabilityEstimate:
    """A probability from a sample with its confidence interval."""

    value: float
    low: float
    high: float

    def holds(self, exact: float) -> bool:
        """Whether the exact value lies in the interval."""
        return self.low <= exact <= self.high


def clopper_pearson(hits: int, trials: int, confidence: float) -> ProbabilityEstimate:
    """Share of hits with its exact two-sided binomial interval (Clopper and Pearson)."""
    tail = (1.0 - confidence) / 2.0
    low = float(beta.ppf(tail, hits, trials - hits + 1)) if hits > 0 else 0.0
    high = float(beta.ppf(1.0 - tail, hits + 1, trials - hits)) if hits < trials else 1.0
    return ProbabilityEstimate(hits / trials, low, high)


@compiled
def _play(
    rng: np.random.Generator,
    received: Ints,
    shift_cumulative: Floats,
    bit_error_rates: Floats,
    right_id: int,
    tags: int,
    rule: tuple[int, int, int],
    count: int,
) -> tuple[int, int]:
    """Numbers of wrong and of missing ids among `count` passages; `received` (shifts, items of a telegram)."""
    items = np.empty(2 * tags * len(bit_error_rates), dtype=np.int64)
    wrong, none = 0, 0
    for _ in range(count):
        receive(rng, received, shift_cumulative, bit_error_rates, items)
        found, _ = judged_windows(items, rule[0], rule[1], rule[2])
        if found == REFUSED:
            none += 1
        elif found != right_id:
            wrong += 1
    return wrong, none


@compiled
def _item_turned(
    rng: np.random.Generator, bit_error_rate: float, turning: int, powers: Floats, spoiled_powers: Floats
) -> tuple[int, float]:
    """Errors of one item in the weighted game, and the ratio of their probability in the air to the game's."""
    choice = rng.random()
    if choice < TURNED:
        pattern = turning
    elif choice < TURNED + SPOILED:
        pattern = error_pattern(rng, SPOILED_RATE)
    else:
        pattern = error_pattern(rng, bit_error_rate)
    weight, rest = 0, pattern
    while rest:
        rest &= rest - 1
        weight += 1
    game = SPOILED * spoiled_powers[weight] + (1.0 - TURNED - SPOILED) * powers[weight]
    if pattern == turning:
        game += TURNED
    return pattern, powers[weight] / game


@compiled
def _play_weighted(
    rng: np.random.Generator,
    received: Ints,
    shift_cumulative: Floats,
    shift_ratios: Floats,
    bit_error_rates: Floats,
    powers: Floats,
    shares: Floats,
    share_cumulative: Floats,
    tags: int,
    rule: tuple[int, int, int],
    count: int,
) -> tuple[float, float]:
    """Sum and sum of squares of the weights of passages that gave the wrong id drawn for them.

    `powers` (telegrams of a tag + 1, 33): probability of one pattern by its weight, the last row for spoiled items.
    """
    places = len(bit_error_rates)
    items = np.empty(2 * tags * places, dtype=np.int64)
    ratios = np.empty(tags * places)
    total, squares = 0.0, 0.0
    for _ in range(count):
        wrong_id = drawn_index(rng, share_cumulative)
        for telegram in range(tags * places):
            place = telegram % places
            shift = drawn_index(rng, shift_cumulative[place])
            ratio = shift_ratios[place, shift]
            for i in range(2):
                word = received[shift, i]
                turning = word ^ item_word(wrong_id, CHECKS[i])
                pattern, item_ratio = _item_turned(
                    rng, float(bit_error_rates[place]), turning, powers[place], powers[places]
                )
                ratio *= item_ratio
                items[2 * telegram + i] = item_id(word ^ pattern, CHECKS[i])
            ratios[telegram] = ratio
        found, items_read = judged_windows(items, rule[0], rule[1], rule[2])
        if found == wrong_id:
            # telegrams after the decision do not weigh: their ratio is one in the mean
            weight = 1.0 / shares[wrong_id]
            for telegram in range(items_read // 2):
                weight *= ratios[telegram]
            total += weight
            squares += weight * weight
    return total, squares


def trials(
    rng: np.random.Generator, channel: Channel, tag_id: int, tags: int, rule: IdAgreement, count: int
) -> Counts:
    """Play `count` passages over `tags` tags with two ids a telegram, as they come."""
    wrong, none = _play(
        rng,
        received_words(channel, tag_id),
        np.cumsum(channel.shift_probabilities(), axis=1),
        np.array(channel.bit_error_rates),
        tag_id,
        tags,
        (rule.window_items, rule.agree, rule.step_items),
        count,
    )
    return Counts(count, int(wrong), int(none))


def weighted_trials(
    rng: np.random.Generator,
    channel: Channel,
    tag_id: int,
    tags: int,
    rule: IdAgreement,
    shares: Floats,
    count: int,
    confidence: float,
) -> ProbabilityEstimate:
    """Probability of a wrong id; interval by the normal law of the mean weight.

    `shares` of the wrong ids in the game, summing to one; zero only where the id's part may be left out.
    """
    weights = np.arange(WORD_BITS + 1)
    rates = np.array([*channel.bit_error_rates, SPOILED_RATE])[:, None]
    shifts = channel.shift_probabilities()
    game_shifts = (1.0 - SHIFTED) * shifts + SHIFTED / shifts.shape[1]
    total, squares = _play_weighted(
        rng,
        received_words(channel, tag_id),
        np.cumsum(game_shifts, axis=1),
        shifts / game_shifts,
        np.array(channel.bit_error_rates),
        rates**weights * (1.0 - rates) ** (WORD_BITS - weights),
        shares,
        np.cumsum(shares),
        tags,
        (rule.window_items, rule.agree, rule.step_items),
        count,
    )
    mean = total / count
    deviation = float(np.sqrt(max(0.0, squares / count - mean * mean) / count))
    reach = float(norm.ppf((1.0 + confidence) / 2.0)) * deviation
    return ProbabilityEstimate(mean, mean - reach, mean + reach)
