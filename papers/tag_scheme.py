"""How often a tag (地上子) passage gives a wrong id or none: exact probabilities for the paper's scheme and others.

Sugiyama, Fukuda and Kitano, section 6. What is exact and what is a bound:

- A received item is the sent word, moved by a shift if the head was misread, with independent bit errors. The
  probability that it becomes one given word at Hamming distance d is p^d (1 - p)^(32 - d), so the probability of
  every one of the 65,536 ids is known for each telegram, and with it that of each pair in one telegram.
- For each wrong id by itself, the windows are followed telegram by telegram with everything that matters to it
  (how many right items and how many of this id stand in the window), by the decoder's own rule. `unsafe` sums
  this over all wrong ids. It leaves out only that two *different* wrong ids stop each other: an upper bound,
  short of the truth by the probability of that.
- `unsafe_any_rule` is the probability, summed likewise, that a wrong id comes often enough anywhere in the passage,
  whatever else was read: a bound that holds for any treatment of ties.
- `safe_side` is the probability that the right id never comes often enough in a window. A wrong id that stops the
  right one can add no more than `unsafe_any_rule`: `safe_side_at_most` has both.

Sums have positive terms only, so nothing cancels; terms below 1e-308 vanish.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from onboard.localisation.reader import (
    CHECK_STRINGS,
    CRC_OFFSET,
    PAPER_RULE,
    WORD_BITS,
    WORD_MASK,
    IdAgreement,
    crc8,
)
from simulation.sensors.tag_air import Channel, Floats, Ints, shifted_words
from vehicle.compiled import compiled

UNREADABLE: Final = 0.5  # the telegram that table 7 marks ※, as bit-error rate: nothing of it is left
IDS: Final = 1 << 16
# what one telegram brings to the vote between the right id and one wrong id: (right items, wrong items)
OUTCOMES: Final = ((0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2))
SINGLE_OUTCOMES: Final = 3  # of a telegram with one item
NEGLIGIBLE: Final = 1e-5  # share of a sum over wrong ids that may be left to its bound
RECOUNT: Final = 256  # wrong ids between two sums over the rest


@dataclass(frozen=True, slots=True)
class Scheme:
    """How a tagging place is made and read. Without `check_strings` the reader does not look at them."""

    name: str
    tags: int = 2
    ids_per_telegram: int = 2
    rule: IdAgreement = PAPER_RULE
    check_strings: bool = True
    crc_offset: int = CRC_OFFSET


@dataclass(frozen=True, slots=True)
class FailureProbabilities:
    """Probabilities of failure of one passage, or the same per hour; see the module for what they bound."""

    unsafe: float
    unsafe_any_rule: float
    safe_side: float

    @property
    def safe_side_at_most(self) -> float:
        """Upper bound of the safe-side failures, passages that a wrong id spoils included."""
        return self.safe_side + self.unsafe_any_rule

    def times(self, passages_per_h: float) -> FailureProbabilities:
        """Per hour, for so many passages an hour."""
        return FailureProbabilities(
            self.unsafe * passages_per_h,
            self.unsafe_any_rule * passages_per_h,
            self.safe_side * passages_per_h,
        )


@dataclass(frozen=True, slots=True)
class PaperTraffic:
    """The paper's line: section 6.1.3."""

    trains: int = 5
    speed_kmh: float = 60.0
    hours_per_day: float = 20.0
    station_spacing_km: float = 3.0
    tag_places_per_station: int = 3

    @property
    def passages_per_day(self) -> float:
        """Passages of a tagging place a day, all trains together; 6,000 for the paper's figures."""
        run_km = self.trains * self.speed_kmh * self.hours_per_day
        return run_km / self.station_spacing_km * self.tag_places_per_station

    @property
    def passages_per_h(self) -> float:
        """Passages in an hour of operation; a day's by 24 hours would be fewer."""
        return self.passages_per_day / self.hours_per_day


@cache
def item_words(crc_offset: int = CRC_OFFSET) -> Ints:
    """Words of both data items for every id, shape (2, ids), with another CRC constant where asked for."""
    tag_ids = np.arange(IDS)
    checks = np.array([crc8(i) for i in range(IDS)], dtype=np.int64) ^ CRC_OFFSET ^ crc_offset
    return np.stack([check << 24 | tag_ids << 8 | checks for check in CHECK_STRINGS])


def outcome_probabilities(scheme: Scheme, channel: Channel, tag_id: int, serial: int = 0) -> Floats:
    """Probability of each of OUTCOMES for every id as the wrong one; shape (telegrams of a tag, outcomes, ids).

    The column of the right id itself has wrong items of probability zero: its outcomes are the right items alone.
    """
    targets = item_words(scheme.crc_offset)
    sent = (serial >> WORD_BITS, int(targets[0, tag_id]), int(targets[1, tag_id]), serial & WORD_MASK)
    mask = WORD_MASK if scheme.check_strings else (1 << 24) - 1
    bits = mask.bit_count()
    received = np.array([shifted_words(sent, shift) for shift in channel.shifts()])
    distances = np.bitwise_count((received[:, :, None] ^ targets[None]) & mask)
    outcomes = SINGLE_OUTCOMES if scheme.ids_per_telegram == 1 else len(OUTCOMES)
    result = np.zeros((len(channel.bit_error_rates), outcomes, IDS))
    for k, (p, shifts) in enumerate(
        zip(channel.bit_error_rates, channel.shift_probabilities(), strict=True),
    ):
        weights = np.arange(bits + 1)
        items = (p**weights * (1.0 - p) ** (bits - weights))[distances]
        for probability, (first, second) in zip(shifts, items, strict=True):
            result[k] += probability * _telegram_outcomes(first, second, tag_id, outcomes)
    return result


def _telegram_outcomes(first: Floats, second: Floats, tag_id: int, outcomes: int) -> Floats:
    """OUTCOMES of one telegram with a given shift, from the probabilities of every id in its two items."""
    r1, r2 = first[tag_id], second[tag_id]
    w1, w2 = first.copy(), second.copy()
    w1[tag_id] = w2[tag_id] = 0.0
    n1, n2 = np.maximum(0.0, 1.0 - r1 - w1), np.maximum(0.0, 1.0 - r2 - w2)
    if outcomes == SINGLE_OUTCOMES:
        return np.stack([n1, np.full(IDS, r1), w1])
    both_right = np.full(IDS, r1 * r2)
    return np.stack([n1 * n2, r1 * n2 + n1 * r2, w1 * n2 + n1 * w2, r1 * w2 + w1 * r2, both_right, w1 * w2])


def any_rule_probabilities(scheme: Scheme, probabilities: Floats) -> Floats:
    """For each id: probability that it comes `agree` times or more among all items of the passage."""
    agree = scheme.rule.agree
    counts = np.zeros((agree + 1, IDS))
    counts[0] = 1.0
    for _ in range(scheme.tags):
        for telegram in probabilities:
            following = np.zeros_like(counts)
            for probability, (_, wrong) in zip(telegram, OUTCOMES, strict=False):
                for have in range(agree + 1):
                    following[min(agree, have + wrong)] += counts[have] * probability
            counts = following
    often: Floats = counts[agree]
    return often


@compiled
def settled(
    probabilities: Floats, tags: int, window: int, agree: int, rights: Ints, wrongs: Ints
) -> tuple[float, float, float]:
    """Probabilities that a passage gives the right id, the one wrong id, and no id, window by window.

    `probabilities` (telegrams of a tag, outcomes); `window` in telegrams; the state is what the last window - 1
    telegrams brought, as digits of a number. Both ids often enough in a window: no id, as the decoder has it.
    """
    outcomes = probabilities.shape[1]
    telegrams = tags * probabilities.shape[0]
    window = min(window, telegrams)
    states = outcomes ** (window - 1)
    history = np.zeros(states)
    history[0] = 1.0
    right_id, wrong_id = 0.0, 0.0
    for telegram in range(telegrams):
        row = probabilities[telegram % probabilities.shape[0]]
        following = np.zeros(states)
        for state in range(states):
            if history[state] == 0.0:
                continue
            right, wrong, digits = 0, 0, state
            for _ in range(window - 1):
                right += rights[digits % outcomes]
                wrong += wrongs[digits % outcomes]
                digits //= outcomes
            for outcome in range(outcomes):
                probability = history[state] * row[outcome]
                is_right = right + rights[outcome] >= agree
                is_wrong = wrong + wrongs[outcome] >= agree
                if telegram >= window - 1 and is_right != is_wrong:
                    if is_right:
                        right_id += probability
                    else:
                        wrong_id += probability
                else:
                    following[(state * outcomes + outcome) % states] += probability
        history = following
    left = 0.0
    for probability in history:
        left += probability
    return right_id, wrong_id, left


@compiled
def wrong_id_probability(
    probabilities: Floats, any_rule: Floats, tags: int, window: int, agree: int, rights: Ints, wrongs: Ints
) -> float:
    """Sum over ids of the probability that the passage gives this wrong id; the likeliest must come first.

    `probabilities` (ids, telegrams of a tag, outcomes), `any_rule` (ids) as a bound of each: where the rest cannot
    add more than NEGLIGIBLE it is added as its bound.
    """
    total = 0.0
    for k in range(len(any_rule)):
        if k % RECOUNT == 0:
            rest = 0.0
            for bound in any_rule[k:]:
                rest += bound
            if rest <= NEGLIGIBLE * total:
                return total + rest
        total += settled(probabilities[k], tags, window, agree, rights, wrongs)[1]
    return total


def passage_failure(scheme: Scheme, channel: Channel, tag_id: int, serial: int = 0) -> FailureProbabilities:
    """Failure probabilities of one passage over the tags of a place that all say `tag_id`.

    Raises ValueError for a rule that does not move by one telegram.
    """
    if scheme.rule.step_items != scheme.ids_per_telegram:
        raise ValueError(f"{scheme.name}: the window must move by one telegram")
    probabilities = outcome_probabilities(scheme, channel, tag_id, serial)
    any_rule = any_rule_probabilities(scheme, probabilities)
    window = scheme.rule.window_items // scheme.ids_per_telegram
    votes = np.array(OUTCOMES, dtype=np.int64)[: probabilities.shape[1]]
    rights, wrongs = np.ascontiguousarray(votes[:, 0]), np.ascontiguousarray(votes[:, 1])
    shape = (scheme.tags, window, scheme.rule.agree, rights, wrongs)
    order = np.argsort(-any_rule)[: int(np.count_nonzero(any_rule))]
    likeliest_first = np.ascontiguousarray(probabilities.transpose(2, 0, 1)[order])
    unsafe = wrong_id_probability(likeliest_first, any_rule[order], *shape)
    alone = np.ascontiguousarray(probabilities[:, :, tag_id])
    return FailureProbabilities(unsafe, float(any_rule.sum()), settled(alone, *shape)[2])
