"""How one section is had by one train: the moments that say it, and the occupation that they make.

A run (`study.capacity.observed`) and theory (`study.capacity.theory`) find the moments; what they mean is decided here
alone, so that the two are cut alike.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

from network.model import Direction
from study.capacity.occupation import TOUCH_S, Occupation, OccupationPart, Slice
from study.measures.register_holds import Throwing


@dataclass(frozen=True, slots=True)
class PassageStand:
    """A stand of the train, s, and what it would be for in the section in which its front is."""

    part: OccupationPart
    begin_s: float
    end_s: float


def setting_out(
    sent_s: float, heard_s: float, held_s: float, throwing: Iterable[Throwing], departs_s: float
) -> Iterator[PassageStand]:
    """What a train stands for while its first way is set: request, grant, and points that are proven as it departs."""
    yield PassageStand(OccupationPart.AIR, sent_s, heard_s)
    yield PassageStand(OccupationPart.GRANT, heard_s, held_s)
    for each in throwing:
        if each.proven_s <= departs_s + TOUCH_S:
            yield PassageStand(OccupationPart.AIR, each.sent_s, each.taken_s)
            yield PassageStand(OccupationPart.THROW, each.taken_s, each.locked_s)
            yield PassageStand(OccupationPart.PROOF, each.locked_s, each.proven_s)


@dataclass(frozen=True, slots=True)
class SectionPassage:
    """The moments of one section, s; infinite where one does not come, minus infinity where it lies before the day.

    In their order: the section could be had and is wanted, the request that is granted is sent, the manager hears it,
    the unit holds the section, its front comes in, goes out, the true rear is out, the safe rear is, the unit reports
    that it is clear, the register has it free. `throwing` and `standing` lie anywhere within.
    """

    section_id: str
    stock_id: str
    number: str
    direction: Direction
    route_id: str
    wanted_s: float
    sent_s: float
    heard_s: float
    held_s: float
    enters_s: float
    leaves_s: float
    rear_s: float
    safe_rear_s: float
    reported_s: float
    freed_s: float
    throwing: tuple[Throwing, ...] = ()
    standing: tuple[PassageStand, ...] = ()
    waited_s: float = 0.0


LAST_STANDS = True  # off: the last train of the day passes the terminus at which its day ends
_COMING = (
    OccupationPart.REQUEST,
    OccupationPart.AIR,
    OccupationPart.GRANT,
    OccupationPart.APPROACH,
    OccupationPart.RUN,
    OccupationPart.LENGTH,
    OccupationPart.BOUND,
    OccupationPart.RULE,
    OccupationPart.RELEASE,
)


def occupation_of(passage: SectionPassage, ends_s: float = math.inf) -> Occupation:
    """The occupation that the moments make; it ends at `ends_s`, when the day is over, if nothing ends it before.

    A moment that comes before the one that should precede it counts as at once with that.
    """
    moments = (
        passage.wanted_s,
        passage.sent_s,
        passage.heard_s,
        passage.held_s,
        passage.enters_s,
        passage.leaves_s,
        passage.rear_s,
        # at a mark the driver sees more than the unit is sure of
        min(passage.safe_rear_s, passage.reported_s),
        passage.reported_s,
        passage.freed_s,
    )
    end_s = max(min(passage.freed_s, ends_s), passage.wanted_s)
    times: list[float] = []
    for moment_s in moments:
        times.append(min(max(moment_s, times[-1] if times else moment_s), end_s))
    stretches = [Slice(part, *ends) for part, ends in zip(_COMING, pairwise(times), strict=True)]
    slices = [piece for stretch in stretches for piece in _painted(stretch, passage)]
    joined = list(_joined(slices)) or [Slice(OccupationPart.RUN, end_s, end_s)]
    # who comes to a stand as the day ends does not pass
    if LAST_STANDS and passage.enters_s <= end_s < passage.leaves_s:
        ends = [Slice(s.part, end_s, end_s) for s in passage.standing if abs(s.begin_s - end_s) <= TOUCH_S]
        joined += ends[-1:]
    return Occupation(
        passage.section_id,
        passage.stock_id,
        passage.number,
        passage.direction,
        tuple(joined),
        passage.enters_s,
        passage.leaves_s if passage.leaves_s <= end_s else math.inf,
        passage.route_id,
        passage.waited_s,
    )


def _painted(stretch: Slice, passage: SectionPassage) -> Iterator[Slice]:
    """A stretch, with what is done in it: points set and stands while it lies ahead, stands with the front in it."""
    over: list[Slice] = []
    if stretch.part is OccupationPart.APPROACH:
        over += [Slice(OccupationPart.READY, s.begin_s, s.end_s) for s in passage.standing]
        for each in passage.throwing:
            over.append(Slice(OccupationPart.AIR, each.sent_s, each.taken_s))
            over.append(Slice(OccupationPart.THROW, each.taken_s, each.locked_s))
            over.append(Slice(OccupationPart.PROOF, each.locked_s, each.proven_s))
    elif stretch.part is OccupationPart.RUN:
        over += [Slice(s.part, s.begin_s, s.end_s) for s in passage.standing]
    ends = {min(max(t, stretch.begin_s), stretch.end_s) for o in over for t in (o.begin_s, o.end_s)}
    for begin_s, end_s in pairwise(sorted({stretch.begin_s, stretch.end_s, *ends})):
        middle_s = (begin_s + end_s) / 2.0
        found = [o.part for o in over if o.begin_s <= middle_s < o.end_s]
        yield Slice(found[-1] if found else stretch.part, begin_s, end_s)


def _joined(slices: Iterable[Slice]) -> tuple[Slice, ...]:
    """Without slices of no length, neighbours of one part as one."""
    found: list[Slice] = []
    for one in slices:
        if one.length_s <= TOUCH_S:
            continue
        if found and found[-1].part is one.part:
            found[-1] = Slice(one.part, found[-1].begin_s, one.end_s)
        else:
            # What was too short to keep is made up for here: slices touch.
            begin_s = found[-1].end_s if found else one.begin_s
            found.append(Slice(one.part, begin_s, one.end_s))
    return tuple(found)
