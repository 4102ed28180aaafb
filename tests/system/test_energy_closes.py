"""Every train and leg, of a set's way out and back and of a real day: a second account finds what it drew, to 0.1 %."""

import pytest

from scenario.scenario import Scenario, load_scenario
from simulation.result import PARTS, REJECTED, EnergyPhase, RunResult
from study.collect.energy import StockMake, energy_tables
from study.runner.run import CarrierKind, simulation_of
from tests.conftest import turn_back_in
from tests.nightly import others_nightly
from tests.system.energy_apart import Balance, Part, balances, figures_of

CLOSES: float = 1e-3
LEGS_LEAST = {"turn_back": 4, "karasuyama_weekday": 200}


@pytest.fixture(scope="module", params=others_nightly(LEGS_LEAST, ["turn_back"]))
def scenario(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Scenario:
    name: str = request.param
    return load_scenario(turn_back_in(tmp_path_factory.mktemp(name)) if name == "turn_back" else name)


@pytest.fixture(scope="module")
def day(scenario: Scenario) -> RunResult:
    with simulation_of(scenario.setup, carrier=CarrierKind.PLAIN) as simulation:
        return simulation.run()


@pytest.fixture(scope="module")
def legs(scenario: Scenario, day: RunResult) -> tuple[Balance, ...]:
    (train,) = {kind.id: kind for kind in scenario.setup.trains.values()}.values()
    return tuple(balances(day, scenario.setup.line, figures_of(train.row[0])))


def test_every_leg_of_every_train_closes(scenario: Scenario, legs: tuple[Balance, ...]) -> None:
    assert len(legs) >= LEGS_LEAST[scenario.id]
    worst = max(legs, key=Balance.open_share)
    assert worst.open_share() < CLOSES, worst


@pytest.mark.parametrize("part", [part for part in Part if part is not Part.KINETIC])
def test_a_part_left_out_is_found_out(legs: tuple[Balance, ...], part: Part) -> None:
    assert max(leg.open_share(part) for leg in legs) > 10.0 * CLOSES


def test_the_records_close_by_themselves(day: RunResult) -> None:
    for record in day.energy:
        assert abs(record.residual_j) <= 1e-6 * (
            record.counted_j["traction"] + record.counted_j["auxiliary"]
        ), record
        if record.phase is not EnergyPhase.RUNNING:
            assert all(record.counted_j[part] == 0.0 for part in (*PARTS, REJECTED))
    for part in PARTS:
        assert sum(abs(record.counted_j[part]) for record in day.energy) > 0.0, part


def test_the_tables_carry_what_the_records_have(scenario: Scenario, day: RunResult) -> None:
    makes = {stock: StockMake.of_kind(kind) for stock, kind in scenario.setup.trains.items()}
    made = energy_tables(day.energy, makes)
    for table in ("energy", "energy_legs"):
        for row in made[table].iter_rows(named=True):
            found = sum(row[f"{name}_kwh"] for name in PARTS) + row["auxiliary_kwh"] + row["residual_kwh"]
            assert found == pytest.approx(row["net_kwh"], abs=1e-9), row
            assert abs(row["residual_kwh"]) <= 1e-6 * row["traction_kwh"] + 1e-12
