"""A train as fast as its wheels may be keeps below supervision before ends and lower limits."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from onboard.board import BoardRow
from onboard.driving.below_supervision import ROW_M
from onboard.driving.laws.pid import PidRow
from onboard.driving.laws.settings import fit_law
from onboard.driving.pattern import pattern_of
from onboard.driving.stop_keeper import fill_design
from onboard.driving.stopping import LIMIT_MARGIN_M
from onboard.driving.supervision import RESERVE_M
from onboard.driving.tuning import Learned
from onboard.notches import brake_below_mps2, driven_notch
from onboard.records import UnitRow
from tests.nightly import A_FIFTH
from tests.onboard.drive_along import NO_PLAN, START_M, TRACK_M, Course, drive_along
from vehicle.train_file import load_train, shipped_train

PID: Final = "pid"


@dataclass(frozen=True)
class Doubted:
    """A train whose wheels are worth more or less than they show, by a share of what its unit allows for."""

    growth: float
    share: float = 1.0
    permille: float = 0.0
    load_share: float = 0.5
    speed_mps: float = 15.0  # as shown
    bound_m: float = 20.0
    weak: bool = False  # SKR 200 brakes with 0.91 m/s2 after 1.6 s, EV-E301 with 1.0 after 0.9
    law: str = "hold_speed"

    def run(self, board: BoardRow, limits_mps: NDArray[np.float64], steps: int) -> Course:
        elevation_m = np.arange(float(TRACK_M)) * self.permille / 1000.0
        path = pattern_of(elevation_m, np.zeros(TRACK_M), limits_mps, board.kind, board.behaviour)
        rows, worth = path.view(np.recarray), 1.0 + self.share * self.growth
        return drive_along(board, rows, self.permille, self.load_share, self.speed_mps, steps, worth)

    @property
    def way_m(self) -> float:
        """Enough for the weak brake on any of these descents, whose guaranteed 0.73 m/s2 are 0.48 at 25 permille."""
        fast_mps = self.speed_mps * (1.0 + self.growth)
        return 50.0 + 2.0 * self.bound_m + 6.0 * fast_mps + fast_mps**2 / (2.0 * 0.45)


DOUBTED = st.builds(
    Doubted,
    st.floats(0.0, 0.25),
    st.floats(-1.0, 1.0),
    st.floats(-25.0, 25.0),
    st.floats(0.0, 1.0),
    st.floats(4.0, 18.0),
    st.floats(0.5, 60.0),
    st.booleans(),
)
Doubts = Callable[[Doubted], BoardRow]


@pytest.fixture
def doubts(boards: Callable[[], BoardRow]) -> Doubts:
    """The board of such a train."""
    weak = load_train(shipped_train("skr200_4")).row

    def make(own: Doubted) -> BoardRow:
        board = boards()
        if own.weak:
            board.kind = weak[0]
            board.behaviour.service_guaranteed_mps2, board.behaviour.service_reaction_s = 0.8 * 0.91, 2.1
            board.behaviour.emergency_guaranteed_mps2, board.behaviour.emergency_reaction_s = 0.8, 2.1
            fill_design(board.design, board.kind, board.behaviour, Learned("K1", 0.8))
        fit_law(board.laws, own.law)
        board.unit.bound_ahead_m = board.unit.bound_behind_m = own.bound_m
        board.unit.bound_growth = own.growth
        return board

    return make


def slows_below_supervision(board: BoardRow, own: Doubted, limit_mps: float) -> None:
    limits_mps, from_m = np.full(TRACK_M, 25.0), int(START_M + own.way_m)
    limits_mps[from_m : from_m + 200] = limit_mps
    course = own.run(board, limits_mps, 1000)
    assert course.interventions == 0
    assert course.position_m[-1] + own.bound_m > from_m


def stops_below_supervision(board: BoardRow, own: Doubted, before_m: float) -> None:
    """A mark so far before the stop limit. It ends at the nearer, 5 m before the limit where its front may be furthest.

    Bounds grow under it in the last second, and predictions do not know: by a metre or two it stands nearer.
    """
    unit, limit_m = board.unit, START_M + own.way_m
    unit.stop_limit_m, unit.target_stop_m = limit_m, limit_m - before_m
    course = own.run(board, np.full(TRACK_M, 25.0), 3000)
    assert course.interventions == 0
    assert course.speed_mps[-1] == 0.0
    assert course.position_m[-1] + own.bound_m < limit_m  # as far ahead as it may be, by the truth
    short_m = min(unit.target_stop_m, limit_m - unit.bound_ahead_m - LIMIT_MARGIN_M) - unit.position_m
    assert -2.5 < short_m < 1.0


@pytest.mark.parametrize(
    ("own", "limit_mps"),
    [
        # its curve falls by 0.4 m/s from one row to the next
        (Doubted(0.2, speed_mps=8.0, bound_m=12.9), 1.9),
        # its motors pull on while the brake is asked for
        (Doubted(0.25, 0.0, 16.9, 0.2, 6.9, 18.0, weak=True), 10.1),
        (Doubted(0.2), 8.0),
    ],
)
def test_supervision_has_nothing_to_do_before_a_lower_limit(
    doubts: Doubts, own: Doubted, limit_mps: float
) -> None:
    slows_below_supervision(doubts(own), own, limit_mps)


@pytest.mark.parametrize(
    ("own", "before_m"),
    [
        # wheels as they show, but the pattern is above the weak brake's curve
        (Doubted(0.0, weak=True), 5.0),
        (Doubted(0.2), 5.0),
        (Doubted(0.2), 40.0),
        (Doubted(0.2, permille=-25.0), 5.0),
        # at the end the emergency brake is first
        (Doubted(0.25, permille=17.0, bound_m=50.0, weak=True), 5.0),
        (Doubted(0.2, share=-1.0), 40.0),
    ],
)
def test_nor_has_it_before_an_end(doubts: Doubts, own: Doubted, before_m: float) -> None:
    stops_below_supervision(doubts(own), own, before_m)


def pid_of(board: BoardRow) -> PidRow:
    """What its `pid` keeps."""
    own: PidRow = getattr(board.laws, PID)
    return own


def at_speed(board: BoardRow, shown_mps: float) -> UnitRow:
    """Its unit, at START_M on a free track, coasting at a speed with brakes released."""
    unit = board.unit
    unit.position_m, unit.path_rows, unit.notch, unit.notch_held_s = START_M, TRACK_M, 0.0, 10.0
    unit.speed_mps = unit.train_mps = shown_mps
    return unit


@pytest.mark.parametrize(("growth", "pulls"), [(0.0, True), (0.25, False)])
def test_power_that_would_have_to_be_braked_once_it_acts_is_not_given(
    doubts: Doubts, track: Callable[..., NDArray[np.void]], growth: float, pulls: bool
) -> None:
    """After a brake `pid` asks for all notches: 0.7 m/s2 or more from 0.5 s on, for a second and more until they fade.

    Limit 20 m/s, kept up to 20.3; wheels that show 16 m/s and may be worth a quarter more have 20, and then more.
    """
    board = doubts(Doubted(growth, law=PID))
    unit, own = at_speed(board, 16.0), pid_of(board)
    own.stops, own.error_mps, own.change_mps2 = 0, 0.2, 3.0
    path = track(np.zeros(TRACK_M), 20.0)
    assert brake_below_mps2(board, path, 0.0) == 0.0
    unit.permitted_mps = unit.ceiling_mps = 20.0
    assert bool(driven_notch(board, path, NO_PLAN) > 0.0) is pulls


def test_a_train_that_creeps_up_to_its_end_comes_to_rest(
    doubts: Doubts, track: Callable[..., NDArray[np.void]]
) -> None:
    """Its front may be 0.3 m short of where nothing is left to run: no curve falls any more, and it would creep on."""
    board = doubts(Doubted(0.0, bound_m=20.0))
    unit = at_speed(board, 0.05)
    unit.stop_limit_m = START_M + 20.0 + RESERVE_M + ROW_M + 0.3
    assert brake_below_mps2(board, track(np.zeros(TRACK_M)), 0.0) >= 0.5


@A_FIFTH
@given(own=DOUBTED, before_m=st.floats(5.0, 60.0), limit_mps=st.floats(1.4, 14.0))
def test_nor_has_it_whatever_the_train(
    doubts: Doubts, own: Doubted, before_m: float, limit_mps: float
) -> None:
    stops_below_supervision(doubts(own), own, before_m)
    slows_below_supervision(doubts(own), own, limit_mps)
