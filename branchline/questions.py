"""What is asked of a scenario or a run, and what is found: headways and capacity, for commands and for `branchline`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import polars as pl
from matplotlib.figure import Figure

from branchline.sources import occupations_of, setup_of_source, stop_of
from network.clock import clock
from network.errors import COMMAND_LINE, InputError
from network.files.toml_input import one_of
from network.model import Line
from scenario.scenario import Scenario
from study.capacity.compression import ContradictionError, StandingRule
from study.capacity.cut import SINGLE_TRACK_CUT, WAYS, LineCut, cut_of
from study.capacity.headway import HeadwayCase, line_cases
from study.capacity.legs import SetLeg, legs_of, places_of
from study.capacity.limits import TrafficKind
from study.capacity.line_capacity import (
    PEAK_S,
    CompressionTerms,
    Period,
    Rate,
    day_of,
    fullest_part,
    peak_of,
    rates_of,
)
from study.capacity.more import AddedTrains, more_trains
from study.capacity.room import PathSearch
from study.record.read_back import RunRead
from study.report.capacity import draw_occupation, rates_table
from study.report.drawn import DrawnFigure
from study.report.headways import draw_matrix, draw_parts, headway_table
from study.report.style import drawing

ALL_CUTS: Final = "all"


@dataclass(frozen=True, slots=True)
class LineHeadways:
    """The least headways of a line (続行, 開通, 追い込み, 着発, 発着), s: a row a station and two kinds of trains."""

    line: Line
    cases: tuple[HeadwayCase, ...]

    def __repr__(self) -> str:
        """In a notebook: how many of which line; `table` has them."""
        return f"<{len(self.cases)} least headways of {self.line.id}>"

    @property
    def table(self) -> pl.DataFrame:
        """A row a headway: which section decides it, and what its seconds go into."""
        return headway_table(self.cases)

    def matrix(self) -> DrawnFigure:
        """A panel a station, first trains down and second ones across."""
        with drawing():
            return _shown(draw_matrix(self.line, self.cases), "headway_matrix")

    def parts(self) -> DrawnFigure:
        """A bar a headway: what radio, points, localisation, release, driving and people cost of it."""
        with drawing():
            return _shown(draw_parts(self.line, self.cases), "headway_parts")


def headways_of(
    loaded: Scenario | RunRead, station: str | None, *, theory: bool, progress: bool = False
) -> LineHeadways:
    """The least headways as run, or by theory. InputError for a station without any, before anything runs."""
    setup = setup_of_source(loaded)
    chosen = stop_of(setup.line, station)
    occupations = occupations_of(loaded, theory=theory, shown=progress)
    cases = line_cases(setup.line, occupations, setup.unit.dwell_min_s)
    return LineHeadways(setup.line, tuple(case for case in cases if chosen in (None, case.station_id)))


@dataclass(frozen=True, slots=True)
class CapacityAsked:
    """What of a line's capacity is asked for. `between_s`: from and to, s after midnight, instead of day and peak.

    `stops` are kept as planned, or least; `buffer_s` stays free between an added train and the others.
    """

    cut: str = ALL_CUTS
    between_s: tuple[float | None, float | None] = (None, None)
    traffic: str = TrafficKind.MIXED.value
    stops: str = StandingRule.KEPT.value
    buffer_s: float = 0.0
    theory: bool = False

    def __post_init__(self) -> None:
        for option, value, known in (
            ("--cut", self.cut, (*WAYS, ALL_CUTS)),
            ("--traffic", self.traffic, tuple(word.value for word in TrafficKind)),
            ("--stops", self.stops, tuple(word.value for word in StandingRule)),
        ):
            if value not in known:
                raise InputError(COMMAND_LINE, option, value, one_of(known, value))
        from_s, to_s = self.between_s
        if from_s is not None and to_s is not None and to_s <= from_s:
            raise InputError(COMMAND_LINE, "--to", clock(to_s), f"a time after {clock(from_s)}")


@dataclass(frozen=True, slots=True)
class LineCapacity:
    """How full each part of a line is (UIC 406), and how many more trains fit between those of the plan."""

    cuts: tuple[LineCut, ...]
    by_cut: Mapping[str, Sequence[Rate]]
    periods: tuple[Period, ...]
    more: AddedTrains

    def __repr__(self) -> str:
        """In a notebook: its conclusion."""
        return f"<{self.conclusion}>"

    @property
    def table(self) -> pl.DataFrame:
        """A row a part of each cut and period: occupancy, limit, room, critical section."""
        return rates_table(self.by_cut)

    @property
    def room(self) -> pl.DataFrame:
        """A row a train that fits between the others."""
        return pl.DataFrame([path.as_dict() for path in self.more.paths], infer_schema_length=None)

    @property
    def conclusion(self) -> str:
        """What a planner can quote: how many more trains, how full by which cut and limit, and what is in doubt."""
        period, more = self.periods[0], self.more.trains_in(self.periods[0])
        room = (
            f"{more} more trains fit between those of the plan in the {period.name}, {clock(period.from_s)} to"
            f" {clock(period.to_s)}, each judged with them; more may fit where other trains are moved."
        )
        cut = next((cut for cut in self.cuts if cut.name == SINGLE_TRACK_CUT), self.cuts[0])
        full = fullest_part(rate for rate in self.by_cut[cut.name] if rate.period is period)
        if full is None:
            return room
        return (
            f"{room} Of the cut by {cut.name}, the fullest part is {full.part.name}: it is occupied"
            f" {100.0 * full.occupied_share:.0f} % of the {period.name}, where UIC 406 has"
            f" {100.0 * full.limit_share:.0f} % at most; another cut gives another figure."
        )

    def picture(self) -> DrawnFigure:
        """A panel a way of cutting, a bar a part, with the limits."""
        with drawing():
            return _shown(draw_occupation(self.by_cut), "occupation")


def capacity_of(loaded: Scenario | RunRead, asked: CapacityAsked, *, progress: bool = False) -> LineCapacity:
    """Compress what trains occupy. InputError where there is nothing in the period, or trains contradict themselves."""
    setup = setup_of_source(loaded)
    occupations = occupations_of(loaded, theory=asked.theory, shown=progress)
    legs = legs_of(occupations, places_of(setup.line))
    periods = _periods(legs, asked.between_s)
    terms = CompressionTerms(TrafficKind(asked.traffic), StandingRule(asked.stops), setup.unit.dwell_min_s)
    names: Iterable[str] = WAYS if asked.cut == ALL_CUTS else (asked.cut,)
    cuts = tuple(cut_of(setup.line, name) for name in names)
    try:
        by_cut = {one.name: rates_of(legs, one, periods, terms) for one in cuts}
    except ContradictionError as error:
        expected = "a plan in which of each two trains one goes first on every section that they share"
        raise InputError(setup.name, "trains", ", ".join(error.numbers), expected) from error
    return LineCapacity(
        cuts, by_cut, periods, more_trains(setup, periods[0], PathSearch(buffer_s=asked.buffer_s))
    )


def _periods(legs: Sequence[SetLeg], between_s: tuple[float | None, float | None]) -> tuple[Period, ...]:
    if not legs:
        raise InputError(COMMAND_LINE, "SOURCE", None, "a day on which trains run")
    day = day_of(legs)
    from_s, to_s = between_s
    if from_s is None and to_s is None:
        return (day, peak_of(legs, day)) if day.length_s > PEAK_S else (day,)  # no peak longer than its day
    begin_s, end_s = day.from_s if from_s is None else from_s, day.to_s if to_s is None else to_s
    chosen = Period("chosen", begin_s, end_s, peak=False)
    if end_s <= begin_s or not chosen.legs(legs):
        run = f"a time with trains after it, {clock(day.from_s)} to {clock(day.to_s)} being their day"
        option, time_s = ("--to", end_s) if from_s is None else ("--from", begin_s)
        raise InputError(COMMAND_LINE, option, clock(time_s), run)
    return (chosen,)


def _shown(figure: Figure | None, name: str) -> DrawnFigure:
    if figure is None:
        raise InputError(name, "", None, "trains that need the same section")
    return DrawnFigure(figure, name)
