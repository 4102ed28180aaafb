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

Said = tuple[tuple[str, Any], ...]  # key path, as TOML writes it, and value


class DayOutcome(Enum):
    """What became of a day."""

    GOOD = "all arrive, nothing broken"
    NOT_ARRIVED = "not every train arrives"
    DEADLOCK = "no train can move any more"
    BROKEN = "a rule is broken"
    CRASHED = "the program crashed"


class DaySpec(msgspec.Struct, frozen=True):
    """All that fixes a day. `scenario`: name or file of the one that is varied.

    `inputs`: digest of all the tables that the day is made of, drawn values and seed apart.
    `point`: what a point of the grid says over the scenario, `drawn`: what was drawn for this day, over both.
    `carrier`: study.runner.run.CarrierKind.
    """

    scenario: str
    inputs: str
    point: Said
    seed: int
    carrier: str
    drawn: Said = ()

    @property
    def key(self) -> str:
        """The hash that its file is named after; the carrier is no part of it, since it must change nothing.

        Where files lie is no part of it either: what they say is in `inputs`.
        """
        said = (self.inputs, self.drawn, self.seed)
        return blake2b(msgspec.json.encode(said), digest_size=HASH_BYTES).hexdigest()


class DayRecord(msgspec.Struct, frozen=True):
    """What is kept of a day. `why` says in a sentence what was not good; `figures` None: it came to no end.

    `digest` and `motion_digest` as in summary.json; `again`: the digest of the same day run again on SUMO, empty
    where it was not. `tries`: how often it was begun; `code`: digest of the code that ran it.
    """

    spec: DaySpec
    index: int
    outcome: DayOutcome
    why: str
    figures: DayFigures | None
    digest: str = ""
    motion_digest: str = ""
    tries: int = 1
    again: str = ""
    code: str = ""

    @property
    def differs(self) -> bool:
        """Whether SUMO carried the day otherwise than what carried it first."""
        return bool(self.again) and self.again != self.digest
