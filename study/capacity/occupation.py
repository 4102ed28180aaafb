"""Blocking times: for how long a section is one train's and nobody else's, and what that time goes into.

One type for the times of a run and for those of theory: pictures, conflicts, headway and capacity are made from these
alone. An occupation is cut without gaps into slices, so that the parts make up the whole.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from types import MappingProxyType
from typing import Final

from network.graph import overlap_id
from network.model import Direction

TOUCH_S: Final = 1e-6  # instants nearer than this are one


class OccupationCost(StrEnum):
    """What time is spent on, as a planner would change it."""

    RADIO = "radio"
    POINTS = "points"
    LOCALISATION = "localisation"
    RULE = "release rule"
    DRIVING = "driving"
    PEOPLE = "people"
    CHARGING = "charging"

    @property
    def column(self) -> str:
        """Its name in a table, s."""
        return f"{self.value.replace(' ', '_')}_s"


class OccupationPart(StrEnum):
    """What an occupation goes into at one instant, in the order in which the parts usually come."""

    REQUEST = "request"  # it could be had and is wanted: until the request that is granted is sent
    AIR = "air"  # that request, or a command to points, on its way
    GRANT = "grant"  # until the unit counts the section as held
    THROW = "throw"  # the terminal has the command: until the points are locked as needed
    PROOF = "proof"  # until the unit has the proof of it
    APPROACH = "approach"  # it is the train's, whose front comes nearer
    READY = "ready"  # the same, but the train stands and waits for its time, or for people
    RUN = "run"  # from front in to front out, as far as it moves
    DWELL = "dwell"  # it stands in it, at a stop
    HELD = "held"  # it stands in it, before a stop limit
    CHANGE_ENDS = "change of ends"
    LAYOVER = "layover"  # it stands where one train ends and the next begins
    CHARGING = "charging"
    START = "start"  # it may leave: until its brakes have let go and it moves
    LENGTH = "length"  # front out: until the true rear is out
    BOUND = "bound"  # until the safe rear is out
    RULE = "rule"  # until the rule of release has it given back: at a tag, as a whole route
    RELEASE = "release"  # until the register has freed it


COST_OF: Final[Mapping[OccupationPart, OccupationCost]] = MappingProxyType(
    {
        OccupationPart.REQUEST: OccupationCost.RADIO,
        OccupationPart.AIR: OccupationCost.RADIO,
        OccupationPart.GRANT: OccupationCost.RADIO,
        OccupationPart.THROW: OccupationCost.POINTS,
        OccupationPart.PROOF: OccupationCost.RADIO,
        OccupationPart.APPROACH: OccupationCost.DRIVING,
        OccupationPart.READY: OccupationCost.PEOPLE,
        OccupationPart.RUN: OccupationCost.DRIVING,
        OccupationPart.DWELL: OccupationCost.PEOPLE,
        OccupationPart.HELD: OccupationCost.DRIVING,
        OccupationPart.CHANGE_ENDS: OccupationCost.PEOPLE,
        OccupationPart.LAYOVER: OccupationCost.PEOPLE,
        OccupationPart.CHARGING: OccupationCost.CHARGING,
        OccupationPart.START: OccupationCost.DRIVING,
        OccupationPart.LENGTH: OccupationCost.DRIVING,
        OccupationPart.BOUND: OccupationCost.LOCALISATION,
        OccupationPart.RULE: OccupationCost.RULE,
        OccupationPart.RELEASE: OccupationCost.RADIO,
    }
)


@dataclass(frozen=True, slots=True)
class Slice:
    """A stretch of an occupation, s after midnight, and what it goes into."""

    part: OccupationPart
    begin_s: float
    end_s: float

    @property
    def length_s(self) -> float:
        """How long it is."""
        return self.end_s - self.begin_s


@dataclass(frozen=True, slots=True)
class Occupation:
    """One section, one train's from the first slice to the last.

    `enters_s` and `leaves_s`: when its front comes in and goes out; infinite where it was there when the day began, or
    stays. `route_id`: by which it came in; empty where it was there. `waited_s`: for how long it had wanted the section
    while that was another's; no part of the occupation.
    """

    section_id: str
    stock_id: str
    number: str
    direction: Direction
    slices: tuple[Slice, ...]
    enters_s: float
    leaves_s: float
    route_id: str = ""
    waited_s: float = 0.0

    def __post_init__(self) -> None:
        """ValueError where slices are missing, of negative length, or do not touch."""
        if not self.slices:
            raise ValueError(f"{self.section_id}, {self.number}: no slices")
        if any(s.length_s < -TOUCH_S for s in self.slices):
            raise ValueError(f"{self.section_id}, {self.number}: a slice that ends before it begins")
        if any(abs(b.begin_s - a.end_s) > TOUCH_S for a, b in pairwise(self.slices)):
            raise ValueError(f"{self.section_id}, {self.number}: slices that do not touch")

    @property
    def begin_s(self) -> float:
        """From when on nobody else can have the section."""
        return self.slices[0].begin_s

    @property
    def end_s(self) -> float:
        """From when on others can have it again."""
        return self.slices[-1].end_s

    @property
    def length_s(self) -> float:
        """How long it is."""
        return self.end_s - self.begin_s

    @property
    def is_overlap(self) -> bool:
        """Whether it is no section, but what one train at a time may have where trains come in."""
        return self.section_id.endswith(overlap_id(""))

    def of_part(self, part: OccupationPart) -> float:
        """How much of it goes into a part, s."""
        return math.fsum(s.length_s for s in self.slices if s.part is part)

    def costs_s(self) -> Mapping[OccupationCost, float]:
        """How much goes into each cost, s; together the length."""
        found: dict[OccupationCost, list[float]] = {cost: [] for cost in OccupationCost}
        for one in self.slices:
            found[COST_OF[one.part]].append(one.length_s)
        return {cost: math.fsum(lengths) for cost, lengths in found.items()}

    def moved(self, by_s: float) -> Occupation:
        """The same occupation so much later."""
        slices = tuple(Slice(s.part, s.begin_s + by_s, s.end_s + by_s) for s in self.slices)
        return Occupation(
            self.section_id,
            self.stock_id,
            self.number,
            self.direction,
            slices,
            self.enters_s + by_s,
            self.leaves_s + by_s,
            self.route_id,
            self.waited_s,
        )


@dataclass(frozen=True, slots=True)
class Conflict:
    """Two trains that want one section at one time, s: in a run that cannot be, in theory it is what does not fit."""

    section_id: str
    first: Occupation
    second: Occupation
    overlap_s: float


def by_section(occupations: Iterable[Occupation]) -> dict[str, list[Occupation]]:
    """The occupations of each section, in order of time."""
    found: dict[str, list[Occupation]] = defaultdict(list)
    for one in sorted(occupations, key=lambda o: (o.begin_s, o.end_s, o.number)):
        found[one.section_id].append(one)
    return dict(found)


def conflicts_of(occupations: Iterable[Occupation]) -> tuple[Conflict, ...]:
    """Each pair of occupations of one section by two stocks that overlap, in order of time."""
    found: list[Conflict] = []
    for section_id, ordered in by_section(occupations).items():
        for index, first in enumerate(ordered):
            for second in ordered[index + 1 :]:
                if second.begin_s >= first.end_s - TOUCH_S:
                    break
                if second.stock_id != first.stock_id:
                    overlap_s = min(first.end_s, second.end_s) - second.begin_s
                    found.append(Conflict(section_id, first, second, overlap_s))
    return tuple(sorted(found, key=lambda c: (c.second.begin_s, c.section_id)))
