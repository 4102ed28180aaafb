"""Faults of what drives on the road over a level crossing (踏切).

They are seen where the road is carried: by SUMO. A run on plain track has no road, and none of this happens in it.
"""

from __future__ import annotations

from simulation.faults.fault import Fault, SwitchedFault


class CrossingRoadFault(SwitchedFault, Fault[bool]):
    """Whether a vehicle has stalled on a crossing; `target` is the crossing."""

    aims_at = "level crossing"
    changes = "stalled vehicle"
    in_order = False
    target: str


class StalledVehicle(CrossingRoadFault):
    """A road vehicle stands on the track, one that is on the crossing then or another; in the end it drives on."""

    kind = "stalled_vehicle"
