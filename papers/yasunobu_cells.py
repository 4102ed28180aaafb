"""The paper's hop driven in one time by PID, fuzzy and the optimum (Yasunobu and others, 6.1): cells of figure 8."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache
from typing import Final

import numpy as np

from network.files.toml_input import Record
from onboard.driving.laws.fuzzy_records import PredictiveFuzzy
from onboard.driving.laws.settings import LawTables
from onboard.driving.planner.plan import PlanOnPath
from papers.parameter_sets import TABLE_1
from papers.single_hop import HopBench, TimedHop, own_plan
from papers.yasunobu_train import NOMINAL_S, paper_hops
from vehicle.optimum import Course, TooShort, least_energy
from vehicle.optimum.bound import lower_bound_j

DECELERATION_MPS2: Final = TABLE_1.driving.stop_deceleration_mps2
PUNCTUAL_S: Final = 1.0
NOMINAL: Final = (0.0, NOMINAL_S)  # permille, s
MISS_M: Final = 1.0  # a hop that ends further from its mark is none


class DrivingWay(Enum):
    """How the hop is driven; the value is how it is printed."""

    PID = "PID"
    FUZZY = "fuzzy"
    OPTIMAL = "law of the optimum"
    WITHOUT = "fuzzy without C-2"


LAW: Final[Mapping[DrivingWay, str]] = {
    DrivingWay.PID: "pid",
    DrivingWay.FUZZY: "predictive_fuzzy",
    DrivingWay.OPTIMAL: "optimal",
    DrivingWay.WITHOUT: "predictive_fuzzy",
}


@dataclass(frozen=True, slots=True)
class EnergyCell:
    """One gradient and one running time: each way's hop, and the optimum of that time (J; None: impossible)."""

    gradient_permille: float
    asked_s: float
    hops: Mapping[DrivingWay, TimedHop]
    over_bound: Mapping[DrivingWay, float]  # share of the lower bound of the same running time
    # fuzzy over the bound of a time shorter by the motors' dead time and lag, and over that of the full service
    # brake; nan unless nominal
    fuzzy_over_idle: float
    fuzzy_over_full: float
    optimum_j: float | None
    bound_j: float | None
    least_s: float

    @property
    def name(self) -> str:
        """As in the rows."""
        return f"{gradient_named(self.gradient_permille)}, {self.asked_s:g} s"

    def saving(self, way: DrivingWay = DrivingWay.FUZZY) -> float:
        """What a way saves of PID's traction energy, as a share."""
        return 1.0 - self.hops[way].traction_kwh / self.hops[DrivingWay.PID].traction_kwh

    def saving_in_time(self, way: DrivingWay = DrivingWay.FUZZY) -> float:
        """The same, and nothing where either is off the time or the mark."""
        return self.saving(way) if self.comparable(DrivingWay.PID, way) else 0.0

    def comparable(self, *ways: DrivingWay) -> bool:
        """Whether these keep the time and the mark; all of them where none is named."""
        return all(way in self.hops and is_kept(self.hops[way]) for way in ways or tuple(DrivingWay))

    @property
    def without_costs(self) -> float:
        """What fuzzy needs more without C-2, as a share; each by the bound of its own running time."""
        return (1.0 + self.over_bound[DrivingWay.WITHOUT]) / (1.0 + self.over_bound[DrivingWay.FUZZY]) - 1.0


def gradient_named(permille: float) -> str:
    """As in rows and charts."""
    return f"{permille:+g} permille" if permille else "level"


def is_kept(hop: TimedHop) -> bool:
    """Whether a hop took the time asked for and ended at its mark."""
    return abs(hop.off_s) <= PUNCTUAL_S and abs(float(hop.outcome["error_m"])) <= MISS_M


def settings_of(way: DrivingWay) -> Record | None:
    """Settings of the law other than its defaults."""
    if way is DrivingWay.WITHOUT:
        return LawTables.model_validate({"predictive_fuzzy": PredictiveFuzzy(c_2=False)})
    return None


def hops_of(way: DrivingWay, gradient_permille: float) -> HopBench:
    """The paper's hop on one gradient, driven in one way."""
    planner = traction_plan if way is DrivingWay.OPTIMAL else None
    return paper_hops(LAW[way], gradient_permille, settings_of(way), planner)


def traction_plan(hops: HopBench, order_s: float, load_share: float) -> PlanOnPath | None:
    """The unit's own plan, where nothing that comes back counts: the paper counts traction energy alone."""
    return own_plan(hops, order_s, load_share, 0.0)


def course_of(hops: HopBench, deceleration_mps2: float) -> Course:
    """What the optimum is asked for: the same train, track and driven limits; traction energy alone counts."""
    return Course(
        hops.bench.prepared["board"]["kind"][0],
        0.0,
        np.ascontiguousarray(hops.pattern["climb_m"]),
        np.ascontiguousarray(hops.pattern["driving_mps"]),
        hops.begin_m,
        hops.mark_m,
        deceleration_mps2,
        regeneration=0.0,
    )


def strongest_mps2(hops: HopBench) -> float:
    """Deceleration of the last service notch."""
    return float(hops.train.brake_deceleration_mps2[int(hops.train.brake_notches)])


def run_cells(
    gradient_permille: float, orders_s: Sequence[float], ways: Sequence[DrivingWay] = tuple(DrivingWay)
) -> list[EnergyCell]:
    """These ways on one gradient, PID among them."""
    benches = {way: hops_of(way, gradient_permille) for way in ways}
    first = benches[DrivingWay.PID]
    shared = course_of(first, DECELERATION_MPS2)
    full = course_of(first, strongest_mps2(first))

    @cache
    def best_j(time_s: float, strong: bool) -> tuple[float, float]:
        """Energy of the optimum and its lower bound, J; TooShort."""
        course = full if strong else shared
        found = least_energy(course, time_s)
        return float(found.energy_j), float(lower_bound_j(course, found, time_s))

    def over(hop: TimedHop, strong: bool = False, idle_s: float = 0.0) -> float:
        try:
            _, bound_j = best_j(float(hop.outcome["time_s"]) - idle_s, strong)
        except TooShort:
            return float("nan")
        return float(hop.outcome["energy_traction_j"]) / bound_j - 1.0

    cells: list[EnergyCell] = []
    idle_s = float(first.train.traction_dead_time_s + first.train.traction_lag_s)
    for asked_s in orders_s:
        nominal = (gradient_permille, asked_s) == NOMINAL and DrivingWay.FUZZY in ways
        hops: dict[DrivingWay, TimedHop] = {}
        optimum_j = bound_j = None
        least_s = 0.0
        try:
            optimum_j, bound_j = best_j(asked_s, False)
            hops = {way: bench.timed(asked_s) for way, bench in benches.items()}
        except TooShort as short:
            optimum_j = bound_j = None
            least_s = short.least_s
            nominal = False
        cells.append(
            EnergyCell(
                gradient_permille,
                asked_s,
                hops,
                {way: over(hop) for way, hop in hops.items()},
                over(hops[DrivingWay.FUZZY], idle_s=idle_s) if nominal else float("nan"),
                over(hops[DrivingWay.FUZZY], strong=True) if nominal else float("nan"),
                optimum_j,
                bound_j,
                least_s,
            )
        )
    return cells
