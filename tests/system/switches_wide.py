"""Behaviours that can be taken away of blocks, of LiDARs, of batteries, and of what a dispatcher does and says."""

from collections.abc import Collection

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from network.model import Line
from network.path import Path
from onboard.charge import ChargeRules
from onboard.reach import Reach
from simulation.world import path_pool
from simulation.world.trains import Trains
from tests.system.switchboard import switch
from wayside import bidden, cutting, dispatch, parts
from wayside.config import RouteEntry
from wayside.register import BiddenUnit, Register


@switch
def grants_a_block_too_many(patch: pytest.MonkeyPatch) -> None:
    """The part of a way that is free ends with the first section of the train ahead."""
    free_part = parts.free_part

    def one_more(
        register: Register, unit_id: str, route: RouteEntry, wanted: tuple[str, ...]
    ) -> tuple[str, ...]:
        part = free_part(register, unit_id, route, wanted)
        return wanted[: len(part) + 1] if part else part

    patch.setattr(dispatch, "free_part", one_more)


@switch
def has_its_markers_elsewhere(patch: pytest.MonkeyPatch) -> None:
    """Trains have each group of markers 3 m further on than it lies."""
    as_laid = path_pool.markers_on

    def moved(line: Line, path: Path, broken: Collection[int] | None = None) -> NDArray[np.void]:
        rows = as_laid(line, path, broken or ())
        if broken is None:  # as units know them
            rows["position_m"] += 3.0
        return rows

    patch.setattr(path_pool, "markers_on", moved)


@switch
def reckons_with_ten_times_the_way(patch: pytest.MonkeyPatch) -> None:
    """A set predicts that it needs ten times as much charge."""
    needed_j = ChargeRules.needed_j

    def too_much_j(self: ChargeRules, reach: Reach, *, commits: bool) -> float:
        return 10.0 * needed_j(self, reach, commits=commits)

    patch.setattr(ChargeRules, "needed_j", too_much_j)


@switch
def takes_no_delay_for_one_that_nobody_knows(patch: pytest.MonkeyPatch) -> None:
    """Where no train would be late, whether to cut one is weighed as where nobody knows how all can finish."""
    delay_s = cutting.delay_s
    patch.setattr(cutting, "delay_s", lambda *asked: delay_s(*asked) or float("inf"))


@switch
def keeps_trains_back_for_ever(patch: pytest.MonkeyPatch) -> None:
    """What a dispatcher has said of a train is over by his word alone."""
    enter = bidden._with

    def without_end(register: Register, unit_id: str, said: BiddenUnit) -> Register:
        return enter(register, unit_id, said if said.next_train else replace(said, until_s=float("inf")))

    patch.setattr(bidden, "_with", without_end)


@switch
def stays_in_hand(patch: pytest.MonkeyPatch) -> None:
    """A train that was driven by hand is not given back to its law."""
    drive = Trains.drive

    def by_hand_alone(self: Trains, slot: int, notch: int | None) -> None:
        if notch is not None:
            drive(self, slot, notch)

    patch.setattr(Trains, "drive", by_hand_alone)
