"""What is left out of a curve can be read off what is kept, within the tolerance, at the same time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from study.report.data import ReportedRun
from study.report.thinning import kept_samples, strands

TOLERANCES = np.array([5.0, 1.5])
Floats = NDArray[np.float64]


def worst_shares(t_s: Floats, values: Floats, indices: NDArray[np.int64]) -> Floats:
    """How far the straight lines between the samples kept are from the samples, of the tolerance; by curve."""
    away = [np.interp(t_s, t_s[indices], column[indices]) - column for column in values.T]
    return np.abs(np.column_stack(away)).max(axis=0) / TOLERANCES


rising = st.lists(st.floats(0.1, 30.0), min_size=1, max_size=120).map(np.cumsum)
numbers = st.floats(-300.0, 300.0)


@given(t_s=rising, data=st.data())
def test_what_is_left_out_is_within_tolerance(t_s: Floats, data: st.DataObject) -> None:
    count = len(t_s)
    both = [data.draw(st.lists(numbers, min_size=count, max_size=count)) for _ in range(2)]
    values = np.array(both, dtype=np.float64).T
    indices = kept_samples(t_s, values, TOLERANCES)
    assert indices[0] == 0 and indices[-1] == count - 1
    assert (np.diff(indices) > 0).all()
    assert (worst_shares(t_s, values, indices) <= 1.0 + 1e-9).all()


@given(t_s=rising, slope=st.floats(-20.0, 20.0), at=numbers)
def test_of_a_straight_line_the_ends_are_kept(t_s: Floats, slope: float, at: float) -> None:
    line = at + slope * t_s
    assert (
        kept_samples(t_s, np.column_stack([line, 0.01 * line]), TOLERANCES).tolist()
        == [0, len(t_s) - 1][: len(t_s)]
    )


def test_a_jump_at_one_time_is_kept() -> None:
    t_s = np.array([0.0, 10.0, 10.0, 20.0])
    values = np.array([[0.0, 0.0], [0.0, 0.0], [100.0, 0.0], [100.0, 0.0]])
    assert kept_samples(t_s, values, TOLERANCES).tolist() == [0, 1, 2, 3]


def test_a_real_course_needs_a_tenth_of_its_samples(weekday: ReportedRun) -> None:
    course = max(weekday.courses.values(), key=len)
    t_s = course["t_s"].to_numpy()
    values = np.column_stack([course["kilometrage_m"].to_numpy(), course["speed_mps"].to_numpy() * 3.6])
    indices = kept_samples(t_s, values, TOLERANCES)
    assert (worst_shares(t_s, values, indices) <= 1.0 + 1e-9).all()
    assert len(indices) < 0.12 * len(t_s)


@pytest.mark.parametrize(
    ("values", "labels", "expected"),
    [
        ([1.0, 2.0], None, [(0, 2)]),
        ([1.0, np.nan, 2.0, 3.0], None, [(0, 1), (2, 4)]),
        ([np.nan], None, []),
        ([], None, []),
        ([1.0, 2.0, 3.0], [0, 0, 1], [(0, 2), (2, 3)]),
    ],
)
def test_a_strand_has_no_gap_and_one_label(
    values: list[float], labels: list[int] | None, expected: list[tuple[int, int]]
) -> None:
    given_labels = None if labels is None else np.array(labels, dtype=np.int64)
    found = strands(np.array(values, dtype=np.float64), given_labels)
    assert [(part.start, part.stop) for part in found] == expected
