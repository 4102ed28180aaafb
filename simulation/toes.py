"""Fronts that come to the toe of points: a train goes where the blades lie, whatever it was to do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from network.model import PointsLeg
from simulation.events import Danger
from simulation.world.stage import World


class Toes:
    """`unsafe` writes down what must never happen to a train, by its slot, and at which points."""

    def __init__(self, world: World, unsafe: Callable[[int, Danger, str], None]) -> None:
        self._line: Final = world.setup.line
        self._trains, self._wayside, self._signs = world.trains, world.wayside, world.signs
        self._unsafe: Final = unsafe

    def cross(self, slot: int, step: int) -> None:
        """The front is about to leave its piece: over points it goes where the blades really lie."""
        line = self._line
        before, expected = self._trains.crossing(slot)
        leaving, entering = line.pieces[before], line.pieces[expected]
        if leaving.leg is PointsLeg.STEM and leaving.points_id == entering.points_id and leaving.points_id:
            points = line.points[leaving.points_id]
            position = self._wayside.position_of(points.id)
            if position is None:
                self._unsafe(slot, Danger.NO_POSITION, points.id)
                return
            onto = points.normal_piece if position.value == "normal" else points.reverse_piece
            if onto != expected:
                self._unsafe(slot, Danger.WRONG_WAY, points.id)
                self._trains.divert(slot, onto)
                self._signs.look_ahead(slot)
        elif (
            leaving.points_id
            and leaving.leg in (PointsLeg.NORMAL, PointsLeg.REVERSE)
            and entering.leg is PointsLeg.STEM
        ):
            position = self._wayside.position_of(leaving.points_id)
            if position is None or position.value != leaving.leg.value:
                self._unsafe(slot, Danger.SET_AGAINST, leaving.points_id)
                self._wayside.force(step, leaving.points_id)
