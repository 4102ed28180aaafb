"""The cameras of line runs: the shipped error figures against the renderer, and frames while a sign is in range."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from radio.chance import generator
from simulation.agenda import Agenda, Due
from simulation.carriers.plain_track import PlainTrack
from simulation.sensors.camera import LINE_CAMERA, LINE_SIGN, Renderer, record_table, sighted_distances
from simulation.sensors.eyes import Eyes, line_sightings
from simulation.settings import Vision
from simulation.setup import STEP_S, Setup
from simulation.world.roster import draw_up
from simulation.world.trains import Trains


@pytest.mark.parametrize("distance_m", [15.0, 30.0])
def test_the_figures_are_those_of_the_renderer(distance_m: float) -> None:
    """Spread of 60 rendered images within a third: that of a sample's own sigma is 9 %."""
    renderer = Renderer(LINE_CAMERA, 7)
    table = record_table(renderer, LINE_SIGN, [float(d) for d in range(8, 37, 2)], 7, repeats=2)
    rng = generator(7, "test", f"{distance_m:g}")
    rendered = sighted_distances(renderer, LINE_SIGN, table, distance_m, 1e-6, 60, rng) - distance_m
    model = line_sightings()
    sigma_m = float(np.interp(distance_m, model.distance_m, model.moving_sigma_m))
    assert rendered.size == 60
    assert rendered.std(ddof=1) == pytest.approx(sigma_m, rel=0.35)
    assert abs(rendered.mean()) < 2.0 * sigma_m


def placed(setup: Setup) -> Trains:
    carrier = PlainTrack({p.id: round(p.length_m, 6) for p in setup.line.pieces.values()}, STEP_S)
    trains = Trains(setup, carrier)
    duties = draw_up(setup.line, setup.timetable, {"K1": 40.0}, setup.operation.portal_lead_s)
    trains.place(0, duties["K1"][0])
    return trains


def test_frames_come_while_the_sign_is_in_range(rtri_setup: Setup) -> None:
    """Mark at path coordinate 660 m, sign 10 m behind it, seen from 87 m."""
    trains = placed(replace(rtri_setup, vision=Vision(stations=("B",), rate_hz=5.0)))
    agenda = Agenda()
    eyes = Eyes(trains, agenda, lambda _slot: 1)
    eyes.look_ahead(0)
    assert trains.truths[0].camera_m == pytest.approx(670.0 - 87.0)
    trains.truths[0].position_m = 640.0
    eyes.begin(0, 1000)
    item = agenda.pop_due(1002)
    assert item is not None
    assert (item.step, item.kind, item.subject) == (1002, Due.CAMERA, "K1")
    seen_m = eyes.frame(0, 1002)
    assert seen_m == pytest.approx(30.0, abs=1.0)
    assert agenda.next_step() == 1004
    trains.truths[0].position_m = 680.0  # past the mark: nothing more to look for
    assert eyes.frame(0, 1004) is None
    assert agenda.pop_due(1004) is not None
    assert agenda.next_step() is None


def test_without_a_sign_no_camera_looks(rtri_setup: Setup) -> None:
    trains = placed(rtri_setup)
    Eyes(trains, Agenda(), lambda _slot: 1).look_ahead(0)
    assert trains.truths[0].camera_m == math.inf


def test_a_train_that_has_called_everywhere_has_no_sign_to_look_for(rtri_setup: Setup) -> None:
    trains = placed(replace(rtri_setup, vision=Vision(stations=("B",), rate_hz=5.0)))
    Eyes(trains, Agenda(), lambda _slot: 2).look_ahead(0)
    assert trains.truths[0].camera_m == math.inf
