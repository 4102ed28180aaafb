"""What virtual blocks buy on a branch line, beside a published corridor: `branchline reproduce virtual-blocks`.

Published (Transportation Research Record 2023, doi 10.1177/03611981231158641, abstract): on a simulated 2,000-mile
freight corridor of single and double track in the USA moving blocks keep today's mean train speed at 40 % more trains,
and five virtual blocks for each fixed block give most of what moving blocks do. Nothing but the abstract was at hand.

Ours: the sections between the stations of a branch line in 1 to 80 virtual blocks (80 stands for moving blocks). The
headways are those of blocking time theory; traffic and speed those of one single track between two crossing stations
to which trains come at random. A part of the gain is measured as the paper does, in trains at one mean speed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

from matplotlib.axes import Axes

from network.model import Line, Station
from network.virtual_blocks import with_virtual_blocks
from papers.charts import ChartPage, Panel, Plottable, Plotted, Ruled
from papers.parameter_sets import NotDriven
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.specification import Findings, Specification
from scenario.scenario import load_scenario
from simulation.setup import Setup
from study.capacity.legs import SetLeg, legs_of, places_of
from study.capacity.rules import MINIMAL, VIRTUAL_BLOCKS, Rules
from study.capacity.shared_stretch import StretchHeadways, mean_wait_s, stretch_of, traffic_at
from study.capacity.standard import path_alone, standard_paths
from study.capacity.theory import occupations
from study.report.style import INK, UNIT_COLOURS, WIDTH_IN

SCENARIOS: Final = ("karasuyama_weekday", "busy_line")
BLOCKS: Final = (1, 2, 3, 4, 5, 8, 12, 20, 40, 80)
QUICK: Final = (1, 2, 5, 40)
TODAY_SHARE: Final = 0.6  # of the most trains with fixed blocks: UIC 406's limit for a day of mixed traffic
LATER_S: Final = 10_800.0  # copies of the trains are laid out so much later: headways do not depend on it
PAPER_GAIN_PERCENT: Final = 40.0
PAPER_BLOCKS: Final = 5
MORE: Final = ": more trains at the same mean speed with moving blocks, %"


@dataclass(frozen=True, slots=True)
class BlocksPoint:
    """One number of blocks: the stretch, and the traffic at which a train waits as long as today."""

    blocks: int
    stretch: StretchHeadways
    trains_per_hour: float


@dataclass(frozen=True, slots=True)
class BlocksCurve:
    """A stretch of a line by number of blocks.

    `had_whole`: the same line, with one block and with the most, by trains that take a route whole and give it back at
    the arrival tag, as units do.
    """

    scenario: str
    name: str
    wait_s: float
    points: tuple[BlocksPoint, ...]
    had_whole: tuple[BlocksPoint, BlocksPoint]

    def gain_percent(self, blocks: int) -> float:
        """How many more trains than with one block run at the same mean speed, %."""
        own = {point.blocks: point.trains_per_hour for point in self.points}
        return 100.0 * (own[blocks] / own[1] - 1.0)

    def share_percent(self, blocks: int) -> float:
        """What of the gain of the most blocks that many give, %."""
        whole = self.gain_percent(self.points[-1].blocks)
        return 100.0 * self.gain_percent(blocks) / whole if whole else 0.0


def slice_of(options: Options) -> tuple[Sequence[str], Sequence[int]]:
    """Scenarios, and numbers of blocks."""
    return (SCENARIOS[:1], QUICK) if options.quick else (SCENARIOS, BLOCKS)


def curve_of(name: str, counts: Sequence[int], seed: int) -> BlocksCurve:
    """The longest stretch between crossing stations of a scenario's line, by number of blocks."""
    setup = load_scenario(name).setup
    low, high = _longest(setup.line)
    fixed = _stretch(setup, low, high, 1, VIRTUAL_BLOCKS)
    wait_s = mean_wait_s(fixed, TODAY_SHARE * fixed.trains_per_hour_max, seed)

    def point(blocks: int, rules: Rules) -> BlocksPoint:
        stretch = _stretch(setup, low, high, blocks, rules)
        return BlocksPoint(blocks, stretch, traffic_at(stretch, wait_s, seed))

    points = tuple(point(blocks, VIRTUAL_BLOCKS) for blocks in counts)
    where = f"{setup.line.name}, {low.name} - {high.name}"
    return BlocksCurve(name, where, wait_s, points, (point(1, MINIMAL), point(counts[-1], MINIMAL)))


def without_idea(curve: BlocksCurve) -> BlocksCurve:
    """The curve by trains that make nothing of the blocks which there are."""
    return replace(curve, points=curve.had_whole)


def _longest(line: Line) -> tuple[Station, Station]:
    """The two stations with tracks next to each other that lie furthest apart."""
    stations = sorted((s for s in line.stations.values() if not s.is_halt), key=lambda s: s.position_m)
    return max(pairwise(stations), key=lambda two: two[1].position_m - two[0].position_m)


def _stretch(setup: Setup, low: Station, high: Station, blocks: int, rules: Rules) -> StretchHeadways:
    line = with_virtual_blocks(setup.line, blocks)
    cut = replace(setup, line=line, belief=None)
    legs: list[SetLeg] = []
    copies: list[SetLeg] = []
    for number, path in enumerate(standard_paths(setup)):
        alone = occupations(path_alone(cut, path), rules)
        first = [replace(one, stock_id=f"first {number}", number=f"{one.number}{number}") for one in alone]
        second = [replace(one, stock_id=f"second {number}").moved(LATER_S) for one in first]
        legs += legs_of(first, places_of(line))
        copies += legs_of(second, places_of(line))
    ends = (
        frozenset(track.section_id for track in low.tracks),
        frozenset(track.section_id for track in high.tracks),
    )
    return stretch_of(legs, copies, ends)


def _parameters(counts: Sequence[int]) -> tuple[Parameter, ...]:
    return (
        Parameter(
            "blocks of a section", ", ".join(map(str, counts)), "", "assumed: the last for moving blocks"
        ),
        Parameter(
            "traffic today",
            100.0 * TODAY_SHARE,
            "% of the most with one block",
            "UIC 406, mixed traffic, day",
        ),
        Parameter("trains", "standard paths of each line, as units drive", "", "study.capacity.standard"),
        Parameter("order", "as they come, at random, as many each way", "", "assumed: no dispatcher"),
    )


def gain_row(curve: BlocksCurve) -> CaseRow:
    """The gain of moving blocks."""
    gain = curve.gain_percent(curve.points[-1].blocks)
    return CaseRow(
        f"{curve.name}{MORE}",
        PAPER_GAIN_PERCENT,
        round(gain, 1),
        gain >= PAPER_GAIN_PERCENT,
        "at least the paper's",
    )


def rows_of(curve: BlocksCurve) -> tuple[CaseRow, ...]:
    """What is judged of a curve: the gain of moving blocks, and what five virtual ones give of it."""
    share = curve.share_percent(PAPER_BLOCKS)
    return (
        gain_row(curve),
        CaseRow(
            f"{curve.name}: of that with five virtual blocks, %",
            "most",
            round(share, 1),
            share > 50.0,
            "more than half",
        ),
    )


def _figures(curve: BlocksCurve) -> tuple[UnjudgedFigure, ...]:
    own = [
        UnjudgedFigure(
            f"{curve.name}: {point.blocks} block{'s' if point.blocks > 1 else ''}",
            round(point.trains_per_hour, 2),
            f"trains an hour at today's speed; following {point.stretch.following_s[0]:.0f} s down,"
            f" {point.stretch.following_s[1]:.0f} s up; {curve.gain_percent(point.blocks):.0f} % more than one",
        )
        for point in curve.points
    ]
    whole = curve.had_whole[0]
    meaning = (
        f"trains an hour at today's speed with routes had whole and given back at the arrival tag, as units do;"
        f" following {whole.stretch.following_s[0]:.0f} s down, {whole.stretch.following_s[1]:.0f} s up"
    )
    return (*own, UnjudgedFigure(f"{curve.name}: as units do", round(whole.trains_per_hour, 2), meaning))


REMARKS: Final = (
    "the paper's corridor is 2,000 miles of single and double track with freight trains and a dispatcher; ours is"
    " one single track between two stations with short trains that go as they come: shapes are compared, not sizes",
    "one of our fixed blocks is the whole way between two stations; signal blocks of a main line are shorter, so that"
    " five parts of ours are longer than five of theirs",
    "opposing trains gain nothing from blocks: in one direction alone the gain would be greater",
    "stations are taken to have room for all trains that wait; a loop of two tracks has not",
)


def chart(curves: Sequence[BlocksCurve]) -> ChartPage:
    """Left: more trains at today's speed, %; right: headway of a follower down, min; over blocks, on a log axis."""
    counts = [point.blocks for point in curves[0].points]
    gains: list[Plottable] = [
        Ruled(
            y=(PAPER_GAIN_PERCENT,), label=f"published, moving blocks: {PAPER_GAIN_PERCENT:g} %", colour=INK
        ),
        Ruled(x=(PAPER_BLOCKS,), label="published: five give most"),
    ]
    headways: list[Plottable] = []
    for curve, colour in zip(curves, UNIT_COLOURS, strict=False):
        gained = [curve.gain_percent(point.blocks) for point in curve.points]
        apart_min = [point.stretch.following_s[0] / 60.0 for point in curve.points]
        whole_min = curve.had_whole[0].stretch.following_s[0] / 60.0
        gains.append(Plotted(counts, gained, curve.name, colour, "o-"))
        headways += [
            Plotted(counts, apart_min, f"{curve.name}, down", colour, "o-"),
            Plotted(counts[:1], [whole_min], "as units do: route had whole", colour, "x", size=7.0),
        ]

    def by_count(axes: Axes) -> None:
        axes.set_xscale("log")
        axes.set_xticks(counts, [str(count) for count in counts])
        axes.minorticks_off()
        axes.set_ylim(bottom=0.0)

    blocks = "virtual blocks of each section between stations"
    more = "more trains at the mean speed of one block, %"
    apart = "headway from departure to departure, min"
    panels = (
        Panel(blocks, more, gains, legend="upper left", also=by_count),
        Panel(blocks, apart, headways, also=by_count),
    )
    return ChartPage("virtual_blocks", (WIDTH_IN, 4.6), (panels,))


def experiment(options: Options) -> Findings:
    """The gain in traffic of five virtual blocks and of moving blocks, the paper's beside ours."""
    names, counts = slice_of(options)
    curves = [curve_of(name, counts, options.seed) for name in names]
    return Findings(
        [row for curve in curves for row in rows_of(curve)],
        _parameters(counts),
        REMARKS,
        [figure for curve in curves for figure in _figures(curve)],
        [gain_row(without_idea(curve)) for curve in curves],
        chart(curves).write,
    )


def had_whole(options: Options) -> Iterator[CaseRow]:
    """The gain of the most blocks alone by such trains."""
    names, counts = slice_of(options)
    curves = (curve_of(name, (1, counts[-1]), options.seed) for name in names)
    return (gain_row(without_idea(curve)) for curve in curves)


reproduce: Final = Specification(
    "virtual-blocks",
    "Virtual blocks on a branch line",
    experiment,
    NullMethod("as many blocks, of routes that are had whole", (MORE,), had_whole),
    NotDriven("running times are computed, nothing drives them"),
    f"quick: {SCENARIOS[0]} alone, {QUICK} blocks",
)
