"""The day's traction worked out once more from where the trains were and how fast, with any running resistance.

Nothing of `vehicle.dynamics` is used: between two samples of the trace the work at the rim is the change of kinetic and
potential energy and what running and curve resistance took; where it is positive the motors did it. What they lose is
the train file's efficiency, or its map of losses where it has one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from network.model import Direction, Line
from network.path import path_of
from network.profile import profile_of
from simulation.result import RunResult, TraceSpan
from study.record.spans import rows_by_span
from vehicle.train_file import TrainType
from vehicle.wire import wire_power_w

Floats: TypeAlias = NDArray[np.float64]
Resistance: TypeAlias = Callable[[TrainType, float, Floats], Floats]  # (train, mass in kg, speed in m/s) -> N

STANDARD_GRAVITY_MPS2: Final = 9.80665
KMH_PER_MPS: Final = 3.6
LEAST_RUN_M: Final = 0.01  # between two samples: work over less of a way tells no force


def jr_resistance_n(kind: TrainType, mass_kg: float, speed_mps: Floats) -> Floats:
    """Running resistance of an electric multiple unit, N, by the formula published for JR.

    1.32 + 0.0164 V + (0.028 + 0.0078 n) V^2 / W, in kgf per tonne: V km/h, n cars, W t.
    """
    mass_t, speed_kmh = mass_kg / 1000.0, speed_mps * KMH_PER_MPS
    cars = float(kind.row[0]["cars"])
    kgf = (1.32 + 0.0164 * speed_kmh) * mass_t + (0.028 + 0.0078 * cars) * speed_kmh**2
    return np.asarray(kgf * STANDARD_GRAVITY_MPS2, dtype=np.float64)


def own_resistance_n(kind: TrainType, mass_kg: float, speed_mps: Floats) -> Floats:
    """Running resistance by the coefficients of the train file (Oda, equation 3), N, written once more."""
    row, speed_kmh = kind.row[0], speed_mps * KMH_PER_MPS
    weight_kn, share = mass_kg * 9.81e-3, float(row["motored_mass_share"])
    per_kn = sum(
        part
        * (
            float(row["resistance"][f"{cars}_constant_n_per_kn"])
            + float(row["resistance"][f"{cars}_linear_n_per_kn_kmh"]) * speed_kmh
        )
        for cars, part in (("motored", share), ("trailer", 1.0 - share))
    )
    return np.asarray(per_kn * weight_kn + float(row["resistance"]["air_n_per_kmh2"]) * speed_kmh**2)


def mass_kg(kind: TrainType, load_share: float) -> float:
    """Mass of a train with its load, kg."""
    return float(kind.row[0]["mass_empty_kg"]) + load_share * float(kind.row[0]["mass_load_full_kg"])


def traction_j(
    result: RunResult, line: Line, trains: Mapping[str, TrainType], resistance: Resistance
) -> float:
    """Traction energy of all trains of a run at the wire or battery, J, on the speeds that they ran."""
    return sum(
        _traction_of_span_j(line, span, rows, trains[result.stock_ids[span.slot]], resistance)
        for span, rows in rows_by_span(result)
        if rows.size > 1
    )


def _traction_of_span_j(
    line: Line, span: TraceSpan, rows: NDArray[np.void], kind: TrainType, resistance: Resistance
) -> float:
    row, mass = kind.row[0], mass_kg(kind, span.load_share)
    profile = profile_of(line, path_of(line, span.piece_ids, Direction(span.direction)))
    length_m, weight_n = float(row["length_m"]), mass * STANDARD_GRAVITY_MPS2
    position_m, speed_mps = rows["position_m"], rows["speed_mps"]
    run_m = np.diff(position_m)
    kinetic_j = 0.5 * mass * (1.0 + float(row["rotating_mass_factor"])) * np.diff(speed_mps**2)
    climb_m = np.diff(_mean_under(profile["elevation_m"], position_m, length_m))
    bend_rad = np.diff(_mean_under(profile["turn_rad"], position_m, length_m))
    curve_j = weight_n * 1e-3 * float(row["resistance"]["curve_coefficient_m"]) * bend_rad
    middle_mps = 0.5 * (speed_mps[1:] + speed_mps[:-1])
    work_j = kinetic_j + weight_n * climb_m + curve_j + resistance(kind, mass, middle_mps) * run_m
    if row["losses_given"] > 0.0:
        pulls = (
            (run_m > LEAST_RUN_M) & (work_j > 0.0) & ((rows["notch"][1:] > 0.0) | (rows["notch"][:-1] > 0.0))
        )
        force_n, time_s = work_j[pulls] / run_m[pulls], run_m[pulls] / middle_mps[pulls]
        power_w = [wire_power_w(row, 1.0, *pair) for pair in zip(force_n, middle_mps[pulls], strict=True)]
        return float(np.dot(power_w, time_s))
    return float(np.sum(np.maximum(work_j, 0.0)[run_m > 0.0])) / float(row["efficiency_traction"])


def _mean_under(values: Floats, front_m: Floats, length_m: float) -> Floats:
    """Mean of what stands at each metre, over the length of a train with its front at `front_m`; ends go on level."""
    grid_m = np.arange(values.size, dtype=np.float64)
    whole = np.concatenate(([0.0], np.cumsum(0.5 * (values[1:] + values[:-1]))))

    def up_to(at_m: Floats) -> Floats:
        inside_m = np.clip(at_m, 0.0, grid_m[-1])
        beyond = np.minimum(at_m, 0.0) * values[0] + np.maximum(at_m - grid_m[-1], 0.0) * values[-1]
        return np.asarray(np.interp(inside_m, grid_m, whole) + beyond, dtype=np.float64)

    return (up_to(front_m) - up_to(front_m - length_m)) / length_m
