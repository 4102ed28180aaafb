"""Where a front crosses points it goes where the blades lie: what is unsafe is written down, and forced is broken."""

from types import SimpleNamespace
from typing import Any

import pytest

from network.model import Position
from simulation.events import Danger, Unsafe
from simulation.setup import Setup
from simulation.toes import Toes


class World:
    """Stands for the world: a train about to go from one piece to the next, over P7 as it lies."""

    def __init__(self, setup: Setup, before: str, expected: str, position: Position | None) -> None:
        self.setup = setup
        self.texts: list[str] = []
        self.forced: list[str] = []
        self.diverted: list[str] = []
        self.signs = SimpleNamespace(look_ahead=lambda _slot: None)
        self.trains = SimpleNamespace(
            crossing=lambda _slot: (before, expected),
            divert=lambda _slot, onto: self.diverted.append(onto),
        )
        self.wayside = SimpleNamespace(
            position_of=lambda _points: position, force=lambda _step, points_id: self.forced.append(points_id)
        )

    def unsafe(self, _slot: int, danger: Danger, points_id: str) -> None:
        self.texts.append(Unsafe(unit_id="K1", danger=danger, points_id=points_id).text)


def crossed(setup: Setup, before: str, expected: str, position: Position | None) -> World:
    world: Any = World(setup, before, expected, position)
    Toes(world, world.unsafe).cross(0, 1)
    found: World = world
    return found


@pytest.mark.parametrize(
    ("position", "texts", "diverted"),
    [
        (Position.NORMAL, [], []),
        (Position.REVERSE, ["was sent the wrong way at points P7"], ["P7.reverse"]),
        (None, ["ran onto points P7 that lie in no position"], []),
    ],
)
def test_towards_the_blades(
    rtri_setup: Setup, position: Position | None, texts: list[str], diverted: list[str]
) -> None:
    world = crossed(rtri_setup, "P7.stem", "P7.normal", position)
    assert (world.texts, world.diverted, world.forced) == (texts, diverted, [])


@pytest.mark.parametrize("position", [Position.NORMAL, Position.REVERSE, None])
def test_from_the_heel_points_set_against_a_train_are_forced(
    rtri_setup: Setup, position: Position | None
) -> None:
    world = crossed(rtri_setup, "P7.normal", "P7.stem", position)
    right = position is Position.NORMAL
    assert world.forced == ([] if right else ["P7"])
    assert world.texts == ([] if right else ["ran through points P7 set against it"])
