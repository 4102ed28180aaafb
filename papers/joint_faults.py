"""Runs about where a train is in which several sensors are out of order at once. `papers.position_fusion`.

A run is one of `papers.fusion_runs`, with lying tags and slippery rails as there; beside them the other sensors
that the train carries fail, one to four times, each over a stretch of the way that is drawn: a gyro that is dead,
stuck, shifted or noisy; a receiver without signals, with reflections, a jump or a wrong time tag; a scanner that is
blind or in fog; beacons that are missing or false. Nothing keeps faults from meeting a slide or one another.

In half of the runs one more fault is drawn: a receiver that stays at one place, or for trains without tags a
tachometer without output (beside tags that lie it is the double failure of decision 035). Nothing is judged while
the latter makes the position false and the unit has not noticed (decision 004). Of other tachometer faults a unit
must stand a scale within what wheels may be worn by, and every run's wheels are; one that shows much too much or too
little, or stays at a speed, beside another sensor that fails is more than a unit can tell apart, and is not drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from papers.fusion_runs import FusionOutcome, FusionRule, draw, outcome_of, run_of
from papers.position_sets import Trouble, moments_of, path_of_run
from radio.chance import generator
from simulation.faults.fault import InForce
from simulation.settings import PositionSensor

SETS: Final = (
    (PositionSensor.TAGS, PositionSensor.CURVATURE),
    (PositionSensor.TAGS, PositionSensor.GNSS),
    (
        PositionSensor.TAGS,
        PositionSensor.BEACONS,
        PositionSensor.CURVATURE,
        PositionSensor.GNSS,
        PositionSensor.LIDAR,
    ),
    (PositionSensor.CURVATURE, PositionSensor.GNSS),
    (PositionSensor.CURVATURE,),
    (PositionSensor.GNSS,),
    (PositionSensor.TAGS, PositionSensor.LIDAR),
)
MOST: Final = 4
LASTS_M: Final = (50.0, 3000.0)

Keys = Mapping[str, float]
Draw = Callable[[np.random.Generator], Keys]


def either_way(chance: np.random.Generator, least: float, most: float) -> float:
    """A size between two, ahead or behind."""
    return round(float(chance.uniform(least, most)) * float(chance.choice([-1.0, 1.0])), 3)


def _no_keys(_chance: np.random.Generator) -> Keys:
    return {}


FAILS: Final[Mapping[PositionSensor, Mapping[str, Draw]]] = MappingProxyType(
    {
        PositionSensor.CURVATURE: {
            "gyro_dead": _no_keys,
            "gyro_stuck": _no_keys,
            "gyro_bias": lambda chance: {"jump_degps": round(float(chance.uniform(0.02, 1.0)), 4)},
            "gyro_noise": lambda chance: {"factor": float(chance.uniform(2.0, 10.0))},
        },
        PositionSensor.GNSS: {
            "gnss_jammed": _no_keys,
            "gnss_reflections": lambda chance: {
                "bias_m": either_way(chance, 3.0, 60.0),
                "over_m": float(chance.uniform(20.0, 150.0)),
            },
            "gnss_jump": lambda chance: {"bias_m": either_way(chance, 3.0, 100.0)},
            "gnss_time_tag": lambda chance: {"late_s": float(chance.uniform(0.2, 3.0))},
        },
        PositionSensor.LIDAR: {
            "lidar_blind": _no_keys,
            "lidar_fog": lambda chance: {"visibility_m": round(float(chance.uniform(20.0, 200.0)), 1)},
        },
        PositionSensor.BEACONS: {"no_beacon": _no_keys, "false_beacon": _no_keys},
    }
)
FURTHER_SHARE: Final = 0.5
OF_WHEELS: Final[Mapping[str, Draw]] = MappingProxyType({"no_output": _no_keys})
OF_RECEIVERS: Final[Mapping[str, Draw]] = MappingProxyType({"gnss_frozen": _no_keys})
FURTHER_LAST_M: Final = (50.0, 1000.0)


def carried_in(number: int) -> tuple[PositionSensor, ...]:
    """The sensors of a run: the sets take turns."""
    return SETS[number % len(SETS)]


def rule_of(number: int, rule: FusionRule) -> FusionRule:
    """The rule with the sensors of a run, or the one that is looked at alone."""
    return replace(rule, carries=(rule.alone,) if rule.alone else tuple(map(str, carried_in(number))))


def joint_outcome(seed: int, number: int, rule: FusionRule) -> FusionOutcome:
    """Draw a run with its faults and let it run."""
    drawn, rule = draw(seed, number), rule_of(number, rule)
    setup = rule.with_rule(drawn.setup)
    length_m, stock_id = path_of_run(setup).length_m, setup.timetable.diagrams[0].stock_id
    run, force = run_of(drawn, rule), InForce()
    for key, trouble in enumerate(troubles_of(seed, number, length_m)):
        run.at(moments_of(trouble, stock_id, key, force))
    return outcome_of(seed, drawn, run.run())


def troubles_of(seed: int, number: int, length_m: float) -> list[Trouble]:
    """What fails in a run, whatever of its sensors it is made with."""
    carried = carried_in(number)
    kinds = [(kind, fill) for one in carried for kind, fill in FAILS.get(one, {}).items()]
    chance = generator(seed, "joint sensor faults", str(number))
    troubles = [trouble(chance, kinds, LASTS_M, length_m) for _ in range(int(chance.integers(1, MOST + 1)))]
    chance = generator(seed, "further sensor faults", str(number))
    if chance.random() < FURTHER_SHARE:
        more = [
            *(OF_WHEELS.items() if PositionSensor.TAGS not in carried else ()),
            *(OF_RECEIVERS.items() if PositionSensor.GNSS in carried else ()),
        ]
        if more:
            troubles.append(trouble(chance, more, FURTHER_LAST_M, length_m))
    return troubles


def trouble(
    chance: np.random.Generator,
    kinds: Sequence[tuple[str, Draw]],
    lasts_m: tuple[float, float],
    length_m: float,
) -> Trouble:
    """One of these faults over a stretch of the way."""
    kind, fill = kinds[int(chance.integers(len(kinds)))]
    from_m = float(chance.uniform(0.0, length_m))
    to_m = min(from_m + float(chance.uniform(*lasts_m)), length_m)
    return Trouble(kind, None, from_m, to_m, kind, fill(chance))
