"""A circle as people read it: which train has which sections for how long, one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from network.model import Direction
from plan.moving.proof import Circle
from study.capacity.compression import held_sections
from study.capacity.legs import SetLeg


@dataclass(frozen=True, slots=True)
class Stint:
    """A train from having one section to freeing another, or the same, with the shortest stands between, s."""

    direction: Direction
    takes: str
    frees: str
    length_s: float


def stints_of(legs: Sequence[SetLeg], circle: Circle, tick_s: float) -> list[Stint]:
    """The stints that a circle is made of: the next one waits for what the one before it frees."""
    held = held_sections(legs)
    begins_s = {(one.occupation.section_id, one.begins): one.occupation.begin_s for one in held}
    ends_s = {(one.occupation.section_id, one.ends): one.occupation.end_s for one in held}
    handed = [at for at, bound in enumerate(circle.bounds) if bound.section_id]
    found: list[Stint] = []
    for at, then in zip(handed, [*handed[1:], *(at + len(circle.bounds) for at in handed[:1])], strict=True):
        comes, goes = circle.bounds[at], circle.bounds[then % len(circle.bounds)]
        stands = (circle.bounds[i % len(circle.bounds)].least for i in range(at + 1, then))
        length_s = ends_s[goes.section_id, goes.before] - begins_s[comes.section_id, comes.after]
        direction = legs[comes.after].direction
        found.append(Stint(direction, comes.section_id, goes.section_id, length_s + sum(stands) * tick_s))
    return found
