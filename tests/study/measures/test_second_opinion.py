"""The published formula by hand, energy worked out again from a trace, and figures beside their sources."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from network.profile import PROFILE
from simulation.result import TraceSpan
from simulation.world.records import TRACE
from study.measures import replayed
from study.measures.public_figures import PUBLIC_FIGURES, FigureBasis
from study.measures.replayed import Resistance, jr_resistance_n, mass_kg, own_resistance_n, traction_j
from study.report.energy import meanings
from vehicle.resistance import running_resistance_n
from vehicle.train_file import load_train, shipped_train
from vehicle.wire import wire_power_w

EV = load_train(shipped_train("ev_e301"))
TRAINS = [load_train(shipped_train(name)) for name in ("ev_e301", "oda_train", "hitachi_train", "br642")]
MASS_KG = mass_kg(EV, 0.2)


def test_the_published_formula_by_hand() -> None:
    """Two cars of 80 t at 60 km/h: (1.32 + 0.984) 80 + (0.028 + 0.0156) 3600 = 184.32 + 156.96 kgf."""
    found = float(jr_resistance_n(EV, 80_000.0, np.array([60.0 / 3.6]))[0])
    assert found == pytest.approx(341.28 * 9.80665)
    assert float(jr_resistance_n(EV, 80_000.0, np.array([0.0]))[0]) == pytest.approx(1.32 * 80 * 9.80665)


@given(speed=st.floats(0.0, 40.0), load=st.floats(0.0, 1.0), which=st.integers(0, len(TRAINS) - 1))
def test_our_formula_written_twice_is_one(speed: float, load: float, which: int) -> None:
    kind = TRAINS[which]
    mass = mass_kg(kind, load)
    twice = float(own_resistance_n(kind, mass, np.array([speed]))[0])
    assert twice == pytest.approx(running_resistance_n(kind.row[0], mass, speed), rel=1e-9)


def run_of(speeds_mps: list[float], start_m: float = 100.0) -> SimpleNamespace:
    """A run of one train with these speeds at whole seconds, and no more than the replay asks for."""
    rows = np.zeros(len(speeds_mps), TRACE)
    speeds = np.array(speeds_mps)
    rows["step"], rows["speed_mps"] = 10 * (1 + np.arange(speeds.size)), speeds
    rows["position_m"] = start_m + np.concatenate(([0.0], np.cumsum(0.5 * (speeds[1:] + speeds[:-1]))))
    span = TraceSpan(0, 0, "T1", 1, (0.0,), ("x",), (0.0,), 0.2)
    return SimpleNamespace(spans=[span], trace=rows, stock_ids=("K1",))


@pytest.fixture
def track(monkeypatch: pytest.MonkeyPatch) -> NDArray[np.void]:
    rows = np.zeros(3001, PROFILE)
    monkeypatch.setattr(replayed, "path_of", lambda *_: None)
    monkeypatch.setattr(replayed, "profile_of", lambda *_: rows)
    return rows


def none(_kind: object, _mass: float, speed_mps: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.zeros_like(speed_mps)


def replay(run: SimpleNamespace, resistance: Resistance = none) -> float:
    result: Any = run
    line: Any = None
    return traction_j(result, line, {"K1": EV}, resistance)


def test_work_to_a_speed_is_the_kinetic_energy_and_braking_gives_nothing_back(
    track: NDArray[np.void],
) -> None:
    up = [0.5 * i for i in range(41)]
    kinetic_j = 0.5 * MASS_KG * 1.08 * 20.0**2
    assert replay(run_of(up)) == pytest.approx(kinetic_j / 0.85)
    assert replay(run_of([*up, *reversed(up)])) == pytest.approx(kinetic_j / 0.85)


def test_at_one_speed_the_work_is_force_times_way(track: NDArray[np.void]) -> None:
    speed = np.array([60.0 / 3.6])
    for resistance in (jr_resistance_n, own_resistance_n):
        force_n = float(resistance(EV, MASS_KG, speed)[0])
        found_j = replay(run_of([60.0 / 3.6] * 61), resistance)
        assert found_j == pytest.approx(force_n * 1000.0 / 0.85)


def test_with_a_map_of_losses_it_is_charged_what_the_plant_is_while_it_pulls(
    track: NDArray[np.void],
) -> None:
    lossy = load_train(shipped_train("ev_e301_losses"))
    line: Any = None
    run: Any = run_of([60.0 / 3.6] * 61)
    run.trace["notch"] = 2.0
    force_n = float(own_resistance_n(lossy, MASS_KG, np.array([60.0 / 3.6]))[0])
    power_w = wire_power_w(lossy.row[0], 1.0, force_n, 60.0 / 3.6)
    assert traction_j(run, line, {"K1": lossy}, own_resistance_n) == pytest.approx(60.0 * power_w)
    run.trace["notch"] = 0.0  # it coasts: what a sample shows of a force is noise
    assert traction_j(run, line, {"K1": lossy}, own_resistance_n) == 0.0


def test_a_climb_costs_its_height_under_the_middle_of_the_train(track: NDArray[np.void]) -> None:
    track["elevation_m"][1000:] = np.minimum(np.arange(2001) * 0.01, 5.0)  # 5 m in 500 m
    found_j = replay(run_of([20.0] * 101))  # to 2100 m: the whole train is up
    assert found_j == pytest.approx(MASS_KG * 9.80665 * 5.0 / 0.85, rel=1e-3)


def test_a_curve_costs_its_angle(track: NDArray[np.void]) -> None:
    track["turn_rad"][1000:] = np.minimum(np.arange(2001) / 300.0, 1.0)  # 300 m of 300 m radius
    found_j = replay(run_of([20.0] * 101))
    assert found_j == pytest.approx(MASS_KG * 9.80665 * 600.0 / 300.0 * 1e-3 * 300.0 / 0.85, rel=1e-3)


def test_public_figures_are_those_of_their_sources() -> None:
    stated = {figure.source.partition(",")[0]: (figure.per, figure.kwh) for figure in PUBLIC_FIGURES}
    assert stated["Toyo Keizai online"] == (FigureBasis.CAR_KM, 1.7)
    assert stated["Sankei"] == (FigureBasis.TRAIN_KM, 190.0 / 50.0)
    assert {kwh for per, kwh in stated.values() if per is FigureBasis.CAR_KM} == {1.7, 2.0}
    assert all(figure.comparable for figure in PUBLIC_FIGURES)


@pytest.mark.parametrize(("ours", "word"), [(2.8, "within"), (4.1, "ABOVE")])
def test_a_bound_that_is_passed_is_said_loudly(ours: float, word: str) -> None:
    row = {
        "figure": "the EV-E301 on the flat, less than", "unit": "kWh per train-km", "ours": ours, "theirs": 3.8,
        "difference_percent": 0.0,
    }  # fmt: skip
    assert word in meanings([row])[0].en
