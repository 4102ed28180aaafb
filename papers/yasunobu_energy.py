"""`branchline reproduce yasunobu-energy`: traction energy over 1,000 m in the same time by PID, fuzzy and the optimum.

Yasunobu, Miyamoto and Ihara, section 6 and figures 8 and 9. Every law runs through the same kernel and tick, is handed
its order by the same loop (`single_hop.HopBench.timed`), and is held against the proven lower bound of its own real
running time. The PID was tuned beforehand (`pid_tuning`); nothing here is chosen by cell.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache
from typing import Final

import numpy as np
from matplotlib.axes import Axes

from network.files.toml_input import Record
from network.units import J_PER_KWH
from onboard.driving.laws.fuzzy_records import PredictiveFuzzy
from onboard.driving.laws.pid import Pid
from onboard.driving.laws.settings import LawTables
from onboard.driving.planner.plan import PlanOnPath
from papers.charts import ChartPage, Panel, Plotted
from papers.parameter_sets import TABLE_1
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.single_hop import HopBench, TimedHop, one_gradient, own_plan
from papers.single_run import Rows
from papers.specification import Findings, Specification
from papers.yasunobu_train import (
    GRADIENTS_PERMILLE,
    HOP_M,
    NOMINAL_S,
    ORDERS_S,
    paper_bench,
    paper_hops,
    paper_train,
)
from study.report.style import INK, UNIT_COLOURS
from vehicle.optimum import Course, TooShort, least_energy
from vehicle.optimum.bound import lower_bound_j
from vehicle.resistance import KMH_PER_MPS

DECELERATION_MPS2: Final = TABLE_1.driving.stop_deceleration_mps2
PUNCTUAL_S: Final = 1.0
SAVING_SHARE: Final = 0.10  # the paper, 6.2
NEAR_BOUND_SHARE: Final = 0.05
WORSE_WITHOUT_SHARE: Final = 0.03  # assumed: a rule that is worth less than this is no rule for saving energy
PAPER_KWH: Final = {"fuzzy": 8.91, "PID": 10.03}  # figure 9: level, 85 s
PAPER_SAVES_PERCENT: Final = round(100.0 * (1.0 - PAPER_KWH["fuzzy"] / PAPER_KWH["PID"]), 1)
NOMINAL: Final = (0.0, NOMINAL_S)  # permille, s
QUICK_ORDERS_S: Final = (NOMINAL_S, 95.0)
MISS_M: Final = 1.0  # a hop that ends further from its mark is none
OWN_MPS2: Final = ((0.7, 0.7), (0.7, 0.8), (0.8, 0.8), (0.8, 0.9), (0.9, 0.9))  # of the stop: PID's, fuzzy's
POWERS_KW: Final = (1280.0, 900.0, 700.0, 560.0)
PAPER_NET_PERCENT: Final = 2  # "about", 6.2: with all that a lossless brake would give back taken off
AT: Final = f"level, {NOMINAL_S:g} s"
ON_AVERAGE: Final = "fuzzy saves on average, %"
AT_NOMINAL: Final = f"fuzzy saves at {AT}, %"
WHY_LESS: Final = "both laws share the stop's deceleration here, which the paper does not print"


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
DRAWN: Final = (DrivingWay.PID, DrivingWay.FUZZY, DrivingWay.OPTIMAL)


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


def percent(share: float) -> float:
    """For people to read."""
    return round(100.0 * share, 1)


def row_of(cell: EnergyCell) -> CaseRow:
    """One cell: energies at equal running time, and what each is above the bound."""
    if cell.optimum_j is None or cell.bound_j is None:
        impossible = f"impossible: at least {cell.least_s:.1f} s"
        return CaseRow(cell.name, None, impossible, False, "a running time that there is")
    ours = {f"{way.value}, kWh": round(cell.hops[way].traction_kwh, 2) for way in DrivingWay}
    ours |= {
        "optimum, kWh": round(cell.optimum_j / J_PER_KWH, 2),
        "lower bound, kWh": round(cell.bound_j / J_PER_KWH, 3),
    }
    ours |= {"fuzzy saves, %": percent(cell.saving())}
    ours |= {f"{way.value} over the bound, %": percent(cell.over_bound[way]) for way in DrivingWay}
    ours |= {f"{way.value} notch changes": cell.hops[way].notch_changes for way in DrivingWay}
    ours |= {f"{way.value} off the time, s": round(cell.hops[way].off_s, 1) for way in DrivingWay}
    never = (
        cell.over_bound[DrivingWay.FUZZY] >= 0.0
        and cell.hops[DrivingWay.FUZZY].traction_kwh >= cell.optimum_j / J_PER_KWH
    )
    criterion = "all four within 1 s of the order and 1 m of the mark, the optimum not above fuzzy"
    if off := [
        f"{way.value} is {hop.off_s:+.1f} s and {float(hop.outcome['error_m']):+.2f} m off"
        for way, hop in cell.hops.items()
        if not is_kept(hop)
    ]:
        criterion += "; missed: " + ", ".join(off)
    return CaseRow(cell.name, None, ours, cell.comparable() and never, criterion)


def saving_rows(
    cells: Sequence[EnergyCell], nominal: EnergyCell, way: DrivingWay = DrivingWay.FUZZY
) -> tuple[CaseRow, ...]:
    """What the paper claims of fuzzy, by it or by another way in its place."""
    mean = float(np.mean([cell.saving(way) for cell in cells if cell.comparable(DrivingWay.PID, way)]))
    saving = nominal.saving(way)
    return (
        share_row(ON_AVERAGE, "more than 10", mean, SAVING_SHARE, "more than 10 %"),
        share_row(AT_NOMINAL, PAPER_SAVES_PERCENT, saving, SAVING_SHARE, "at least 10 %", WHY_LESS),
    )


def judged_claims(cells: Sequence[EnergyCell], nominal: EnergyCell) -> tuple[CaseRow, ...]:
    """What the paper claims, and what the optimum adds to it."""
    over = nominal.over_bound[DrivingWay.FUZZY]
    return (
        *saving_rows(cells, nominal),
        CaseRow(
            f"fuzzy over the lower bound at {AT}, %",
            None,
            {
                "with the stop pattern's deceleration": percent(over),
                "with the full service brake": percent(nominal.fuzzy_over_full),
            },
            over <= NEAR_BOUND_SHARE,
            missed_by(
                "at most 5 % with the deceleration that all laws share",
                over,
                NEAR_BOUND_SHARE,
                f"of it {percent(over - nominal.fuzzy_over_idle)} are the motors' dead"
                " time and lag, which the bound has not",
            ),
        ),
        share_row(
            f"without C-2 fuzzy needs more at {AT}, %",
            None,
            nominal.without_costs,
            WORSE_WITHOUT_SHARE,
            "at least 3 % more, each over the bound of its own running time",
        ),
    )


def share_row(case: str, paper: object, found: float, least: float, criterion: str, why: str = "") -> CaseRow:
    """A share that must not be below another, in percent."""
    return CaseRow(case, paper, percent(found), found >= least, missed_by(criterion, least, found, why))


def missed_by(criterion: str, least: float, found: float, why: str = "") -> str:
    """The criterion, and by how much it is missed where it is, and why."""
    short = least - found
    if short <= 0.0:
        return criterion
    return f"{criterion}; missed by {percent(short):g} points" + (f": {why}" if why else "")


def saved_percent(pid_mps2: float, fuzzy_mps2: float, power_kw: float = POWERS_KW[0]) -> tuple[float, float]:
    """What fuzzy saves in the nominal cell with other decelerations of the stop, each law's own, or other motors, %.

    Of traction; and net, with all that a lossless brake gives back taken off: the work of running resistance is left.
    """
    shipped = paper_train()
    row = shipped.row.copy()
    row["traction_power_max_w"] = row["regenerative_power_max_w"] = 1e3 * power_kw
    used_j: list[tuple[float, float]] = []
    for way, deceleration_mps2 in ((DrivingWay.PID, pid_mps2), (DrivingWay.FUZZY, fuzzy_mps2)):
        bench = paper_bench(LAW[way], deceleration_mps2=deceleration_mps2, train=replace(shipped, row=row))
        hops = HopBench(bench, one_gradient(HOP_M))
        timed = hops.timed(NOMINAL_S)
        hops.traced(timed)
        resisted_j = float(bench.work["plant"]["energy_resistance_j"][0])
        used_j.append((float(timed.outcome["energy_traction_j"]), resisted_j))
    (pid_j, pid_net_j), (fuzzy_j, fuzzy_net_j) = used_j
    return percent(1.0 - fuzzy_j / pid_j), percent(1.0 - fuzzy_net_j / pid_net_j)


def open_rows() -> tuple[CaseRow, ...]:
    """What the miss of the nominal cell depends on; the paper prints no running curves: nothing is chosen."""
    by_stop: dict[str, str] = {}
    for pid_mps2, fuzzy_mps2 in OWN_MPS2:
        saved, net = saved_percent(pid_mps2, fuzzy_mps2)
        by_stop[f"PID {pid_mps2:g}, fuzzy {fuzzy_mps2:g} m/s^2"] = f"{saved:g}, net {net:g}"
    by_power = {
        f"{power_kw:g} kW": saved_percent(DECELERATION_MPS2, DECELERATION_MPS2, power_kw)[0]
        for power_kw in POWERS_KW
    }
    return (
        CaseRow(
            f"the same by the stop's deceleration at {AT}, %",
            f"{PAPER_SAVES_PERCENT:g} of traction, about {PAPER_NET_PERCENT} net",
            by_stop,
            True,
            "the paper prints neither; a pattern to follow and a brake that is foretold need not share one",
            judged=False,
        ),
        CaseRow(
            f"the same by the motors' power at {AT}, %",
            PAPER_SAVES_PERCENT,
            by_power,
            True,
            "less power leaves less time for coasting, and less to save",
            judged=False,
        ),
    )


def figures(nominal: EnergyCell) -> tuple[UnjudgedFigure, ...]:
    """The paper's kWh, which depend on what it does not name."""
    pid, fuzzy = nominal.hops[DrivingWay.PID], nominal.hops[DrivingWay.FUZZY]
    unknown = (
        "the paper names neither efficiency (here 0.85), power above the base speed (here 1280 kW at the rim), rotating"
        " mass (9 %), speed limit (80 km/h, driven 4 km/h below it), load nor the deceleration of the stop"
    )
    return (
        UnjudgedFigure(
            "PID, level, 85 s, kWh", [PAPER_KWH["PID"], round(pid.traction_kwh, 2)], "paper, ours; " + unknown
        ),
        UnjudgedFigure(
            "fuzzy, level, 85 s, kWh", [PAPER_KWH["fuzzy"], round(fuzzy.traction_kwh, 2)], "the same"
        ),
        UnjudgedFigure(
            "fuzzy over the lower bound of 0.8 s less, level, 85 s, %",
            percent(nominal.fuzzy_over_idle),
            "what is left with the motors' dead time and lag, which no law can pass by, taken off the bound's time",
        ),
        UnjudgedFigure(
            "PID over fuzzy with regenerated energy taken off, level, 85 s, %",
            percent(net_kwh(pid) / net_kwh(fuzzy) - 1.0),
            "the paper: about 2 % (6.2), of ideal regeneration",
        ),
    )


def net_kwh(hop: TimedHop) -> float:
    """Traction less what came back."""
    return hop.traction_kwh - float(hop.outcome["energy_regenerated_j"]) / J_PER_KWH


def parameters() -> tuple[Parameter, ...]:
    """What was chosen, and why."""
    train, gains = paper_train().row[0], Pid()
    margin_kmh = TABLE_1.driving.driving_margin_mps * KMH_PER_MPS
    return (
        Parameter("train", "hitachi_train", "", "table 1; what it leaves out is assumed in the train file"),
        Parameter("hop", HOP_M, "m", "6.1"),
        Parameter(
            "speed limit",
            round(float(train["speed_max_mps"]) * KMH_PER_MPS, 1),
            "km/h",
            f"assumed: the paper has none; trains are driven {margin_kmh:.1f} km/h below it, the optimum too",
        ),
        Parameter(
            "efficiency of traction", float(train["efficiency_traction"]), "", "assumed: not in the paper"
        ),
        Parameter("load", 0.0, "share", "table 1's weight is taken with what is on board"),
        Parameter("proportional gain of PID", gains.gain_per_s, "1/s", "papers.pid_tuning"),
        Parameter("integral gain of PID", gains.integral_gain_per_s2, "1/s^2", "papers.pid_tuning"),
        Parameter("derivative gain of PID", gains.derivative_gain, "", "papers.pid_tuning"),
    )


def energy_chart(cells: Sequence[EnergyCell]) -> ChartPage:
    """The like of figure 8: energy over running time, one panel a gradient, one line a law."""
    top_kwh = 1.05 * max(hop.traction_kwh for cell in cells for hop in cell.hops.values())
    panels: list[Panel] = []
    for gradient in GRADIENTS_PERMILLE:
        own = [cell for cell in cells if cell.gradient_permille == gradient and cell.bound_j is not None]
        lines: list[Plotted] = []
        for way, colour in zip(DRAWN, UNIT_COLOURS, strict=False):
            times_s = [float(cell.hops[way].outcome["time_s"]) for cell in own]
            used_kwh = [cell.hops[way].traction_kwh for cell in own]
            lines.append(Plotted(times_s, used_kwh, way.value, colour, "o-", 1.4, 3.5))
        bounds_kwh = [(cell.bound_j or 0.0) / J_PER_KWH for cell in own]
        lines.append(Plotted([cell.asked_s for cell in own], bounds_kwh, "lower bound", INK, ":"))
        y = "traction energy at the wire, kWh"
        if own:
            title = gradient_named(gradient)
            panels.append(Panel("running time, s", y, lines, title, y_limits=(0.0, top_kwh)))
    return ChartPage("yasunobu_energy", (10.0, 3.8), [panels])


def running_curves() -> ChartPage:
    """The like of figure 9: speed and notch over distance, one panel a law."""
    rows: list[list[Panel]] = []
    for way, colour in zip(DRAWN, UNIT_COLOURS, strict=False):
        hops = hops_of(way, 0.0)
        trace = hops.traced(hops.timed(NOMINAL_S))
        at_m, speed_kmh = trace["position_m"], trace["speed_mps"] * KMH_PER_MPS
        x = "distance from the start, m" if len(rows) == len(DRAWN) - 1 else ""
        line = Plotted(at_m, speed_kmh, colour=colour, width=1.4)
        rows.append(
            [Panel(x, "km/h", [line], way.value, y_limits=(0.0, 80.0), legend="", also=notches(trace))]
        )
    return ChartPage("yasunobu_running_curves", (10.0, 2.6 * len(rows)), rows)


def notches(trace: Rows) -> Callable[[Axes], None]:
    """What draws the notch over distance beside the speed."""
    moving = trace["speed_mps"] > 0.0

    def draw(axes: Axes) -> None:
        beside = axes.twinx()
        beside.step(trace["position_m"][moving], trace["notch"][moving], where="post", color=INK, lw=0.7)
        beside.axhline(0.0, color=INK, lw=0.3)
        beside.set(ylabel="notch", ylim=(-9.5, 18.0), yticks=[-9, -6, -3, 0, 3, 7])

    return draw


REMARKS: Final = (
    "Running time counts from the order to depart, with the brakes released, to the stand at the mark: dead times,"
    " lags and whole notches are in it for the laws, not for the optimum and its bound.",
    "The optimum and the bound brake by at most the stop pattern's deceleration, as all laws mean to; beside that"
    " stands the bound with the full service brake. Each law is held against the bound of its own running time.",
    "Why fuzzy saves less here than in the paper: not the motors' power, which it does not name (less of it saves"
    " less), but the stop's deceleration, which all laws share here: with a gentler pattern for PID than fuzzy"
    " brakes by, the row of 85 s would come out (row above). Its running curves (figures 8 to 10) are not in the"
    " text that there is, and its other figure, some 2 % net, does not either: nothing was chosen by it.",
)


def experiment(options: Options) -> Findings:
    """Every gradient and running time; `options.quick`: the level alone, in two times."""
    gradients, orders_s = ((0.0,), QUICK_ORDERS_S) if options.quick else (GRADIENTS_PERMILLE, ORDERS_S)
    cells = [cell for gradient in gradients for cell in run_cells(gradient, orders_s)]
    nominal = next(cell for cell in cells if (cell.gradient_permille, cell.asked_s) == NOMINAL)
    return Findings(
        (*judged_claims(cells, nominal), *open_rows(), *map(row_of, cells)),
        parameters(),
        REMARKS,
        figures(nominal),
        saving_rows(cells, nominal, DrivingWay.WITHOUT),
        lambda folder: (*energy_chart(cells).write(folder), *running_curves().write(folder)),
    )


def without_c_2(_options: Options) -> Sequence[CaseRow]:
    """What is saved on the level without it."""
    cells = run_cells(0.0, QUICK_ORDERS_S, (DrivingWay.PID, DrivingWay.WITHOUT))
    return saving_rows(cells, cells[0], DrivingWay.WITHOUT)


reproduce: Final = Specification(
    "yasunobu-energy",
    "Traction energy by PID, predictive fuzzy control and the optimum in the same time (Yasunobu and others, 6)",
    experiment,
    NullMethod("fuzzy without C-2, which is to save energy", (ON_AVERAGE, AT_NOMINAL), without_c_2),
    TABLE_1,
    "A short slice: the level, in two of the five times; what is missed at 85 s the whole misses too.",
    whole=(ON_AVERAGE,),
)
