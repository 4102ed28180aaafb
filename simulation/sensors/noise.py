"""Noise that is counted, not drawn in turn: a function of source and step alone, so that no stretch changes it.

The generator is splitmix64 (Steele, Lea, Flood, OOPSLA 2014) with its counter set to the step.
"""

from __future__ import annotations

import math
from hashlib import blake2b
from typing import Final

import numpy as np

from vehicle.compiled import compiled

GAMMA: Final = np.uint64(0x9E3779B97F4A7C15)
MIX_A: Final = np.uint64(0xBF58476D1CE4E5B9)
MIX_B: Final = np.uint64(0x94D049BB133111EB)
LOW: Final = np.uint64(0xFFFFFFFF)
HALF: Final = np.uint64(32)
DRAWS: Final = 2  # counters that one step uses
TO_UNIT: Final = 2.0**-53


def source_of(seed: int, *names: str) -> int:
    """Number of a source of noise, from the run's seed and names such as sensor and stock."""
    text = "/".join((str(seed), *names)).encode()
    return int.from_bytes(blake2b(text, digest_size=8).digest(), "little", signed=True)


@compiled
def plus(a: np.uint64, b: np.uint64) -> np.uint64:
    """a + b modulo 2^64, in halves: nothing overflows, of which interpreted code would warn."""
    low = (a & LOW) + (b & LOW)
    high = (a >> HALF) + (b >> HALF) + (low >> HALF)
    return ((high & LOW) << HALF) | (low & LOW)


@compiled
def times(a: np.uint64, b: np.uint64) -> np.uint64:
    """a * b modulo 2^64, likewise."""
    low = (a & LOW) * (b & LOW)
    across = (((a >> HALF) * (b & LOW)) & LOW) + (((a & LOW) * (b >> HALF)) & LOW)
    return plus(low, (across & LOW) << HALF)


@compiled
def bits_of(number: int) -> np.uint64:
    """The 64 bits of an integer in two's complement."""
    return (np.uint64((number >> 32) & 0xFFFFFFFF) << HALF) | np.uint64(number & 0xFFFFFFFF)


@compiled
def uniform(source: int, counter: int) -> float:
    """A number in [0, 1) of a source."""
    z = plus(bits_of(source), times(bits_of(counter), GAMMA))
    z = times(z ^ (z >> np.uint64(30)), MIX_A)
    z = times(z ^ (z >> np.uint64(27)), MIX_B)
    z ^= z >> np.uint64(31)
    return float(np.float64(z >> np.uint64(11)) * TO_UNIT)


@compiled
def normal(source: int, step: int) -> float:
    """A number of the standard normal distribution for one step of a source (Box and Muller)."""
    radius = math.sqrt(-2.0 * math.log(1.0 - uniform(source, DRAWS * step)))
    return radius * math.cos(2.0 * math.pi * uniform(source, DRAWS * step + 1))
