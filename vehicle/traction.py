"""Notch to tractive force (力行): constant force, constant power, then falling with its square. SI units."""

from __future__ import annotations

from vehicle.compiled import compiled
from vehicle.mass import mass_kg
from vehicle.records import TrainRow


@compiled
def curve_force_n(train: TrainRow, speed_mps: float) -> float:
    """Force of the measured curve (引張力曲線), N, straight between its points, level beyond the last."""
    last = int(train.traction_curve_points) - 1
    place = speed_mps / train.traction_curve_step_mps
    index = int(place)
    if index >= last:
        return train.traction_curve_n[last]
    below = train.traction_curve_n[index]
    return below + (train.traction_curve_n[index + 1] - below) * (place - index)


@compiled
def full_force_n(train: TrainRow, load_share: float, speed_mps: float) -> float:
    """Force at the wheel rim at full notch, N, steady state.

    With load compensation (応荷重) the force limit keeps the force per mass of the empty train; power stays.
    """
    if train.traction_curve_points > 0.0:
        return curve_force_n(train, speed_mps)
    force = train.traction_force_max_n
    if train.traction_load_compensated > 0.0:
        force *= mass_kg(train, load_share) / train.mass_empty_kg
    power = train.traction_power_max_w
    if force * speed_mps > power:
        force = power / speed_mps
    weak = train.traction_weak_field_speed_mps
    if weak > 0.0 and speed_mps > weak:
        force = min(force, power * weak / (speed_mps * speed_mps))
    return force


@compiled
def notch_share(train: TrainRow, notch: float, speed_mps: float) -> float:
    """Share of the full force a power notch asks for; 0 in coasting, braking and above the notch's cap.

    A fraction of a notch counts as the notch below: the weaker one is the safe one.
    """
    index = int(min(notch + 1e-9, train.power_notches))
    if index <= 0:
        return 0.0
    cap = train.traction_speed_cap_mps[index]
    if cap > 0.0 and speed_mps > cap:
        return 0.0
    return train.traction_notch_share[index]


@compiled
def motored_grip_n(train: TrainRow, weight_n: float, adhesion: float) -> float:
    """What the rail passes on to the driven axles of a train of `weight_n`, N."""
    return weight_n * adhesion * train.motored_axle_mass_share


@compiled
def traction_target_n(train: TrainRow, load_share: float, notch: float, speed_mps: float) -> float:
    """Force that a notch settles at, N, before dead time, lag, jerk limit and adhesion."""
    share = notch_share(train, notch, speed_mps)
    return share * full_force_n(train, load_share, speed_mps) if share > 0.0 else 0.0
