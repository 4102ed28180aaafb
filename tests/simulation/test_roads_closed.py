"""When a road is closed although no train comes: by hand, for a road at 500 m of the way and a train of 40 m."""

from types import SimpleNamespace
from typing import Any

import pytest

from network.model import CrossingClass, CrossingControl, Direction, LevelCrossing
from simulation.roads_closed import LOOKS_ALONG_M, RoadsClosedForNothing

ROAD_M = 500.0


def crossing(control: CrossingControl) -> LevelCrossing:
    """Its road from km 0.5 to 0.506, its contacts 300 m before it and 20 m beyond."""
    return LevelCrossing(
        "C",
        "C",
        CrossingClass.BARRIERS,
        control,
        "P",
        503.0,
        6.0,
        8.0,
        15.0,
        20.0,
        {Direction.DOWN: 200.0, Direction.UP: 806.0},
        {Direction.DOWN: 526.0, Direction.UP: 480.0},
    )


class Way:
    """A way over one piece of track, whose metres are those of the line."""

    direction = Direction.DOWN

    def __contains__(self, piece_id: object) -> bool:
        return piece_id == "P"

    def to_road_m(self, _crossing: LevelCrossing) -> float:
        return ROAD_M


def for_nothing(
    front_m: float,
    *,
    speed_mps: float = 0.0,
    holds: bool = True,
    works: bool = True,
    closes: bool = True,
    control: CrossingControl = CrossingControl.RADIO,
) -> bool:
    own = crossing(control)
    line = SimpleNamespace(pieces={"P": SimpleNamespace(section_id="S")})
    trains: Any = SimpleNamespace(
        setup=SimpleNamespace(line=line),
        active=lambda: [0],
        true_path=lambda _slot: Way(),
        truths=[SimpleNamespace(position_m=front_m)],
        bodies=[SimpleNamespace(length_m=40.0)],
        plants=[SimpleNamespace(speed_mps=speed_mps)],
    )
    shown = SimpleNamespace(held=("S",) if holds else ())
    on_board: Any = SimpleNamespace(
        unpowered=set[int]() if works else {0}, shown_to_driver=lambda _slot: shown
    )
    crossings: Any = SimpleNamespace(on_line=(own,), equipment={"C": SimpleNamespace(closes=closes)})
    return RoadsClosedForNothing(trains, on_board, crossings).for_nothing() == ("C",)


@pytest.mark.parametrize(
    ("front_m", "how", "nothing"),
    [
        (400.0, {}, False),  # stands before it, and may come over it
        (400.0, {"holds": False}, True),
        (400.0, {"works": False}, True),
        (400.0, {"works": False, "speed_mps": 5.0}, False),
        (ROAD_M - LOOKS_ALONG_M - 1.0, {"works": False, "speed_mps": 5.0}, True),
        (500.0, {"works": False}, False),  # its front is on the road
        (546.0, {"works": False}, False),  # so is its rear
        (546.1, {"works": False}, True),
        (546.1, {"speed_mps": 5.0}, True),
    ],
)
def test_a_train_comes_to_a_road(front_m: float, how: dict[str, Any], nothing: bool) -> None:
    assert for_nothing(front_m, **how) is nothing


@pytest.mark.parametrize(
    ("front_m", "nothing"), [(199.9, True), (200.0, False), (566.0, False), (566.1, True)]
)
def test_between_contacts_a_dead_train_keeps_the_road_closed(front_m: float, nothing: bool) -> None:
    """Its front at the first contact, and its rear at the last one: 526 + 40 m."""
    assert for_nothing(front_m, works=False, control=CrossingControl.CONTACTS) is nothing


def test_an_open_road_is_closed_for_nothing_by_nobody() -> None:
    assert not for_nothing(0.0, holds=False, closes=False)
