"""When two trains on plain track touch, by front and rear on each piece: SUMO's judgement, made again without SUMO.

On each piece of track that two trains lie on and one of them has its front on (`Look`):

- from behind: the rear of the one ahead is more than `OVERLAP_M` behind the front of the one that follows;
- head-on: they have a point in common, each reaching back by what it runs in a step at its speed, so that none gets
  through another between two steps.

Points in between make no difference: a train lies on every piece from its front to its rear, by the way it came.
What is found is what SUMO finds, in the same step, save that SUMO, where three trains lie on one piece, compares one
whose front is beyond with the hindmost alone. What SUMO has no eyes for can be looked for besides:

- fouling: one lies on the normal leg of points and one on the reverse leg. That trains clear each other beyond the
  legs' ends (車両接触限界) is assumed. In a run the checkers judge that by the section of the points, on any carrier.
"""

from __future__ import annotations

from enum import Flag, auto
from typing import Final, NamedTuple

from network.model import Direction
from simulation.carriers.carrier import Truth

OVERLAP_M: Final = 0.001  # SUMO's NUMERICAL_EPS, by which it lets a train run into the one ahead (MSLane)


class Look(Flag):
    """What the check looks for; each may be left out by name."""

    NOTHING = 0
    FROM_BEHIND = auto()
    HEAD_ON = auto()
    FOULING = auto()
    AS_SUMO = FROM_BEHIND | HEAD_ON


class Extent(NamedTuple):
    """Where a train lies, along the piece in question: front and rear from where its direction enters that, m.

    Either may be beyond the piece's ends; `leads`: the front is on it. `step_m`: what it runs in a step at the speed
    that it has now.
    """

    direction: Direction
    front_m: float
    rear_m: float
    step_m: float
    leads: bool


def touch(one: Extent, other: Extent, length_m: float, look: Look) -> bool:
    """Whether two trains that both lie on a piece of that length touch."""
    if not one.leads and not other.leads:
        return False
    if one.direction is other.direction:
        first, second = (one, other) if one.front_m > other.front_m else (other, one)
        return Look.FROM_BEHIND in look and first.rear_m - second.front_m < -OVERLAP_M
    high_m, low_m = one.front_m, one.rear_m - one.step_m
    other_low_m, other_high_m = length_m - other.front_m, length_m - other.rear_m + other.step_m
    return Look.HEAD_ON in look and high_m >= other_low_m and other_high_m >= low_m


def text_of(one_id: str, one: Truth, other_id: str, other: Truth) -> str:
    """A collision in a line, the same from whatever carrier."""
    (first_id, first), (second_id, second) = sorted(((one_id, one), (other_id, other)))
    how = "from behind" if one.direction is other.direction else "head-on"
    return f"collision {how} of {_at(first_id, first)} with {_at(second_id, second)}"


def _at(unit_id: str, truth: Truth) -> str:
    way = "down" if truth.direction is Direction.DOWN else "up"
    return f"{unit_id} ({way} on {truth.piece_id} at {truth.offset_m:.1f} m)"
