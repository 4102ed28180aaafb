"""SUMO and the plain track carry the same run to the same places."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import polars as pl
import pytest

from network.model import Direction, Line
from scenario.scenario import load_scenario
from simulation.carriers.carrier import Carrier, Truth
from study.runner.run import CarrierKind, FinishedRun, PartyLink, carrier_factory, execute
from sumo_cfg.build import net_for

AGREE_M, AGREE_MPS = 0.001, 0.01


@dataclass
class Watched:
    """A carrier that is asked step by step where the moving trains are. The tables have their positions from the
    speeds, and SUMO's only every few steps, so they alone would not show a carrier that strays in between.
    """

    inner: Carrier
    line: Line
    steps: int = 0
    seen: dict[tuple[int, str], tuple[float, float]] = field(default_factory=dict)

    def insert(
        self, unit_id: str, pieces: Sequence[str], direction: Direction, offset_m: float, length_m: float
    ) -> None:
        self.inner.insert(unit_id, pieces, direction, offset_m, length_m)

    def run(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> int:
        if not columns:
            self.steps += steps
            return self.inner.run(columns, steps)
        for k in range(steps):
            if self.inner.run([(unit_id, speeds[k : k + 1]) for unit_id, speeds in columns], 1):
                return k + 1
            self.steps += 1
            for unit_id, _ in columns:
                truth = self.inner.truth(unit_id)
                self.seen[self.steps, unit_id] = (self.kilometrage_m(truth), truth.speed_mps)
        return 0

    def kilometrage_m(self, truth: Truth) -> float:
        piece = self.line.pieces[truth.piece_id]
        if truth.direction is Direction.DOWN:
            return piece.from_m + truth.offset_m
        return piece.to_m - truth.offset_m

    def truth(self, unit_id: str) -> Truth:
        return self.inner.truth(unit_id)

    def reroute(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        self.inner.reroute(unit_id, pieces, direction)

    def reverse(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        self.inner.reverse(unit_id, pieces, direction)

    def remove(self, unit_id: str) -> None:
        self.inner.remove(unit_id)

    def collisions(self) -> tuple[str, ...]:
        return self.inner.collisions()

    def close(self) -> None:
        self.inner.close()


def run_on(kind: CarrierKind, scenario: str) -> tuple[FinishedRun, Watched]:
    watched: list[Watched] = []
    loaded = load_scenario(scenario)

    def wrap(carrier: Carrier) -> Carrier:
        watched.append(Watched(carrier, loaded.setup.line))
        return watched[0]

    return execute(loaded, PartyLink.SIMULATED, carrier=kind, wrap=wrap), watched[0]


def check_agreement(scenario: str, moving_s_min: float) -> None:
    on_sumo, sumo = run_on(CarrierKind.SUMO, scenario)
    on_plain, plain = run_on(CarrierKind.PLAIN, scenario)
    assert on_sumo.broken == on_plain.broken == ()
    assert sumo.seen.keys() == plain.seen.keys()
    assert len(sumo.seen) > moving_s_min * 10
    for key, (at_m, speed_mps) in sumo.seen.items():
        other_m, other_mps = plain.seen[key]
        assert abs(at_m - other_m) <= AGREE_M, key
        assert abs(speed_mps - other_mps) <= AGREE_MPS, key
    tables = [
        run.tables.trajectory.select("t_s", "unit", "kilometrage_m", "speed_mps")
        for run in (on_sumo, on_plain)
    ]
    both = tables[0].join(tables[1], on=["t_s", "unit"], how="full", suffix="_plain")
    assert both.null_count().sum_horizontal().item() == 0
    away = (pl.col("kilometrage_m") - pl.col("kilometrage_m_plain")).abs().max().alias("m")
    faster = (pl.col("speed_mps") - pl.col("speed_mps_plain")).abs().max().alias("mps")
    worst = both.select(away, faster).row(0)
    assert worst[0] <= AGREE_M
    assert worst[1] <= AGREE_MPS


def test_the_run_of_the_paper() -> None:
    check_agreement("rtri_test_line", moving_s_min=60.0)


def test_a_set_that_changes_ends_on_the_karasuyama_line(turn_back: str) -> None:
    check_agreement(turn_back, moving_s_min=1500.0)


def test_the_same_seed_is_the_same_run_and_another_is_not(turn_back: str) -> None:
    digests = [
        execute(load_scenario(turn_back, seed), PartyLink.SIMULATED, carrier=CarrierKind.PLAIN).result.digest
        for seed in (1, 1, 7)
    ]
    assert digests[0] == digests[1] != digests[2]


def test_a_train_that_turns_over_a_joint_has_its_front_where_its_rear_was(tmp_path: Path) -> None:
    """Its front at 550 m going down, 40 m long: its rear lies 10 m before the toe of P5, beyond a piece of 10 m."""
    line = load_scenario("rtri_test_line").setup.line
    for kind in (CarrierKind.SUMO, CarrierKind.PLAIN):
        carrier = carrier_factory(kind, line, net_for(line, tmp_path))(0.0, None)
        carrier.insert("K1", ("6", "P7.stem"), Direction.DOWN, 20.0, 40.0)
        carrier.run([], 1)
        carrier.reverse("K1", ("6", "P5.stem", "P5.normal", "3"), Direction.UP)
        carrier.run([("K1", [0.0])], 1)
        seen = carrier.truth("K1")
        assert (seen.piece_id, seen.direction) == ("P5.normal", Direction.UP)
        assert seen.offset_m == pytest.approx(10.0, abs=1e-4)
        carrier.run([("K1", [10.0] * 50)], 50)
        seen = carrier.truth("K1")
        assert (seen.piece_id, seen.offset_m) == ("3", pytest.approx(10.0 + 49.5 - 50.0, abs=1e-3))
        carrier.close()


def test_a_train_that_moves_in_the_step_in_which_it_turns_keeps_what_it_ran(tmp_path: Path) -> None:
    """SUMO turns it in its next step and is put right afterwards: by the turn, not back to a stand."""
    line = load_scenario("rtri_test_line").setup.line
    (track,) = (s for s in line.sections.values() if s.id == "3")
    seen: list[Truth] = []
    for kind in (CarrierKind.SUMO, CarrierKind.PLAIN):
        carrier = carrier_factory(kind, line, net_for(line, tmp_path))(0.0, None)
        carrier.insert("K1", track.piece_ids, Direction.DOWN, 60.0, 40.0)
        carrier.run([], 1)
        carrier.reverse("K1", track.piece_ids, Direction.UP)
        carrier.run([("K1", [0.3, 0.5])], 2)
        seen.append(carrier.truth("K1"))
        carrier.close()
    on_sumo, on_plain = seen
    assert on_sumo.piece_id == on_plain.piece_id
    assert on_sumo.offset_m == pytest.approx(on_plain.offset_m, abs=1e-4)
    assert on_plain.offset_m == pytest.approx(
        line.pieces[track.piece_ids[0]].length_m - 20.0 + 0.015 + 0.04, abs=1e-9
    )
