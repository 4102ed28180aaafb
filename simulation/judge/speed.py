"""No train faster than its own greatest speed and any limit under it, beyond what an intervention takes.

By the truth, in each step that a train has run since the last look. Where limits lie is handed in, as they are and not
as units have them. Supervision brakes by the emergency brake `margin_mps` above a limit, by the speed that wheels show,
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


class LimitBetween(NamedTuple):
    """A speed limit between two places, m and m/s: along an edge, or by how far beyond a front they lie."""

    from_m: float
    to_m: float
    speed_mps: float


class TrueLimits(NamedTuple):
    """Limits by edge, what each train may run at all, by unit, and how far above a limit supervision lets it (m/s)."""

    on_edges: Mapping[str, Sequence[LimitBetween]]
    tops_mps: Mapping[str, float]
    margin_mps: float


NO_LIMITS: Final = TrueLimits(MappingProxyType({}), MappingProxyType({}), 0.0)


class RunSince(NamedTuple):
    """How a train has run since the last look: its speed at the end of each step, m/s, the last one now; if any."""

    step_s: float
    speeds_mps: Sequence[float]


NOT_RUN: Final = RunSince(0.0, ())


class SpeedWatch:
    """Checks `too-fast`."""

    def __init__(self, net: NetMap, limits: TrueLimits, log: Log) -> None:
        self._edges, self._limits, self._log = net.edges, limits, log
        on_edges = limits.on_edges.items()
        self._lowest_mps = {edge: min(each.speed_mps for each in found) for edge, found in on_edges if found}

    def observe(self, t_s: float, body: Body, rail: RailWatch, ran: RunSince) -> None:
        """The train was seen; of the steps that it `ran` the one in which it was too fast by most counts."""
        allowed_mps = self._limits.margin_mps + GAINED_MPS
        speeds_mps = ran.speeds_mps or (body.speed_mps,)
        lower_mps = max(speeds_mps) - allowed_mps  # a limit that is not under this nothing was above
        top_mps = self._limits.tops_mps.get(body.unit_id, math.inf)
        lowest_mps = [self._lowest_mps.get(edge_id, math.inf) for edge_id in (*body.left, *body.path)]
        if lower_mps <= min(top_mps, *lowest_mps):
            return
        nearby = self._nearby(body, lower_mps)
        worst_mps, worst_s, worst_limit_mps, speed_mps = allowed_mps, t_s, top_mps, 0.0
        front_m, after_mps = 0.0, speeds_mps[-1]
        for steps, mps in enumerate(reversed(speeds_mps)):
            front_m -= (mps + after_mps) / 2.0 * ran.step_s if steps else 0.0
            after_mps, rear_m = mps, front_m - body.length_m
            under = [each.speed_mps for each in nearby if each.from_m < front_m and each.to_m > rear_m]
            limit_mps = min([top_mps, *under])
            if mps - limit_mps > worst_mps:
                worst_mps, worst_s = mps - limit_mps, t_s - steps * ran.step_s
                worst_limit_mps, speed_mps = limit_mps, mps
        if speed_mps > 0.0:
            unit_id, limit = body.unit_id, f"{worst_limit_mps:.1f}"
            text = f"{unit_id} runs at {speed_mps:.1f} m/s where no more than {limit} m/s is allowed"
            subject, outside = f"{unit_id} {limit} {body.path[-1]}", rail.outside(worst_s, unit_id)
            self._log.note(worst_s, Checker.TOO_FAST, subject, text, outside=outside)

    def _nearby(self, body: Body, lower_mps: float) -> list[LimitBetween]:
        """The limits below a speed on the edges that the train lies on, or has left since the last look."""
        found: list[LimitBetween] = []
        begin_m = -body.front_m
        for edge_id in reversed((*body.left, *body.path)):
            begin_m -= 0.0 if edge_id == body.path[-1] else self._edges[edge_id].length_m
            found += (
                LimitBetween(begin_m + each.from_m, begin_m + each.to_m, each.speed_mps)
                for each in self._limits.on_edges.get(edge_id, ())
                if each.speed_mps < lower_mps
            )
        return found
