import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.rows import Change, Rows
from vehicle.mass import equivalent_mass_kg
from vehicle.optimum import Course, TooShort, least_energy, least_time
from vehicle.optimum.bound import Term, bound_of, lower_bound_j
from vehicle.optimum.course import NotFound
from vehicle.optimum.laws import laws_at
from vehicle.optimum.mesh import laid_course, shares_of
from vehicle.optimum.proof import consumed_j, possible_speeds2, proven_run
from vehicle.optimum.way import times_s
from vehicle.running_time import predicted_run
from vehicle.train_file import load_train, shipped_train

Floats = NDArray[np.float64]

DECELERATION_MPS2 = 0.7
PARTS = 12


def course(row: Rows, length_m: int = 3000, **changes: Any) -> Course:  # noqa: ANN401
    """A level run of a train under one limit, unless changed."""
    values: dict[str, Any] = {
        "climb_m": np.zeros(length_m + 2),
        "limit_mps": np.full(length_m + 2, 65 / 3.6),
        "start_m": 0.0,
        "stop_m": float(length_m),
        "deceleration_mps2": DECELERATION_MPS2,
    }
    return Course(row[0], 0.3, **{**values, **changes})


def hilly(row: Rows, rng: np.random.Generator, length_m: int = 2000, **changes: Any) -> Course:  # noqa: ANN401
    """A run over random gradients under random limits."""
    slopes = np.repeat(rng.uniform(-0.025, 0.025, length_m // 100 + 1), 100)[: length_m + 1]
    climbs = np.concatenate(([0.0], np.cumsum(slopes)))
    limits = np.repeat(rng.choice([10.0, 14.0, 18.0, 23.0], length_m // 200 + 1), 200)
    limits = np.concatenate((limits, limits[-1:], limits[-1:]))[: length_m + 2]
    return course(row, length_m, climb_m=climbs, limit_mps=limits, **changes)


# --- closed form


@pytest.mark.parametrize("share", [1.05, 1.2, 1.6])
def test_without_resistance_it_is_the_least_speed_that_makes_the_time(
    ev_e301: Rows, changed: Change, share: float
) -> None:
    row = changed(ev_e301, free=True, traction_power_max_w=1e9, adhesion_dry=5.0)
    run = course(row, limit_mps=np.full(3002, 60.0), regeneration=0.0)
    up = 48_000.0 * (77_900 + 0.3 * 14_600) / 77_900 / equivalent_mass_kg(row[0], 0.3)
    both = 0.5 / up + 0.5 / DECELERATION_MPS2
    least_s = 2.0 * math.sqrt(3000.0 * both)
    train_least_s = float(least_time(course(row, limit_mps=np.full(3002, 27.0))).time_s[-1])
    assert train_least_s == pytest.approx(3000 / 27.0 + 27.0 * both, rel=1e-4)
    time_s = share * max(least_s, train_least_s)
    # T = S / v + v (1 / 2a + 1 / 2b)
    speed = (time_s - math.sqrt(time_s**2 - 4.0 * both * 3000.0)) / (2.0 * both)
    closed_j = 0.5 * equivalent_mass_kg(row[0], 0.3) * speed**2 / 0.85
    proof = proven_run(run, time_s)
    assert proof.bound_j <= closed_j <= proof.energy_j * (1.0 + 1e-9)
    assert proof.energy_j <= 1.005 * closed_j
    assert proof.bound_j >= 0.995 * closed_j


def test_on_the_level_without_losses_the_bound_meets_a_steady_speed(ev_e301: Rows, changed: Change) -> None:
    row = changed(ev_e301, efficiency_traction=1.0, efficiency_regeneration=1.0)
    run = course(row, 5000, initial_mps=15.0, final_mps=15.0)
    resist_n, _, _ = laws_at(row[0], 0.3, 15.0)
    proof = proven_run(run, 5000.0 / 15.0)
    assert proof.energy_j == pytest.approx(resist_n * 5000.0, rel=1e-3)
    assert proof.bound_j == pytest.approx(resist_n * 5000.0, rel=1e-3)
    assert proof.bound_j <= resist_n * 5000.0 * (1.0 + 1e-12)


# --- the bound against whatever else can be thought of


def slower_run(run: Course, rng: np.random.Generator) -> tuple[float, float]:
    """Time and energy of a random run that the train can make: the fastest one with its speeds cut at random."""
    found = laid_course(run)
    way = found.way
    knots = np.sort(rng.uniform(way.at_m[0], way.at_m[-1], 6))
    cut = np.interp(way.at_m, knots, rng.uniform(0.2, 1.0, 6))
    line = found.fastest * cut * cut
    held = np.stack((np.diff(way.lift) / np.diff(way.at_m), way.drag), axis=1)
    limits = np.array([way.brake_extra, way.deceleration, way.acceleration])
    z = possible_speeds2(run.train, run.load_share, found.inertia_kg, way.at_m, held, limits, line)
    energy_j = consumed_j(run.train, run.load_share, found.inertia_kg, run.regeneration, way.at_m, held, z)
    return float(times_s(way.at_m, z)[-1]), energy_j


@given(seed=st.integers(0, 10_000), name=st.sampled_from(["ev_e301", "br642", "ev_e301_losses"]))
def test_no_random_run_is_below_the_bound(seed: int, name: str) -> None:
    rng = np.random.default_rng(seed)
    run = hilly(load_train(shipped_train(name)).row, rng, regeneration=float(rng.choice([0.0, 0.5, 1.0])))
    time_s, energy_j = slower_run(run, rng)
    # A bound is one whatever optimum it was sought at; with losses none is found in far more than twice the least time.
    least_s = float(least_time(run).time_s[-1])
    about_s = max(min(time_s, 1.5 * least_s), 1.01 * least_s)
    optimum = least_energy(run, about_s)
    assert lower_bound_j(run, optimum, time_s) <= energy_j
    other = least_energy(run, 1.3 * about_s)
    assert lower_bound_j(run, other, time_s) <= energy_j


@given(seed=st.integers(0, 10_000), cruise_mps=st.floats(9.0, 20.0))
def test_no_cruise_of_the_running_time_model_is_below_the_bound(seed: int, cruise_mps: float) -> None:
    row = load_train(shipped_train("ev_e301")).row
    run = hilly(row, np.random.default_rng(seed), auxiliaries=True)
    time_s, energy_j = predicted_run(
        row[0], 0.3, run.climb_m, run.limit_mps, 0.0, 2000.0, cruise_mps, DECELERATION_MPS2, 0.02
    )
    least_s = float(least_time(run).time_s[-1])
    optimum = least_energy(run, max(time_s, 1.02 * least_s))
    # Its steps hold the force of their start: a few hundredths of a percent, of the kinetic energy too.
    assert lower_bound_j(run, optimum, time_s) <= energy_j + 0.002 * abs(energy_j) + 2e4


@given(
    seed=st.integers(0, 10_000),
    share=st.floats(1.05, 1.5),
    name=st.sampled_from(["ev_e301", "br642", "oda_train", "hitachi_train"]),
)
def test_bound_and_possible_run_are_close(seed: int, share: float, name: str) -> None:
    run = hilly(load_train(shipped_train(name)).row, np.random.default_rng(seed))
    time_s = share * float(least_time(run).time_s[-1])
    proof = proven_run(run, time_s)
    assert proof.time_s <= time_s
    assert proof.bound_j <= proof.energy_j
    # Of what is spent in all, as downhill the net may be about nothing.
    spent_j = float(np.sum(np.maximum(proof.optimum.force_n, 0.0) * np.diff(proof.optimum.position_m)))
    assert proof.energy_j - proof.bound_j <= 0.02 * spent_j
    assert proof.mesh_energy_j == pytest.approx(proof.energy_j, abs=0.01 * spent_j)


@pytest.mark.parametrize("term", list(Term))
def test_a_term_left_out_is_found_out(ev_e301: Rows, term: Term) -> None:
    falls = np.concatenate((np.zeros(500), -0.02 * np.arange(1502)))
    limits = np.full(2002, 20.0)
    limits[1200:1500] = 10.0
    run = course(ev_e301, 2000, climb_m=falls, limit_mps=limits)
    time_s = 1.1 * float(least_time(run).time_s[-1])
    proof = proven_run(run, time_s)
    assert bound_of(laid_course(run), proof.optimum, time_s) <= proof.energy_j
    assert bound_of(laid_course(run), proof.optimum, time_s, left_out=term) > proof.energy_j


# --- a dynamic programme, which shares only the laws


def programmed(run: Course, price_w: float, step_m: float, speeds: Floats) -> float:
    """Least energy + price * time over runs that hold one acceleration between points of a coarse grid, J."""
    inertia = equivalent_mass_kg(run.train, run.load_share)
    heights = np.interp(np.arange(0.0, run.stop_m + 0.5, step_m), np.arange(len(run.climb_m)), run.climb_m)
    z = 0.5 * speeds**2
    laws = np.array([laws_at(run.train, run.load_share, float(v)) for v in speeds])
    weight = 9.81 * (77_900 + 0.3 * 14_600)
    worth = np.where(z == 0.0, 0.0, np.inf)
    for k in range(len(heights) - 2, -1, -1):
        limit = float(run.limit_mps[int(k * step_m) : int((k + 1) * step_m)].min())
        a = (z[None, :] - z[:, None]) / step_m
        climbed = weight * (heights[k + 1] - heights[k]) / step_m
        cost: Floats = np.zeros(a.shape)
        shares: list[float] = ((np.arange(PARTS) + 0.5) / PARTS).tolist()
        for part in shares:  # the electric brake fades within a step
            inside = np.sqrt(2.0 * (z[:, None] + part * (z[None, :] - z[:, None])))
            force = inertia * a + np.interp(inside, speeds, laws[:, 0]) + climbed
            motors = np.maximum(force, -np.interp(inside, speeds, laws[:, 2]))
            cost += step_m / PARTS * np.where(motors > 0.0, motors / 0.85, motors * 0.75)
        pull = np.minimum(laws[None, :, 1], laws[:, None, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            cost = cost + price_w * 2.0 * step_m / (speeds[None, :] + speeds[:, None])
        worst = inertia * a + np.maximum(laws[None, :, 0], laws[:, None, 0]) + climbed
        allowed = (worst <= pull) & (a >= -run.deceleration_mps2) & (speeds[None, :] <= limit)
        allowed &= speeds[:, None] <= limit
        worth = np.min(np.where(allowed, cost + worth[None, :], np.inf), axis=1)
    return float(worth[0])


@pytest.mark.parametrize("share", [1.1, 1.4])
def test_a_dynamic_programme_lies_between_the_bound_and_a_little_above_the_optimum(
    ev_e301: Rows, changed: Change, share: float
) -> None:
    row = changed(ev_e301, length_m=1.0)  # its gradients are those of a point
    rises = np.concatenate((np.zeros(401), 0.015 * np.arange(1, 401), np.full(402, 6.0)))
    run = course(row, 1200, climb_m=rises)
    time_s = share * float(least_time(run).time_s[-1])
    proof = proven_run(run, time_s)
    price_w = proof.optimum.price_w
    speeds = np.sqrt(np.linspace(0.0, (65 / 3.6) ** 2, 300))
    by_programme_j = programmed(run, price_w, 20.0, speeds)
    assert proof.bound_j + price_w * time_s <= by_programme_j
    assert by_programme_j <= 1.06 * (proof.energy_j + price_w * time_s)


# --- the optimum itself


def test_forces_limits_and_time_are_kept(ev_e301: Rows) -> None:
    run = hilly(ev_e301, np.random.default_rng(5))
    time_s = 1.08 * float(least_time(run).time_s[-1])
    found = least_energy(run, time_s)
    assert time_s * (1.0 - 1e-4) <= found.time_s[-1] <= time_s
    assert found.speed_mps[0] == found.speed_mps[-1] == 0.0
    ahead = np.minimum(
        run.limit_mps[found.position_m.astype(int)],
        run.limit_mps[np.maximum(found.position_m.astype(int) - 1, 0)],
    )
    assert np.all(found.speed_mps <= ahead + 1e-6)
    acceleration = np.diff(0.5 * found.speed_mps**2) / np.diff(found.position_m)
    assert np.all(acceleration >= -DECELERATION_MPS2 - 1e-6)
    middle = np.sqrt(0.5 * (found.speed_mps[1:] ** 2 + found.speed_mps[:-1] ** 2))
    pulls = np.array([laws_at(ev_e301[0], 0.3, float(v))[1] for v in middle])
    assert np.all(found.force_n <= 1.01 * pulls)
    assert np.all(found.brake_n >= 0.0)


def test_the_price_is_what_a_second_more_saves(ev_e301: Rows) -> None:
    run = hilly(ev_e301, np.random.default_rng(8))
    time_s = 1.15 * float(least_time(run).time_s[-1])
    before, after = least_energy(run, time_s - 1.0).energy_j, least_energy(run, time_s + 1.0).energy_j
    assert least_energy(run, time_s).price_w == pytest.approx((before - after) / 2.0, rel=0.03)


def test_it_is_deterministic_and_a_warm_start_finds_the_same(ev_e301: Rows) -> None:
    run = hilly(ev_e301, np.random.default_rng(3))
    time_s = 1.2 * float(least_time(run).time_s[-1])
    first, second = least_energy(run, time_s), least_energy(run, time_s)
    np.testing.assert_array_equal(first.speed_mps, second.speed_mps)
    assert first.energy_j == second.energy_j
    warm = least_energy(run, time_s, warm=least_energy(run, 1.1 * time_s))
    assert warm.energy_j == pytest.approx(first.energy_j, rel=1e-3)


def test_too_short_a_time_names_the_least(ev_e301: Rows) -> None:
    run = course(ev_e301)
    least_s = float(least_time(run).time_s[-1])
    with pytest.raises(TooShort, match=f"least running time is {least_s:.2f} s") as raised:
        least_energy(run, 0.98 * least_s)
    assert raised.value.least_s == pytest.approx(least_s)


def test_humps_that_a_mesh_does_not_see_leave_no_run(ev_e301: Rows) -> None:
    """On 60 points a stretch is 33 m; at 2 m/s a train with one force on all of it stalls on half a metre of climb."""
    humps = 0.02 * np.abs(np.arange(2002) % 160 - 80.0)
    run = course(ev_e301, 2000, climb_m=humps, limit_mps=np.full(2002, 2.0))
    time_s = 1.1 * float(least_time(run).time_s[-1])
    with pytest.raises(NotFound, match=f"no run of {time_s:.2f} s was found"):
        proven_run(run, time_s, points=60)


def test_a_train_that_stalls_says_where(ev_e301: Rows) -> None:
    wall = np.concatenate((np.zeros(1000), 0.15 * np.arange(2002)))
    with pytest.raises(ValueError, match="cannot climb"):
        least_time(course(ev_e301, climb_m=wall))


@pytest.mark.parametrize(
    "changes",
    [
        {"stop_m": 0.0},
        {"limit_mps": np.zeros(3002)},
        {"climb_m": np.zeros(10)},
        {"deceleration_mps2": 0.0},
        {"regeneration": 1.5},
        {"initial_mps": 60.0},
    ],
)
def test_what_is_no_run_is_refused(ev_e301: Rows, changes: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"."):
        least_time(course(ev_e301, **changes))


def test_least_time_is_that_of_the_running_time_model(ev_e301: Rows) -> None:
    run = hilly(ev_e301, np.random.default_rng(11))
    time_s, _ = predicted_run(
        ev_e301[0], 0.3, run.climb_m, run.limit_mps, 0.0, 2000.0, math.inf, DECELERATION_MPS2, 0.02
    )
    assert float(least_time(run).time_s[-1]) == pytest.approx(time_s, rel=1e-3)


def test_regeneration_that_counts_saves_and_a_missing_friction_brake_costs(ev_e301: Rows) -> None:
    limits = np.full(3002, 65 / 3.6)
    run = course(ev_e301, limit_mps=limits, final_mps=3.0, initial_mps=3.0)
    alone = course(ev_e301, limit_mps=limits, final_mps=3.0, initial_mps=3.0, friction_brake_n=0.0)
    none = course(ev_e301, limit_mps=limits, final_mps=3.0, initial_mps=3.0, regeneration=0.0)
    time_s = 1.1 * float(least_time(alone).time_s[-1])
    whole_j = least_energy(run, time_s).energy_j
    assert whole_j <= least_energy(alone, time_s).energy_j * (1.0 + 1e-4)
    assert whole_j < least_energy(none, time_s).energy_j
    assert np.max(least_energy(alone, time_s).brake_n) < 10.0


def test_a_run_that_never_changes_speed_is_laid_out_evenly() -> None:
    """Its changes of speed come to nothing: a share of nothing is no number."""
    assert shares_of(np.zeros(5)).tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert shares_of(np.array([0.0, 1.0, 4.0])).tolist() == [0.0, 0.25, 1.0]
    assert shares_of(np.array([0.0, 1.0, np.inf])).tolist() == [0.0, 0.5, 1.0]
