"""No train faster than its own greatest speed and any limit under it, beyond what an intervention takes.

By the truth, at each look, which are some seconds apart at most. Where limits lie is handed in, as they are and not as
units have them. Supervision brakes by the emergency brake `margin_mps` above a limit, by the speed that wheels show,
and a train gains on until that acts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Final, NamedTuple

from simulation.judge.body import Body
from simulation.judge.log import Checker, Log
from simulation.judge.rail import RailWatch
from sumo_cfg.truth_map import NetMap

GAINED_MPS: Final = 1.0  # 0.7 m/s2 for the reaction time, and what worn wheels show too little


class LimitOnEdge(NamedTuple):
    """A speed limit between two places along an edge, m and m/s."""

    from_m: float
    to_m: float
    speed_mps: float


class TrueLimits(NamedTuple):
    """Limits by edge, what each train may run at all, by unit, and how far above a limit supervision lets it (m/s)."""

    on_edges: Mapping[str, Sequence[LimitOnEdge]]
    tops_mps: Mapping[str, float]
    margin_mps: float


NO_LIMITS: Final = TrueLimits(MappingProxyType({}), MappingProxyType({}), 0.0)


class SpeedWatch:
    """Checks `too-fast`."""

    def __init__(self, net: NetMap, limits: TrueLimits, log: Log) -> None:
        self._edges, self._limits, self._log = net.edges, limits, log

    def observe(self, t_s: float, body: Body, rail: RailWatch) -> None:
        """The train was seen."""
        limit_mps = self._limit_mps(body)
        if body.speed_mps > limit_mps + self._limits.margin_mps + GAINED_MPS:
            unit_id, speed_mps = body.unit_id, body.speed_mps
            text = f"{unit_id} runs at {speed_mps:.1f} m/s where no more than {limit_mps:.1f} m/s is allowed"
            subject, outside = f"{unit_id} {limit_mps:.1f} {body.path[-1]}", rail.outside(t_s, unit_id)
            self._log.note(t_s, Checker.TOO_FAST, subject, text, outside=outside)

    def _limit_mps(self, body: Body) -> float:
        """The lowest limit under any part of a train, and its own, m/s."""
        least_mps, front_m = self._limits.tops_mps.get(body.unit_id, math.inf), body.front_m
        for edge_id in reversed(body.path):
            front_m += 0.0 if edge_id == body.path[-1] else self._edges[edge_id].length_m
            for limit in self._limits.on_edges.get(edge_id, ()):
                if limit.from_m < front_m and limit.to_m > front_m - body.length_m:
                    least_mps = min(least_mps, limit.speed_mps)
        return least_mps
