import numpy as np
import pytest

from radio.chance import generator
from simulation.scatter import Individual, ScatterSettings, Weather
from vehicle.train_file import load_train, shipped_train

BELIEVED = load_train(shipped_train("ev_e301")).row


def test_without_scatter_a_train_is_as_its_file_says() -> None:
    body, factor = ScatterSettings().body(1, "V1", BELIEVED)
    assert factor == 1.0
    assert body.tobytes() == BELIEVED.tobytes()


def test_a_train_stays_the_same_and_others_differ() -> None:
    scatter = ScatterSettings(brake_sigma=0.1, dead_time_spread_s=0.3, lag_spread_s=0.1)
    first, again, other = (scatter.body(7, stock, BELIEVED) for stock in ("V1", "V1", "V2"))
    assert first[1] == again[1] != other[1]
    assert first[0].tobytes() == again[0].tobytes() != other[0].tobytes()
    assert abs(float(first[0]["brake_dead_time_s"][0]) - 0.5) <= 0.3


def test_spread_and_cut_of_the_fleet() -> None:
    """A sigma of 5 % cut at three: none beyond 15 %, and about 5 % over many."""
    factors = np.array([ScatterSettings(brake_sigma=0.05).body(1, f"V{n}", BELIEVED)[1] for n in range(1000)])
    assert np.abs(factors - 1.0).max() <= 0.15 + 1e-12
    assert factors.std() == pytest.approx(0.05, rel=0.1)


def test_what_is_known_is_not_drawn() -> None:
    scatter = ScatterSettings(
        brake_sigma=0.1, stock={"V1": Individual(brake_factor=0.3, dead_time_offset_s=-2.0)}
    )
    body, factor = scatter.body(1, "V1", BELIEVED)
    assert factor == 0.3
    assert body["brake_dead_time_s"][0] == 0.0  # never negative


def test_weather_holds_in_its_hours() -> None:
    part = Weather.model_validate({"from": "05:00", "to": "08:00", "adhesion_low": 0.5, "adhesion_high": 0.8})
    scatter = ScatterSettings(weather=(part,))
    chance = generator(1, "test")
    wet = [scatter.adhesion_of_leg(chance, 20000.0) for _ in range(200)]
    assert 0.5 <= min(wet) < 0.55
    assert 0.75 < max(wet) <= 0.8
    assert scatter.adhesion_of_leg(chance, 28800.0) == 1.0


def test_legs_differ_only_where_they_are_to() -> None:
    chance = generator(1, "test")
    assert {ScatterSettings().brake_of_leg(chance) for _ in range(5)} == {1.0}
    assert len({ScatterSettings(brake_leg_sigma=0.02).brake_of_leg(chance) for _ in range(5)}) == 5
