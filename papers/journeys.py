"""`branchline reproduce journeys`: whole runs of several hops, their time shared in proportion and where it saves most.

Trains of the Karasuyama line, from end to end, with windows free (the ends and the least dwell alone bind), as
published, and as published to the minute (a time in whole minutes hides up to 59 s; none where trains can meet); and
the tracks of TTOBench that have several stops. There is no published result to compare with: what is judged is that
windows are kept, that the plan lies within 1 % of a bound proven for all journeys, and that it is no dearer than in
proportion.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes

from network.model import Direction
from network.units import J_PER_KWH
from onboard.driving.planner.windows import journey_stops
from onboard.driving.planner.wish import Style
from onboard.mission import Mission
from papers.charts import ChartPage, Panel
from papers.parameter_sets import NotDriven
from papers.reference_data import reference_folder
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.specification import Findings, Specification
from papers.ttobench_files import course_of as bench_course
from papers.ttobench_files import read_track, read_train
from scenario.scenario import load_scenario
from simulation.setup import Setup
from simulation.world.roster import drawn_up
from study.measures.journeys import GAP_ENOUGH, JourneyEnergies, SampledHop, SharedTime, journey_energies
from study.measures.least_energy import Allowed, course_of
from study.measures.running_times import planned_hops
from study.report.style import INK, PALE, RED, TRACTION
from vehicle.optimum.coast import coast_run, cruise_run
from vehicle.optimum.journey import ANY_TIME, JourneyStop, TimeWindow, WindowMissed

SCENARIO: Final = "karasuyama_weekday"
HIDDEN_S: Final = 59.0
TRACKS: Final = (
    ("CH_Stadelhofen_Altstetten", "CH_Stadler_KISS_SBB"),
    ("CN_Songjiazhuang_Yizhuang", "CN_Beijing_Subway"),
    ("00_reference", "NL_Intercity_VIRM6"),
)
FACTORS: Final = (1.05, 1.1, 1.2)
GAP_MAX_PERCENT: Final = 1.0
ROUNDING: Final = 1e-6
WIDTH: Final = 0.38  # of a bar in the chart
MOVED_S: Final = 0.1  # journeys that differ by less are not drawn
CRITERION: Final = f"windows kept; within {GAP_MAX_PERCENT:g} % of the bound; no dearer than in proportion"


@dataclass(frozen=True, slots=True)
class JourneyCase:
    """One journey with one set of windows, and what came of it; None: its windows cannot be kept, `why` says where."""

    name: str
    hops: tuple[SampledHop, ...]
    stops: tuple[JourneyStop, ...]
    energies: JourneyEnergies | None
    why: str = ""

    @property
    def moved_s(self) -> float:
        """The most that the time of a hop differs between the two ways to share; 0 where nothing was solved."""
        if self.energies is None:
            return 0.0
        proportional, optimal = self.energies.proportional.journey, self.energies.optimal.journey
        times = zip(proportional.running_s, optimal.running_s, strict=True)
        return max(abs(one - other) for one, other in times)


def solved_case(name: str, hops: Sequence[SampledHop], stops: Sequence[JourneyStop]) -> JourneyCase:
    """The case with its journey shared in all three ways."""
    try:
        return JourneyCase(name, tuple(hops), tuple(stops), journey_energies(hops, stops))
    except WindowMissed as missed:
        return JourneyCase(name, tuple(hops), tuple(stops), None, str(missed))


def as_laid_down(case: JourneyCase) -> JourneyCase:
    """The case as if every hop in its standard time were the plan."""
    found = case.energies
    return case if found is None else replace(case, energies=replace(found, optimal=found.standard))


def missed_by_s(stops: Sequence[JourneyStop], shared: SharedTime) -> float:
    """By how much the worst window or least dwell is missed, s."""
    worst = 0.0
    for stop, times in zip(stops, shared.journey.stops, strict=True):
        for time_s, window in ((times.arrival_s, stop.arrival), (times.departure_s, stop.departure)):
            if time_s is not None:
                worst = max(worst, window.earliest_s - time_s, time_s - window.latest_s)
        if times.arrival_s is not None and times.departure_s is not None:
            worst = max(worst, times.arrival_s + stop.dwell_min_s - times.departure_s)
    return worst


# trains of the line -------------------------------------------------------------------------------------------------


def line_cases(setup: Setup, *, quick: bool) -> Iterator[JourneyCase]:
    """The first train of the day in each direction: windows free, as published, and published to the minute."""
    duties = sorted(
        (d for of in drawn_up(setup, setup.line).values() for d in of), key=lambda duty: duty.enter_s
    )
    missions = [duty.mission for duty in duties if duty.mission.revenue]
    first = {mission.direction: mission for mission in reversed(missions)}
    for direction in (Direction.DOWN,) if quick else (Direction.DOWN, Direction.UP):
        yield from _train_cases(setup, first[direction])


def _train_cases(setup: Setup, mission: Mission) -> Iterator[JourneyCase]:
    allowed, load = Allowed.as_units_drive(setup), setup.load.load_share_mean
    hops = tuple(
        SampledHop(f"{hop.here.station_id}-{hop.there.station_id}", course_of(setup, hop, load, allowed))
        for hop in planned_hops(setup)
        if hop.mission == mission
    )
    published = published_stops(setup, mission, 0.0)
    yield solved_case(f"{mission.number}, windows free", hops, ends_alone(published))
    yield solved_case(f"{mission.number}, as published", hops, published)
    yield solved_case(
        f"{mission.number}, published to the minute", hops, published_stops(setup, mission, HIDDEN_S)
    )


def published_stops(setup: Setup, mission: Mission, tolerance_s: float) -> tuple[JourneyStop, ...]:
    """The windows from the train's first station to its last, without the reserve that units keep before each."""
    stations = [i for i, target in enumerate(mission.targets) if target.station_id is not None]
    stops = journey_stops(mission, stations[0], 0.0, setup.timetable.head.dwell_min_s, 0.0, tolerance_s)
    return stops[: len(stations)]


def ends_alone(stops: Sequence[JourneyStop]) -> tuple[JourneyStop, ...]:
    """The same journey with the windows of its ends alone."""
    inner = (replace(stop, arrival=ANY_TIME, departure=ANY_TIME) for stop in stops[1:-1])
    return (stops[0], *inner, stops[-1])


# tracks of TTOBench -------------------------------------------------------------------------------------------------


def track_cases(folder: Path) -> Iterator[JourneyCase]:
    """Tracks with several stops, each with a train of its own kind, at several times the least time in all."""
    for track_id, train_id in TRACKS:
        track = read_track(folder / "tracks" / f"{track_id}.json")
        train = read_train(folder / "trains" / f"{train_id}.json")
        hops = [
            SampledHop(
                f"{begin / 1e3:.1f}-{end / 1e3:.1f}",
                bench_course(track, train, perfect=False, from_m=begin, to_m=end),
            )
            for begin, end in pairwise(track.stops_m)
        ]
        least_s = sum(hop.least_s for hop in hops)
        middle = [JourneyStop(f"{at / 1e3:.1f} km") for at in track.stops_m[1:-1]]
        for factor in FACTORS:
            end = JourneyStop("end", TimeWindow(latest_s=factor * least_s))
            stops = (JourneyStop("start", departure=TimeWindow(0.0, 0.0)), *middle, end)
            yield solved_case(f"{track_id}, {train_id}, {factor:g} of {least_s:.0f} s", hops, stops)


# what is shown ------------------------------------------------------------------------------------------------------


def row_of(case: JourneyCase) -> CaseRow:
    """The case's figures, judged."""
    found = case.energies
    if found is None:
        return CaseRow(case.name, None, f"not possible: {case.why}", passed=False, criterion=CRITERION)
    kept = all(
        missed_by_s(case.stops, shared) <= ROUNDING
        for shared in (found.standard, found.proportional, found.optimal)
    )
    dearer_j = found.optimal.energy_j - found.proportional.energy_j
    ours = {
        "proportional_kwh": _kwh(found.proportional.energy_j),
        "optimal_kwh": _kwh(found.optimal.energy_j),
        "bound_kwh": _kwh(found.bound_j),
        "saving_percent": round(found.saving_percent, 2),
        "gap_percent": round(found.gap_percent, 3),
    }
    passed = kept and found.gap_percent <= GAP_MAX_PERCENT and dearer_j <= GAP_ENOUGH * abs(found.bound_j)
    return CaseRow(case.name, None, ours, passed, CRITERION)


def figures_of(case: JourneyCase) -> Iterator[UnjudgedFigure]:
    """Where the seconds go: each hop's times and what it saves against its share in proportion."""
    found = case.energies
    if found is None:
        return
    standard = found.standard
    yield UnjudgedFigure(
        f"{case.name}: margin at the end",
        {"kwh": _kwh(standard.energy_j), "early_s": round(_end_s(found.optimal) - _end_s(standard), 1)},
        "every hop in its standard time: the energy, and how much sooner the train is there",
    )
    yield UnjudgedFigure(
        f"{case.name}: styles",
        {f"{style.value}_kwh": _kwh(styled_j(case, found.optimal, style)) for style in Style},
        "the same times, each hop at one speed, at one speed with one place to shut off, and by the optimum",
    )
    ways = (found.proportional, found.optimal)
    for i, hop in enumerate(case.hops):
        proportional_s, allocated_s = (shared.journey.running_s[i] for shared in ways)
        yield UnjudgedFigure(
            f"{case.name}: {hop.name}",
            {
                "least_s": round(found.least_s[i], 1),
                "standard_s": round(standard.journey.running_s[i], 1),
                "proportional_s": round(proportional_s, 1),
                "allocated_s": round(allocated_s, 1),
                "saved_kwh": round((ways[0].hops_j[i] - ways[1].hops_j[i]) / J_PER_KWH, 3),
                "price_kw": round(found.optimal.journey.prices_w[i] / 1e3, 2),
            },
            "where the seconds go; the price is what one more would save",
        )


def styled_j(case: JourneyCase, shared: SharedTime, style: Style) -> float:
    """Energy of a journey's times when every hop is run in a style, J."""
    if style is Style.OPTIMAL:
        return shared.energy_j
    run = cruise_run if style is Style.HOLD else coast_run
    times = zip(case.hops, shared.journey.running_s, strict=True)
    return sum(run(hop.course, max(time_s, hop.least_s)).energy_j for hop, time_s in times)


def _end_s(shared: SharedTime) -> float:
    return shared.journey.stops[-1].arrival_s or 0.0


def _kwh(energy_j: float) -> float:
    return round(energy_j / J_PER_KWH, 3)


def parameters(setup: Setup) -> tuple[Parameter, ...]:
    """What was chosen, and why."""
    return (
        Parameter("scenario", setup.name, "", "the line's weekday; the first train of each direction"),
        Parameter("load", setup.load.load_share_mean, "", "the scenario's mean"),
        Parameter("below the limits", setup.driving.driving_margin_mps, "m/s", "as units drive"),
        Parameter("braking", setup.driving.stop_deceleration_mps2, "m/s^2", "as units brake"),
        Parameter("dwell", setup.timetable.head.dwell_min_s, "s", "the timetable's least"),
        Parameter(
            "tracks",
            "release 1.5, with their files' efficiencies",
            "",
            "TTOBench; dwell apart, as windows are free",
        ),
        Parameter(
            "time on tracks",
            ", ".join(f"{factor:g}" for factor in FACTORS),
            "of the least",
            "as its single runs",
        ),
        Parameter(
            "hidden by whole minutes", HIDDEN_S, "s", "assumed: times are cut to the minute, not rounded"
        ),
    )


REMARKS: Final = (
    "There is no published result of these journeys: nothing stands in the paper's column.",
    "Each hop is run by the optimum of its time, so only the sharing differs. Energies are at the wire without"
    " auxiliaries, which draw the same whether the train runs or stands.",
    "Time in proportion lies within 1 % of the bound on the line too: where it is shared is worth little there, that it"
    " is used is worth much, as the null method shows.",
    "As published every departure is fixed, so each hop has its own time and nothing can be shared.",
)


def write_seconds(cases: Sequence[JourneyCase], folder: Path) -> tuple[Path, ...]:
    """Draw the cases in which there was anything to share below `folder`; the files written."""
    rows = [[seconds_panel(case)] for case in cases if case.moved_s > MOVED_S]
    page = ChartPage("journeys", (9.0, 2.6 * len(rows)), rows, shared=False)
    return page.write(folder) if rows else ()


def seconds_panel(case: JourneyCase) -> Panel:
    """What each hop gets over its least time, in proportion and where it saves most, and what that saves."""
    found = case.energies
    assert found is not None
    ways = {"in proportion": (found.proportional, PALE), "where it saves most": (found.optimal, TRACTION)}
    over_s = [np.array(way.journey.running_s) - np.array(found.least_s) for way, _ in ways.values()]
    saved_kwh = (np.array(found.proportional.hops_j) - np.array(found.optimal.hops_j)) / J_PER_KWH

    def bars(axes: Axes) -> None:
        at = np.arange(len(case.hops), dtype=np.float64)
        for side, seconds, (label, (_, colour)) in zip((-0.5, 0.5), over_s, ways.items(), strict=True):
            axes.bar(at + side * WIDTH, seconds, WIDTH, color=colour, label=label)
        for x, top_s, kwh in zip(at, np.maximum(*over_s), saved_kwh, strict=True):
            colour = INK if kwh >= 0 else RED
            axes.annotate(f"{kwh:+.2f}", (x, top_s), ha="center", va="bottom", fontsize=7, color=colour)
        axes.set_xticks(at, [hop.name for hop in case.hops], fontsize=7.5)

    title = f"{case.name}: {found.saving_percent:.2f} % saved; figures are kWh saved"
    limits = (0.0, 1.2 * float(np.max(over_s)))
    return Panel("", "over the least time, s", (), title, y_limits=limits, grid=False, also=bars)


def experiment(options: Options) -> Findings:
    """All cases; `options.quick`: the first train of the line alone."""
    library = None if options.quick else reference_folder(options, "ttobench")
    setup = load_scenario(SCENARIO, options.seed).setup
    cases = list(line_cases(setup, quick=options.quick))
    if library is not None:
        cases += track_cases(library)
    return Findings(
        map(row_of, cases),
        parameters(setup),
        REMARKS,
        [figure for case in cases for figure in figures_of(case)],
        [row_of(as_laid_down(case)) for case in cases],
        lambda folder: write_seconds(cases, folder),
    )


def at_the_end(options: Options) -> Sequence[CaseRow]:
    """A train of the line with its windows free, every hop in its standard time."""
    free = next(line_cases(load_scenario(SCENARIO, options.seed).setup, quick=True))
    return [row_of(as_laid_down(free))]


reproduce: Final = Specification(
    "journeys",
    "Whole journeys: time shared in proportion, and where it saves most",
    experiment,
    NullMethod("every hop in its standard time, the reserve at the end", (", windows free",), at_the_end),
    NotDriven("runs are computed as optima, nothing drives them"),
    "A short slice: one train of the line, and no track of TTOBench.",
)
