"""Rails as laid: their spectrum, that every path meets the same, and what changes with day and seed."""

import numpy as np
import pytest

from network.graph import next_pieces
from network.model import Direction
from network.path import Path, path_of
from simulation.sensor_settings import Rails
from simulation.setup import Setup
from simulation.world.irregularities import Irregularities, heading_density


def way(setup: Setup, direction: Direction) -> Path:
    pieces = ["HSK.MD" if direction is Direction.DOWN else "KRS.1"]
    while following := next_pieces(setup.line, pieces[-1], direction):
        pieces.append(following[0])
    return path_of(setup.line, pieces, direction)


def laid(setup: Setup, rails: Rails = Rails.HIGH, seed: int = 1, *today: str) -> np.ndarray:
    return Irregularities(setup.line, rails, seed, today).on_path_rad(way(setup, Direction.DOWN))


def band(values: np.ndarray, shortest_m: float, longest_m: float) -> np.ndarray:
    """Only the waves between two lengths."""
    spectrum, waves = np.fft.rfft(values), np.fft.rfftfreq(values.size)
    with np.errstate(divide="ignore"):
        length_m = 1.0 / waves
    spectrum[(length_m < shortest_m) | (length_m > longest_m)] = 0.0
    return np.fft.irfft(spectrum, values.size)


@pytest.mark.parametrize("rails", [Rails.LOW, Rails.HIGH])
@pytest.mark.parametrize("wave_m", [(10.0, 20.0), (30.0, 45.0), (60.0, 200.0)])
def test_the_spectrum_is_that_of_its_source(
    karasuyama_setup: Setup, rails: Rails, wave_m: tuple[float, float]
) -> None:
    waves_radpm = np.linspace(2.0 * np.pi / wave_m[1], 2.0 * np.pi / wave_m[0], 500)
    expected = np.sqrt(np.trapezoid(heading_density(waves_radpm, rails), waves_radpm))
    assert band(laid(karasuyama_setup, rails), *wave_m).std() == pytest.approx(expected, rel=0.15)


def test_straight_rails_are_straight_and_no_rails_drift(karasuyama_setup: Setup) -> None:
    assert not laid(karasuyama_setup, Rails.STRAIGHT).any()
    points_rad = laid(karasuyama_setup)
    assert abs(points_rad.mean()) < 1e-4 and np.abs(points_rad).max() < 6e-3


def test_both_directions_meet_the_same_rails(karasuyama_setup: Setup) -> None:
    rails = Irregularities(karasuyama_setup.line, Rails.HIGH, 1)
    down, up = way(karasuyama_setup, Direction.DOWN), way(karasuyama_setup, Direction.UP)
    going = {step.piece_id for step in down.steps} & {step.piece_id for step in up.steps}
    for piece_id in sorted(going):
        step, back = down.step_of(piece_id), up.step_of(piece_id)
        at_m = np.arange(np.ceil(step.start_m), np.floor(step.end_m))
        places_m = np.array([step.kilometrage_m(at) for at in at_m])
        seen_down = rails.on_path_rad(down)[at_m.astype(int)]
        seen_up = np.interp(
            [back.to_path_m(place) for place in places_m],
            np.arange(np.ceil(up.length_m) + 1),
            rails.on_path_rad(up),
        )
        inside = slice(2, -2)
        assert seen_up[inside] == pytest.approx(seen_down[inside], abs=2e-5)


def test_long_waves_stay_and_short_ones_are_others_every_day(karasuyama_setup: Setup) -> None:
    first, seed, day = (
        laid(karasuyama_setup),
        laid(karasuyama_setup, Rails.HIGH, 2),
        laid(karasuyama_setup, Rails.HIGH, 1, "day 2"),
    )

    def alike(one: np.ndarray, other: np.ndarray, shortest_m: float, longest_m: float) -> float:
        return float(np.corrcoef(band(one, shortest_m, longest_m), band(other, shortest_m, longest_m))[0, 1])

    assert alike(first, seed, 60.0, 500.0) > 0.99 and alike(first, day, 60.0, 500.0) > 0.99
    assert abs(alike(first, seed, 30.0, 45.0)) < 0.2 and alike(first, day, 30.0, 45.0) > 0.95
    assert abs(alike(first, seed, 5.0, 20.0)) < 0.1 and abs(alike(first, day, 5.0, 20.0)) < 0.1
