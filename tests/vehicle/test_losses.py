"""The map of losses and the number of motors that run: what physics asks of them, and what a file may not say."""

import tomllib
from pathlib import Path
from typing import Final

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from network.errors import InputError
from tests.rows import Change, Rows
from vehicle.dynamics import step
from vehicle.losses import losses_w, motors_needed, no_load_w, running_motors
from vehicle.mass import equivalent_mass_kg
from vehicle.optimum.costs import cost_terms
from vehicle.running_time import predicted_run
from vehicle.train_file import load_train, new_plant, shipped_train
from vehicle.wire import power_at_grip_w, wire_power_w

CONSTANT: Final = ("br642", "ev_e301", "hitachi_train", "oda_scale_car", "oda_train")
ROWS: Final = {name: load_train(shipped_train(name)).row for name in CONSTANT}
LOSSES: Final = ("standby_w", "magnetising_w", "hysteresis_w", "eddy_w", "inverter_w", "copper_w")
DT_S: Final = 0.1
GRIP_N: Final = 93_000.0  # of the empty train on dry rail at rest
speeds = st.floats(0.1, 27.0)
forces = st.floats(-48_000.0, 48_000.0)


@pytest.fixture(scope="module")
def lossy() -> Rows:
    return load_train(shipped_train("ev_e301_losses")).row


@pytest.fixture(scope="module")
def cutting(lossy: Rows, changed: Change) -> Rows:
    """The same train with equipment that cuts motors out."""
    return changed(lossy, motors_cut_out=1.0)


@pytest.mark.parametrize("name", CONSTANT)
@given(force=forces, speed=st.floats(0.0, 30.0))
def test_without_the_table_the_efficiencies_hold_to_the_bit(name: str, force: float, speed: float) -> None:
    train = ROWS[name][0]
    rim_w = force * speed
    expected_w = (
        rim_w / train["efficiency_traction"] if force > 0.0 else rim_w * train["efficiency_regeneration"]
    )
    assert wire_power_w(train, 1.0, force, speed) == expected_w
    assert wire_power_w(train, 0.0, force, speed) == 0.0


def test_the_figures_of_the_shipped_map_by_hand(lossy: Rows) -> None:
    """At its full 12 kN and 28.5 km/h, twice that speed, and while it coasts magnetised."""
    train, base_mps = lossy[0], 28.5 / 3.6
    motor_w = 300.0 + 900.0 + 900.0 + 600.0 + 1600.0 + 5700.0 + 0.025 * 12_000.0 * base_mps
    assert wire_power_w(train, 1.0, 48_000.0, base_mps) == pytest.approx(48_000.0 * base_mps + 4.0 * motor_w)
    assert wire_power_w(train, 0.5, -24_000.0, base_mps) == pytest.approx(
        -24_000.0 * base_mps + 2.0 * motor_w
    )
    # half the flux, so twice the current for a force; hysteresis at twice the speed and a quarter of the flux squared
    weak_w = 300.0 + 225.0 + 450.0 + 600.0 + 1600.0 + 5700.0 + 0.025 * 6_000.0 * 2 * base_mps
    assert wire_power_w(train, 1.0, 24_000.0, 2 * base_mps) == pytest.approx(
        48_000.0 * base_mps + 4.0 * weak_w
    )
    assert no_load_w(train, 2 * base_mps) == pytest.approx(300.0 + 225.0 + 450.0 + 600.0)


@given(
    force=forces,
    speed=speeds,
    share=st.sampled_from([0.25, 0.5, 0.75, 1.0]),
    losses=st.lists(st.floats(0.0, 3e5), min_size=6, max_size=6),
    gear=st.floats(0.0, 0.1),
    cut=st.booleans(),
)
def test_no_map_that_a_file_may_have_makes_energy(
    lossy: Rows,
    changed: Change,
    force: float,
    speed: float,
    share: float,
    losses: list[float],
    gear: float,
    cut: bool,
) -> None:
    """Nothing is pulled at more than 100 %, and no brake gives back more than it takes from the train."""
    fields = {f"loss_{name}": value for name, value in zip(LOSSES, losses, strict=True)}
    train = changed(lossy, loss_gear_share=gear, motors_cut_out=float(cut), **fields)[0]
    assert wire_power_w(train, share, force, speed) >= force * speed


@given(force=forces, speed=speeds, share=st.sampled_from([0.5, 0.75, 1.0]))
def test_motors_cut_out_never_cost_more_and_none_would_cost_less(
    lossy: Rows, cutting: Rows, force: float, speed: float, share: float
) -> None:
    all_w, cut_w = (wire_power_w(train[0], share, force, speed) for train in (lossy, cutting))
    assert cut_w <= all_w * (1.0 + 1e-12) if all_w > 0.0 else cut_w <= all_w * (1.0 - 1e-12)
    assume(force != 0.0)
    runs = running_motors(cutting[0], share, force, speed, GRIP_N)
    assert runs == int(runs) and 1 <= runs <= 4 * share
    needed = motors_needed(cutting[0], force, speed, GRIP_N)
    enough = [n for n in range(1, int(4 * share) + 1) if n >= needed - 1e-9] or [int(4 * share)]
    least_w = min(losses_w(cutting[0], n, force, speed) for n in enough)
    assert losses_w(cutting[0], runs, force, speed) == pytest.approx(least_w, rel=1e-12)


@given(speed=speeds, pull=st.floats(0.005, 0.06))
def test_at_light_load_motors_are_cut_out_and_it_saves(
    lossy: Rows, cutting: Rows, speed: float, pull: float
) -> None:
    """With the equipment switched off in the file (`motors_cut_out = false`) nothing is saved."""
    force_n = pull * min(48_000.0, 380_000.0 / speed)
    assert running_motors(cutting[0], 1.0, force_n, speed, GRIP_N) == 1.0
    assert running_motors(lossy[0], 1.0, force_n, speed, GRIP_N) == 4.0
    saved_w = wire_power_w(lossy[0], 1.0, force_n, speed) - wire_power_w(cutting[0], 1.0, force_n, speed)
    assert saved_w > 1_000.0


def test_the_number_is_capped_by_force_grip_and_motors_in_service(cutting: Rows) -> None:
    train = cutting[0]
    assert running_motors(train, 1.0, 14_000.0, 5.0, GRIP_N) == 2.0  # what loses least
    assert running_motors(train, 1.0, 48_000.0, 5.0, GRIP_N) == 4.0  # force of a motor
    assert running_motors(train, 1.0, 14_000.0, 5.0, 20_000.0) == 3.0  # grip of an axle
    assert running_motors(train, 0.5, 48_000.0, 5.0, GRIP_N) == 2.0  # motors in service
    assert running_motors(train, 1.0, -48_000.0, 7.0, GRIP_N) == 4.0


@given(force=forces, speed=speeds, more=st.sampled_from([*LOSSES, "gear_share"]), cut=st.booleans())
def test_power_rises_with_every_loss(
    lossy: Rows, changed: Change, force: float, speed: float, more: str, cut: bool
) -> None:
    train = changed(lossy, motors_cut_out=float(cut))
    worse = changed(train, **{f"loss_{more}": 1.2 * float(train[f"loss_{more}"][0])})
    assert wire_power_w(worse[0], 1.0, force, speed) >= wire_power_w(train[0], 1.0, force, speed)


@given(force=forces, speed=speeds)
def test_it_is_continuous_in_force_and_speed(
    lossy: Rows, changed: Change, force: float, speed: float
) -> None:
    """Also through no force, where magnetised motors coast."""
    train = changed(lossy, magnetised_coasting=1.0)[0]
    here_w = wire_power_w(train, 1.0, force, speed)
    assert wire_power_w(train, 1.0, force + 1e-3, speed) == pytest.approx(here_w, abs=1.0)
    assert wire_power_w(train, 1.0, force, speed + 1e-6) == pytest.approx(here_w, abs=1.0)
    at_rest_w = wire_power_w(train, 1.0, 0.0, speed)
    assert wire_power_w(train, 1.0, 1e-6, speed) == pytest.approx(at_rest_w, abs=1e-3)
    assert wire_power_w(train, 1.0, -1e-6, speed) == pytest.approx(at_rest_w, abs=1e-3)


def test_who_coasts_magnetised_pays_for_it(lossy: Rows, cutting: Rows, changed: Change) -> None:
    magnetised, cut = changed(lossy, magnetised_coasting=1.0), changed(cutting, magnetised_coasting=1.0)
    assert wire_power_w(magnetised[0], 1.0, 0.0, 15.0) == pytest.approx(4.0 * no_load_w(lossy[0], 15.0))
    assert wire_power_w(magnetised[0], 0.5, 0.0, 15.0) == pytest.approx(2.0 * no_load_w(lossy[0], 15.0))
    assert wire_power_w(lossy[0], 1.0, 0.0, 15.0) == wire_power_w(cut[0], 1.0, 0.0, 15.0) == 0.0
    assert wire_power_w(magnetised[0], 1.0, 0.0, 0.0) == 0.0  # it stands with its inverters off
    coasted_j = []
    for train in (magnetised[0], lossy[0]):
        plant = new_plant(1, 15.0)[0]
        for _ in range(50):
            step(plant, train, 0.0, False, 0.0, 0.0, DT_S)
        coasted_j.append(float(plant["energy_traction_j"]))
    assert coasted_j[0] == pytest.approx(4.0 * no_load_w(lossy[0], 15.0) * 5.0, rel=0.02)
    assert coasted_j[1] == 0.0


def test_the_plant_is_charged_what_the_prediction_counts(lossy: Rows, cutting: Rows) -> None:
    """A hop of 2 km on the level, held at 15 m/s: one function for both, so a stronger loss shows in both alike."""
    elevation_m, limit_mps = np.zeros(2_100), np.full(2_100, 15.0)
    spent_j = []
    for train in (lossy[0], cutting[0]):
        _, net_j = predicted_run(train, 0.0, elevation_m, limit_mps, 50.0, 2_050.0, 15.0, 0.7, DT_S)
        plant = new_plant(1, 15.0)[0]
        plant["traction_force_n"] = 3_000.0
        predicted_w = power_at_grip_w(train, 1.0, 3_000.0, 15.0, GRIP_N)
        assert predicted_w == wire_power_w(train, 1.0, 3_000.0, 15.0)
        spent_j.append(net_j)
    assert 0.01 < 1.0 - spent_j[1] / spent_j[0] < 0.10


@given(speed=st.floats(3.0, 25.0), gives=st.floats(0.0, 4e5), takes=st.floats(0.0, 3e5), cut=st.booleans())
def test_the_limits_of_a_source_hold_with_losses(
    lossy: Rows, changed: Change, speed: float, gives: float, takes: float, cut: bool
) -> None:
    train = changed(lossy, motors_cut_out=float(cut), magnetised_coasting=1.0)[0]
    plant = new_plant(1, speed)[0]
    plant["source_gives_w"], plant["source_takes_w"] = gives, takes
    for notch in [5.0] * 40 + [0.0] * 20 + [-7.0] * 120:
        before_j = plant["energy_traction_j"] - plant["energy_regenerated_j"]
        step(plant, train, notch, False, 0.0, 0.0, DT_S)
        power_w = (plant["energy_traction_j"] - plant["energy_regenerated_j"] - before_j) / DT_S
        assert power_w <= max(gives - 30_000.0, 0.0) * (1.0 + 1e-9) + 1e-3
        assert -power_w <= (takes + 30_000.0) * (1.0 + 1e-9) + 1e-3


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("copper_kw = 5.7", "copper_kw = -5.7", "losses.copper_kw"),  # more than 100 %
        ("inverter_kw = 1.6", "inverter_kw = -0.1", "losses.inverter_kw"),  # braking would make energy
        ("gear_share = 0.025", "gear_share = -0.01", "losses.gear_share"),
        ("gear_share = 0.025", "gear_share = 0.4", "losses.gear_share"),
        ("standby_kw = 0.3", "standby_kw = 400.0", "losses.standby_kw"),
        ("base_speed_kmh = 28.5", "base_speed_kmh = 0.0", "losses.base_speed_kmh"),
        ("base_speed_kmh = 28.5", "base_speed_kmh = 400.0", "losses.base_speed_kmh"),  # beyond what it runs
        ("motors_cut_out = false", "motors_cut_out = 1", "losses.motors_cut_out"),
        ("eddy_kw = 0.6", "", "losses.eddy_w"),
        ("eddy_kw = 0.6", "eddy_kw = 0.6\nwindage_kw = 0.1", "losses.windage_kw"),
        ("copper_kw = 5.7", "copper_kw = 290.0", "losses.copper_kw"),  # a heater
        ('"losses" = "assumed', '"body.cars2" = "assumed', "provenance"),
    ],
)
def test_nonsense_is_refused(tmp_path: Path, old: str, new: str, key: str) -> None:
    text = shipped_train("ev_e301_losses").read_text("utf-8")
    assert old in text
    file = tmp_path / "train.toml"
    file.write_text(text.replace(old, new), "utf-8")
    with pytest.raises(InputError) as caught:
        load_train(file)
    assert caught.value.key.startswith(key)


NO_LOSS: Final = ("standby_kw", "magnetising_kw", "hysteresis_kw", "eddy_kw")


@pytest.mark.parametrize(
    ("left_out", "key"),
    [(NO_LOSS, "standby"), (("inverter_kw", "copper_kw", "gear_share", *NO_LOSS), "copper")],
)
def test_motors_that_lose_nothing_are_refused(tmp_path: Path, left_out: tuple[str, ...], key: str) -> None:
    """Idle for nothing, or at 100 % throughout."""
    lines = shipped_train("ev_e301_losses").read_text("utf-8").splitlines()
    keys = [line.partition(" = ")[0] for line in lines]
    file = tmp_path / "train.toml"
    nothing = [f"{k} = 0.0" if k in left_out else line for k, line in zip(keys, lines, strict=True)]
    file.write_text("\n".join(nothing), "utf-8")
    with pytest.raises(InputError, match=key):
        load_train(file)


def test_the_shipped_trains_with_and_without_losses_are_otherwise_alike() -> None:
    plain, lossy = (tomllib.loads(shipped_train(n).read_text("utf-8")) for n in ("ev_e301", "ev_e301_losses"))
    assert lossy.pop("losses")
    for table in (plain, lossy):
        del table["id"], table["name"]
    # Whose efficiencies have the battery among them says so, and the other that its map has not.
    assert "battery, inverter, motor and gear" in plain["provenance"].pop("energy")
    assert "to the terminals of the battery" in lossy["provenance"].pop("energy")
    own = {key: text for key, text in lossy["provenance"].items() if key.partition(".")[0] == "losses"}
    assert plain["provenance"] == {k: text for k, text in lossy.pop("provenance").items() if k not in own}
    assert {key: plain[key] for key in plain if key != "provenance"} == lossy


@pytest.mark.parametrize("speed_mps", [5.0, 12.0, 25.0])
def test_what_a_force_costs_the_optimum_is_what_the_wire_gives_from_the_efficient_point_on(
    lossy: Rows, speed_mps: float
) -> None:
    train, inertia_kg = lossy[0], equivalent_mass_kg(lossy[0], 0.3)
    slope, _, bend, curve, idle = cost_terms(train, 0.3, speed_mps)
    for force_n in (0.5 * bend * inertia_kg, bend * inertia_kg, 40_000.0):
        asks = force_n / inertia_kg
        cost = slope * asks + curve * max(asks - bend, 0.0) ** 2 + idle
        drawn = wire_power_w(train, 1.0, force_n, speed_mps) / (speed_mps * inertia_kg)
        assert cost < drawn - 1e-4 if asks < bend else cost == pytest.approx(drawn)
