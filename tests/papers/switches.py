"""What reproductions guard and can be taken away, each under the name of its function (as in `tests.system`)."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Final

import numpy as np
import pytest
from numpy.typing import NDArray

from onboard.driving import stop_keeper, tuning
from onboard.driving.tasc import WHOLE_LAW, DesignRow, StopLawPart
from onboard.driving.tuning import CharacteristicFit, Learned, StopDecelerations
from onboard.records import BehaviourRow
from papers import (
    oda_table4,
    oda_tuning,
    position_sets,
    single_train,
    stop_set,
    stop_statistics,
    stop_window,
    table4_stops,
)
from papers.position_run import Moment
from papers.reproduction import CaseRow
from vehicle.records import TrainRow

Switch = Callable[[pytest.MonkeyPatch], None]

SWITCHES: Final[dict[str, Switch]] = {}


def missed(rows: Iterable[CaseRow]) -> list[str]:
    """Cases that did not pass."""
    return [row.case for row in rows if not row.passed]


def switch(function: Switch) -> Switch:
    """Enter a switch under its name."""
    SWITCHES[function.__name__] = function
    return function


# the stop law -------------------------------------------------------------------------------------------------


def _without(part: StopLawPart) -> Switch:
    return lambda patch: patch.setattr(stop_keeper, "WHOLE_LAW", WHOLE_LAW & ~part)


SWITCHES.update(
    prediction_removed=_without(StopLawPart.PREDICTION),
    redrawing_removed=_without(StopLawPart.REDRAWING),
    feed_forward_removed=_without(StopLawPart.FEED_FORWARD),
    resistance_not_taken_off=_without(StopLawPart.RESISTANCE),
    soft_end_removed=_without(StopLawPart.SOFT_END),
)


@switch
def gain_0(patch: pytest.MonkeyPatch) -> None:
    fill = stop_keeper.fill_design

    def without_gain(design: DesignRow, train: TrainRow, behaviour: BehaviourRow, learned: Learned) -> None:
        fill(design, train, behaviour, learned)
        design.gain_per_s = 0.0

    patch.setattr(single_train, "fill_design", without_gain)


# the camera ---------------------------------------------------------------------------------------------------


@switch
def frame_error_reversed(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(table4_stops, "FRAME_S", -table4_stops.FRAME_S)


@switch
def null_method_has_beacons_and_signs(patch: pytest.MonkeyPatch) -> None:
    """A null method that is the method: what it meets, nothing shows."""
    patch.setattr(oda_table4, "unseen_cells", oda_table4.cells_of_table4)


# self-tuning --------------------------------------------------------------------------------------------------


@switch
def mode_replaced_by_mean(patch: pytest.MonkeyPatch) -> None:
    def mean(counts: tuple[int, ...]) -> int:
        return round(sum(index * count for index, count in enumerate(counts)) / sum(counts))

    patch.setattr(tuning, "_mode", mean)


@switch
def disturbed_stops_kept(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(tuning, "disturbance", lambda *_: None)


@switch
def six_points_off_their_centre(patch: pytest.MonkeyPatch) -> None:
    """The six points lie six steps of dead time and offset beside what is expected, where J is no bowl."""
    approximate = tuning.approximate

    def aside(record: StopDecelerations, centre: tuple[int, int]) -> CharacteristicFit | None:
        return approximate(record, (centre[0] + 6, centre[1] + 6))

    patch.setattr(oda_tuning, "approximate", aside)


# stops at scale and the set -----------------------------------------------------------------------------------


@switch
def shares_of_the_variance_by_chance(patch: pytest.MonkeyPatch) -> None:
    share = stop_statistics.first_order_share

    def by_chance(values: NDArray[np.float64], errors_m: NDArray[np.float64]) -> float:
        return share(np.roll(values, values.size // 3), errors_m)

    patch.setattr(stop_statistics, "first_order_share", by_chance)


@switch
def brakes_beyond_the_stated_range(patch: pytest.MonkeyPatch) -> None:
    draw = stop_set.random_brakes

    def worn(rng: np.random.Generator, n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        brakes, adhesions = draw(rng, n)
        return brakes * (1.0, 1.0, 0.85), adhesions

    patch.setattr(stop_window, "random_brakes", worn)


def _edge_shifted(share: float) -> Switch:
    lowest_shares = stop_set.lowest_shares

    def shifted(
        shares: NDArray[np.float64], least_m: NDArray[np.float64], most_m: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        lowest = np.clip(lowest_shares(shares, least_m, most_m) + share, 0.0, None)
        return np.where(lowest > 1.0, np.inf, lowest)

    return lambda patch: patch.setattr(stop_set, "lowest_shares", shifted)


SWITCHES.update(set_taken_too_large=_edge_shifted(-0.4), set_taken_too_small=_edge_shifted(0.2))


# where trains are ---------------------------------------------------------------------------------------------------


@switch
def creeping_reflections_claimed_to_be_held(patch: pytest.MonkeyPatch) -> None:
    """What no reader can see: the bounds break, and the reproduction must say so."""
    creeping = [replace(each, held=True) for each in position_sets.TROUBLES if not each.held]
    patch.setattr(position_sets, "TROUBLES", tuple(creeping))


@switch
def faults_do_nothing(patch: pytest.MonkeyPatch) -> None:
    def nothing(*_: object) -> list[Moment]:
        return []

    patch.setattr(position_sets, "moments_of", nothing)
