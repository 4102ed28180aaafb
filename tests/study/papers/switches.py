"""What reproductions guard and can be taken away, each under the name of its function (as in `tests.system`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import pytest

from onboard.driving import stop_keeper, tuning
from onboard.driving.tasc import WHOLE_LAW, DesignRow, Part
from onboard.driving.tuning import Fit, Learned, StopRecord
from onboard.records import BehaviourRow
from study.papers import oda_tuning, single_train, table4_stops
from vehicle.records import TrainRow

Switch = Callable[[pytest.MonkeyPatch], None]

SWITCHES: Final[dict[str, Switch]] = {}


def switch(function: Switch) -> Switch:
    """Enter a switch under its name."""
    SWITCHES[function.__name__] = function
    return function


# the stop law -------------------------------------------------------------------------------------------------


@switch
def prediction_removed(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(stop_keeper, "WHOLE_LAW", WHOLE_LAW & ~Part.PREDICTION)


@switch
def redrawing_removed(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(stop_keeper, "WHOLE_LAW", WHOLE_LAW & ~Part.REDRAWING)


@switch
def feed_forward_removed(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(stop_keeper, "WHOLE_LAW", WHOLE_LAW & ~Part.FEED_FORWARD)


@switch
def resistance_not_taken_off(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(stop_keeper, "WHOLE_LAW", WHOLE_LAW & ~Part.RESISTANCE)


@switch
def soft_end_removed(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(stop_keeper, "WHOLE_LAW", WHOLE_LAW & ~Part.SOFT_END)


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

    def aside(record: StopRecord, centre: tuple[int, int]) -> Fit | None:
        return approximate(record, (centre[0] + 6, centre[1] + 6))

    patch.setattr(oda_tuning, "approximate", aside)
