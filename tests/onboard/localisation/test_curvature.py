"""Curvature collation on the Karasuyama line: bounds that hold, where there is a fix and where none, what faults do."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from onboard import notes
from onboard.localisation.curvature_map import CurvatureMap, design_map
from papers.position_run import SLOT, Moment, PositionResult, PositionRun
from scenario.scenario import load_scenario
from simulation.sensor_settings import Filter, Rails
from simulation.settings import PositionSensor
from simulation.setup import Setup

STRAIGHT_M = 1000.0


@pytest.fixture(scope="module")
def setup() -> Setup:
    return load_scenario("karasuyama_weekday").setup


@dataclass(frozen=True)
class Ran:
    """A run, its result, and the notes of the reader by kind."""

    run: PositionRun
    result: PositionResult

    def noted(self, kind: type[notes.Note]) -> list[float]:
        """Where the reader noted that, m."""
        return [at_m for _, at_m, note in self.result.notes if isinstance(note, kind)]

    @property
    def half_m(self) -> np.ndarray:
        return (self.result.trace["bound_ahead_m"] + self.result.trace["bound_behind_m"]) / 2.0


def ran(
    setup: Setup,
    moments: tuple[Moment, ...] = (),
    of: CurvatureMap | None = None,
    wheel: float | None = None,
    **curvature: object,
) -> Ran:
    sensors = setup.sensors.model_copy(update={"carries": (PositionSensor.CURVATURE,)})
    changed = setup.curvature.model_copy(update=curvature)
    run = PositionRun(replace(setup, sensors=sensors, curvature=changed, curvature_map=of), moments)
    if wheel is not None:
        run.trains.tachometers[SLOT].wheel_factor = wheel
    return Ran(run, run.run())


@pytest.fixture(scope="module")
def plain(setup: Setup) -> Ran:
    return ran(setup)


def gyro(**state: float) -> Callable[[Any, int], None]:
    """What sets the gyro of a train so."""

    def put(trains: Any, slot: int) -> None:  # noqa: ANN401
        for name, value in state.items():
            setattr(trains.sensors["yaw_gyro"][slot], name, value)

    return put


def between(
    from_m: float, to_m: float, begun: Mapping[str, float], over: Mapping[str, float]
) -> tuple[Moment, ...]:
    return Moment(from_m, gyro(**begun)), Moment(to_m, gyro(**over))


def near_curves(path_m: np.ndarray, run: PositionRun) -> np.ndarray:
    """Whether the map has had a transition within the last kilometre."""
    unit = run.trains.units[SLOT]
    laid = run.trains.pool.pattern["curvature_per_m"][unit.path_offset : unit.path_offset + unit.path_rows]
    bends = np.flatnonzero(np.abs(np.diff(laid)) > 1e-5)
    last = np.searchsorted(bends, path_m.astype(int)) - 1
    return np.where(last >= 0, path_m - bends[np.maximum(last, 0)], np.inf) < STRAIGHT_M


def test_bounds_hold_in_every_step_and_are_narrow_near_curves(plain: Ran) -> None:
    result = plain.result
    assert result.arrived and result.out_m <= 0.0 and result.known_steps == result.steps
    near = near_curves(result.trace["position_m"], plain.run)
    assert near.mean() > 0.7
    late = result.trace["position_m"] > 4000.0  # by then the wheels are known
    assert np.median(plain.half_m[near & late]) < 5.5
    assert result.trace["estimate_error_m"][late].std() < 0.65
    assert plain.noted(notes.FixTaken) and not plain.noted(notes.ForeignTrack)


def test_the_wheels_scale_is_learned_as_an_interval_that_holds_it(plain: Ran) -> None:
    own = plain.run.trains.readers[SLOT].curvature
    scale = float(plain.run.trains.tachometers[SLOT].wheel_factor)
    assert own.scale_low <= scale <= own.scale_high
    assert own.scale_high - own.scale_low < 2.0 * own.varies_share + 0.002 < own.worn_share
    assert plain.run.trains.units[SLOT].odometer_scale == pytest.approx(scale, abs=0.002)


@pytest.mark.parametrize("wheel", [0.9805, 1.0195])
def test_worn_wheels_and_twice_the_noise_break_nothing(setup: Setup, wheel: float) -> None:
    made = ran(setup, wheel=wheel, noise_factor=2.0, rails=Rails.LOW)
    assert made.result.arrived and made.result.out_m <= 0.0
    assert np.median(made.half_m) < 4.0


def test_wheels_that_creep_break_nothing_and_units_know_nothing_of_how_much(setup: Setup, plain: Ran) -> None:
    """The allowance is what is stated of units, the same on wheels that creep and on wheels that do not."""
    sensors = setup.sensors.model_copy(update={"creep_share": 0.0033, "tread_conicity": 0.1})
    made = ran(replace(setup, sensors=sensors, seed=1))
    before, even = (PositionRun(one.run.setup).trains.readers[SLOT].curvature for one in (made, plain))
    assert before == even  # all that the unit knows before it has moved
    own = made.run.trains.readers[SLOT].curvature
    wheel_m = float(next(iter(setup.trains.values())).row[0]["wheel_diameter_m"])
    assert own.varies_share == even.varies_share > sensors.wheel_varies_share(wheel_m)
    scale = float(made.run.trains.tachometers[SLOT].wheel_factor)
    assert made.result.arrived and made.result.out_m <= 0.0
    assert own.scale_low <= scale <= own.scale_high


def test_without_its_allowance_wheels_that_creep_break_the_bounds(setup: Setup) -> None:
    creeping = {"creep_share": 0.007, "tread_conicity": 0.1, "carries": (PositionSensor.CURVATURE,)}
    run = PositionRun(replace(setup, sensors=setup.sensors.model_copy(update=creeping), seed=1))
    sure = run.trains.readers[SLOT].curvature
    sure.varies_share, sure.scale_low, sure.scale_high = 0.0, 0.98, 1.02
    assert run.run().out_m > 0.0


@pytest.mark.parametrize("seed", [24_492, 24_494])
def test_a_bias_that_jumps_by_too_little_to_be_noticed_breaks_no_bounds(seed: int) -> None:
    """It is learned as the bias; a step in the ring where it is learned would pull the fixes behind it aside."""
    from_m, to_m = 13_676.0, 18_188.0
    jump = between(from_m, to_m, {"jump_radps": -math.radians(0.09)}, {"jump_radps": 0.0})
    made = ran(replace(load_scenario("kururi_weekday").setup, seed=seed), jump)
    assert made.result.arrived and made.result.out_m <= 0.0
    after = made.result.trace["position_m"] > to_m + 600.0
    assert np.median(made.half_m[after]) < 6.5  # there are fixes


def test_without_room_for_noise_the_bounds_break(setup: Setup, monkeypatch: pytest.MonkeyPatch) -> None:
    run = PositionRun(
        replace(setup, sensors=setup.sensors.model_copy(update={"carries": (PositionSensor.CURVATURE,)}))
    )
    own = run.trains.readers[SLOT].curvature
    own.settings.sure_sigmas = own.gain_share = own.delay_share = 0.01
    own.rail_heading_rad = own.yaw_density = own.rail_level = own.rail_peak = 1e-12
    own.map_error_m = -0.3
    own.varies_share = 0.0
    assert run.run().out_m > 0.0


@pytest.mark.parametrize("filter_by", [Filter.OFF, Filter.TIME])
def test_without_the_spatial_filter_it_is_worse(setup: Setup, plain: Ran, filter_by: Filter) -> None:
    other = ran(setup, filter=filter_by)
    assert np.median(other.half_m) > np.median(plain.half_m)


@pytest.mark.parametrize(
    ("begun", "over", "noted"),
    [
        ({"state": 1}, {"state": 0}, notes.FixMissed),
        ({"state": 2}, {"state": 0}, notes.FixMissed),
        ({"jump_radps": 0.02}, {"jump_radps": 0.0}, notes.ForeignTrack),
        ({"noise_factor": 300.0}, {"noise_factor": 1.0}, notes.ForeignTrack),
    ],
)
def test_a_gyro_that_fails_is_noticed_and_breaks_no_bounds(
    setup: Setup, begun: Mapping[str, float], over: Mapping[str, float], noted: type[notes.Note]
) -> None:
    made = ran(setup, between(8000.0, 9000.0, begun, over))
    assert made.result.out_m <= 0.0
    first_m = min(made.noted(noted))
    assert 8000.0 < first_m < 8700.0
    assert any(at_m > 9000.0 for at_m in made.noted(notes.FixTaken))


def test_where_the_map_has_another_track_nothing_is_taken_until_it_fits_again(setup: Setup) -> None:
    whole = design_map(setup.line)
    piece = whole.pieces["OGN-KRS"]
    other = piece.curvature_per_m.copy()
    other[3000:3400] = -other[3000:3400] + 2e-3  # kilometrage rises, this train goes up
    wrong = CurvatureMap(whole.line_id, {**whole.pieces, "OGN-KRS": replace(piece, curvature_per_m=other)})
    made = ran(setup, of=wrong, rails=Rails.LOW)
    begins = made.noted(notes.ForeignTrack)
    path = made.run.mission.path
    from_m = path.to_path_m("OGN-KRS", piece.from_m + 3400.0)
    assert len(begins) == 1 and from_m < begins[0] < from_m + 200.0
    assert made.result.out_m <= 0.0
    again_m = min(at_m for at_m in made.noted(notes.FixTaken) if at_m > begins[0])
    assert from_m + 400.0 < again_m < from_m + 1600.0
    blind = ran(setup, of=wrong, rails=Rails.LOW, mismatch_per_m=0.01)
    assert not blind.noted(notes.ForeignTrack)


def test_over_pieces_that_the_map_leaves_out_nothing_is_compared(setup: Setup) -> None:
    whole = design_map(setup.line)
    part = CurvatureMap(whole.line_id, {k: v for k, v in whole.pieces.items() if k != "OGN-KRS"})
    made = ran(setup, of=part)
    path = made.run.mission.path
    assert made.result.out_m <= 0.0
    assert min(made.noted(notes.FixTaken)) > path.step_of("OGN-KRS").end_m
