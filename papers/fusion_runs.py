"""Random runs about where a train is: what is drawn for one, and what came of it. `papers.position_fusion`.

A run is one train along a real line, with that line's tags or with random ones, and with everything between rail and
unit drawn from (seed, number): worn wheels, creep, treads, slippery stretches, and tags that are missed, moved,
swapped, that say another's id, or that nobody knows of. What is drawn keeps to what units are told to expect
(`unit.tags_wrong_together` = 1): of two tags read one after another at least one is right, unless they were swapped.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cache
from itertools import pairwise
from typing import Final, NamedTuple

import msgspec
import numpy as np

from network.model import Line, Tag, TagPurpose
from network.path import Path
from onboard.notes import PositionFault, TagDoubted, TagRead
from papers.position_run import (
    SLOT,
    PositionResult,
    PositionRun,
    half_widths_m,
    in_motion,
    slippery,
    unprotected,
)
from papers.position_sets import furnished_line
from papers.specification import Evenly
from radio.chance import generator
from scenario.scenario import load_scenario
from simulation.setup import Belief, Setup
from simulation.world.roster import drawn_up

LINES: Final = ("karasuyama_weekday", "kururi_weekday", "isumi_weekday", "busy_line", "rtri_test_line")
LINE_SHARES: Final = (0.12, 0.08, 0.1, 0.2, 0.5)  # the short ones more often
FIRST_RANDOM_ID: Final = 20_000
UNKNOWN_ID: Final = 60_000  # of no tag on any line
FAULT_SHARE: Final = 0.15  # of the tags
MOVED_M: Final = Evenly("tags moved", 1.0, 60.0, "m", "assumed: maintenance of the track")
SLIPPERY: Final = Evenly("slippery stretches", 0.1, 0.6, "of the dry rail", "assumed: leaves")
SLIPPERY_FOR_M: Final = (50.0, 1500.0)
UNPROTECTED_SHARE: Final = 0.2  # of the runs, without slide protection
WHEEL_SIGMA: Final = 0.005
CREEP_MAX: Final = 0.003
CONICITY: Final = (0.0, 0.05, 0.1)
EVERY_ROWS: Final = 10  # of a run's trace that are kept, of one a second


class TagDefect(StrEnum):
    """What is wrong with a tag."""

    MISSED = "missed"
    MOVED = "moved"
    WRONG = "another's id"
    FOREIGN = "an id of another track"
    SWAPPED = "swapped"
    ADDED = "added"


LIES: Final = (
    TagDefect.MOVED,
    TagDefect.WRONG,
    TagDefect.SWAPPED,
)  # where the train may be believed where it is not


@dataclass(slots=True)
class LaidTag:
    """A tag of a run: where it truly lies and where units believe it (path coordinates, m), and what it says."""

    tag_id: int
    believed_m: float
    true_m: float
    says: int | None
    ill: TagDefect | None = None
    group: int = -1  # of swapped ones, the number of the pair

    def heal(self) -> None:
        """Nothing is wrong with it."""
        self.true_m, self.says, self.ill, self.group = self.believed_m, self.tag_id, None, -1


class SlipperyStretch(NamedTuple):
    """A slippery stretch of the way, m, with what is left of the dry rail's adhesion."""

    from_m: float
    to_m: float
    share: float


@dataclass(frozen=True, slots=True)
class DrawnRun:
    """One run as drawn: what is so and what the unit believes, ids read instead of others, slippery stretches."""

    number: int
    scenario: str
    setup: Setup
    says: Mapping[int, int | None]
    stretches: tuple[SlipperyStretch, ...]
    ills: tuple[TagDefect, ...]


class FusionOutcome(msgspec.Struct, frozen=True):
    """What came of a run. `out_m`: by how much the truth was out of the bounds at worst (> 0: broken)."""

    number: int
    scenario: str
    seed: int
    steps: int
    known_steps: int
    out_m: float
    out_at_m: float
    arrived: bool
    ills: dict[str, int]
    read: int
    doubted: int
    faults: int  # position faults
    halves_m: list[float]  # half of what the bounds spanned, at times in motion while the position was known
    halves_at_m: list[float]  # the front's true place then


@dataclass(frozen=True, slots=True)
class FusionRule:
    """What units go by in a run; the defaults are the ones they have. Each may be switched off by name."""

    name: str = "as units are"
    tags_wrong_together: int | None = None
    wheel_error_share: float | None = None
    carries: tuple[str, ...] = ("tags",)
    only: tuple[TagDefect, ...] = field(default=tuple(TagDefect))
    forgives: bool = False  # receivers do not count what may hide in slides and gaps
    forgives_jumps: bool = False  # nor those of curvature a bias that jumps
    alone: str = ""  # of the sensors of a joint run this one alone

    def with_rule(self, setup: Setup) -> Setup:
        """The setup with this rule."""
        update: dict[str, float] = {}
        if self.tags_wrong_together is not None:
            update["tags_wrong_together"] = self.tags_wrong_together
        if self.wheel_error_share is not None:
            update["wheel_error_share"] = self.wheel_error_share
            update["wheel_scale_limit"] = min(setup.unit.wheel_scale_limit, self.wheel_error_share)
        sensors = setup.sensors.model_validate(setup.sensors.model_dump() | {"carries": self.carries})
        return replace(setup, unit=setup.unit.model_copy(update=update), sensors=sensors)


AS_UNITS_ARE: Final = FusionRule()


@cache
def base_setup(scenario: str) -> Setup:
    """A shipped scenario's setup."""
    return load_scenario(scenario, 1).setup


def draw(seed: int, number: int) -> DrawnRun:
    """The run of this seed and number."""
    chance = generator(seed, "position fusion", str(number))
    scenario = str(chance.choice(LINES, p=LINE_SHARES))
    setup = replace(base_setup(scenario), seed=int(chance.integers(1, 2**31)))
    stock_id = setup.timetable.diagrams[0].stock_id
    path = drawn_up(setup, setup.line)[stock_id][0].mission.path
    believed = setup.line
    if chance.random() < 0.5:
        believed = replace(believed, tags=random_tags(chance, path))
    believed = furnished_line(believed, path)  # for trains that carry more than tags
    laid = laid_tags(chance, believed, path)
    conicity, axle = float(chance.choice(CONICITY)), str(chance.choice(["leading", "trailing"]))
    sensors = setup.sensors.model_copy(
        update={
            "wheel_factor_sigma": WHEEL_SIGMA,
            "creep_share": float(chance.uniform(0.0, CREEP_MAX)),
            "tread_conicity": conicity,
            "tachometer_axle": axle,
        }
    )
    trains = setup.trains
    if chance.random() < UNPROTECTED_SHARE:
        trains = {name: unprotected(train) for name, train in trains.items()}
    true_line = replace(believed, tags=true_tags(believed, path, laid))
    says = {tag.tag_id: tag.says for tag in laid if tag.says != tag.tag_id}
    ills = tuple(tag.ill for tag in laid if tag.ill is not None)
    stretches = slippery_stretches(chance, path.length_m)
    setup = replace(setup, line=true_line, belief=Belief(believed), sensors=sensors, trains=trains)
    return DrawnRun(number, scenario, setup, says, stretches, ills)


def random_tags(chance: np.random.Generator, path: Path) -> dict[int, Tag]:
    """Tags at random places of a path, some close to one another and some far."""
    spacing_m = float(chance.uniform(0.05, 0.25)) * min(path.length_m, 12_000.0)
    tags: dict[int, Tag] = {}
    at_m = float(chance.exponential(spacing_m))
    while at_m < path.length_m - 1.0:
        piece_id, km_m = path.locate(at_m)
        tag_id = FIRST_RANDOM_ID + len(tags)
        tags[tag_id] = Tag(tag_id, piece_id, km_m, TagPurpose.POSITION, (path.direction,))
        near = chance.random() < 0.4
        at_m += 5.0 + float(chance.uniform(0.0, 60.0) if near else chance.exponential(spacing_m))
    return tags


def laid_tags(chance: np.random.Generator, line: Line, path: Path) -> list[LaidTag]:
    """The tags of a path with what is wrong with them, and those that nobody knows of, in the order of the way."""
    laid = [
        LaidTag(tag.id, at_m, at_m, tag.id)
        for tag in line.tags.values()
        if tag.piece_id in path and path.direction in tag.directions
        for at_m in [path.to_path_m(tag.piece_id, tag.position_m)]
    ]
    laid.sort(key=lambda tag: tag.believed_m)
    kinds = [ill for ill in TagDefect if ill is not TagDefect.ADDED]
    for index, tag in enumerate(laid):
        if tag.ill is None and chance.random() < FAULT_SHARE:
            fall_ill(
                chance,
                laid,
                index,
                TagDefect(str(chance.choice([str(kind) for kind in kinds]))),
                path.length_m,
            )
    keep_to_the_model(laid)
    for tag in laid:  # a train begins on the portal's tag, and its crew says truly where that is
        portal = tag.tag_id in line.tags and line.tags[tag.tag_id].purpose is TagPurpose.PORTAL
        if portal and tag.ill is TagDefect.MOVED:
            tag.heal()
    if chance.random() < 0.1:
        at_m = float(chance.uniform(0.0, path.length_m - 1.0))
        laid.append(LaidTag(UNKNOWN_ID - 1, at_m, at_m, UNKNOWN_ID - 1, TagDefect.ADDED))
    return laid


def fall_ill(
    chance: np.random.Generator, laid: Sequence[LaidTag], index: int, ill: TagDefect, end_m: float
) -> None:
    """Make something wrong with a tag; nothing where that cannot be (no neighbour to be mixed up with)."""
    tag = laid[index]
    beside = laid[index + 1] if index + 1 < len(laid) else None
    if ill in (TagDefect.WRONG, TagDefect.SWAPPED) and (beside is None or beside.ill is not None):
        return
    tag.ill = ill
    if ill is TagDefect.MISSED:
        tag.says = None
    elif ill is TagDefect.FOREIGN:
        tag.says = UNKNOWN_ID
    elif ill is TagDefect.MOVED:
        by_m = MOVED_M.draw(chance) * float(chance.choice([-1.0, 1.0]))
        tag.true_m = min(max(tag.believed_m + by_m, 1.0), end_m - 1.0)
    elif beside is not None:
        tag.says = beside.tag_id
        if ill is TagDefect.SWAPPED:
            beside.ill, beside.says = ill, tag.tag_id
            tag.group = beside.group = index


def keep_to_the_model(laid: Sequence[LaidTag]) -> None:
    """Heal what would make two tags lie that are read one after another, but for those that were swapped."""
    while True:
        read = sorted((tag for tag in laid if tag.says is not None), key=lambda tag: tag.true_m)
        lying = [tag.ill in LIES for tag in read]
        broken = [
            (first, second)
            for index, (first, second) in enumerate(pairwise(read))
            if lying[index] and lying[index + 1] and (first.group < 0 or first.group != second.group)
        ]
        if not broken:
            return
        second = broken[0][1]
        for tag in [one for one in laid if one is second or (one.group == second.group >= 0)]:
            tag.heal()


def true_tags(line: Line, path: Path, laid: Iterable[LaidTag]) -> dict[int, Tag]:
    """The tags as they truly lie: the line's own, with those of the path where they are."""
    tags = dict(line.tags)
    for one in laid:
        piece_id, km_m = path.locate(one.true_m)
        purpose = line.tags[one.tag_id].purpose if one.tag_id in line.tags else TagPurpose.POSITION
        if one.tag_id not in line.tags or one.true_m != one.believed_m:
            tags[one.tag_id] = Tag(one.tag_id, piece_id, km_m, purpose, (path.direction,))
    return tags


def slippery_stretches(chance: np.random.Generator, length_m: float) -> tuple[SlipperyStretch, ...]:
    """Slippery stretches of a way, up to four, one behind the other."""
    stretches: list[SlipperyStretch] = []
    at_m = float(chance.uniform(0.0, length_m))
    while at_m < length_m and len(stretches) < 4:
        to_m = at_m + float(chance.uniform(*SLIPPERY_FOR_M))
        stretches.append(SlipperyStretch(at_m, to_m, SLIPPERY.draw(chance)))
        at_m = to_m + float(chance.uniform(100.0, length_m))
    return tuple(stretches)


def run_of(drawn: DrawnRun, rule: FusionRule = AS_UNITS_ARE) -> PositionRun:
    """The run as drawn, under a rule, ready to run."""
    rails = [moment for stretch in drawn.stretches for moment in slippery(*stretch)]
    run = PositionRun(rule.with_rule(drawn.setup), rails)
    run.trains.tag_faults.update(drawn.says)
    run.trains.readers[SLOT].gnss.forgives = int(rule.forgives)
    run.trains.readers[SLOT].curvature.forgives_jumps = int(rule.forgives_jumps)
    return run


def outcome(seed: int, number: int, rule: FusionRule = AS_UNITS_ARE) -> FusionOutcome:
    """Draw a run and let it run."""
    drawn = draw(seed, number)
    return outcome_of(seed, drawn, run_of(drawn, rule).run())


def outcome_of(seed: int, drawn: DrawnRun, result: PositionResult) -> FusionOutcome:
    """What came of a run that was drawn so."""
    seen = in_motion(result.trace[result.stated])[::EVERY_ROWS]
    happened = [note for _, _, note in result.notes]
    return FusionOutcome(
        drawn.number,
        drawn.scenario,
        seed,
        result.steps,
        result.known_steps,
        result.out_m,
        result.out_at_m,
        result.arrived,
        {str(ill): drawn.ills.count(ill) for ill in TagDefect},
        sum(isinstance(note, TagRead) for note in happened),
        sum(isinstance(note, TagDoubted) for note in happened),
        sum(isinstance(note, PositionFault) for note in happened),
        [round(float(half_m), 2) for half_m in half_widths_m(seen)],
        [round(float(at_m), 1) for at_m in seen["position_m"]],
    )
