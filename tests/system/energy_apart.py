"""A day's energy worked out once more from where trains were and how fast, with nothing of `vehicle` but its files.

Kinetic energy from speeds, potential energy from the gradients of the line, resistance and curves from formulas written
here again, losses from the efficiencies of the train file, auxiliaries from their power. Only what the air brake took
is the run's own figure, for nothing else tells it. Between two samples of the trace everything is taken as even.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from network.model import Alignment, Curve, Line
from simulation.result import EnergyPhase, EnergyRecord, RunResult, TraceSpan

Floats: TypeAlias = NDArray[np.float64]
Numbers: TypeAlias = Mapping[str, float]

G_MPS2: Final = 9.81
STEP_S: Final = 0.1


class Part(StrEnum):
    """What the balance is made of; each can be left out by name."""

    KINETIC = "kinetic"  # from a stand to a stand there is none: tests/vehicle/test_energy.py leaves it out
    RESISTANCE = "resistance"
    GRADIENT = "gradient"
    CURVE = "curve"
    TRACTION_LOSS = "traction loss"
    REGENERATION_LOSS = "regeneration loss"
    FRICTION = "friction"
    AUXILIARY = "auxiliary"
    REGENERATED = "regenerated"


@dataclass
class Balance:
    """One leg: what was drawn at the wire, J, and what of it is found again."""

    train: str
    drawn_j: float
    parts_j: dict[Part, float] = field(default_factory=dict[Part, float])

    def open_share(self, without: Part | None = None) -> float:
        """What the parts leave open, of what was drawn."""
        found_j = math.fsum(joules for part, joules in self.parts_j.items() if part is not without)
        return abs(self.drawn_j - found_j) / self.drawn_j


def balances(result: RunResult, line: Line, train: Numbers) -> Iterator[Balance]:
    """Of every train and leg, from a stand to the next where it was to stop. `train`: what its file says, in SI."""
    legs: dict[tuple[str, str, str], list[EnergyRecord]] = {}
    for record in result.energy:
        if (
            record.phase in (EnergyPhase.RUNNING, EnergyPhase.HELD)
            and record.distance_m + record.counted_j["traction"] > 0.0
        ):
            legs.setdefault((record.number, record.from_id, record.to_id), []).append(record)
    for (number, *_), records in legs.items():
        balance = Balance(number, sum(r.counted_j["traction"] + r.counted_j["auxiliary"] for r in records))
        apart = dict.fromkeys(Part, 0.0)
        for record in records:
            _add_losses(apart, record, train)
            for span, rows in _samples(result, record):
                _add_work(apart, line, train, span, rows)
        balance.parts_j = apart
        yield balance


def _add_losses(apart: dict[Part, float], record: EnergyRecord, train: Numbers) -> None:
    apart[Part.TRACTION_LOSS] += record.counted_j["traction"] * (1.0 - train["efficiency_traction"])
    apart[Part.REGENERATION_LOSS] += record.counted_j["regenerated"] * (
        1.0 / train["efficiency_regeneration"] - 1.0
    )
    apart[Part.REGENERATED] += record.counted_j["regenerated"]
    apart[Part.FRICTION] += record.counted_j["friction"]
    apart[Part.AUXILIARY] += train["auxiliary_power_w"] * (record.end_s - record.begin_s)


def _samples(result: RunResult, record: EnergyRecord) -> Iterator[tuple[TraceSpan, NDArray[np.void]]]:
    """The samples of the trace of one record, each stretch with the train that it belongs to."""
    first, last = round(record.begin_s / STEP_S), round(record.end_s / STEP_S)
    slot = result.stock_ids.index(record.stock_id)
    spans = [span for span in result.spans if span.slot == slot and span.number == record.number]
    step = result.trace["step"]
    mine = (result.trace["slot"] == slot) & (step >= first) & (step <= last)
    yield spans[0], result.trace[mine]


def _add_work(
    apart: dict[Part, float], line: Line, train: Numbers, span: TraceSpan, rows: NDArray[np.void]
) -> None:
    mass = train["mass_empty_kg"] + span.load_share * train["mass_load_full_kg"]
    position_m, speed_mps = rows["position_m"], rows["speed_mps"]
    inertia = mass * (1.0 + train["rotating_mass_factor"])
    apart[Part.KINETIC] += 0.5 * inertia * float(speed_mps[-1] ** 2 - speed_mps[0] ** 2)
    run_m = np.diff(position_m)
    middle_mps = 0.5 * (speed_mps[1:] + speed_mps[:-1])
    apart[Part.RESISTANCE] += float(np.sum(_resistance_n(train, mass, middle_mps) * run_m))
    climb_m, turn_rad = _under(line, span, position_m, train["length_m"])
    apart[Part.GRADIENT] += mass * G_MPS2 * climb_m
    apart[Part.CURVE] += mass * G_MPS2 * 1e-3 * train["resistance.curve_coefficient_m"] * turn_rad


def _running_n(train: Numbers, mass: float, speed_mps: Floats) -> Floats:
    """Oda, equation 3, with the coefficients of the file."""
    kmh, weight_kn = 3.6 * speed_mps, mass * G_MPS2 / 1000.0
    share = train["motored_mass_share"]
    motored = (
        train["resistance.motored_constant_n_per_kn"] + train["resistance.motored_linear_n_per_kn_kmh"] * kmh
    )
    trailer = (
        train["resistance.trailer_constant_n_per_kn"] + train["resistance.trailer_linear_n_per_kn_kmh"] * kmh
    )
    per_kn = share * motored + (1.0 - share) * trailer
    return np.asarray(per_kn * weight_kn + train["resistance.air_n_per_kmh2"] * kmh**2)


def _resistance_n(train: Numbers, mass: float, speed_mps: Floats) -> Floats:
    """With the starting resistance: below 3 km/h a straight line from it at rest to the running resistance."""
    at_rest_n = train["resistance.starting_n_per_kn"] * mass * G_MPS2 / 1000.0
    at_3_n = _running_n(train, mass, np.array([3.0 / 3.6]))[0]
    slow = at_rest_n + (at_3_n - at_rest_n) * speed_mps * 3.6 / 3.0
    return np.where(speed_mps * 3.6 < 3.0, slow, _running_n(train, mass, speed_mps))


def _under(line: Line, span: TraceSpan, front_m: Floats, length_m: float) -> tuple[float, float]:
    """How far the middle of the train's mass climbed (m), and the integral of the mean |curvature| under it (rad)."""
    grid_m = np.arange(math.floor(front_m[0] - length_m) - 1.0, math.ceil(front_m[-1]) + 1.0)
    permille, curvature = np.zeros(grid_m.size), np.zeros(grid_m.size)
    for i, at_m in enumerate(grid_m + 0.5):
        permille[i], curvature[i] = _track_at(line, span, at_m)
    height_m = np.concatenate(([0.0], np.cumsum(permille) * 1e-3))
    turn_rad = np.concatenate(([0.0], np.cumsum(np.abs(curvature))))
    edges_m = np.append(grid_m, grid_m[-1] + 1.0)

    def mean(values: Floats, at_m: float) -> float:
        inside = np.linspace(at_m - length_m, at_m, 801)
        return float(np.trapezoid(np.interp(inside, edges_m, values), inside)) / length_m

    first, last = float(front_m[0]), float(front_m[-1])
    return mean(height_m, last) - mean(height_m, first), mean(turn_rad, last) - mean(turn_rad, first)


def _track_at(line: Line, span: TraceSpan, at_m: float) -> tuple[float, float]:
    """Gradient (permille, positive where the train climbs) and curvature (1/m) at a path coordinate."""
    index = max(int(np.searchsorted(span.starts_m, at_m, side="right")) - 1, 0)
    kilometrage_m = span.entries_m[index] + span.direction * (at_m - span.starts_m[index])
    alignment = line.alignments[line.pieces[span.piece_ids[index]].alignment_id]
    return span.direction * _gradient(alignment, kilometrage_m), _curvature(alignment.curves, kilometrage_m)


def _gradient(alignment: Alignment, kilometrage_m: float) -> float:
    return next((g.permille for g in alignment.gradients if g.from_m <= kilometrage_m < g.to_m), 0.0)


def _curvature(curves: Sequence[Curve], kilometrage_m: float) -> float:
    for curve in curves:
        if curve.from_m <= kilometrage_m < curve.to_m:
            inside_m = min(kilometrage_m - curve.from_m, curve.to_m - kilometrage_m)
            return (
                min(inside_m / curve.transition_m, 1.0) / curve.radius_m
                if curve.transition_m
                else 1.0 / curve.radius_m
            )
    return 0.0


def figures_of(row: Any) -> Numbers:  # noqa: ANN401
    """The figures of a TRAIN record that are single numbers, and those of its resistance."""
    numbers = {name: float(row[name]) for name in row.dtype.names if row.dtype[name] == np.float64}
    return numbers | {
        f"resistance.{name}": float(row["resistance"][name]) for name in row["resistance"].dtype.names
    }
