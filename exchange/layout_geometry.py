"""What the lie of the land says: which of three tracks that meet is the stem of points, which track is the nearest."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from exchange.layout import LayoutTrack, Place, Spot, TurnoutSide

CHORD_M: Final = 30.0  # over which a track's direction from a node counts: about the length of a turnout
THROUGH_DEG_MIN: Final = 120.0  # less, and no train runs from one track into the other
LIKE_DEG: Final = 0.5  # two legs equally straight, but for where the mappers clicked


@dataclass(frozen=True, slots=True)
class ForkLegs:
    """Indices of the three tracks given: the stem, its straighter leg and the other; `side` seen from the toe."""

    stem: int
    straight: int
    branch: int
    side: TurnoutSide
    alike: bool  # the legs bend alike: which is the straighter one is a guess


def direction_from(shape: Sequence[Place], *, from_high: bool) -> Place:
    """Unit vector from one end of a track to where it is CHORD_M on, or to its other end."""
    points = list(reversed(shape)) if from_high else list(shape)
    x, y = points[0]
    for px, py in points[1:]:
        if math.hypot(px - x, py - y) >= CHORD_M:
            break
    else:
        px, py = points[-1]
    length = math.hypot(px - x, py - y)
    return ((px - x) / length, (py - y) / length) if length > 0 else (0.0, 0.0)


def angle_deg(one: Place, other: Place) -> float:
    """Angle between two directions, 0 to 180."""
    return math.degrees(math.acos(max(-1.0, min(1.0, one[0] * other[0] + one[1] * other[1]))))


def stem_and_legs(directions: Sequence[Place]) -> ForkLegs | None:
    """Stem and legs of three tracks, by their directions away from the node; None where they form no points."""
    pairs = {(a, b): angle_deg(directions[a], directions[b]) for a, b in ((0, 1), (0, 2), (1, 2))}
    legs = min(pairs, key=lambda pair: pairs[pair])
    stem = 3 - sum(legs)
    straightness = {leg: angle_deg(directions[stem], directions[leg]) for leg in legs}
    if min(straightness.values()) < THROUGH_DEG_MIN:
        return None
    straight, branch = sorted(legs, key=lambda leg: -straightness[leg])
    (x, y), (bx, by) = directions[straight], directions[branch]
    side = TurnoutSide.LEFT if x * by - y * bx > 0 else TurnoutSide.RIGHT
    alike = abs(straightness[straight] - straightness[branch]) < LIKE_DEG
    return ForkLegs(stem, straight, branch, side, alike)


def length_of_m(shape: Sequence[Place]) -> float:
    """Length of a polyline, m."""
    return sum(math.hypot(bx - ax, by - ay) for (ax, ay), (bx, by) in pairwise(shape))


def nearest_spot(place: Place, tracks: Iterable[LayoutTrack], within_m: float) -> Spot | None:
    """The nearest spot of any track within a distance, m."""
    best: tuple[float, Spot] | None = None
    for track in tracks:
        along_m = 0.0
        for (ax, ay), (bx, by) in pairwise(track.shape):
            length_m = length_of_m([(ax, ay), (bx, by)])
            share = ((place[0] - ax) * (bx - ax) + (place[1] - ay) * (by - ay)) / max(length_m**2, 1e-9)
            share = min(max(share, 0.0), 1.0)
            at = (ax + share * (bx - ax), ay + share * (by - ay))
            far_m = length_of_m([place, at])
            if far_m <= within_m and (best is None or far_m < best[0]):
                best = far_m, Spot(track.id, round(along_m + share * length_m, 6))
            along_m += length_m
    return None if best is None else best[1]
