"""Faults of a train's doors, brakes (車両状態・ブレーキ状態, Sugiyama et al. 2017, 4.1.3 (2)) and motors.

The unit sees them by its inputs. A brake loses at most the force beyond the share that supervision relies on
(`[driving] service_guaranteed_share`, `emergency_guaranteed_share`): a weaker brake than guaranteed is outside the
design, because no supervision could stop that train in time. Doors are otherwise not modelled: they count as closed
when a train starts.
"""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import Field

from network.files.quantities import Motors as MotorCount
from network.files.quantities import Share
from simulation.faults.fault import SwitchedFault, UnitFault


class DoorsFault(SwitchedFault, UnitFault[bool]):
    """Whether the doors show that they are closed and locked."""

    changes = "doors"
    in_order = True


class Doors(DoorsFault):
    """The doors show that they are not closed and locked."""

    kind = "doors"


@dataclass(frozen=True, slots=True)
class BrakeState:
    """Whether the pressure is as commanded, and the share that is left of the force beyond the guaranteed one."""

    good: bool = True
    reserve: float = 1.0


class BrakeFault(UnitFault[BrakeState]):
    """What is wrong with a train's brakes."""

    changes = "brake"
    in_order = BrakeState()


class Brake(BrakeFault):
    """The brake has too little pressure: the unit sees that, and force may be missing."""

    kind = "brake"
    reserve: Share = Field(
        default=0.0,
        description="remaining share of the force beyond the guaranteed one; 1: only the reading is wrong",
    )

    def applied_to(self, brake: BrakeState) -> BrakeState:
        return BrakeState(good=False, reserve=brake.reserve * self.reserve)


class MotorsFault(UnitFault[int]):
    """How many motors of a train are cut out (主電動機開放)."""

    changes = "motors"
    in_order = 0


class Motors(MotorsFault):
    """Motors are cut out. The unit sees it; the train stays at a stop if the others cannot take it to the next one.

    Without any motor a train on its way rolls.
    """

    kind = "motors"
    cut_out: MotorCount = Field(description="number of motors cut out, at most all of the train")

    def applied_to(self, cut_out: int) -> int:
        return cut_out + self.cut_out
