"""Where a train is in thirds of spans, and what `onboard.motion` would make of that."""

from __future__ import annotations

from typing import Final

from onboard.duty.records import PlaceInJoints

PLACES_A_SPAN: Final = 3  # whole in it; perhaps beyond the next joint; surely beyond, its rear still behind


def place_in_joints(spot: int, end: int, *, known: bool, moves: bool, emergency: bool) -> PlaceInJoints:
    """The place of a train `spot` thirds on its plan, with a mark at 0 and one at `end`."""
    if not known:
        return PlaceInJoints(stands=not moves, emergency=emergency)
    span, part = divmod(spot, PLACES_A_SPAN)
    here = span + (part == 2)
    perhaps = span + 1 + (part > 0)
    return PlaceInJoints(
        known=True,
        stands=not moves,
        emergency=emergency,
        here=here,
        sure=here + 1,
        perhaps=perhaps,
        clear=span,
        clear_at_mark=span,
        reach=perhaps,
        near={0: 0, end: 1}.get(spot, -1),
        passed=int(spot == end and not moves),
    )
