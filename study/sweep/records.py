"""What a day of a sweep is, and what is kept of it: small records, written to disk one a file.

A day is fixed by its specification alone: two days of one specification are the same day, wherever they run.
"""

from __future__ import annotations

from enum import Enum
from hashlib import blake2b
from typing import Any, Final

import msgspec

from study.measures.day_figures import DayFigures

HASH_BYTES: Final = 16


class DayOutcome(Enum):
    """What became of a day."""

    GOOD = "all arrive, nothing broken"
    NOT_ARRIVED = "not every train arrives"
    DEADLOCK = "no train can move any more"
    BROKEN = "a rule is broken"
    CRASHED = "the program crashed"


class DaySpec(msgspec.Struct, frozen=True):
    """All that fixes a day. `scenario`: its name or file; `inputs`: digest of all the tables that it is made of.

    `point`: where in the sweep's grid it is, in words of the file (key path and value), in the order of the file.
    `carrier`: study.run.run.CarrierKind.
    """

    scenario: str
    inputs: str
    point: tuple[tuple[str, Any], ...]
    seed: int
    carrier: str

    @property
    def key(self) -> str:
        """The hash that its file is named after; the carrier is no part of it, since it must change nothing."""
        said = (self.scenario, self.inputs, self.point, self.seed)
        return blake2b(msgspec.json.encode(said), digest_size=HASH_BYTES).hexdigest()


class DayRecord(msgspec.Struct, frozen=True):
    """What is kept of a day. `why` says in a sentence what was not good; `figures` None: it came to no end.

    `digest` and `motion_digest` as in summary.json; `tries`: how often it was begun.
    """

    spec: DaySpec
    index: int
    outcome: DayOutcome
    why: str
    figures: DayFigures | None
    digest: str = ""
    motion_digest: str = ""
    tries: int = 1
