"""What two figures of a train say together: a train may be nonsense of which every figure alone could be true.

Each rule is a figure made of a TRAIN row by the laws that a run uses, with the range outside of which it is nonsense.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final, TypeAlias

import numpy as np

from network.errors import InputError
from vehicle.adhesion import DRY, adhesion_coefficient, grip_mps2
from vehicle.losses import no_load_w
from vehicle.mass import GRAVITY_MPS2, equivalent_mass_kg, mass_kg
from vehicle.records import TRAIN
from vehicle.resistance import resistance_n
from vehicle.traction import full_force_n, motored_grip_n
from vehicle.wire import wire_power_w

Record: TypeAlias = Any  # one of TRAIN: numpy knows no type of its fields; compiled laws take a TrainRow
_EMPTY: Final = 0.0
_FULL: Final = 1.0


@dataclass(frozen=True, slots=True)
class CombinedRange:
    """A figure made of several: `key` is the one to blame, by its name in SI; `low` and `high` are in the range."""

    name: str
    key: str
    others: tuple[str, ...]
    unit: str
    low: float
    high: float
    source: str
    figure: Callable[[Record], float]

    def text(self) -> str:
        """The range in words."""
        unit = f" {self.unit}" if self.unit else ""
        if math.isinf(self.high):
            return f"at least {self.low:g}{unit}"
        return f"at most {self.high:g}{unit}" if self.low == 0.0 else f"{self.low:g} to {self.high:g}{unit}"


def _grip_mps2(train: Record) -> float:
    """What all axles can brake with on dry rail at rest, m/s^2."""
    return float(grip_mps2(train, DRY, 0.0))


def pull_over_grip(train: Record, load_share: float) -> float:
    """The greatest force at a start by what the driven axles pass on to a dry rail at rest; above 1 they slip."""
    weight_n = float(mass_kg(train, load_share)) * GRAVITY_MPS2
    grip_n = float(motored_grip_n(train, weight_n, adhesion_coefficient(train, DRY, 0.0)))
    return float(full_force_n(train, load_share, 0.0)) / grip_n


def _service_mps2(train: Record) -> float:
    return float(train["brake_deceleration_mps2"].max())


def _start_mps2(train: Record) -> float:
    """Acceleration of the full train from a stand on the level, m/s^2."""
    pull_n = float(full_force_n(train, _FULL, 0.0)) - float(resistance_n(train, mass_kg(train, _FULL), 0.0))
    return pull_n / float(equivalent_mass_kg(train, _FULL))


def _drag_n_per_kn(train: Record) -> float:
    """Running resistance of the empty train at its greatest speed by its weight."""
    mass = mass_kg(train, _EMPTY)
    drag_n = float(resistance_n(train, mass, float(train["speed_max_mps"])))
    return drag_n / (float(mass) * GRAVITY_MPS2 * 1e-3)


@lru_cache(maxsize=64)
def _best_efficiency_of(row: bytes) -> float:
    """Greatest share of the power at the rim in that at the wire, over speeds and forces of the full notch and less."""
    train, best = np.frombuffer(row, TRAIN)[0], 0.0
    for speed_mps in np.linspace(0.02, 1.0, 50) * float(train["speed_max_mps"]):
        full_n = float(full_force_n(train, _FULL, speed_mps))
        for force_n in np.linspace(0.02, 1.0, 50) * full_n:
            best = max(best, float(force_n * speed_mps / wire_power_w(train, 1.0, force_n, speed_mps)))
    return best


def _full_efficiency(train: Record) -> float:
    """The same at the greatest force, at base speed."""
    base_mps = float(train["loss_base_speed_mps"])
    full_n = float(full_force_n(train, _EMPTY, base_mps))
    return full_n * base_mps / float(wire_power_w(train, 1.0, full_n, base_mps))


def _no_load_share(train: Record) -> float:
    """No-load losses of all motors at base speed by the greatest power."""
    base_mps = float(train["loss_base_speed_mps"])
    return float(train["motors"]) * float(no_load_w(train, base_mps)) / float(train["traction_power_max_w"])


LOSSES: Final = "losses"  # rules of keys below it hold for trains that have the table
RULES: Final[tuple[CombinedRange, ...]] = (
    CombinedRange(
        "load over empty mass",
        "body.mass_load_full_kg",
        ("body.mass_empty_kg",),
        "",
        0.0,
        10.0,
        "ore wagons carry 6 to 7 times their own mass",
        lambda train: float(train["mass_load_full_kg"]) / float(train["mass_empty_kg"]),
    ),
    CombinedRange(
        "mass by length, full",
        "body.mass_empty_kg",
        ("body.mass_load_full_kg", "body.length_m"),
        "kg/m",
        30.0,
        20_000.0,
        "the heaviest train has 13 600 kg/m, the test car of Oda, 3.3.2 has 67",
        lambda train: float(mass_kg(train, _FULL)) / float(train["length_m"]),
    ),
    CombinedRange(
        "length by car",
        "body.length_m",
        ("body.cars",),
        "m",
        1.0,
        60.0,
        "assumed: twice the longest passenger cars, for those that share a bogie",
        lambda train: float(train["length_m"]) / float(train["cars"]),
    ),
    CombinedRange(
        "acceleration of the full train from a stand on the level",
        "traction.force_max_n",
        ("body", "resistance", "traction"),
        "m/s^2",
        0.005,
        4.0,
        "assumed: the heaviest train had about 0.03; the quickest electric cars on rails stay below 2",
        _start_mps2,
    ),
    CombinedRange(
        "greatest force at a start over the grip of the driven axles on dry rail, full",
        "traction.force_max_n",
        ("adhesion.dry", "body.motored_axle_mass_share", "body"),
        "",
        0.0,
        1.0,
        "what slips at each start as designed has another force, or other axles; empty, a strong one may slip",
        lambda train: pull_over_grip(train, _FULL),
    ),
    CombinedRange(
        "power over greatest force times greatest speed",
        "traction.power_max_w",
        ("traction.force_max_n", "body.speed_max_mps"),
        "",
        0.01,
        10.0,
        "assumed: below, it could not leave walking pace; above, the power is of no use",
        lambda train: (
            float(train["traction_power_max_w"])
            / (float(train["traction_force_max_n"]) * float(train["speed_max_mps"]))
        ),
    ),
    CombinedRange(
        "running resistance at the greatest speed by weight",
        "body.speed_max_mps",
        ("resistance",),
        "N/kN",
        0.0,
        200.0,
        "assumed: at 575 km/h it was about 30 to 40",
        _drag_n_per_kn,
    ),
    CombinedRange(
        "strongest service notch over the grip of all axles on dry rail",
        "brakes.notch_deceleration_mps2",
        ("adhesion.dry", "body.rotating_mass_factor"),
        "",
        0.0,
        1.0,
        "a brake that slides on dry rail as designed is none",
        lambda train: _service_mps2(train) / _grip_mps2(train),
    ),
    CombinedRange(
        "emergency brake over the grip of all axles on dry rail",
        "emergency.deceleration_mps2",
        ("adhesion.dry", "body.rotating_mass_factor"),
        "",
        0.0,
        1.0,
        "the same",
        lambda train: float(train["emergency_deceleration_mps2"]) / _grip_mps2(train),
    ),
    CombinedRange(
        "emergency brake over the strongest service notch",
        "emergency.deceleration_mps2",
        ("brakes.notch_deceleration_mps2",),
        "",
        1.0,
        math.inf,
        "an emergency brake is no weaker",
        lambda train: float(train["emergency_deceleration_mps2"]) / _service_mps2(train),
    ),
    CombinedRange(
        "greatest efficiency of motors, inverters and gears",
        "losses.copper_w",
        (LOSSES, "traction"),
        "",
        0.0,
        0.985,
        "assumed: published drives with gear reach 0.90 to 0.96; none gives all, or more than it takes",
        lambda train: _best_efficiency_of(train.tobytes()),
    ),
    CombinedRange(
        "efficiency of motors, inverters and gears at the greatest force and base speed",
        "losses.copper_w",
        (LOSSES, "traction"),
        "",
        0.4,
        1.0,
        "assumed: what loses more than it gives is a heater",
        _full_efficiency,
    ),
    CombinedRange(
        "no-load losses at base speed by greatest power",
        "losses.standby_w",
        (LOSSES, "traction.power_max_w", "traction.motors"),
        "",
        0.0005,
        0.3,
        "assumed: induction motors take 2 to 5 % of their rating; without any, light load would be free",
        _no_load_share,
    ),
    CombinedRange(
        "base speed over greatest speed",
        "losses.base_speed_mps",
        ("body.speed_max_mps",),
        "",
        0.02,
        1.5,
        "assumed: flux is weakened from a fifth to the whole of the greatest speed",
        lambda train: float(train["loss_base_speed_mps"]) / float(train["speed_max_mps"]),
    ),
)


def check_train(file: str, train: Record, written: Mapping[str, str], value_of: Callable[[str], Any]) -> None:
    """Every rule, or InputError; `written` has the file's own key by that in SI, `value_of` its value."""
    for rule in RULES:
        if rule.key.startswith(LOSSES) and train["losses_given"] <= 0.0:
            continue
        figure = rule.figure(train)
        if rule.low <= figure <= rule.high:
            continue
        key = written.get(rule.key, rule.key)
        others = ", ".join(written.get(other, other) for other in rule.others)
        expected = f"{rule.name} {rule.text()}, and with {others} it is {figure:.3g}"
        raise InputError(file, key, value_of(key), expected)
