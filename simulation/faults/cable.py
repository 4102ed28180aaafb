"""Faults of the cable along the line, over which a central interlocking reaches signals and points (通信ケーブル断).

With a central interlocking (`[operation] interlocking = "central"`) no train beyond the cut, seen from the centre, is
granted a route, and no points there are thrown or proven; a train runs on to the end of what it holds and has proven. A
cut of the whole cable (`*`) stands for a centre that cannot be reached at all, or a system that stops the whole line
for one cut, as on the Koumi line on 16 October 2024. With interlocking on board trains need nothing from the cable, and
cutting it has no effect.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from pydantic import Field

from network.files.quantities import Share
from network.model import Line
from simulation.faults.fault import Fault, Names

WHOLE: Final = "*"
BETWEEN: Final = " - "


def stretches_of(line: Line) -> tuple[str, ...]:
    """What of a line's cable may be cut: between two neighbouring stations, as `A - B` with the kilometrage."""
    ids = [station.id for station in sorted(line.stations.values(), key=lambda station: station.position_m)]
    return tuple(f"{low}{BETWEEN}{high}" for low, high in pairwise(ids))


@dataclass(frozen=True, slots=True)
class CableCut:
    """Where the cable is cut: a stretch of it, and how far along that; or all of it (`*`)."""

    stretch: str
    along_share: float


class CableFault(Fault[tuple[CableCut, ...]]):
    """Where the line's cable is cut; all cuts in force are one quantity, since it is one cable."""

    aims_at = "stretch of the cable"
    changes = "cable"
    in_order = ()
    target: str

    @classmethod
    def targets(cls, names: Names) -> tuple[str, ...]:
        return WHOLE, *names.cable

    @property
    def place(self) -> tuple[str, str]:
        return self.changes, WHOLE


class CutCable(CableFault):
    """The cable along the line is cut, between two neighbouring stations (`A - B`) or for all of the line (`*`)."""

    kind = "cable_cut"
    along_share: Share = Field(
        default=0.5,
        description="place of the cut, as a share of the way from the first station to the second",
    )

    def applied_to(self, cuts: tuple[CableCut, ...]) -> tuple[CableCut, ...]:
        return (*cuts, CableCut(self.target, self.along_share))
