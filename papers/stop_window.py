"""`branchline reproduce stop-window`: the proof that statistics of stops can't give, and 100,000 stops that try it.

What is proven, what is computed on a grid and what is assumed stands in `stop_set`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from papers.charts import Band, ChartPage, Panel, Plotted, Ruled
from papers.parameter_sets import LINE
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.single_run import STEPS_MAX
from papers.specification import Findings, Specification
from papers.stop_set import (
    BEYOND_M,
    BRAKES,
    MARGIN_M,
    QUICK_GRID,
    RANGES,
    SPEED_LEAST_MPS,
    STRIP_STEPS,
    TOP_SHARE,
    WHOLE_GRID,
    WINDOW_M,
    Floats,
    StopGrid,
    StopSet,
    beyond_the_grid_m,
    corner_brakes,
    ends_m,
    random_brakes,
    random_states,
    stop_bench,
    stop_set,
    stops_from,
)
from radio.chance import generator
from study.report.style import RED, RULE

NAME: Final = "stop-window"
STOPS: Final = 100_000
STOPS_QUICK: Final = 4_000
BETWEEN: Final = 20_000
BETWEEN_QUICK: Final = 2_000
OUTSIDE: Final = 4_000
SEARCHED: Final = 200
ROUNDS: Final = 20
MARGIN_TIMES: Final = 2.0
LINE_TOP_MPS: Final = 65.0 / 3.6
TIGHT_LEAST: Final = 0.9
MISSED_LEAST: Final = 0.02
COASTED: Final = 20
COASTED_STEPS: Final = 10
ROUNDING_M: Final = 1e-6
ENDS_WITHIN: Final = f"random stops from the set that end within {WINDOW_M:g} m"
NEARER_SHARE: Final = 0.4


def inside_rows(found: StopSet, seed: int, n: int) -> tuple[CaseRow, ...]:
    """Random stops from inside the set, and a search from the worst of them for a worse one."""
    rng = generator(seed, NAME, "inside")
    shares, speeds = random_states(found, rng, n, beyond=True)
    brakes, adhesions = random_brakes(rng, n)
    ends = ends_m(found, shares, speeds, brakes, adhesions)
    held = int(np.sum(np.abs(ends) <= WINDOW_M))
    worst = np.argsort(-np.abs(ends), kind="stable")[:SEARCHED]
    searched_m = searched_worst_m(found, rng, (shares[worst], speeds[worst], brakes[worst], adhesions[worst]))
    return (
        CaseRow(ENDS_WITHIN, None, f"{held:,} of {n:,}", held == n, "all"),
        CaseRow(
            "worst of them, and worst of a search from the worst, m",
            None,
            f"{np.abs(ends).max():.3f}; {searched_m:.3f}",
            searched_m <= WINDOW_M,
            f"at most {WINDOW_M:g}",
        ),
    )


def searched_worst_m(
    found: StopSet, rng: np.random.Generator, starts: tuple[Floats, Floats, Floats, Floats]
) -> float:
    """The worst end that small random steps find from these stops, each step kept where it makes the stop worse, m."""
    shares, speeds, brakes, adhesions = starts
    worst = np.abs(ends_m(found, shares, speeds, brakes, adhesions))
    values = np.column_stack((shares, speeds, brakes, adhesions))
    low = np.array([SPEED_LEAST_MPS, *(RANGES[name].low for name in RANGES)])
    high = np.array([found.top_mps - 1e-9, *(RANGES[name].high for name in RANGES)])
    size = np.array([0.02, 0.3, 0.1, 0.05, 0.05, 0.1])
    for _ in range(ROUNDS):
        tried = values + rng.normal(0.0, 1.0, values.shape) * size
        tried[:, 1:] = np.clip(tried[:, 1:], low, high)
        tried[:, 0] = np.clip(tried[:, 0], found.least_share(tried[:, 1]), None)
        ends = np.abs(ends_m(found, tried[:, 0], tried[:, 1], tried[:, 2:5], tried[:, 5]))
        better = ends > worst
        values[better], worst[better] = tried[better], ends[better]
    return float(worst.max())


def tight_columns(found: StopSet) -> tuple[int, int, int]:
    """Speeds at which a brake misses the window just outside the set; where it ends as every law's does; all."""
    tight = limit = 0
    columns = [
        column
        for column, speed_mps in enumerate(found.speeds_mps.tolist())
        if SPEED_LEAST_MPS <= speed_mps <= found.top_mps
    ]
    for column in columns:
        first = int(np.argmin(np.abs(found.shares - float(found.lowest[column]))))
        below = slice(max(first - STRIP_STEPS, 0), first)
        far_m = np.maximum(-found.least_m[column, below], found.most_m[column, below])
        misses = bool(np.any(far_m > WINDOW_M))
        tight += misses
        limit += not misses and first <= STRIP_STEPS
    return tight, limit, len(columns)


def stops_outside(found: StopSet, seed: int, n: int) -> tuple[Floats, Floats, Floats]:
    """Distances, speeds and ends of stops by brakes at the ends of their ranges: a strip nearer, and above the top."""
    rng = generator(seed, NAME, "outside")
    speeds = rng.uniform(SPEED_LEAST_MPS, found.speeds_mps[-1], n)
    lowest = np.where(speeds < found.top_mps, found.least_share(speeds), 1.0 + found.strip)
    shares = np.maximum(lowest - rng.uniform(0.0, found.strip, n), 0.0)
    ends = ends_m(found, shares, speeds, *corner_brakes(rng, n))
    return found.distance_m(shares, speeds), speeds, ends


def exact_rows(found: StopSet, seed: int) -> tuple[CaseRow, ...]:
    """What must hold to the bit, or to rounding: adhesion where nothing slides, and coasting."""
    rng = generator(seed, NAME, "exact")
    shares, speeds = random_states(found, rng, STOPS_QUICK, beyond=False)
    brakes, adhesions = random_brakes(rng, STOPS_QUICK)
    distances = found.distance_m(shares, speeds)
    least = np.full(adhesions.size, RANGES["adhesion"].low)
    at_least, _ = stop_bench().run(stops_from(distances, speeds, brakes, least))
    rolled = at_least["slid_steps"] == 0
    other, _ = stop_bench().run(stops_from(distances, speeds, brakes, adhesions))
    differ = int(np.sum(at_least["error_m"][rolled] != other["error_m"][rolled]))
    apart_m = max(coasting_apart_m(found, rng) for _ in range(COASTED))
    return (
        CaseRow(
            "stops that differ by adhesion, of those that slide at none",
            None,
            f"{differ} of {int(rolled.sum()):,}",
            differ == 0 and bool(rolled.any()),
            "none, to the bit",
        ),
        CaseRow(
            "a start and a later moment of its coasting end apart, m",
            None,
            f"{apart_m:.1e}",
            apart_m <= ROUNDING_M,
            f"at most {ROUNDING_M:g}",
        ),
    )


def coasting_apart_m(found: StopSet, rng: np.random.Generator) -> float:
    """How far apart a start beyond the grid and the state that it coasts into end, m."""
    speed = rng.uniform(SPEED_LEAST_MPS, found.top_mps, 1)
    start = found.distance_m(np.ones(1), speed) + BEYOND_M
    brakes, adhesions = random_brakes(rng, 1)
    first, trace = stop_bench().single_stop(stops_from(start, speed, brakes, adhesions), STEPS_MAX)
    later = trace[COASTED_STEPS]
    state = np.array([-later["position_m"]]), np.array([later["speed_mps"]])
    again, _ = stop_bench().single_stop(stops_from(*state, brakes, adhesions))
    return abs(float(first.error_m) - float(again.error_m))


def top_row(found: StopSet) -> CaseRow:
    """Up to which speed the set reaches."""
    return CaseRow(
        "greatest speed of the set, km/h",
        None,
        round(found.top_mps * 3.6, 1),
        found.top_mps >= LINE_TOP_MPS,
        "at least the 65 of the line's stock",
    )


def set_rows(found: StopSet, seed: int, between: int, missed: int, n: int) -> tuple[CaseRow, ...]:
    """How large the set is, that it could not be much larger, and what its grid leaves open."""
    beyond_m = beyond_the_grid_m(found, generator(seed, NAME, "between"), between)
    tight, limit, columns = tight_columns(found)
    return (
        top_row(found),
        CaseRow(
            f"stops between the points of the grid that leave what it spans ({between:,}), by at most, m",
            None,
            round(max(beyond_m, 0.0), 4),
            MARGIN_TIMES * beyond_m <= MARGIN_M,
            f"half of the margin of {MARGIN_M} m",
        ),
        CaseRow(
            f"speeds at which a brake misses within {STRIP_STEPS} steps outside; at which the set ends as for any law",
            None,
            f"{tight}; {limit} of {columns}",
            tight + limit >= TIGHT_LEAST * columns and tight > limit,
            f"{TIGHT_LEAST:.0%} in all: the set could not be much larger",
        ),
        CaseRow(
            "stops from just outside, by brakes at the ends of their ranges, that miss the window",
            None,
            f"{missed:,} of {n:,}",
            missed >= MISSED_LEAST * n,
            f"at least {MISSED_LEAST:.0%}",
        ),
    )


def parameters(grid: StopGrid, stops: int) -> tuple[Parameter, ...]:
    """What was chosen, and why."""
    return (
        Parameter("train", "oda_train", "", "Oda, 3.2.3, with the lag of stop-statistics"),
        *(within.parameter for within in RANGES.values()),
        Parameter("window", WINDOW_M, "m either way", "Oda, 2.2"),
        Parameter(
            "margin of it kept for the grid", MARGIN_M, "m", "over twice what is found between its points"
        ),
        Parameter(
            "grid",
            f"{grid.speeds_mps.size} speeds by {grid.shares} distances by {len(BRAKES)} brakes by "
            f"{len(RANGES['adhesion'].tried)} adhesions",
            "",
            "assumed",
        ),
        Parameter("known exactly", "position, wheel, gradient", "", "the brake alone is in question"),
        Parameter("coasting before the brake", BEYOND_M, "m at most", "assumed"),
        Parameter("random stops", stops, "", "the issue"),
    )


def chart(found: StopSet, missed: tuple[Floats, Floats]) -> ChartPage:
    """The set, what no law can hold, and stops that `missed` the window (distances m, speeds m/s)."""
    speeds = np.linspace(SPEED_LEAST_MPS, found.top_mps, 600)
    # just under the top: the cell above it is out
    nearest = found.distance_m(found.least_share(np.minimum(speeds, found.top_mps - 1e-6)), speeds)
    begin = found.distance_m(np.ones(speeds.size), speeds)
    every: Floats = np.linspace(float(found.speeds_mps[0]), float(found.speeds_mps[-1]), 600)
    outer, top_kmh = found.distance_m(np.zeros(every.size), every), found.top_mps * 3.6
    held = f"every brake stops in the window (from up to {BEYOND_M:.0f} m before braking)"
    panel = Panel(
        "distance to the mark, m",
        "speed, km/h",
        [
            Band(
                every * 3.6, 0.0 * every, outer, "no law can: even the full brake overruns", RULE, across=True
            ),
            Band(speeds * 3.6, nearest, begin + BEYOND_M, held, "#9cc3e0", across=True),
            Plotted(begin, speeds * 3.6, "where the law begins to brake, at the earliest", style="--"),
            Plotted(missed[0], missed[1] * 3.6, "stops from just outside that missed it", RED, ".", size=2.5),
            Ruled(y=[top_kmh], style="-", width=0.6),
        ],
        f"Starts from which every brake of the stated range stops within {WINDOW_M:g} m of the mark",
        (0.0, float(begin.max()) + BEYOND_M),
        (0.0, float(every[-1]) * 3.6),
        "lower right",
        also=lambda axes: axes.annotate(f"{top_kmh:.0f} km/h", (2.0, top_kmh), va="bottom", fontsize=7.5),
    )
    return ChartPage("stop_window", (9.0, 5.2), [[panel]])


def experiment(options: Options) -> Findings:
    """Compute the set and try it."""
    grid, stops = (QUICK_GRID, STOPS_QUICK) if options.quick else (WHOLE_GRID, STOPS)
    found = stop_set(grid)
    if found.is_empty:
        why = "Empty: from nowhere does every brake of the range stop inside the window; there is nothing to try."
        nothing = CaseRow(ENDS_WITHIN, None, "nothing to try", passed=False)
        return Findings([top_row(found)], parameters(grid, stops), [why], null=[nothing])
    distances, speeds, ends = stops_outside(found, options.seed, OUTSIDE)
    missing = np.abs(ends) > WINDOW_M
    between = BETWEEN_QUICK if options.quick else BETWEEN
    return Findings(
        (
            *inside_rows(found, options.seed, stops),
            *set_rows(found, options.seed, between, int(missing.sum()), OUTSIDE),
            *exact_rows(found, options.seed),
        ),
        parameters(grid, stops),
        [
            "Proven: adhesion has no part where nothing slides at the least; the dead times are all there are in whole "
            "steps; a start further back is a later moment of its coasting; what no law can hold. Computed: the rest, "
            "on the grid, with a margin. Assumed: the ranges, and a position, a wheel and a gradient that are known.",
            f"Nearer than the set's edge the weakest brake overruns; {what_ends_it(found)}.",
            f"Up to the set's greatest speed every column reaches to {TOP_SHARE:.0%} of the way or nearer.",
        ],
        edge_figures(found),
        nearer_rows(found, options.seed),
        chart(found, (distances[missing], speeds[missing])).write,
    )


def nearer_rows(found: StopSet, seed: int) -> tuple[CaseRow, ...]:
    """The null method: the same stops from a set that is too large."""
    nearer = replace(found, lowest=np.maximum(found.lowest - NEARER_SHARE, 0.0))
    return inside_rows(nearer, seed, STOPS_QUICK)


def what_ends_it(found: StopSet) -> str:
    """Why the set reaches no faster than it does: what stops of the next speed of the grid come to, in words."""
    top_kmh = f"{found.top_mps * 3.6:.0f} km/h"
    column = int(np.argmin(np.abs(found.speeds_mps - found.top_mps))) + 1
    if column == found.speeds_mps.size:
        return f"above {top_kmh} nothing was computed"
    far = found.shares >= TOP_SHARE
    least_m, most_m = float(found.least_m[column, far].min()), float(found.most_m[column, far].max())
    words = [f"overruns by up to {most_m:.2f} m"] if most_m > WINDOW_M - MARGIN_M else []
    words += [f"stops up to {-least_m:.2f} m short"] if -least_m > WINDOW_M - MARGIN_M else []
    return f"above {top_kmh} a brake of the range {' and another '.join(words)} however early it begins"


def edge_figures(found: StopSet) -> tuple[UnjudgedFigure, ...]:
    """The edge of the set at a few speeds, and how much of what any law could hold it takes."""
    figures = [
        UnjudgedFigure(
            "share in the set of what any law could hold, once the law brakes",
            round(found.holds_share(), 3),
            "of the distances between the least that any law needs and where braking begins; the rest is what "
            "following a pattern without knowing the brake costs",
        )
    ]
    for speed_kmh in (20.0, 40.0, 60.0):
        speed = np.array([speed_kmh / 3.6])
        edge = float(found.distance_m(found.least_share(speed), speed)[0])
        none, begin = (float(found.distance_m(np.array([share]), speed)[0]) for share in (0.0, 1.0))
        figures.append(
            UnjudgedFigure(
                f"from {speed_kmh:.0f} km/h every brake needs, m",
                round(edge, 1),
                f"{none:.1f} m is what any law needs, {begin:.1f} m where the law has not braked yet",
            )
        )
    return tuple(figures)


reproduce: Final = Specification(
    NAME,
    "Starts from which every brake of a stated range stops inside the window",
    experiment,
    NullMethod(
        "a set that reaches nearer by four tenths of the way",
        (ENDS_WITHIN,),
        lambda options: nearer_rows(stop_set(QUICK_GRID), options.seed),
    ),
    LINE,
    f"A short slice: a coarser grid, and {STOPS_QUICK} of {STOPS} stops.",
)
