"""The satellite receiver (GNSS): where the front is along the path, a little late, with slowly changing errors.

Its output is already a place on the track: the unit knows its route and projects latitude and longitude onto it. Only
the error along the track remains, and a loop has the same coordinate as the main track beside it. The distance from
antenna to front is known.

Errors along the track are a first-order Gauss-Markov process (`sigma_m`, `time_constant_s`: atmosphere, orbits,
clocks), white noise and, where part of the sky is hidden, reflections. Reflections depend on the place and on the
satellites' positions, which repeat after a sidereal day: a train that passes again within minutes has nearly the same
error, an hour later another one, and four minutes earlier on the next day the same again. The receiver states one
protection level, and whether it sees all satellites that should be visible. In tunnels and for some time after them it
has no fix.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Final, Protocol

from network.profile import NO_SKY, OPEN_SKY
from onboard.board import SensedRow
from simulation.faults.gnss import Reception
from simulation.gnss_settings import Gnss, GnssReceiver
from simulation.sensors.noise import normal, source_of
from simulation.sensors.scene import SceneRow
from simulation.settings import PositionSensor
from simulation.setup import Setup
from vehicle.compiled import compiled, compiled_when_called
from vehicle.record import put_settings

RING: Final = 64  # fixes under way: more than the latest tag of the fastest receiver needs
SIDEREAL_DAY_S: Final = 86_164.1  # after which the satellites stand as before
DAY_S: Final = 86_400.0
HOURS: Final = 96  # of a sidereal day: in 15 min reflections have become others
SPREAD: Final = 1_000_003  # between the counters of neighbouring places, more than there are times
LONG_AGO: Final = -(10**9)  # steps


class GnssReceiverRow(Protocol):
    """One train's receiver, what it errs by now, and its fixes on their way to the unit."""

    every_steps: Annotated[int, "a fix each so many steps of the day; 0: no receiver"]
    latency_steps: int
    reacquire_steps: Annotated[int, "without a fix after it had no signals"]
    source: Annotated[int, "of the error that lasts"]
    noise_source: int
    place_source: Annotated[int, "of reflections: the same for all trains"]
    settings: Gnss
    receiver: GnssReceiver
    ahead_s: Annotated[float, "how far the satellites are ahead of where they stood at this time on day 1"]
    step_s: float
    lasting_m: Annotated[float, "error that lasts, along the line, at `lasting_step`"]
    lasting_step: int
    lost_step: Annotated[int, "the last in which it had no signals"]
    run_m: Annotated[float, "the way run since the day began"]
    no_signals: Annotated[int, "1: the antenna is dead or jammed"]
    bias_m: Annotated[float, "what a fault adds, along the path"]
    bias_due_m: Annotated[float, "what it comes to"]
    bias_slope: Annotated[float, "m per m run; 0: at once"]
    late_steps: Annotated[int, "fixes are older than they say by so many"]
    frozen: Annotated[int, "1: its fixes are all where the last one was before, with new time tags"]
    frozen_run_m: Annotated[float, "run_m where that was"]
    frozen_error_m: Annotated[float, "its error then"]
    error_m: Annotated[float, "of the last fix"]
    taken_step: Annotated[list[int], RING]
    taken_run_m: Annotated[list[float], RING]
    taken_error_m: Annotated[list[float], RING]
    taken_open: Annotated[list[int], RING]


def fit(own: GnssReceiverRow, setup: Setup, stock_id: str) -> None:
    """A receiver for stock that carries one; reflections are those of the place and the day."""
    if PositionSensor.GNSS not in setup.sensors.carried_by(stock_id):
        return
    gnss, receiver = setup.gnss, setup.gnss.receiver
    own.every_steps = setup.steps_of(1.0 / gnss.rate_hz)
    own.step_s = 1.0 / setup.steps_of(1.0)
    own.latency_steps = round(gnss.latency_s / own.step_s)
    own.reacquire_steps = round(gnss.reacquisition_s / own.step_s)
    own.source = source_of(setup.seed, "gnss", stock_id, *setup.today)
    own.noise_source = source_of(setup.seed, "gnss noise", stock_id, *setup.today)
    own.place_source = source_of(setup.seed, "gnss reflections")
    put_settings(own.settings, gnss)
    put_settings(own.receiver, receiver)
    own.ahead_s = (setup.day - 1) * (DAY_S - SIDEREAL_DAY_S)
    own.lasting_m = receiver.sigma_m * normal(own.source, -1)
    own.lost_step = LONG_AGO
    own.taken_step = [LONG_AGO] * RING


@compiled
def gnss_receiver(own: GnssReceiverRow, _sensors: Any, scene: SceneRow, sensed: SensedRow) -> None:  # noqa: ANN401
    """Take a fix if one is due and there are signals; hand over the one that has become due."""
    shown = sensed.readings.gnss
    shown.taken = 0
    if own.every_steps == 0:
        return
    own.run_m += scene.run_m
    follow_bias(own, abs(scene.run_m))
    if scene.sky == NO_SKY or own.no_signals != 0:
        own.lost_step = scene.step
    if scene.step % own.every_steps == 0 and scene.step - own.lost_step > own.reacquire_steps:
        draw_fix(own, scene)
    of_step = scene.step - own.latency_steps - own.late_steps
    slot = of_step // own.every_steps % RING
    if of_step % own.every_steps != 0 or own.taken_step[slot] != of_step:
        return
    shown.taken = 1
    since_m = own.run_m - own.taken_run_m[slot]
    shown.position_m = scene.front_m - since_m + own.taken_error_m[slot]
    shown.age_s = own.latency_steps * own.step_s
    shown.protection_m = own.receiver.protection_m
    shown.open_sky = own.taken_open[slot]


@compiled_when_called
def draw_fix(own: GnssReceiverRow, scene: SceneRow) -> None:
    """One fix: its error, and whether it was taken under an open sky."""
    slot = scene.step // own.every_steps % RING
    own.taken_step[slot], own.taken_run_m[slot] = scene.step, own.run_m
    keeps = math.exp(-(scene.step - own.lasting_step) * own.step_s / own.settings.time_constant_s)
    fresh_m = own.receiver.sigma_m * normal(own.source, scene.step)
    own.lasting_m = keeps * own.lasting_m + math.sqrt(1.0 - keeps * keeps) * fresh_m
    own.lasting_step = scene.step
    error_m = own.lasting_m + own.receiver.noise_sigma_m * normal(own.noise_source, scene.step)
    own.taken_open[slot] = 1
    if scene.sky < OPEN_SKY:
        own.taken_open[slot] = 0
        error_m += own.receiver.multipath_sigma_m * reflection_sigmas(own, scene.kilometrage_m, scene.now_s)
    own.error_m = scene.down * error_m + own.bias_m
    if own.frozen != 0:
        own.error_m = own.frozen_error_m - (own.run_m - own.frozen_run_m)
    own.taken_error_m[slot] = own.error_m


@compiled
def reflection_sigmas(own: GnssReceiverRow, kilometrage_m: float, now_s: float) -> float:
    """What reflections add at a place and a time, in standard deviations: smooth in both, the same for who comes again.

    Standard normal numbers at knots of place and time, blended by the cosine so that the variance is 1 everywhere.
    """
    place = kilometrage_m / own.settings.multipath_way_m
    hour = (now_s + own.ahead_s) % SIDEREAL_DAY_S / SIDEREAL_DAY_S * HOURS
    i, j = math.floor(place), math.floor(hour)
    along, later = 0.5 * math.pi * (place - i), 0.5 * math.pi * (hour - j)
    total = 0.0
    for di in range(2):
        for dj in range(2):
            share = math.sin(along) if di == 1 else math.cos(along)
            share *= math.sin(later) if dj == 1 else math.cos(later)
            total += share * normal(own.place_source, (i + di) * SPREAD + (j + dj) % HOURS)
    return total


@compiled
def follow_bias(own: GnssReceiverRow, run_m: float) -> None:
    """Let what a fault adds come to what it is to be, as the train runs."""
    missing_m = own.bias_due_m - own.bias_m
    if own.bias_slope > 0.0:
        most_m = own.bias_slope * run_m
        missing_m = min(max(missing_m, -most_m), most_m)
    own.bias_m += missing_m


def put_reception(own: GnssReceiverRow, reception: Reception) -> None:
    """Make a receiver so. A bias that went over some way goes over the same way, if it came over any."""
    if own.every_steps == 0:
        return
    own.no_signals = int(reception.no_signals)
    if reception.over_m > 0.0:
        own.bias_slope = abs(reception.bias_m - own.bias_due_m) / reception.over_m
    elif reception.bias_m != 0.0:
        own.bias_slope = 0.0
    own.bias_due_m = reception.bias_m
    own.late_steps = round(reception.late_s / own.step_s)
    if reception.frozen and own.frozen == 0:
        own.frozen_run_m, own.frozen_error_m = own.run_m, own.error_m
    own.frozen = int(reception.frozen)
