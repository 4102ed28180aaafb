"""Runs about where a train is in which several sensors are out of order at once. `study.papers.position_fusion`.

A run is one of `study.papers.fusion_runs`, with lying tags and slippery rails as there; beside them the other sensors
that the train carries fail, one to four times, each over a stretch of the way that is drawn: a gyro that is dead,
stuck, shifted or noisy; a receiver without signals, with reflections, a jump or a wrong time tag; a scanner that is
blind or in fog; beacons that are missing or false. Nothing keeps faults from meeting a slide or one another.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from radio.chance import generator
from simulation.faults.fault import InForce
from simulation.settings import Carried
from study.papers.fusion_runs import Outcome, Rule, draw, outcome_of, run_of
from study.papers.position_sets import Trouble, moments_of, path_of_run

SETS: Final = (
    (Carried.TAGS, Carried.CURVATURE),
    (Carried.TAGS, Carried.GNSS),
    (Carried.TAGS, Carried.BEACONS, Carried.CURVATURE, Carried.GNSS, Carried.LIDAR),
    (Carried.CURVATURE, Carried.GNSS),
    (Carried.CURVATURE,),
    (Carried.GNSS,),
    (Carried.TAGS, Carried.LIDAR),
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


FAILS: Final[Mapping[Carried, Mapping[str, Draw]]] = MappingProxyType(
    {
        Carried.CURVATURE: {
            "gyro_dead": _no_keys,
            "gyro_stuck": _no_keys,
            "gyro_bias": lambda chance: {"jump_degps": round(float(chance.uniform(0.02, 1.0)), 4)},
            "gyro_noise": lambda chance: {"factor": float(chance.uniform(2.0, 10.0))},
        },
        Carried.GNSS: {
            "gnss_jammed": _no_keys,
            "gnss_reflections": lambda chance: {
                "bias_m": either_way(chance, 3.0, 60.0),
                "over_m": float(chance.uniform(20.0, 150.0)),
            },
            "gnss_jump": lambda chance: {"bias_m": either_way(chance, 3.0, 100.0)},
            "gnss_time_tag": lambda chance: {"late_s": float(chance.uniform(0.2, 3.0))},
        },
        Carried.LIDAR: {
            "lidar_blind": _no_keys,
            "lidar_fog": lambda chance: {"visibility_m": round(float(chance.uniform(20.0, 200.0)), 1)},
        },
        Carried.BEACONS: {"no_beacon": _no_keys, "false_beacon": _no_keys},
    }
)


def rule_of(number: int, rule: Rule) -> Rule:
    """The rule with the sensors of a run: the sets take turns."""
    return replace(rule, carries=tuple(str(kind) for kind in SETS[number % len(SETS)]))


def joint_outcome(seed: int, number: int, rule: Rule) -> Outcome:
    """Draw a run with its faults and let it run."""
    drawn, rule = draw(seed, number), rule_of(number, rule)
    chance = generator(seed, "joint sensor faults", str(number))
    setup = rule.of(drawn.setup)
    length_m, stock_id = path_of_run(setup).length_m, setup.timetable.diagrams[0].stock_id
    kinds = [(kind, fill) for one in rule.carries for kind, fill in FAILS.get(Carried(one), {}).items()]
    run, force = run_of(drawn, rule), InForce()
    for key in range(int(chance.integers(1, MOST + 1))):
        kind, fill = kinds[int(chance.integers(len(kinds)))]
        from_m = float(chance.uniform(0.0, length_m))
        to_m = min(from_m + float(chance.uniform(*LASTS_M)), length_m)
        trouble = Trouble(kind, None, from_m, to_m, kind, fill(chance))
        run.at(moments_of(trouble, stock_id, key, force))
    return outcome_of(seed, drawn, run.run())
