"""What wheel and rail can pass on (粘着), and what the wheel does beyond it: slip (空転) and slide (滑走).

Model: force beyond the limit does not reach the rail; the excess spins up or slows down what turns,

    d(wheel speed - train speed)/dt = (demand - limit) / rotating mass,

and once the demand falls below the limit the spare adhesion brings the wheel back by the same law. Slide
protection bounds the depth by a share of the train's speed. The tachometer counts the first axle, so its distance
is wrong by the integral of the difference. The last axle finds rail that those before it have cleaned: it slides later
and rolls again sooner, which is what slide protections compare.
"""

from __future__ import annotations

from typing import Final

from vehicle.compiled import compiled
from vehicle.mass import GRAVITY_MPS2
from vehicle.records import TrainRow

DRY: Final = 1.0  # adhesion factor of a dry rail
ROTATING_SHARE_MIN: Final = 0.03  # assumed, where the train file gives no rotating mass
CLEANED_RAIL: Final = (
    1.15  # assumed: adhesion under the last axle, over that which the train as a whole finds
)
SLIP_FLOOR_MPS: Final = 1.0  # assumed: slip protection acts on a difference even at the start


@compiled
def adhesion_coefficient(train: TrainRow, adhesion_factor: float, speed_mps: float) -> float:
    """Adhesion coefficient (粘着係数) at a speed: dry / (1 + factor v), times the weather's factor."""
    return adhesion_factor * train.adhesion_dry / (1.0 + train.adhesion_speed_factor_s_per_m * speed_mps)


@compiled
def grip_mps2(train: TrainRow, adhesion_factor: float, speed_mps: float) -> float:
    """What all axles together can brake with at a speed, m/s^2; what turns has to be braked too."""
    coefficient = adhesion_coefficient(train, adhesion_factor, speed_mps)
    return GRAVITY_MPS2 * coefficient / (1.0 + train.rotating_mass_factor)


@compiled
def axle_excess_n(
    pull_n: float, pull_limit_n: float, brake_n: float, brake_limit_n: float, speed_mps: float
) -> float:
    """What the rail refuses of the forces of one axle, N: positive traction, negative brake; 0 within the limits.

    Forces and limits are those of a train whose axles were all like this one. A wheel at rest cannot slide.
    """
    excess_n = max(pull_n - pull_limit_n, 0.0) - max(brake_n - brake_limit_n, 0.0)
    return 0.0 if speed_mps <= 0.0 and excess_n < 0.0 else excess_n


@compiled
def next_slip_mps(
    slip_mps: float, excess_n: float, spare_n: float, rotating_mass_kg: float, dt_s: float
) -> float:
    """Wheel speed less train speed one step on, m/s; positive slip, negative slide.

    `excess_n` is the demand the rail refused (positive traction, negative brake), 0 within the limit; then
    `spare_n` >= 0 brings the wheel back to zero difference, never past it.
    """
    if excess_n != 0.0:
        return slip_mps + excess_n / rotating_mass_kg * dt_s
    recovery = spare_n / rotating_mass_kg * dt_s
    if slip_mps > 0.0:
        return max(0.0, slip_mps - recovery)
    return min(0.0, slip_mps + recovery)


@compiled
def bounded_slip_mps(train: TrainRow, slip_mps: float, speed_mps: float) -> float:
    """`slip_mps` within what protection allows at `speed_mps`; the wheel never turns backwards."""
    share = min(1.0, train.wheel_slide_share_max)
    return min(max(slip_mps, -share * speed_mps), share * speed_mps + SLIP_FLOOR_MPS)


@compiled
def rotating_mass_kg(train: TrainRow, mass_kg: float) -> float:
    """Mass equivalent of what turns, kg."""
    return mass_kg * max(train.rotating_mass_factor, ROTATING_SHARE_MIN)
