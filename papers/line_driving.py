"""`branchline reproduce line-driving`: a weekday of the Karasuyama line by every driving law, equally punctual.

Each law of the table drives all trains of the same day by the code of `branchline run`. How early they aim to arrive
(`unit.time_margin_s`, one figure a law and day) is set anew until they arrive as early as those of every other law, so
that no law saves by coming late. Energy is traction less what came back, without auxiliaries, which do not depend on
how a train is driven.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import fmean, pstdev
from typing import Any, Final

import polars as pl

from onboard.driving.laws.optimal import optimal
from onboard.driving.laws.table import LAW_NAMES, LAWS
from papers.parameter_sets import LINE
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.specification import Findings, Specification
from scenario.law_choice import driven_by
from scenario.scenario import Scenario, load_scenario
from study.measures.driving import driving_sums
from study.measures.least_energy import Allowed, HopLeast, Key, LeastEnergy, least_of_hops
from study.record.driving import DrivenHop
from study.record.figure import rows_in
from study.report.data import ReportedRun as RunSeen
from study.report.hop import write_hop
from study.runner.run import CarrierKind, FinishedRun, PartyLink, execute

SCENARIO: Final = "karasuyama_weekday"
SLICE: Final = "karasuyama_round_trip"
SHOWN: Final = ("322M", "TAK")  # the hop of the picture
PRESENT: Final = LAW_NAMES[0]
BEST: Final = optimal.__name__
ABOVE: Final = "as driven, above the lower bound of the same hops in the same times"
EARLY_S: Final = 10.0
WITHIN_S: Final = 0.3
ROOM_S: Final = 15.0
LATE_S: Final = 1.0
ROUNDS: Final = 6
MARGIN_MAX_S: Final = 60.0
DRIVERS_DAYS: Final = 5
ABOVE_BOUND_PERCENT: Final = 3.0


@dataclass(frozen=True, slots=True)
class LawDay:
    """A day of one law, with the margin that its trains aimed at and in how many runs that was found."""

    law: str
    seed: int
    time_margin_s: float
    runs: int
    run: FinishedRun
    hops: tuple[DrivenHop, ...]

    @property
    def early_s(self) -> tuple[float, ...]:
        """Seconds before the time at each arrival of the hops that leave a law room, in order."""
        room = with_room(self.run)
        return tuple(-hop.late_s for hop in self.hops if key_of(hop) in room and hop.late_s is not None)

    @property
    def mean_early_s(self) -> float:
        """Mean of those; minus infinity where no train arrived."""
        return fmean(self.early_s) if self.early_s else float("-inf")

    @property
    def late(self) -> frozenset[Key]:
        """Hops of which the train came later than the plan allows, or never."""
        late_s = {key_of(hop): hop.late_s for hop in self.hops if hop.late_s is not None}
        never = with_room(self.run) - late_s.keys()
        return frozenset(key for key, by_s in late_s.items() if by_s > LATE_S) | never

    def least_of_hops(self, allowed: Allowed, time_s: dict[Key, float] | None = None) -> tuple[HopLeast, ...]:
        """The hops beside what they could have cost at the least."""
        return least_of_hops(self.run.scenario.setup, self.run.result, self.hops, allowed, time_s)


def key_of(hop: DrivenHop) -> Key:
    """What names a hop of the timetable."""
    return hop.train, hop.from_station, hop.to_station


def rooms_s(run: FinishedRun) -> dict[Key, float]:
    """How much faster than planned a train can run each hop with passengers, as far below the limits as driven, s."""
    room = (pl.col("planned_s") - pl.col("attainable_s")).alias("room_s")
    rows = run.tables.margins.filter(pl.col("revenue")).select("train", "from_station", "to_station", room)
    return {(train, low, high): room_s for train, low, high, room_s in rows.drop_nulls().iter_rows()}


def with_room(run: FinishedRun) -> frozenset[Key]:
    """Those with `ROOM_S` of it."""
    return frozenset(key for key, room_s in rooms_s(run).items() if room_s >= ROOM_S)


def drive(scenario: Scenario, law: str, time_margin_s: float) -> FinishedRun:
    """The scenario's day with every stock driven by one law that aims to arrive so much before the time."""
    setup = scenario.setup
    unit = setup.unit.model_copy(update={"time_margin_s": time_margin_s})
    changed = replace(driven_by(setup, law), unit=unit)
    return execute(replace(scenario, setup=changed), PartyLink.SIMULATED, carrier=CarrierKind.PLAIN)


def day_of(scenario: Scenario, law: str, time_margin_s: float) -> LawDay:
    """One day of a law at a margin."""
    run = drive(scenario, law, time_margin_s)
    return LawDay(law, scenario.setup.seed, time_margin_s, 1, run, rows_in(DrivenHop, run.tables.driving))


def punctual_day(scenario: Scenario, law: str) -> LawDay:
    """A day of a law with the margin by which its trains arrive `EARLY_S` before the time, in the mean.

    The margin is moved by what is missing, from the scenario's own on; between two that came out on either side, to
    where it would lie on a straight line. Of at most `ROUNDS` runs the nearest counts: a law of rules may leap over it.
    """
    days: list[LawDay] = []
    margin_s = scenario.setup.unit.time_margin_s
    while len(days) < ROUNDS:
        days.append(day_of(scenario, law, margin_s))
        if not days[-1].early_s or abs(days[-1].mean_early_s - EARLY_S) <= WITHIN_S:
            break
        margin_s = next_margin_s(days)
    return replace(min(days, key=lambda day: abs(day.mean_early_s - EARLY_S)), runs=len(days))


def next_margin_s(days: Sequence[LawDay]) -> float:
    """The margin to be tried after these days, s."""
    late = [day for day in days if day.mean_early_s < EARLY_S]
    early = [day for day in days if day.mean_early_s > EARLY_S]
    last = days[-1]
    if not late or not early:
        return min(max(last.time_margin_s + EARLY_S - last.mean_early_s, 0.0), MARGIN_MAX_S)
    low = max(late, key=lambda day: (day.mean_early_s, day.time_margin_s))
    high = min(early, key=lambda day: (day.mean_early_s, day.time_margin_s))
    share = (EARLY_S - low.mean_early_s) / (high.mean_early_s - low.mean_early_s)
    return low.time_margin_s + share * (high.time_margin_s - low.time_margin_s)


def told_of(day: LawDay) -> dict[str, Any]:
    """The figures of a day."""
    whole = driving_sums(day.hops)
    if whole is None:
        return {}
    figures = {name: _rounded(value) for name, value in whole.items() if name != "early_s"}
    early = day.early_s
    return {
        **figures,
        "early_s": _rounded(day.mean_early_s),
        "early_s_sigma": _rounded(pstdev(early)) if early else None,
        "late_hops": len(day.late),
        "time_margin_s": _rounded(day.time_margin_s),
        "runs": day.runs,
    }


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 3)


def punctuality_rows(days: Sequence[LawDay]) -> tuple[CaseRow, ...]:
    """Whether the days are equally punctual, and whole: in the mean law by law, then where which law is late."""
    means = tuple(
        CaseRow(
            f"{day.law}: the day, equally punctual in the mean",
            None,
            told_of(day),
            abs(day.mean_early_s - EARLY_S) <= WITHIN_S,
            f"{EARLY_S:g} s before the time, within {WITHIN_S:g} s, on hops of passengers with {ROOM_S:g} s of room",
        )
        for day in days
    )
    later = {day.law: later_than(day, days[0]) for day in days[1:]}
    broken = {day.law: day.run.broken[:3] for day in days if day.run.broken}
    return (
        *means,
        CaseRow(
            f"hops on which a law is late and {days[0].law} is not, s late",
            None,
            {law: hops for law, hops in later.items() if hops},
            not any(later.values()),
            f"none, by more than {LATE_S:g} s: no law may save by coming late{hops_too_tight(days)}",
        ),
        CaseRow(
            "everyone arrived and no invariant broken", None, broken or True, not broken, "with every law"
        ),
    )


def hops_too_tight(days: Sequence[LawDay]) -> str:
    """What the hops on which a law is later than the first have in common, for the row that is missed by them."""
    missed = {key for day in days[1:] for key in day.late - days[0].late}
    if not missed:
        return ""
    room_s = rooms_s(days[0].run)
    most_s = max((room_s[key] for key in missed if key in room_s), default=0.0)
    return (
        f"; missed on {len(missed)} hops, on which a train can run at most {most_s:.1f} s faster than planned"
    )


def later_than(day: LawDay, present: LawDay) -> dict[str, float]:
    """By how much a law is late on the hops on which the present law is not, s."""
    late_s = {key_of(hop): hop.late_s for hop in day.hops}
    return {" ".join(key): round(late_s[key] or 0.0, 1) for key in sorted(day.late - present.late)}


def above_row(least: LeastEnergy) -> CaseRow:
    """How far the law of least energy, or another in its place, is above the bound of what it drove."""
    above = least.above_bound_percent
    criterion = f"at most {ABOVE_BOUND_PERCENT:g} %: notches, brake steps, telegrams and stops in it"
    return CaseRow(f"{BEST}: {ABOVE}", None, f"{above:.2f} %", above <= ABOVE_BOUND_PERCENT, criterion)


def bound_rows(days: Sequence[LawDay], least: dict[str, LeastEnergy]) -> tuple[CaseRow, ...]:
    """How far the law of least energy is above its own bound, and whether any law takes less than it."""
    if BEST not in least:
        return ()
    taken = {day.law: sum(hop.running_kwh for hop in day.hops) for day in days}
    cheapest = min(taken, key=lambda law: taken[law])
    return (
        above_row(least[BEST]),
        CaseRow(
            "the law that takes least on this day",
            None,
            cheapest,
            cheapest == BEST,
            f"{BEST}",
        ),
    )


def standing_figures(scenario: Scenario) -> tuple[UnjudgedFigure, ...]:
    """Where driving stands: the present law as shipped, and what the same times, or all of them, would allow."""
    day = day_of(scenario, PRESENT, scenario.setup.unit.time_margin_s)
    allowed = Allowed.as_units_drive(scenario.setup)
    margins = day.run.tables.margins
    whole_s = {
        (t, a, b): s
        for t, a, b, s in margins.select("train", "from_station", "to_station", "planned_s").iter_rows()
    }
    same, whole = (
        LeastEnergy.sum_of(day.least_of_hops(allowed)),
        LeastEnergy.sum_of(day.least_of_hops(allowed, whole_s)),
    )
    return (
        UnjudgedFigure(
            "the present law as shipped", told_of(day), f"{PRESENT}, time_margin_s as in the scenario"
        ),
        UnjudgedFigure(
            "what an optimum saves at the same running times, %",
            round(100.0 * (1.0 - same.least_kwh / same.running_kwh), 1),
            f"{same.running_kwh:.1f} kWh as driven on {same.hops} hops, {same.least_kwh:.1f} at the least",
        ),
        UnjudgedFigure(
            "what it saves using all of the time, %",
            round(100.0 * (1.0 - whole.least_kwh / whole.running_kwh), 1),
            f"{whole.least_kwh:.1f} kWh, from the planned departure to the latest arrival that keeps the plan",
        ),
    )


def room_figure(day: LawDay, allowed: Allowed) -> UnjudgedFigure:
    """How far a law is above its bound where the plan leaves room, and where it leaves none."""
    room, found = with_room(day.run), day.least_of_hops(allowed)
    parts = {
        f"with {ROOM_S:g} s of room": [hop for hop in found if hop.key in room],
        "with less": [hop for hop in found if hop.key not in room],
    }
    value = {
        name: {
            "hops": len(part),
            "above_bound_percent": _rounded(LeastEnergy.sum_of(part).above_bound_percent),
        }
        for name, part in parts.items()
        if part
    }
    meaning = "a hop that is run as fast as it can be leaves nothing to choose; there a second is worth most"
    return UnjudgedFigure(f"{day.law}: above its bound, by room", value, meaning)


def saving_figures(days: Sequence[LawDay], least: dict[str, LeastEnergy]) -> tuple[UnjudgedFigure, ...]:
    """Each law beside the present one and beside its own bound."""
    present = driving_sums(days[0].hops)
    figures: list[UnjudgedFigure] = []
    for day in days:
        whole = driving_sums(day.hops)
        if whole is None or present is None:
            continue
        beside = least[day.law]
        figures.append(
            UnjudgedFigure(
                f"{day.law}: against {PRESENT}",
                {
                    "traction_percent": round(
                        100.0 * (whole["traction_kwh"] / present["traction_kwh"] - 1.0), 1
                    ),
                    "net_percent": round(100.0 * (whole["running_kwh"] / present["running_kwh"] - 1.0), 1),
                    "above_bound_percent": round(beside.above_bound_percent, 1),
                },
                "net: traction less what came back; bound: of the same hops in the same times, as units may drive",
            )
        )
    return tuple(figures)


def drivers_figures(days: Sequence[LawDay]) -> tuple[UnjudgedFigure, ...]:
    """The spread between drivers of days that are equally punctual, each beside the bound of what they drove."""
    if not days:
        return ()
    above: dict[str, float] = {}
    for day in days:
        found = day.least_of_hops(Allowed.as_units_drive(day.run.scenario.setup))
        units = {hop.train: hop.unit for hop in day.hops}
        for unit in sorted(set(units.values())):
            own = LeastEnergy.sum_of(hop for hop in found if units[hop.train] == unit)
            above[f"seed {day.seed} {unit}"] = round(own.above_bound_percent, 1)
    kwh = [sum(hop.running_kwh for hop in day.hops) for day in days]
    ratios = [100.0 + percent for percent in above.values()]
    spread = 100.0 * (max(ratios) - min(ratios)) / fmean(ratios)
    return (
        UnjudgedFigure(
            f"{days[0].law}: net kWh of a day, by seed",
            {day.seed: round(value, 1) for day, value in zip(days, kwh, strict=True)},
            "each seed draws four drivers, and the loads of the trains anew",
        ),
        UnjudgedFigure(
            f"{days[0].law}: above the bound, %, by driver", above, "the bound has the loads in it"
        ),
        UnjudgedFigure(
            f"{days[0].law}: from the thriftiest driver to the other end, % of their mean",
            round(spread, 1),
            f"{len(above)} drivers; about 20 % between drivers is known from practice",
        ),
    )


def parameters(scenario: Scenario, days: Sequence[LawDay]) -> tuple[Parameter, ...]:
    """What was chosen, and why."""
    return (
        Parameter(
            "scenario",
            scenario.id,
            "",
            "the line's own day, on the plain carrier: kernel and units as on SUMO",
        ),
        Parameter("laws", ", ".join(day.law for day in days), "", "every law of the table of laws"),
        Parameter("arrival before the time", EARLY_S, "s", "assumed: what units aim at as shipped"),
        Parameter("room that a hop must leave", ROOM_S, "s", "assumed: that, and 5 s to choose in"),
        Parameter("late", LATE_S, "s", "after the latest arrival that keeps the plan"),
        Parameter("days of drivers", DRIVERS_DAYS, "", "seeds from --seed on, four drivers each"),
    )


REMARKS: Final = (
    "The margin that trains aim at is the only thing that is set for each law; the figures say what it came to.",
    "Hops planned faster than a train can run are late by every law; their energy counts, their arrival does not.",
    "The bound is of the same trains, loads and running times, as far below the limits and braked as gently as"
    " units drive; it knows no notches, no dead times and no telegrams.",
)


def scenario_of(options: Options) -> Scenario:
    """The day, or a round trip of it."""
    return load_scenario(SLICE if options.quick else SCENARIO, options.seed)


def experiment(options: Options) -> Findings:
    """Every law on the day of `seed`, at equal punctuality; the laws with drawn drivers on further days."""
    scenario = scenario_of(options)
    days = [punctual_day(scenario, law) for law in LAW_NAMES]
    allowed = Allowed.as_units_drive(scenario.setup)
    least = {day.law: LeastEnergy.sum_of(day.least_of_hops(allowed)) for day in days}
    drivers: list[UnjudgedFigure] = []
    for law in (law.name for law in LAWS if law.drawn):  # no two drivers are alike
        seeds = () if options.quick else range(options.seed + 1, options.seed + DRIVERS_DAYS)
        more = [punctual_day(load_scenario(SCENARIO, seed), law) for seed in seeds]
        drivers += drivers_figures([*(day for day in days if day.law == law), *more])
    best = [room_figure(day, allowed) for day in days if day.law == BEST]
    return Findings(
        (*punctuality_rows(days), *bound_rows(days, least)),
        parameters(scenario, days),
        REMARKS,
        (*standing_figures(scenario), *saving_figures(days, least), *best, *drivers),
        [above_row(least[PRESENT])],
        lambda folder: write_hop([seen(day.run) for day in days], SHOWN, folder),
    )


def seen(run: FinishedRun) -> RunSeen:
    """A run as its picture needs it."""
    return RunSeen(run.scenario.setup.line, run.scenario.setup.timetable, run.tables)


def by_present(options: Options) -> Sequence[CaseRow]:
    """The present law alone, as punctual."""
    scenario = scenario_of(options)
    day = punctual_day(scenario, PRESENT)
    return [above_row(LeastEnergy.sum_of(day.least_of_hops(Allowed.as_units_drive(scenario.setup))))]


reproduce: Final = Specification(
    "line-driving",
    "A weekday of the Karasuyama line by every driving law, equally punctual",
    experiment,
    NullMethod(f"the law {PRESENT} in place of {BEST}", (ABOVE,), by_present),
    LINE,
    "A short slice: one round trip instead of the day, and one day of drivers.",
)
