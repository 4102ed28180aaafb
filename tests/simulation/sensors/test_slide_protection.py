"""The slide protection knows what its axles show, and from that alone tells nearly all that the wheels do."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from onboard.board import SENSED
from simulation.sensors import tachometer
from simulation.sensors.scene import SCENE
from simulation.sensors.slide_protection import SlideProtectionRow, fit_train, rolls_at, slide_protection
from simulation.sensors.table import SENSORS_ROW
from vehicle.dynamics import step
from vehicle.record import dtype_of
from vehicle.train_file import load_train, new_plant, shipped_train

STEP_S = 0.1
TRAIN = load_train(shipped_train("ev_e301")).row
ROW = dtype_of(SlideProtectionRow)


class Run:
    """A train with its protection, a step at a time; `speed_shown` stands in for the truth where given."""

    def __init__(
        self,
        speed_mps: float,
        diameters_differ: float = 0.0,
        share_max: float = 0.3,
        wheel_factor: float = 1.0,
    ) -> None:
        self.train = np.array(TRAIN)
        self.train["wheel_slide_share_max"] = share_max
        self.plant = new_plant(1, speed_mps).view(np.recarray)[0]
        self.own = np.zeros(1, dtype=ROW).view(np.recarray)[0]
        self.scene = np.zeros(1, dtype=SCENE).view(np.recarray)[0]
        self.sensed = np.zeros(1, dtype=SENSED).view(np.recarray)[0]
        self.sensors = np.zeros(1, dtype=SENSORS_ROW).view(np.recarray)[0]
        tachometer.fit_train(self.sensors.tachometer, self.train.view(np.recarray)[0], wheel_factor)
        fit_train(self.own, self.train.view(np.recarray)[0], diameters_differ)
        rolls_at(self.own, speed_mps)

    def go(self, notch: float, adhesion: float, emergency: bool = False, truth: float | None = None) -> int:
        """One step; what the protection shows after it."""
        self.plant.adhesion_factor = adhesion
        self.plant.last_axle_released = int(self.sensed.wheel_slide < 0)
        step(self.plant, self.train[0], notch, emergency, 0.0, 0.0, STEP_S)
        self.scene.speed_mps = self.plant.speed_mps if truth is None else truth
        self.scene.wheel_mps, self.scene.last_wheel_mps = (
            self.plant.wheel_speed_mps,
            self.plant.last_wheel_speed_mps,
        )
        self.scene.step_s = STEP_S
        slide_protection(self.own, self.sensors, self.scene, self.sensed)
        return int(self.sensed.wheel_slide)

    @property
    def slip_mps(self) -> float:
        """Of the first axle, over the train."""
        return float(self.plant.wheel_speed_mps - self.plant.speed_mps)


def test_it_shows_the_same_whatever_the_train_does() -> None:
    """Only axles are looked at: the true speed may be anything."""
    for truth in (0.0, 7.0, 100.0):
        told, free = Run(18.0), Run(18.0)
        shown = [(told.go(-7.0, 0.4, truth=truth), free.go(-7.0, 0.4)) for _ in range(250)]
        assert all(one == other for one, other in shown)
        assert {one for one, _ in shown} == {-1, 0}


@given(
    notches=st.lists(st.integers(-7, 5), min_size=1, max_size=8),
    speed=st.floats(0.0, 27.0),
    differ=st.floats(-0.01, 0.01),
)
def test_on_dry_rail_wheels_roll(notches: list[int], speed: float, differ: float) -> None:
    run = Run(speed, differ)
    for notch in notches:
        assert {run.go(float(notch), 1.0) for _ in range(30)} == {0}


phases = st.lists(
    st.tuples(st.sampled_from([-7.0, -5.0, -3.0, 0.0, 5.0]), st.floats(0.1, 1.0), st.integers(5, 60)),
    min_size=1,
    max_size=8,
)


@given(phases=phases, speed=st.floats(3.0, 27.0), differ=st.floats(-0.01, 0.01), emergency=st.booleans())
@example([(-7.0, 0.1, 60)] * 8, 27.0, 0.01, False)  # all axles slide, to the depth that protection allows
@example([(-7.0, 0.55, 60)] * 4, 18.0, 0.0, False)  # the last one rolls
def test_what_it_does_not_see_is_within_what_a_bound_grows_by(
    phases: list[tuple[float, float, int]], speed: float, differ: float, emergency: bool
) -> None:
    """2 % of the way, and half a metre a slide for the moment until it is seen."""
    run = Run(speed, differ)
    unseen_m = way_m = 0.0
    changes, before = 1, 0
    for notch, adhesion, steps in phases:
        for _ in range(steps):
            shown = run.go(notch, adhesion, emergency and notch < 0.0)
            changes += int(shown != before)
            before = shown
            way_m += float(run.plant.speed_mps) * STEP_S
            if (run.slip_mps < 0.0 and shown >= 0) or (run.slip_mps > 0.0 and shown <= 0):
                unseen_m += abs(run.slip_mps) * STEP_S
    assert unseen_m <= 0.02 * way_m + 0.5 * changes


def test_a_slide_of_all_axles_is_seen_to_its_end() -> None:
    """Adhesion 0.05 and full service brake: every wheel would slide; the axle that is let go shows the speed."""
    run = Run(20.0)
    slid = told = 0
    while run.plant.speed_mps > 1.0:
        shown = run.go(-7.0, 0.2)
        if run.slip_mps < -0.1 * run.plant.speed_mps:
            slid += 1
            told += int(shown < 0)
    assert slid > 100
    assert told >= slid - 3


def test_without_the_axle_that_is_let_go_the_end_of_a_slide_is_seen_too_early() -> None:
    """What the test before this one rests on."""
    run = Run(20.0)
    missed = 0
    while run.plant.speed_mps > 1.0:
        shown = run.go(-7.0, 0.2)
        run.sensed.wheel_slide = 0  # the last axle keeps its brake
        missed += int(shown >= 0 and run.slip_mps < -0.1 * run.plant.speed_mps)
    assert missed > 50


def test_a_trailing_axle_shows_that_driven_ones_slip() -> None:
    run = Run(2.0)
    shown = [run.go(5.0, 0.25) for _ in range(60)]
    assert run.slip_mps > 0.5
    assert shown[-1] == 1
    for _ in range(100):
        shown.append(run.go(0.0, 1.0))
    assert run.slip_mps == pytest.approx(0.0)
    assert shown[-1] == 0
