"""Faults of the cable along the line, over which a central interlocking reaches signals and points (通信ケーブル断).

With a central interlocking (`[operation] interlocking = "central"`) nobody beyond a cut, seen from the centre, is
granted anything, and no points there are thrown or proven; a train goes on to the end of what it holds and has proven.
A cut of the whole cable (`*`) is that of a centre which can't be reached at all, or of a system that stops a whole line
for one cut, as on the Koumi line on 16 October 2024. With interlocking on board the cable carries nothing that trains
need, and its cut changes nothing.
"""

from __future__ import annotations

from pydantic import Field

from network.files.quantities import Share
from simulation.faults.fault import Fault, Names, World
from simulation.world.cable import WHOLE, CableCut


class CableFault(Fault[tuple[CableCut, ...]]):
    """Where the line's cable is cut; all cuts in force are one quantity, since it is one cable."""

    aims_at = "stretch of the cable"
    changes = "cable"
    target: str

    @classmethod
    def targets(cls, names: Names) -> tuple[str, ...]:
        return WHOLE, *names.cable

    @property
    def place(self) -> tuple[str, str]:
        return self.changes, WHOLE

    def base(self, _world: World) -> tuple[CableCut, ...]:
        return ()

    def put(self, world: World, cuts: tuple[CableCut, ...]) -> None:
        world.wayside.cable.cut(cuts)


class CutCable(CableFault):
    """The cable along the line is cut, between two neighbouring stations (`A - B`) or for all of the line (`*`)."""

    kind = "cable_cut"
    along_share: Share = Field(default=0.5, description="how far along from the first station to the second")

    def over(self, cuts: tuple[CableCut, ...]) -> tuple[CableCut, ...]:
        return (*cuts, CableCut(self.target, self.along_share))
