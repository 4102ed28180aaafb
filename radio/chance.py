"""Every random draw of the project: a generator per named source, so that adding one source disturbs no
other.
"""

from __future__ import annotations

from hashlib import blake2b

import msgspec
import numpy as np


def generator(seed: int, *names: str) -> np.random.Generator:
    """The generator of the source `names` under `seed`: PCG64 seeded by blake2b of both, the same on any
    machine.
    """
    digest = blake2b(msgspec.msgpack.encode((str(seed), *names)), digest_size=16).digest()
    return np.random.Generator(np.random.PCG64(int.from_bytes(digest, "little")))
