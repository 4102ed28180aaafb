"""A digest of how the trains moved, and of nothing else: where each stood how fast at every whole second.

It is made of stock id, step, position and speed alone, rounded to 0.1 mm, stock by stock: how rows are laid out, in
which order slots stand and how far the kernel ran ahead do not count, nor does any word of the journal. Two versions
of the program that only arrange things otherwise give the same digest.
"""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import blake2b
from typing import Final

import numpy as np
from numpy.typing import NDArray

ROUNDED_TO_M: Final = 1e-4


def motion_digest(trace: NDArray[np.void], stock_ids: Sequence[str], every_steps: int) -> str:
    """Digest (32 hex digits) of the moving samples of `trace` (rows of TRACE) at multiples of `every_steps`."""
    digest = blake2b(digest_size=16)
    kept = trace[(trace["step"] % every_steps == 0) & (trace["speed_mps"] > 0.0)]
    for slot, stock_id in sorted(enumerate(stock_ids), key=lambda pair: pair[1]):
        mine = kept[kept["slot"] == slot]
        mine = mine[np.argsort(mine["step"], kind="stable")]
        digest.update(stock_id.encode() + b"\0" + len(mine).to_bytes(8, "little"))
        digest.update(mine["step"].astype("<i8").tobytes())
        for name in ("position_m", "speed_mps"):
            digest.update(np.rint(mine[name] / ROUNDED_TO_M).astype("<i8").tobytes())
    return digest.hexdigest()
