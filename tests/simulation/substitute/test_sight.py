"""What those who let a train into a track look at, whatever the plan says of who comes there."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from simulation.substitute.sight import LineSight
from tests.simulation.substitute.test_book import HOP


@pytest.mark.parametrize(
    ("held", "unpowered", "under", "may"),
    [
        ((), (), (), True),
        (("B.1",), (), (), False),  # by authority for a track that is not its own in the plan
        (("B.1",), (1,), (), True),  # who cannot run by it any more
        (("B.2",), (), ("B.2",), True),
        ((), (), ("B.1",), False),
    ],
)
def test_nobody_is_let_into_a_track_to_which_another_has_authority_or_in_which_it_is(
    held: tuple[str, ...], unpowered: tuple[int, ...], under: tuple[str, ...], may: bool
) -> None:
    shown = {0: ("B.1",), 1: held}
    world = SimpleNamespace(
        setup=None,
        wayside=None,
        trains=SimpleNamespace(
            slot_of={HOP.stock_id: 0, "V2": 1}, sections_under=lambda: {"V2": frozenset(under)}
        ),
        on_board=SimpleNamespace(
            unpowered=set(unpowered), shown_to_driver=lambda slot: SimpleNamespace(held=shown[slot])
        ),
    )
    duties = SimpleNamespace(of_stock={})
    sight = LineSight(cast("Any", world), cast("Any", duties), cast("Any", None))
    assert sight._may_be_let_in(HOP, HOP.after_block) is may
