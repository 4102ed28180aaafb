import numpy as np

from onboard.driving.tuning import OFFSET_STEP_MPS2, Learned, StopDecelerations, search
from study.record.shown import LearnedTrain
from study.report.papers import _learned
from study.report.tasc import most_telling, response_surface


def a_stop(dead_steps: int = 8, offset_mps2: float = -2 * OFFSET_STEP_MPS2) -> StopDecelerations:
    """A brake of 0.6 m/s^2 for 25 s that answers late and weakly."""
    designed = np.concatenate([np.zeros(25), np.full(250, 0.6)])
    actual = np.concatenate([np.zeros(25 + dead_steps), np.full(250 - dead_steps, 0.6 + offset_mps2)])
    return StopDecelerations(designed, actual)


def learned(dead_time_index: int, offset_index: int) -> Learned:
    dead_times = tuple(4 * int(index == dead_time_index) for index in range(21))
    offsets = tuple(4 * int(index == offset_index) for index in range(21))
    return Learned("V1", 0.5, dead_times, offsets, 1, (dead_time_index, offset_index))


def test_the_surface_is_least_where_the_search_finds_it() -> None:
    stop = a_stop()
    surface = response_surface(stop)
    assert surface is not None
    assert surface.shape == (21, 21)
    row, column = divmod(int(surface.argmin()), 21)
    assert (column, row) == (8, 8)  # 0.8 s, two steps below no offset
    fit = search(stop)
    assert fit is not None
    assert (fit.dead_time_index, fit.offset_index) == (column, row)


def test_a_stop_without_braking_has_no_surface() -> None:
    stop = StopDecelerations(np.zeros(200), np.zeros(200))
    assert response_surface(stop) is None


def test_the_train_farthest_from_its_design_is_shown() -> None:
    tuned = {"V1": LearnedTrain(learned(5, 10), a_stop()), "V2": LearnedTrain(learned(9, 6), a_stop())}
    assert most_telling(tuned) == "V2"
    assert most_telling({}) is None
    (table,) = _learned(tuned)
    row = {column.label: column.as_dict()["values"][1] for column in table.columns}
    assert row == {
        "unit": "V2", "stops_counted": 4, "left_out": 1, "dead_time_designed": 0.5, "dead_time_learned": 0.9,
        "offset_learned": -0.4,
    }  # fmt: skip
    assert _learned({}) == ()
