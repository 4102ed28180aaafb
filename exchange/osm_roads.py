"""What OpenStreetMap says of a level crossing (踏切): with what it is protected, by its tags.

The tags are those of the OpenStreetMap wiki, Tag:railway=level_crossing and Key:crossing:barrier.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from network.model import CrossingClass

ROAD_TAGS: Final = frozenset({"level_crossing", "crossing"})  # values of `railway`: of roads, of footpaths


def protection_of(tags: Mapping[str, str]) -> CrossingClass | None:
    """What `crossing:barrier`, `crossing:light` and `crossing:bell` come to; None where they say nothing."""
    barrier = tags.get("crossing:barrier")
    if barrier is not None and barrier != "no":
        return CrossingClass.BARRIERS
    warnings = [tags.get(f"crossing:{what}") for what in ("light", "bell")]
    if any(given not in (None, "no") for given in warnings):
        return CrossingClass.WARNING
    unprotected = barrier == "no" or "no" in warnings or tags.get("crossing") == "uncontrolled"
    return CrossingClass.NO_DEVICE if unprotected else None
