"""Fewer points for the same curve: Douglas and Peucker's rule with the error measured at the same time.

The distance of a left-out sample from the chord is taken along the value axis, so that what is drawn says at every
sampled time the sampled value within the tolerance, whatever the scale of the picture.
Source: D. H. Douglas and T. K. Peucker, Cartographica 10 (1973) 112-122.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def kept_samples(t_s: Floats, values: Floats, tolerances: Floats) -> NDArray[np.int64]:
    """Indices of the samples to keep, the first and the last among them.

    `t_s` (n) does not fall; `values` (n, k) are k curves over it, each with its tolerance (k). Between two samples
    kept, each curve's straight line is within its tolerance of every sample. At one time the line has the value at its
    end.
    """
    count = len(t_s)
    if count <= 2:
        return np.arange(count)
    keep = np.zeros(count, dtype=np.bool_)
    keep[[0, -1]] = True
    scaled = values / tolerances
    ahead = [(0, count - 1)]
    while ahead:
        low, high = ahead.pop()
        if high - low < 2:
            continue
        span_s = t_s[high] - t_s[low]
        inner = slice(low + 1, high)
        # A chord without length in time is a jump: nothing between its ends can be left out unless it is at the end.
        share = np.ones(high - low - 1) if span_s <= 0.0 else (t_s[inner] - t_s[low]) / span_s
        chord = scaled[low] + share[:, None] * (scaled[high] - scaled[low])
        away = np.abs(scaled[inner] - chord).max(axis=1)
        worst = int(away.argmax())
        if away[worst] > 1.0:
            middle = low + 1 + worst
            keep[middle] = True
            ahead += [(low, middle), (middle, high)]
    return np.flatnonzero(keep)


def strands(values: Floats, labels: NDArray[np.int64] | None = None) -> list[slice]:
    """Stretches of samples without a gap: finite, and of one label where labels are given."""
    if not len(values):
        return []
    finite = np.isfinite(values)
    cut = finite[1:] != finite[:-1]
    if labels is not None:
        cut |= labels[1:] != labels[:-1]
    edges = [0, *(np.flatnonzero(cut) + 1).tolist(), len(values)]
    return [slice(a, b) for a, b in pairwise(edges) if finite[a]]
