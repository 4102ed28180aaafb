"""How SUMO is run: the one place of its options and of the vehicle type that trains have.

SUMO carries trains and judges collisions, nothing else: no lane changes, no car following, no right of way,
no teleports, no chance. Road vehicles, if any, follow each other and their signals. What it was seen to do (1.28):

- A standing train reverses in place in the step after its route continues on the bidi edge. The route must
  run back over every edge under the train, else it stays; the new front stands 1 mm ahead of the former rear.
  A train whose rear is still outside the net has nowhere to put its front and leaves.
- A train is removed when its front reaches the end of the last edge of its route.
- Collisions (`libsumo.simulation.getCollisions`) are reported in every step while they last: type `collision`
  from behind, `frontal` between bidi edges.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    import libsumo

STEP_S: Final = 0.1
SEED: Final = 1
RAIL_TYPE: Final = "DEFAULT_RAILTYPE"
SPEED_MODE: Final = 0  # setSpeedMode: the speed set is the speed run
LANE_CHANGE_MODE: Final = 0
# Far above any train, so that SUMO neither limits a speed change nor reports it.
TYPE_ACCELERATION_MPS2: Final = 100.0
TYPE_SPEED_MPS: Final = 200.0


def clock_ahead_s(begin_s: float) -> float:
    """What SUMO's clock is ahead of a run that begins then: it knows no time before midnight."""
    return max(-begin_s, 0.0)


def sumo_command(net: Path, step_s: float = STEP_S, routes: Path | None = None) -> tuple[str, ...]:
    """The command for `libsumo.start`: exact motion, own authority, collisions only reported.

    Warnings are off: those of interest are collisions, which come from `getCollisions`, and stdout and stderr
    stay the caller's. Errors still raise. `routes`: a file of road vehicles.
    """
    options = {
        "net-file": str(net),
        "step-length": f"{step_s:g}",
        # Ballistic: the position is the trapezoid of the speeds set, to 1e-13 m.
        "step-method.ballistic": "true",
        "insertion-checks": "none",
        "time-to-teleport": "-1",
        "collision.action": "warn",
        "collision.check-junctions": "true",
        "default.speeddev": "0",
        "seed": str(SEED),
        "no-step-log": "true",
        "no-warnings": "true",
        "duration-log.disable": "true",
        "xml-validation": "never",
        "xml-validation.net": "never",
    }
    if routes is not None:
        options |= {"route-files": str(routes), "xml-validation.routes": "never"}
    return ("sumo", *(part for name, value in options.items() for part in (f"--{name}", value)))


def add_train_type(
    type_id: str, length_m: float, vehicletype: type[libsumo.vehicletype] | None = None
) -> None:
    """Make the vehicle type of trains of `length_m` in a simulation; default: the one running in this process.

    Each vehicle needs SPEED_MODE and LANE_CHANGE_MODE besides.
    """
    if vehicletype is None:
        import libsumo as running

        vehicletype = running.vehicletype
    vehicletype.copy(RAIL_TYPE, type_id)
    vehicletype.setLength(type_id, length_m)
    vehicletype.setMinGap(type_id, 0.0)
    vehicletype.setTau(type_id, STEP_S)
    vehicletype.setAccel(type_id, TYPE_ACCELERATION_MPS2)
    vehicletype.setDecel(type_id, TYPE_ACCELERATION_MPS2)
    vehicletype.setEmergencyDecel(type_id, TYPE_ACCELERATION_MPS2)
    vehicletype.setApparentDecel(type_id, TYPE_ACCELERATION_MPS2)
    vehicletype.setMaxSpeed(type_id, TYPE_SPEED_MPS)
    vehicletype.setSpeedFactor(type_id, 1.0)
    vehicletype.setSpeedDeviation(type_id, 0.0)
    vehicletype.setImperfection(type_id, 0.0)
