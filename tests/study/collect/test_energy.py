"""Energy by train, leg and layover: sums that close, on made-up records and against the plants of a whole run."""

from collections.abc import Callable, Sequence
from typing import Final

import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.units import J_PER_KWH
from scenario.scenario import load_scenario
from simulation.result import COUNTED, DRAWN, EnergyPhase, EnergyRecord
from simulation.world.energy_book import EnergyBook
from study.collect.energy import StockMake, energy_tables, stays_of
from study.drilling.drill import find_drill
from study.runner.run import simulation_of
from vehicle.train_file import RegenerationReceiver

FLEET: Final = dict.fromkeys(("K1", "K2"), StockMake(2, RegenerationReceiver.BATTERY))


def record(
    number: str,
    phase: EnergyPhase,
    ends: str,
    times_s: tuple[float, float],
    kwh: tuple[float, float, float],
    m: float = 0.0,
) -> EnergyRecord:
    from_id, to_id = ends.split("-") if "-" in ends else (ends, ends)
    joules = (figure * J_PER_KWH for figure in kwh)
    counted_j = dict.fromkeys(COUNTED, 0.0) | dict(zip(DRAWN, joules, strict=True))
    return EnergyRecord("K1", number, True, phase, from_id, to_id, *times_s, m, counted_j)


DAY: Final = (
    record("T1", EnergyPhase.HELD, "P-A", (0.0, 10.0), (0.0, 0.0, 0.1)),
    record("T1", EnergyPhase.RUNNING, "P-A", (10.0, 50.0), (2.0, 0.5, 0.4), 300.0),
    record("T1", EnergyPhase.AT_STOP, "A", (50.0, 80.0), (0.0, 0.0, 0.3)),
    record("T1", EnergyPhase.RUNNING, "A-B", (80.0, 180.0), (7.0, 2.0, 1.0), 1700.0),
    record("T1", EnergyPhase.LAYOVER, "B", (180.0, 400.0), (0.0, 0.0, 2.0)),
    record("T2", EnergyPhase.LAYOVER, "B", (400.0, 500.0), (0.0, 0.0, 1.0)),
    record("T2", EnergyPhase.RUNNING, "B-P", (500.0, 600.0), (6.0, 1.0, 1.0), 2000.0),
    # it stands in the portal and leaves
    record("T2", EnergyPhase.HELD, "P", (600.0, 610.0), (0.0, 0.0, 0.1)),
)


def test_a_day_worked_out_by_hand() -> None:
    made = energy_tables(DAY, FLEET)
    names = ("train", "distance_km", "running_s", "standing_s", "traction_kwh", "standing_kwh", "net_kwh")
    assert made["energy"].select(names).rows() == [
        ("T1", 2.0, 140.0, 40.0, 9.0, pytest.approx(0.4), pytest.approx(9.0 - 2.5 + 1.8)),
        ("T2", 2.0, 100.0, 10.0, 6.0, pytest.approx(0.1), pytest.approx(6.0 - 1.0 + 1.1)),
    ]
    assert made["energy_legs"].select("train", "from_station", "to_station", "auxiliary_kwh").rows() == [
        ("T1", "P", "A", pytest.approx(0.8)),  # with the stop at A
        ("T1", "A", "B", pytest.approx(1.0)),
        ("T2", "B", "P", pytest.approx(1.1)),
    ]
    assert made["layovers"].select(
        "station", "after_train", "before_train", "from_s", "to_s", "net_kwh"
    ).rows() == [("B", "T1", "T2", 180.0, 500.0, pytest.approx(3.0))]


def test_what_resistors_take_does_not_come_back() -> None:
    burnt = energy_tables(DAY, dict.fromkeys(FLEET, StockMake(2, RegenerationReceiver.RESISTORS)))["energy"]
    assert burnt["net_kwh"].to_list() == pytest.approx([9.0 + 1.8, 6.0 + 1.1])
    assert set(burnt["regenerated_to"]) == {"resistors"}


def test_stock_that_begins_or_ends_its_day_here_has_one_train_beside_its_layover() -> None:
    first = record("T1", EnergyPhase.LAYOVER, "A", (0.0, 30.0), (0.0, 0.0, 0.1))
    ran = record("T1", EnergyPhase.RUNNING, "A-B", (30.0, 90.0), (1.0, 0.0, 0.1), 500.0)
    last = record("T1", EnergyPhase.LAYOVER, "B", (90.0, 120.0), (0.0, 0.0, 0.1))
    stabled = record("T1", EnergyPhase.STABLED, "B", (120.0, 900.0), (0.0, 0.0, 5.0))
    stays = stays_of((first, ran, last, stabled))
    assert [(s.after_train, s.before_train) for s in stays] == [(None, "T1"), ("T1", None)]
    assert energy_tables((first, ran, last, stabled), FLEET)["energy"][
        "auxiliary_kwh"
    ].sum() == pytest.approx(0.1)


figures = st.tuples(*[st.floats(0.0, 100.0)] * 3)
phases = st.sampled_from([p for p in EnergyPhase if p is not EnergyPhase.STABLED])


@given(parts=st.lists(st.tuples(st.sampled_from(["T1", "T2", "T3"]), phases, figures), max_size=30))
def test_sums_close(parts: Sequence[tuple[str, EnergyPhase, tuple[float, float, float]]]) -> None:
    """Trains and layovers make the total, and legs their train, whatever happened in whatever order."""
    records = [
        record(
            number,
            phase,
            "A-B" if phase in (EnergyPhase.RUNNING, EnergyPhase.HELD) else "B",
            (i * 10.0, i * 10.0 + 9.0),
            kwh,
        )
        for i, (number, phase, kwh) in enumerate(parts)
    ]
    made = energy_tables(records, FLEET)
    for index, kind in enumerate(DRAWN):
        column = f"{kind}_kwh"
        booked = made["energy"][column].sum() + made["layovers"][column].sum()
        assert booked == pytest.approx(sum(kwh[index] for _, _, kwh in parts), abs=1e-6)
        by_leg = made["energy_legs"].group_by("train").agg(pl.col(column).sum())
        by_train = dict(made["energy"].select("train", column).iter_rows())
        assert dict(by_leg.iter_rows()) == pytest.approx(by_train, abs=1e-6)


TURN_BACK: Final = find_drill("rtri/02_turn_back")


def unbooked_kwh(drill: str) -> float:
    """What the plants of a drill have counted and no record has, or the other way round; the worst of all kinds."""
    with simulation_of(load_scenario(drill).setup) as simulation:
        result = simulation.run()
        plants = simulation.trains.stock["plant"]
        counted = {kind: float(plants[f"energy_{kind}_j"].sum()) for kind in DRAWN}
    booked = {kind: sum(r.counted_j[kind] for r in result.energy) for kind in DRAWN}
    standing = [r for r in result.energy if r.phase is not EnergyPhase.RUNNING]
    assert all(r.counted_j["traction"] == r.counted_j["regenerated"] == r.distance_m == 0.0 for r in standing)
    assert all(r.end_s >= r.begin_s and r.counted_j["auxiliary"] >= 0.0 for r in result.energy)
    return max(abs(counted[kind] - booked[kind]) for kind in DRAWN) / J_PER_KWH


def test_every_joule_of_a_run_is_in_one_record() -> None:
    assert unbooked_kwh(TURN_BACK) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "instead"),
    [
        ("moves", lambda *_: None),  # a run that is no run: work is done at a stand
        ("close", lambda book, slot, _step: book._accounts.pop(slot, None)),
        ("_arrive", lambda _book, account, at: account.leg.clear() or setattr(account, "at", at)),
    ],
)
def test_a_book_that_loses_energy_is_found_out(
    monkeypatch: pytest.MonkeyPatch, name: str, instead: Callable[..., object]
) -> None:
    monkeypatch.setattr(EnergyBook, name, instead)
    try:
        lost = unbooked_kwh(TURN_BACK) > 1e-3
    except AssertionError:
        lost = True
    assert lost
