"""What a tag (地上子) says and when the train believes it: the telegram, its two data items, the vote.

Invariant: no id is believed unless `agree` data items of one window carry it, each with its check string and its
CRC right, and no other id reaches as many in that window.

Sugiyama, Fukuda and Kitano, section 6.1.3 and figure 6: a telegram has 128 data bits, of which 64 are the
user's; these hold the same id twice, each with a CRC-8, and a string of check bits that betrays a telegram read
some bits early or late (ビットずれ). An id with its CRC is one *data item* (データ), judged by itself; of a
passage the first eight items are taken, three or more equal pass, otherwise the window moves by one telegram.

The bit positions of figure 6 are not in the text. Assumed, most significant bit first:

    32 bits not the user's | check 8 | id 16 | CRC 8 | check 8 | id 16 | CRC 8 | 32 bits not the user's

CRC: polynomial x^8 + x^5 + x^2 + x + 1. No CRC-8 does better than Hamming distance 4 over 24 bits, and of those
that reach it this one (with its mirror image) leaves the fewest words of weight four, 29. A constant is added to
the remainder, because a plain CRC is blind to shifts: moved by a bit, many of its words are again words.
Check strings: one for each item, each the other's complement, so that a shifted telegram cannot bring the same
wrong id twice through an early reading. Moved by 1 to 4 bits a string differs from itself in three places,
moved by 5 to 7 in one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled

TELEGRAM_BITS: Final = 128
WORD_BITS: Final = 32  # a telegram is four words; words 1 and 2 are the user's, one data item each
WORD_MASK: Final = 0xFFFF_FFFF
ID_BITS: Final = 16
CRC_POLYNOMIAL: Final = 0x27
CRC_OFFSET: Final = 0x17  # assumed; with it no id survives a shift of 1 to 3 bits even without check strings
CHECK_STRINGS: Final = (0b1100_0010, 0b0011_1101)
REFUSED: Final = -1


@dataclass(frozen=True, slots=True)
class IdAgreement:
    """When a passage gives an id: `agree` equal items among `window_items`, else `step_items` further on."""

    window_items: int = 8
    agree: int = 3
    step_items: int = 2


@dataclass(frozen=True, slots=True)
class Judgement:
    """The id of a passage, None if no window passed, and how many items had been read when it was settled."""

    tag_id: int | None
    items_read: int


PAPER_RULE: Final = IdAgreement()


@compiled
def crc8(tag_id: int) -> int:
    """CRC-8 of a 16-bit id, constant included."""
    remainder = tag_id << 8
    for bit in range(23, 7, -1):
        if remainder >> bit & 1:
            remainder ^= (CRC_POLYNOMIAL | 0x100) << (bit - 8)
    return remainder ^ CRC_OFFSET


@compiled
def item_word(tag_id: int, check: int) -> int:
    """The 32 bits of one data item: check string, id, CRC-8."""
    return check << 24 | tag_id << 8 | crc8(tag_id)


@compiled
def item_id(word: int, check: int) -> int:
    """The id of 32 received bits, REFUSED unless the check string and the CRC are right."""
    tag_id = word >> 8 & 0xFFFF
    if word >> 24 != check or crc8(tag_id) != word & 0xFF:
        return REFUSED
    return tag_id


@compiled
def window_id(items: NDArray[np.int64], first: int, last: int, agree: int) -> int:
    """The one id that `agree` or more of items[first:last] carry; REFUSED if none does, or more than one."""
    found = REFUSED
    for i in range(first, last):
        if items[i] == REFUSED or items[i] == found:
            continue
        votes = 0
        for j in range(first, last):
            if items[j] == items[i]:
                votes += 1
        if votes >= agree:
            if found != REFUSED:
                return REFUSED
            found = items[i]
    return found


@compiled
def judged_windows(
    items: NDArray[np.int64], window_items: int, agree: int, step_items: int
) -> tuple[int, int]:
    """Id (or REFUSED) and the number of items read, by the first window that passes.

    A passage of fewer items than a window is one window; otherwise no window is cut short.
    """
    window = min(window_items, len(items))
    last = window
    while last <= len(items):
        tag_id = window_id(items, last - window, last, agree)
        if tag_id != REFUSED:
            return tag_id, last
        last += step_items
    return REFUSED, len(items)


def encode(tag_id: int, serial: int = 0) -> int:
    """The 128 bits of a telegram; `serial` is what stands in the 64 bits that are not the user's.

    Raises ValueError unless the id has at most 16 and the serial at most 64 bits.
    """
    if not (0 <= tag_id < 1 << ID_BITS and 0 <= serial < 1 << 2 * WORD_BITS):
        raise ValueError(f"tag id {tag_id} or serial {serial} does not fit into 16 and 64 bits")
    telegram = serial >> WORD_BITS
    for check in CHECK_STRINGS:
        telegram = telegram << WORD_BITS | item_word(tag_id, check)
    return telegram << WORD_BITS | serial & WORD_MASK


def decode(telegram: int) -> tuple[int | None, int | None]:
    """The two data items of 128 received bits, in order of reading; None for a refused one."""
    if not 0 <= telegram < 1 << TELEGRAM_BITS:
        raise ValueError(f"telegram {telegram:#x} does not fit into {TELEGRAM_BITS} bits")
    words = (telegram >> 2 * WORD_BITS & WORD_MASK, telegram >> WORD_BITS & WORD_MASK)
    first, second = (item_id(word, check) for word, check in zip(words, CHECK_STRINGS, strict=True))
    return (None if first == REFUSED else first), (None if second == REFUSED else second)


def judge(items: Sequence[int | None], rule: IdAgreement = PAPER_RULE) -> Judgement:
    """Judge the data items of one passage in order of reading, refused ones (None) in their places."""
    numbers = np.array([REFUSED if item is None else item for item in items], dtype=np.int64)
    tag_id, items_read = judged_windows(numbers, rule.window_items, rule.agree, rule.step_items)
    return Judgement(None if tag_id == REFUSED else int(tag_id), int(items_read))
