"""Which vehicles come to a crossing, when, and what their drivers do: drawn for each crossing, way and hour by itself.

Arrivals are a Poisson process with the rate of the hour. Every quantity of a vehicle is drawn whether a setting asks
for it or not, so that no setting moves another's draws.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from radio.chance import generator
from sumo_cfg.road_net import RoadAt, RoadWay
from sumo_cfg.road_traffic import CAR, HEAVY, RoadVehicle

HOUR_S: Final = 3600.0
# Share of the limit that drivers choose: SUMO's default for passenger cars is N(1, 0.1), cut at 0.2 and 2.
SPEED_SIGMA: Final = 0.1
SPEED_SHARES: Final = (0.8, 1.2)


def road_vehicles(
    roads: Sequence[RoadAt], seed: int, today: Sequence[str], from_s: float, to_s: float
) -> tuple[RoadVehicle, ...]:
    """All that come in the hours that `from_s` to `to_s` touch; `today` names the day among days of one seed."""
    hours = range(int(from_s // HOUR_S), int(to_s // HOUR_S) + 1)
    return tuple(
        vehicle
        for at in roads
        for way in RoadWay
        for hour in hours
        for vehicle in _in_hour(at, way, hour, seed, today)
    )


def _in_hour(at: RoadAt, way: RoadWay, hour: int, seed: int, today: Sequence[str]) -> Iterator[RoadVehicle]:
    chance = generator(seed, *today, "road", at.crossing_id, way.value, str(hour))
    road = at.road
    number = int(chance.poisson(road.per_h(hour) / 2.0))
    depart_s = np.round(np.sort(chance.uniform(hour * HOUR_S, (hour + 1) * HOUR_S, number)), 1)
    speed_share = np.clip(chance.normal(1.0, SPEED_SIGMA, number), *SPEED_SHARES)
    heavy, stalls, rounds = (chance.random(number) for _ in range(3))
    stall_s, patience_s = (np.maximum(chance.exponential(1.0, number), 0.1) for _ in range(2))
    goes_round = road.round_share if road.half_barriers else 0.0
    for k in range(number):
        yield RoadVehicle(
            f"road.{at.crossing_id}.{way.value}.{hour}.{k}",
            at,
            way,
            HEAVY if heavy[k] < road.heavy_share else CAR,
            float(depart_s[k]),
            float(speed_share[k]),
            float(stall_s[k]) * road.stall_s if stalls[k] < road.stall_share else 0.0,
            float(patience_s[k]) * road.round_after_s if rounds[k] < goes_round else 0.0,
        )
