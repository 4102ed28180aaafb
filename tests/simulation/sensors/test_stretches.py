"""The length of a stretch changes nothing: the kernel in stretches of any lengths, compared bit by bit."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.driving.stop_keeper import believed_dead_time_s, fill_design
from onboard.driving.tuning import Learned
from onboard.records import MODE_DRIVE
from simulation.carriers.plain_track import PlainTrack
from simulation.settings import Vision
from simulation.setup import STEP_S, Setup
from simulation.world.kernel import advance, new_sheet
from simulation.world.records import PASSED_FRONT, PASSED_REAR, PASSED_TAG, TRACE
from simulation.world.roster import draw_up
from simulation.world.trains import Trains

STEPS = 600  # to beyond the tags 601 to 603, a stop sign in range for most of it
SIGN_M = 560.0


def course(setup: Setup, lengths: list[int]) -> tuple[np.ndarray, list[tuple[int, float]]]:
    """All that is on board after STEPS steps, in stretches of these lengths over and over, and the tags read."""
    pieces_m = {piece.id: round(piece.length_m, 6) for piece in setup.line.pieces.values()}
    trains = Trains(replace(setup, vision=Vision()), PlainTrack(pieces_m, STEP_S))
    trains.place(0, draw_up(setup.line, setup.timetable, {"K1": 40.0}, 0.0)["K1"][0])
    unit = trains.units[0]
    unit.mode, unit.stop_limit_m, unit.target_stop_m, unit.cruise_mps = MODE_DRIVE, 640.0, 600.0, 11.0
    learned = Learned("K1", believed_dead_time_s(trains.kinds[0]))
    fill_design(trains.designs[0], trains.kinds[0], trains.behaviours[0], learned)
    unit.position_m, unit.position_known = trains.truths[0].position_m, 1
    unit.bound_ahead_m = unit.bound_behind_m = 5.0
    unit.odometer_scale, unit.bound_growth, unit.restricted_mps = 1.0, 0.02, np.inf
    unit.expected_tag_m = unit.rear_trigger_m = unit.position_trigger_m = np.inf
    trains.readers[0].sign.mark_m, trains.truths[0].sign_m = SIGN_M - 10.0, SIGN_M
    trains.set_rail(0, 1.0)
    sheet, trace, used, step, turn = new_sheet(1), np.zeros(5000, dtype=TRACE), 0, 0, 0
    read: list[tuple[int, float]] = []
    while step < STEPS:
        steps = min(lengths[turn % len(lengths)], STEPS - step)
        done, used, _ = advance(trains.stock, trains.pool.track, sheet, trace, used, step, steps)
        step, turn = step + done, turn + 1
        passed = int(sheet.passed[0])
        if passed & PASSED_TAG:
            tag_id, _, odometer_m = trains.read_tag(0)
            read.append((tag_id, odometer_m))
        if passed & (PASSED_FRONT | PASSED_REAR):
            trains.set_boundaries(0)
    return trains.stock.copy(), read


@pytest.fixture(scope="module")
def whole(rtri_setup: Setup) -> tuple[np.ndarray, list[tuple[int, float]]]:
    return course(rtri_setup, [50])


@given(lengths=st.lists(st.integers(1, 50), min_size=1, max_size=20))
def test_stretches_of_any_lengths_leave_the_same_bits(
    rtri_setup: Setup, whole: tuple[np.ndarray, list[tuple[int, float]]], lengths: list[int]
) -> None:
    stock, read = course(rtri_setup, lengths)
    assert read == whole[1]
    assert stock.tobytes() == whole[0].tobytes()


def test_the_course_has_noise_in_it(
    rtri_setup: Setup, whole: tuple[np.ndarray, list[tuple[int, float]]]
) -> None:
    """Else the comparison would show nothing: with another seed tags and sign are read elsewhere."""
    stock, read = course(replace(rtri_setup, seed=2), [50])
    assert len(read) >= 3
    assert read != whole[1]
    seen = whole[0]["board"]["readers"]["sign"]["seen"][0]
    assert seen == 1
    assert stock["board"]["unit"]["position_m"][0] != whole[0]["board"]["unit"]["position_m"][0]
