"""What a force costs by metre, per equivalent mass, in the form that the optimum works with.

    traction p:        slope p + curve max(p - bend, 0)^2
    electric brake d:  -(gain d - curve max(d - bend, 0)^2) times the share that counts
    and idle, whatever the force, where motors stay magnetised.

Constant efficiencies are slope = 1 / eta, gain = eta_r and nothing else. With a map of losses (`vehicle.losses`) n
motors cost n no-load losses as soon as they pull, so small forces are better given in turns: at the efficient point
p* = bend, and not at all. The straight line from 0 to p* is what that comes to; from there on it is the loss
itself. The same line holds for any number of motors in service out of n, each at its own efficient point, so it is
also below what cutting motors out can reach. A run that holds a force below p* costs more: `proof` counts that.
"""

from __future__ import annotations

import math
from typing import Final

from vehicle.compiled import compiled
from vehicle.losses import flux_share, no_load_w
from vehicle.mass import equivalent_mass_kg
from vehicle.records import TrainRow

SLOWEST_MPS: Final = 0.05  # by metre, what a second costs has no end towards a stand


@compiled
def cost_terms(
    train: TrainRow, load_share: float, speed_mps: float
) -> tuple[float, float, float, float, float]:
    """Slope, gain, bend (m/s^2), curve (s^2/m) and idle (m/s^2) at a speed; see above."""
    if train.losses_given <= 0.0:
        return 1.0 / train.efficiency_traction, train.efficiency_regeneration, 0.0, 0.0, 0.0
    inertia = equivalent_mass_kg(train, load_share)
    v = max(speed_mps, SLOWEST_MPS)
    full_n = train.loss_force_n * flux_share(train, v)
    by_force = train.loss_gear_share + train.loss_inverter_w / (full_n * v)
    curve = train.loss_copper_w * inertia / (full_n * full_n * v * train.motors)
    none = train.motors * no_load_w(train, v) / (v * inertia)
    if train.motors_cut_out <= 0.0 and train.magnetised_coasting > 0.0:
        return 1.0 + by_force, 1.0 - by_force, 0.0, curve, none
    if curve <= 0.0:  # no copper: the no-load loss is spread over any force
        return 1.0 + by_force, 1.0 - by_force, 0.0, 0.0, 0.0
    more = 2.0 * math.sqrt(none * curve)
    return 1.0 + by_force + more, max(1.0 - by_force - more, 0.0), math.sqrt(none / curve), curve, 0.0
