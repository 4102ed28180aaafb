"""How a law stops where brake and gradient are not what the unit believes (Yasunobu, Miyamoto and Ihara, 6.1 and 6.2).

`branchline reproduce yasunobu-robust`: the level turns into a descent of 20 permille 60 m before the mark, which the
unit's map does not have (figure 10); and stops with brakes and gradients that scatter, of which the paper quotes a
third of the standard deviation and half of the notch changes from its reference 8, for stopping alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from network.files.kinds import origin_of
from network.files.toml_input import Record
from onboard.driving.laws.fuzzy_records import PredictiveFuzzy
from onboard.driving.laws.pid import Pid
from onboard.driving.laws.settings import LawTables
from papers.parameter_sets import TABLE_1
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.single_hop import HopWay
from papers.single_run import NONE_S, Rows, new_hops
from papers.specification import Findings, Specification, none_of
from papers.yasunobu_train import HOP_M, NOMINAL_S, ORDERS_S, paper_hops
from radio.chance import generator

NAME: Final = "yasunobu-robust"
FUZZY: Final = "predictive_fuzzy"
PID: Final = "pid"
DROP_PERMILLE: Final = -20.0
DROP_BEFORE_M: Final = 60.0
DROP: Final = HopWay(HOP_M, ((0.0, 0.0), (HOP_M - DROP_BEFORE_M, DROP_PERMILLE)), ((0.0, 0.0),))
FUZZY_MISS_M: Final = 0.3
PAPERS_MISS_M: Final = 1.33
PID_MISSES_M: Final = (0.9, 1.8)
STOPS: Final = 500
STOPS_QUICK: Final = 60
BRAKE_SPREAD: Final = 0.2
GRADIENT_SPREAD_PERMILLE: Final = 10.0
SIGMA_SHARE: Final = 1.0 / 3.0
BRAKE_SETTLES_S: Final = 0.8
CHANGES_SHARE: Final = 0.5
ESTIMATE: Final = "its estimate of the brake"
TAKEN_AWAY: Final[Mapping[str, PredictiveFuzzy]] = {
    ESTIMATE: PredictiveFuzzy(estimates=False),
    "rule T-1": PredictiveFuzzy(t_1=False),
}
OTHER_PIDS: Final[Mapping[str, Pid]] = {
    "without its integral": Pid(integral_gain_per_s2=0.0),
    "in proportion alone": Pid(integral_gain_per_s2=0.0, derivative_gain=0.0),
    "in proportion alone, at a third of the gain": Pid(
        gain_per_s=Pid().gain_per_s / 3.0, integral_gain_per_s2=0.0, derivative_gain=0.0
    ),
}


HOLDS_S: Final = (
    0.1,
    0.5,
    0.8,
    1.0,
    1.5,
)  # of a notch of the PID; 0.8: table 1's dead time and lag of the brake
WHY_EXACT: Final = (
    "our PID, with exact sensors and the notch hold assumed, corrects its notch until the train stands"
)
FUZZY_DROP: Final = "descent before the mark, fuzzy, worst of five orders, m past it"


@dataclass(frozen=True, slots=True)
class ScatteredStops:
    """What came of many stops: bias and standard deviation (m), changes of the brake notch a stop, interventions."""

    stops: int
    mean_m: float
    sigma_m: float
    largest_m: float
    brake_changes: float
    interventions: int


def settings(fuzzy: PredictiveFuzzy | None = None, pid: Pid | None = None) -> Record:
    """Settings of the laws, those left out as they are by default."""
    given = {key: own for key, own in (("predictive_fuzzy", fuzzy), ("pid", pid)) if own is not None}
    return LawTables(**given)


def drop_misses_m(law: str, law_settings: Record | None = None) -> tuple[float, ...]:
    """Where the train stops on the way that falls before its end, m past the mark; one for each of ORDERS_S."""
    outcomes, _ = paper_hops(law, law_settings=law_settings, way=DROP).run(new_hops(ORDERS_S))
    return tuple(float(error_m) for error_m in outcomes["error_m"])


def drop_miss_m(law: str, law_settings: Record | None = None) -> float:
    """That of the order of figure 9, 85 s."""
    return drop_misses_m(law, law_settings)[ORDERS_S.index(NOMINAL_S)]


def worst_drop_miss_m(law_settings: Record | None = None) -> float:
    """The greatest miss of the fuzzy law in any of the five orders."""
    return max(drop_misses_m(FUZZY, law_settings), key=abs)


def scattered_hops(seed: int, count: int) -> Rows:
    """Hops in 85 s whose brake and gradient are drawn, each for itself."""
    hops = new_hops([NOMINAL_S] * count)
    brake = generator(seed, NAME, "brake").uniform(-BRAKE_SPREAD, BRAKE_SPREAD, count)
    gradient = generator(seed, NAME, "gradient").uniform(-1.0, 1.0, count)
    hops["brake_factor"] = 1.0 + brake
    hops["gradient_permille"] = GRADIENT_SPREAD_PERMILLE * gradient
    return hops


def scattered_stops(law: str, hops: Rows, law_settings: Record | None = None) -> ScatteredStops:
    """Make these stops under a law. One that never came to rest has no place, and makes the spread infinite."""
    outcomes, _ = paper_hops(law, law_settings=law_settings).run(hops.copy())
    stands = outcomes["time_s"] < NONE_S
    errors_m = np.where(stands, outcomes["error_m"], np.inf)
    whole = bool(stands.all())
    return ScatteredStops(
        int(hops.size),
        float(errors_m.mean()) if whole else np.inf,
        float(errors_m.std()) if whole else np.inf,
        float(np.abs(errors_m).max()),
        float(outcomes["brake_changes"].mean()),
        int(np.count_nonzero(outcomes["intervention"])),
    )


def fuzzy_drop_row(law_settings: Record | None = None) -> CaseRow:
    """Figure 10, fuzzy."""
    fuzzy_m = worst_drop_miss_m(law_settings)
    return CaseRow(
        FUZZY_DROP, "copes (6.2)", round(fuzzy_m, 3), abs(fuzzy_m) <= FUZZY_MISS_M, f"within {FUZZY_MISS_M} m"
    )


def drop_rows() -> tuple[CaseRow, ...]:
    """Figure 10."""
    pid_m = drop_miss_m(PID)
    least_m, most_m = PID_MISSES_M
    return (
        fuzzy_drop_row(),
        CaseRow(
            "descent before the mark, PID in 85 s, m past it",
            PAPERS_MISS_M,
            round(pid_m, 3),
            least_m <= abs(pid_m) <= most_m,
            f"off by {least_m} to {most_m} m"
            + ("" if least_m <= abs(pid_m) <= most_m else f"; missed: {WHY_EXACT}"),
        ),
    )


def hold_row(hops: Rows, fuzzy: ScatteredStops) -> CaseRow:
    """What the rows on the PID depend on: how long it keeps a notch, which the paper does not print."""
    ours: dict[str, object] = {}
    for hold_s in HOLDS_S:
        own = settings(pid=Pid(notch_hold_s=hold_s))
        found = scattered_stops(PID, hops, own)
        ours[f"{hold_s:g} s"] = {
            "sigma_m": round(found.sigma_m, 3),
            "fuzzy_over_it": round(fuzzy.sigma_m / found.sigma_m, 2),
            "descent_m": round(drop_miss_m(PID, own), 2),
        }
    return CaseRow(
        "the same by how long the PID keeps a notch",
        f"a third, and {PAPERS_MISS_M} m",
        ours,
        True,
        f"{Pid().notch_hold_s:g} s is assumed, and {BRAKE_SETTLES_S:g} s, after which a notch has shown what it does"
        " (table 1's dead time and lag), changes little; at 1 s it comes after the fact and the stops fall apart",
        judged=False,
    )


def scatter_rows(fuzzy: ScatteredStops, pid: ScatteredStops) -> tuple[CaseRow, ...]:
    """What is quoted from reference 8."""
    sigma, changes = fuzzy.sigma_m / pid.sigma_m, fuzzy.brake_changes / pid.brake_changes
    why = ""
    if not np.isfinite(pid.sigma_m):
        why = "; missed: no PID that stops"
    elif not sigma <= SIGMA_SHARE:
        why = f"; missed {sigma / SIGMA_SHARE:.0f} times: {WHY_EXACT}"
    return (
        CaseRow(
            "sigma of the stops, fuzzy over PID",
            "a third",
            round(sigma, 3),
            not why,
            f"at most a third{why}",
        ),
        CaseRow(
            "changes of the brake notch a stop, fuzzy over PID",
            "half",
            round(changes, 3),
            changes <= CHANGES_SHARE,
            "at most half",
        ),
        none_of("scattered stops in which supervision had to brake, fuzzy", fuzzy.interventions),
    )


def _figure(name: str, found: ScatteredStops) -> UnjudgedFigure:
    return UnjudgedFigure(
        f"{found.stops} stops, {name}",
        {
            "mean_m": round(found.mean_m, 3),
            "sigma_m": round(found.sigma_m, 3),
            "largest_m": round(found.largest_m, 3),
            "brake_changes": round(found.brake_changes, 2),
            "interventions": found.interventions,
        },
        "bias, standard deviation and greatest miss, changes of the brake notch a stop, supervision's brakes",
    )


def figures(hops: Rows, fuzzy: ScatteredStops, pid: ScatteredStops) -> tuple[UnjudgedFigure, ...]:
    """The stops in full, other orders, and both laws with parts taken away."""
    without_parts = tuple(
        figure
        for name, own in TAKEN_AWAY.items()
        for figure in (
            _figure(f"fuzzy without {name}", scattered_stops(FUZZY, hops, settings(fuzzy=own))),
            UnjudgedFigure(
                f"descent before the mark, fuzzy without {name}, worst of five orders, m past it",
                round(worst_drop_miss_m(settings(fuzzy=own)), 3),
                "what the whole law's figure owes to it",
            ),
        )
    )
    other_pids = tuple(
        figure
        for name, own in OTHER_PIDS.items()
        for figure in (
            _figure(f"PID {name}", scattered_stops(PID, hops, settings(pid=own))),
            UnjudgedFigure(
                f"descent before the mark, PID {name}, m past it",
                round(drop_miss_m(PID, settings(pid=own)), 3),
                f"the paper's is {PAPERS_MISS_M} m off; its gains are not printed",
            ),
        )
    )
    orders = ", ".join(f"{order_s:g}" for order_s in ORDERS_S)
    misses = tuple(
        UnjudgedFigure(
            f"descent before the mark, {name}, m past it in {orders} s",
            [round(miss_m, 3) for miss_m in drop_misses_m(law)],
            "the row above has the 85 s of figure 9",
        )
        for name, law in (("fuzzy", FUZZY), ("PID", PID))
    )
    return (_figure("fuzzy", fuzzy), _figure("PID", pid), *misses, *without_parts, *other_pids)


def _set_to(law: str, given: Record) -> tuple[Parameter, ...]:
    """A law's settings, with what the file format says of their origin, or of their meaning."""
    found: list[Parameter] = []
    for key, field in type(given).model_fields.items():
        origin = origin_of(field) or str(field.description)
        found.append(Parameter(f"law.{law}.{key}", getattr(given, key), "", origin))
    return tuple(found)


def parameters(options: Options, stops: int) -> tuple[Parameter, ...]:
    """What the paper leaves open, with both laws' settings."""
    laws = (*_set_to(FUZZY, PredictiveFuzzy()), *_set_to(PID, Pid()))
    return (
        Parameter("descent", DROP_PERMILLE, "permille", "6.1; the unit's map is level"),
        Parameter("begins before the mark", DROP_BEFORE_M, "m", "6.1"),
        Parameter("ordered running time", NOMINAL_S, "s", "figure 9; figure 10 does not say"),
        Parameter("scattered stops", stops, "", "assumed: as many as make a sigma sure to 3 %"),
        Parameter("seed", options.seed, "", "of brakes and gradients, each drawn for itself"),
        Parameter("brake", BRAKE_SPREAD, "share", "assumed: evenly within +-; reference 8 is not at hand"),
        Parameter(
            "gradient",
            GRADIENT_SPREAD_PERMILLE,
            "permille",
            "assumed: evenly within +- of what the unit believes; the paper's own range of gradients (6.1)",
        ),
        *laws,
    )


REMARKS: Final = (
    "The text is damaged: TA is printed with V_s where V_t must stand, GG and GA have X_t for the mark and for "
    "what is allowed, CG and CB would find a greater change the more comfortable one right after it. Settled by "
    "what each rule must do; the settings above say how.",
    "X_s grows with the way left: a prediction that a later change of one notch can still mend is a good one.",
    "R is RT stays once the stop has begun, and T-2.2 is for a brake that is not yet on: read to the letter, it "
    "would take every stop back to the first notch.",
    "The PID's gains were fixed on the nominal case before (papers.pid_tuning). Where it copes with the"
    " descent and with scattered brakes, the rows that expect the paper's error of it, and three times the spread"
    " of fuzzy, are missed: it changes its notch twice a second with exact sensors until the train stands, while"
    " fuzzy leaves what X_s allows. Between 0.8 and 1 s of keeping a notch its spread grows many times over (row"
    " above), so the paper's third lies on a cliff; its runs (figure 10) are not in the text that there is, and no"
    " interval was chosen by the row. What a softer PID makes is told below.",
    "Both laws run through the kernel's step, as on the line; sensors are exact.",
)


def experiment(options: Options) -> Findings:
    """Run the descent and the scattered stops."""
    stops = STOPS_QUICK if options.quick else STOPS
    hops = scattered_hops(options.seed, stops)
    fuzzy, pid = scattered_stops(FUZZY, hops), scattered_stops(PID, hops)
    return Findings(
        (*drop_rows(), *scatter_rows(fuzzy, pid), hold_row(hops, fuzzy)),
        parameters(options, stops),
        REMARKS,
        () if options.quick else figures(hops, fuzzy, pid),
    )


reproduce: Final = Specification(
    NAME,
    "Stops on brakes and gradients that are not as believed (Yasunobu and others, figure 10 and reference 8)",
    experiment,
    NullMethod(
        f"fuzzy without {ESTIMATE}",
        (FUZZY_DROP,),
        lambda _options: [fuzzy_drop_row(settings(fuzzy=TAKEN_AWAY[ESTIMATE]))],
    ),
    TABLE_1,
    "A short slice: fewer stops, nothing of what is told and not judged.",
)
