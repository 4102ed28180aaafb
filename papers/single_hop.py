"""One hop from a stand to a stand at the mark, through the kernel, compiled: what is ordered, and what came of it.

The train, its unit and its law are those of a `single_train.Bench`; here they get a way to run on, an ordered running
time, and the loop that hands every law the order with which the time that is asked for comes out. The running time
counts from the order to depart, brakes released, until the train stands. The unit has no fix on its way and needs
none: sensors are exact unless the bench says otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from network.profile import PROFILE
from network.units import J_PER_KWH
from onboard.driving.laws.cue import PLAN
from onboard.driving.laws.table import LAWS
from onboard.driving.pattern import limit_for_train, pattern_of
from onboard.driving.planner.plan import PlanOnPath, PlanRequest, plan_in_time
from onboard.duty.timekeeping import cruise_for
from onboard.records import NO_PLACES
from papers.single_run import STEPS_MAX, Floats, Heights, Rows, new_hops
from papers.single_train import BEYOND_M, Bench
from simulation.world.kernel import PathArrays
from vehicle.optimum import TooShort
from vehicle.running_time import predicted_run

LEAST_STEP_S: Final = 0.1
COARSE_S: Final = 0.5  # steps in which orders are tried,
FINE_S: Final = 0.1  # and then those beside the best of them
TRIED_S: Final = 15.0  # this far to either side of the time that is asked for
# a plan on the grid of the way's path, for an ordered running time, s, and a load; None: there is none
Planner = Callable[["HopBench", float, float], PlanOnPath | None]


@dataclass(frozen=True, slots=True)
class HopWay:
    """The track of a hop. Pieces are (from m after the start, value), rising; the first one also lies behind it."""

    length_m: float
    gradients_permille: tuple[tuple[float, float], ...] = ((0.0, 0.0),)
    # what the unit's map says instead; None: what is so
    believed_permille: tuple[tuple[float, float], ...] | None = None
    limits_mps: tuple[tuple[float, float], ...] = ()  # empty: the train's own greatest speed alone

    def elevation_m(self, begin_m: float, believed: bool = False) -> Floats:
        """Elevation on the 1 m grid of a path on which hops begin at `begin_m`; shape (rows,)."""
        pieces = self.gradients_permille
        if believed and self.believed_permille is not None:
            pieces = self.believed_permille
        slopes = _by_metre(pieces, self.rows(begin_m), begin_m) / 1000.0
        return np.concatenate([[0.0], np.cumsum(slopes[:-1])])

    def limit_mps(self, begin_m: float, speed_max_mps: float) -> Floats:
        """Limits on the same grid, m/s."""
        pieces = self.limits_mps or ((0.0, speed_max_mps),)
        return np.minimum(_by_metre(pieces, self.rows(begin_m), begin_m), speed_max_mps)

    def rows(self, begin_m: float) -> int:
        """Metres of the path's grid."""
        return int(np.ceil(begin_m + self.length_m + BEYOND_M)) + 2


def _by_metre(pieces: tuple[tuple[float, float], ...], rows: int, begin_m: float) -> Floats:
    """The value of each metre of the grid."""
    starts = np.array([start for start, _ in pieces])
    values = np.array([value for _, value in pieces])
    here = np.arange(rows) - begin_m
    return np.asarray(
        values[np.maximum(np.searchsorted(starts, here, side="right") - 1, 0)], dtype=np.float64
    )


def one_gradient(length_m: float, gradient_permille: float = 0.0) -> HopWay:
    """A way of one gradient, which the unit knows, without a limit."""
    return HopWay(length_m, ((0.0, gradient_permille),))


@dataclass(frozen=True, slots=True)
class TimedHop:
    """A hop in a time that was asked for: the order that was handed to the law so that it came out, and the outcome."""

    asked_s: float
    order_s: float
    outcome: np.void  # a row of BENCH_OUTCOME

    @property
    def off_s(self) -> float:
        """By how much the running time is longer than asked for, s."""
        return float(self.outcome["time_s"]) - self.asked_s

    @property
    def traction_kwh(self) -> float:
        """Drawn for traction, at the wire."""
        return float(self.outcome["energy_traction_j"]) / J_PER_KWH

    @property
    def notch_changes(self) -> int:
        """Of power and brake."""
        return int(self.outcome["power_changes"] + self.outcome["brake_changes"])


def own_plan(
    bench: HopBench, order_s: float, load_share: float, regeneration_share: float = 1.0
) -> PlanOnPath | None:
    """The plan that the unit lays for itself at a departure, on its own map."""
    return plan_in_time(
        PlanRequest(
            bench.train,
            load_share,
            np.ascontiguousarray(bench.pattern["climb_m"]),
            np.ascontiguousarray(bench.pattern["driving_mps"]),
            bench.begin_m,
            bench.mark_m,
            0.0,
            float(bench.behaviour.settings.stop_deceleration_mps2),
            order_s,
            regeneration_share,
        )
    )


class HopBench:
    """A bench's train on one way: makes as many hops as are asked for, in one compiled call."""

    def __init__(self, bench: Bench, way: HopWay, planner: Planner | None = None) -> None:
        """`planner` lays a plan for each hop; if left out, the unit's own does for laws that follow one.

        No law plans anew on its way: nothing here comes upon it that a plan has not taken in.
        """
        self.bench, self.way = bench, way
        law = LAWS[int(bench.prepared.view(np.recarray)[0].board.laws.number)]
        self.planner = own_plan if planner is None and law.plans else planner
        self.begin_m = bench.begin_m
        self.mark_m = self.begin_m + way.length_m
        row = bench.prepared.view(np.recarray)[0]
        self.train, self.behaviour = row.board.kind, row.board.behaviour
        elevation_m = way.elevation_m(self.begin_m)
        believed_m = way.elevation_m(self.begin_m, believed=True)
        limit_mps = way.limit_mps(self.begin_m, float(self.train.speed_max_mps))
        turn_rad = np.zeros(limit_mps.size)
        self.pattern = pattern_of(believed_m, turn_rad, limit_mps, self.train, self.behaviour)
        self.profile = np.zeros(limit_mps.size, dtype=PROFILE)
        self.profile["limit_mps"] = limit_mps
        self.heights = Heights(
            elevation_m, self.pattern["climb_m"].copy(), self.pattern["body_elevation_m"].copy()
        )
        self._cruise: dict[tuple[float, float], float] = {}
        self._laid: dict[tuple[float, float], PlanOnPath | None] = {}

    def cruise_mps(self, order_s: float, load_share: float = 0.0) -> float:
        """The cruising speed that the unit chooses for an ordered running time, as at a departure on the line."""
        key = (order_s, load_share)
        if key not in self._cruise:
            self._cruise[key] = cruise_for(
                self.train,
                load_share,
                np.ascontiguousarray(self.pattern["climb_m"]),
                np.ascontiguousarray(self.pattern["driving_mps"]),
                self.begin_m,
                self.mark_m,
                order_s,
                float(self.behaviour.settings.stop_deceleration_mps2),
            )
        return self._cruise[key]

    def least_s(self, load_share: float = 0.0) -> float:
        """The least running time of the way, s, at the limits, with the unit's braking; infinite: it cannot climb."""
        train = self.train
        limit_mps = np.ascontiguousarray(limit_for_train(self.profile["limit_mps"], train))
        braking_mps2 = float(self.behaviour.settings.stop_deceleration_mps2)
        run = (limit_mps, self.begin_m, self.mark_m, math.inf, braking_mps2, LEAST_STEP_S)
        return float(predicted_run(train, load_share, self.heights.elevation_m, *run)[0])

    def run(self, hops: Rows, trace_steps: int = 0) -> tuple[Rows, Rows]:
        """Make hops: rows of BENCH_OUTCOME, and the last one's TRACE, in m past the hop's start.

        The unit chooses its cruising speed for each order, and the planner, if there is one, lays its plan.
        """
        laid: list[PlanOnPath] = []
        for index, hop in enumerate(hops):
            order_s, load_share = float(hop["order_s"]), float(hop["load_share"])
            hops["cruise_mps"][index] = self.cruise_mps(order_s, load_share)
            if self.planner is not None:
                key = (order_s, load_share)
                if key not in self._laid:
                    self._laid[key] = self.planner(self, order_s, load_share)
                found = self._laid[key]
                if found is not None:
                    hops["plan_offset"][index] = sum(plan.rows.size for plan in laid)
                    hops["plan_rows"][index], hops["plan_due_s"][index] = found.rows.size, found.takes_s
                    laid.append(found)
        plan = np.concatenate([plan.rows for plan in laid]) if laid else np.zeros(0, dtype=PLAN)
        track = PathArrays(self.profile, self.pattern.copy(), plan, np.zeros(0), NO_PLACES, NO_PLACES)
        hops["start_m"] = self.way.length_m
        outcomes, trace = self.bench.run_over(track, self.heights, hops, trace_steps)
        trace["position_m"] -= self.begin_m
        return outcomes, trace

    def timed(self, asked_s: float, like: Rows | None = None) -> TimedHop:
        """The hop that takes the time asked for, as near as any order within TRIED_S of it makes this law take it.

        Every law is handed the same orders, every half second and then every tenth beside the best; the nearest
        running time counts, of equal ones the earliest order. `like`: a hop for all but the order. Raises
        TooShort, with the least running time, for a time in which no train gets there.
        """
        least_s = self.least_s(0.0 if like is None else float(like["load_share"][0]))
        if asked_s < least_s:
            raise TooShort(asked_s, least_s)
        steps = np.arange(-TRIED_S, TRIED_S + COARSE_S / 2.0, COARSE_S)
        coarse = self._nearest(asked_s, asked_s + steps, like)
        beside = np.arange(-COARSE_S, COARSE_S + FINE_S / 2.0, FINE_S)
        fine = self._nearest(asked_s, coarse.order_s + beside, like)
        return fine if abs(fine.off_s) < abs(coarse.off_s) else coarse

    def _nearest(self, asked_s: float, orders_s: Floats, like: Rows | None) -> TimedHop:
        orders = [float(order_s) for order_s in np.round(orders_s, 6) if order_s > 0.0]
        hops = new_hops(orders)
        if like is not None:
            hops[:] = like[0]
            hops["order_s"] = orders
        outcomes, _ = self.run(hops)
        best = int(np.argmin(np.abs(outcomes["time_s"] - asked_s)))
        return TimedHop(asked_s, orders[best], outcomes[best])

    def traced(self, timed: TimedHop) -> Rows:
        """The TRACE of a hop made before, every step of it."""
        return self.run(new_hops([timed.order_s]), STEPS_MAX)[1]
