"""What equipment buys: how the headway and the occupancy of a day move with one parameter at a time, low to high.

Measured by theory with ways set as late as can be: the greatest headway of a follower on the way down, the greatest
time from an arrival to the departure of an opposing train at a crossing station, and the occupancy of the fullest part
between crossing stations with the trains and times of the plan. For headways trains run as fast as they are driven and
stop as short as they can; for the occupancy they keep their times.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from network.model import Direction, Line, TagPurpose
from network.virtual_blocks import with_virtual_blocks
from simulation.setup import Setup
from study.capacity.cut import SINGLE_TRACK_CUT, cut_of
from study.capacity.headway import HeadwayCase, HeadwayKind, line_cases
from study.capacity.legs import legs_of, places_of
from study.capacity.line_capacity import CompressionTerms, day_of, fullest_part, rates_of
from study.capacity.occupation import OccupationCost
from study.capacity.rules import MINIMAL, Rules
from study.capacity.theory import occupations
from study.record.columns import tenth

BLOCKS: Final = 5  # as many as are published to give most
FOLLOWS: Final = frozenset({HeadwayKind.FOLLOWING, HeadwayKind.OPEN})


@dataclass(frozen=True, slots=True)
class EquipmentFigures:
    """What a setup makes possible, s and share; NaN where there is no such pair of trains.

    `block_headway_s`: the follower's headway with the sections between stations in BLOCKS virtual blocks besides; NaN
    where the setup itself is about that.
    """

    headway_s: float
    section_id: str
    block_headway_s: float
    meet_s: float
    occupied_share: float
    part: str

    def as_dict(self, prefix: str) -> dict[str, Any]:
        """For JSON and CSV."""
        return {
            f"{prefix}_headway_s": tenth(self.headway_s),
            f"{prefix}_section": self.section_id,
            f"{prefix}_block_headway_s": tenth(self.block_headway_s),
            f"{prefix}_meet_s": tenth(self.meet_s),
            f"{prefix}_percent": tenth(100.0 * self.occupied_share),
            f"{prefix}_part": self.part,
        }


@dataclass(frozen=True, slots=True)
class Lever:
    """A parameter, what it costs where it is bad, and both ends: words for each, and the setup and rules made so."""

    name: str
    cost: OccupationCost
    low: str
    high: str
    at: Callable[[Setup, bool], tuple[Setup, Rules]]


@dataclass(frozen=True, slots=True)
class LeverWorth:
    """What a lever moves: as it is, and at its ends."""

    name: str
    cost: OccupationCost
    low: str
    high: str
    base: EquipmentFigures
    low_end: EquipmentFigures
    high_end: EquipmentFigures

    @property
    def headway_swing_s(self) -> float:
        """By how much the headway differs between the ends."""
        return abs(self.high_end.headway_s - self.low_end.headway_s)

    def as_dict(self) -> dict[str, Any]:
        """For JSON and CSV."""
        return {
            "name": self.name,
            "cost": self.cost.value,
            "low": self.low,
            "high": self.high,
            **self.base.as_dict("base"),
            **self.low_end.as_dict("low"),
            **self.high_end.as_dict("high"),
        }


def measured_by_rules(setup: Setup, rules: Rules = MINIMAL) -> EquipmentFigures:
    """The headways and the occupancy of a setup by rules."""
    dwell_min_s, is_place = setup.unit.dwell_min_s, places_of(setup.line)
    most = _following(setup, rules)
    cut = (
        None
        if rules.by_section
        else replace(setup, line=with_virtual_blocks(setup.line, BLOCKS), belief=None)
    )
    with_blocks = None if cut is None else _following(cut, replace(rules, by_section=True))
    planned = occupations(setup, rules)
    meets = [
        case.headway.least_s
        for case in line_cases(setup.line, planned, dwell_min_s)
        if case.headway.kind is HeadwayKind.ARRIVAL_DEPARTURE
    ]
    legs = legs_of(planned, is_place)
    rates = rates_of(
        legs, cut_of(setup.line, SINGLE_TRACK_CUT), (day_of(legs),), CompressionTerms(dwell_min_s=dwell_min_s)
    )
    full = fullest_part(rates)
    return EquipmentFigures(
        math.nan if most is None else most.headway.least_s,
        "" if most is None else most.headway.section_id,
        math.nan if with_blocks is None else with_blocks.headway.least_s,
        max(meets, default=math.nan),
        math.nan if full is None else full.occupied_share,
        "" if full is None else full.part.name,
    )


def _following(setup: Setup, rules: Rules) -> HeadwayCase | None:
    """The greatest headway of a follower on the way down, trains running as fast as they are driven."""
    quick = occupations(setup, replace(rules, unslowed=True))
    down = [one for one in quick if one.direction is Direction.DOWN]
    cases = line_cases(setup.line, down, setup.unit.dwell_min_s)
    found = [
        case for case in cases if case.headway.kind in FOLLOWS and "passes" not in case.first + case.second
    ]
    return max(found, key=lambda case: case.headway.least_s, default=None)


def worth_of(setup: Setup, levers: Sequence[Lever] | None = None) -> tuple[LeverWorth, ...]:
    """Every lever from end to end, the one that moves the headway most first."""
    base = measured_by_rules(setup)
    found = [
        LeverWorth(
            lever.name,
            lever.cost,
            lever.low,
            lever.high,
            base,
            measured_by_rules(*lever.at(setup, False)),
            measured_by_rules(*lever.at(setup, True)),
        )
        for lever in (LEVERS if levers is None else levers)
    ]
    return tuple(sorted(found, key=lambda worth: -worth.headway_swing_s))


def with_delay(setup: Setup, delay_s: float) -> Setup:
    """Telegrams that are under way for so long, each."""
    air = setup.air.model_copy(update={"delay_min_s": delay_s, "delay_mean_s": delay_s})
    return replace(setup, air=air, second_air=None)


def with_loss(setup: Setup, share: float) -> Setup:
    """An air that loses such a share of telegrams."""
    return replace(setup, air=setup.air.model_copy(update={"loss_good_p": share}), second_air=None)


def with_throw(setup: Setup, throw_s: float) -> Setup:
    """Points that take so long to throw."""
    points = {one.id: replace(one, throw_time_s=throw_s) for one in setup.line.points.values()}
    return replace(setup, line=replace(setup.line, points=points))


def with_wheel_error(setup: Setup, share: float) -> Setup:
    """Bounds that grow so much with the way, wheels that change on the way by half of it."""
    limit = min(setup.unit.wheel_scale_limit, share / 2.0)
    unit = setup.unit.model_copy(update={"wheel_error_share": share, "wheel_scale_limit": limit})
    return replace(setup, unit=unit)


def with_fewer_tags(setup: Setup) -> Setup:
    """Without every second one of the tags that only fix the position; those that routes need stay."""
    return replace(setup, line=fewer_tags(setup.line))


def fewer_tags(line: Line) -> Line:
    """A line without every second tag that only fixes the position."""
    plain = [
        tag.id for tag in sorted(line.tags.values(), key=lambda t: t.id) if tag.purpose is TagPurpose.POSITION
    ]
    gone = frozenset(plain[1::2])
    return replace(line, tags={tag_id: tag for tag_id, tag in line.tags.items() if tag_id not in gone})


def _lever(
    name: str,
    cost: OccupationCost,
    ends: tuple[str, str],
    low: Callable[[Setup], Setup],
    high: Callable[[Setup], Setup],
) -> Lever:
    def at(setup: Setup, is_high: bool) -> tuple[Setup, Rules]:
        return (high if is_high else low)(setup), MINIMAL

    return Lever(name, cost, *ends, at)


def _same(setup: Setup) -> Setup:
    return setup


def _driven(setup: Setup, deceleration_mps2: float) -> Setup:
    return replace(
        setup, driving=setup.driving.model_copy(update={"stop_deceleration_mps2": deceleration_mps2})
    )


def _dwells(setup: Setup, dwell_s: float) -> Setup:
    return replace(setup, unit=setup.unit.model_copy(update={"dwell_min_s": dwell_s}))


def _blocks(blocks: int) -> Callable[[Setup, bool], tuple[Setup, Rules]]:
    by_section = replace(MINIMAL, by_section=True)

    def at(setup: Setup, is_high: bool) -> tuple[Setup, Rules]:
        if not is_high:
            return setup, MINIMAL
        line = with_virtual_blocks(setup.line, blocks)
        return replace(setup, line=line, belief=None), by_section

    return at


# assumed: ends that such equipment is sold or found with; none is of a paper.
LEVERS: Final = (
    _lever(
        "radio delay",
        OccupationCost.RADIO,
        ("0.1 s", "2 s"),
        lambda s: with_delay(s, 0.1),
        lambda s: with_delay(s, 2.0),
    ),
    _lever(
        "telegrams lost",
        OccupationCost.RADIO,
        ("0 %", "10 %"),
        lambda s: with_loss(s, 0.0),
        lambda s: with_loss(s, 0.1),
    ),
    _lever(
        "throw time",
        OccupationCost.POINTS,
        ("3 s", "12 s"),
        lambda s: with_throw(s, 3.0),
        lambda s: with_throw(s, 12.0),
    ),
    _lever(
        "growth of bounds",
        OccupationCost.LOCALISATION,
        ("0.5 %", "5 %"),
        lambda s: with_wheel_error(s, 0.005),
        lambda s: with_wheel_error(s, 0.05),
    ),
    _lever("tags that only fix", OccupationCost.LOCALISATION, ("all", "half"), _same, with_fewer_tags),
    _lever(
        "braking to stops",
        OccupationCost.DRIVING,
        ("0.8 m/s^2", "0.4 m/s^2"),
        lambda s: _driven(s, 0.8),
        lambda s: _driven(s, 0.4),
    ),
    _lever(
        "shortest dwell",
        OccupationCost.PEOPLE,
        ("15 s", "45 s"),
        lambda s: _dwells(s, 15.0),
        lambda s: _dwells(s, 45.0),
    ),
    Lever("clear section by section", OccupationCost.RULE, "at arrival tag", "each section", _blocks(1)),
    Lever("virtual blocks", OccupationCost.RULE, "as it is", f"{BLOCKS} a section", _blocks(BLOCKS)),
)
