"""What holds a train back (列車抵抗): running, starting, gradient and curve resistance. SI in and out.

Running resistance (走行抵抗), Oda's equation 3 after the Japanese standard, V in km/h and weights in kN:

    R = (1.650 + 0.025 V) M_motored + (0.780 + 0.003 V) M_trailer + 9.810 (0.028 + 0.008 (n - 1)) V^2   [N]

The coefficients stand in TRAIN, so a formula in kg per ton (which is N per kN) fits as well.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled
from vehicle.mass import GRAVITY_MPS2
from vehicle.records import TrainRow

KMH_PER_MPS: Final = 3.6
STARTING_BAND_KMH: Final = 3.0


@compiled
def running_resistance_n(train: TrainRow, mass_kg: float, speed_mps: float) -> float:
    """Running resistance (走行抵抗) on straight level track, N, equation 3 with the train's coefficients."""
    weight_kn = mass_kg * GRAVITY_MPS2 * 1e-3
    speed_kmh = speed_mps * KMH_PER_MPS
    motored = (
        train.resistance.motored_constant_n_per_kn + train.resistance.motored_linear_n_per_kn_kmh * speed_kmh
    )
    trailer = (
        train.resistance.trailer_constant_n_per_kn + train.resistance.trailer_linear_n_per_kn_kmh * speed_kmh
    )
    share = train.motored_mass_share
    mechanical_n = weight_kn * (share * motored + (1.0 - share) * trailer)
    return mechanical_n + train.resistance.air_n_per_kmh2 * speed_kmh * speed_kmh


@compiled
def resistance_n(train: TrainRow, mass_kg: float, speed_mps: float) -> float:
    """Running resistance with the starting resistance (出発抵抗) below 3 km/h, N.

    Usual Japanese practice: a straight line from the starting value (about 30 N per tonne on roller bearings)
    at rest to the running resistance at 3 km/h. A starting value of 0 in the train file switches it off.
    """
    band_mps = STARTING_BAND_KMH / KMH_PER_MPS
    start_n = train.resistance.starting_n_per_kn * mass_kg * GRAVITY_MPS2 * 1e-3
    if start_n <= 0.0 or speed_mps >= band_mps:
        return running_resistance_n(train, mass_kg, speed_mps)
    return start_n + (running_resistance_n(train, mass_kg, band_mps) - start_n) * speed_mps / band_mps


@compiled
def gradient_force_n(mass_kg: float, gradient_permille: float) -> float:
    """Gradient resistance (勾配抵抗), N, positive uphill; the gradient is the mean over the train."""
    return mass_kg * GRAVITY_MPS2 * gradient_permille * 1e-3


@compiled
def curve_resistance_n(train: TrainRow, mass_kg: float, curvature_per_m: float) -> float:
    """Curve resistance (曲線抵抗), N: coefficient/R permille of the weight, mean over the train.

    600/R is usual for 1067 mm gauge in Japan, 800/R where a source says so; either sign of curvature resists.
    """
    return mass_kg * GRAVITY_MPS2 * 1e-3 * train.resistance.curve_coefficient_m * abs(curvature_per_m)


def climb_m(
    train: TrainRow, elevation_m: NDArray[np.float64], turn_rad: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Elevation (m) on a path's grid with the climb that its curves are worth to this train.

    Curve resistance (曲線抵抗) is coefficient / radius in permille of the weight, as a gradient is: over a way it adds
    up to the coefficient times the angle that the track turns by (`turn_rad`, integral of |curvature|).
    """
    climbs: NDArray[np.float64] = elevation_m + 1e-3 * train.resistance.curve_coefficient_m * turn_rad
    return climbs
