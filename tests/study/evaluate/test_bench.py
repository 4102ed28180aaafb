"""The recording that SUMO alone replays: the same trains at the same places, with nothing of ours running."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import libsumo
import numpy as np
import pytest

from host.party import Advance
from network.errors import InputError
from network.model import Direction
from scenario.scenario import load_scenario
from simulation.carriers.carrier import Carrier, Truth
from study.evaluate import laws
from study.evaluate.bench import BUDGET, BUSY_BUDGET, MemorySampler, Metered, Recorder, parts, replay, report
from study.evaluate.parts import PARTS, part_of
from study.runner.run import PartyLink, execute
from sumo_cfg.build import net_for

SAME_M = 0.002  # a reversal puts back SUMO's own millimetre, which SUMO alone keeps


@dataclass
class Silent:
    """A carrier that does nothing and says what it was asked."""

    asked: list[str] = field(default_factory=list)

    def insert(
        self, unit_id: str, pieces: Sequence[str], direction: Direction, offset_m: float, length_m: float
    ) -> None:
        self.asked.append("insert")

    def run(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> int:
        self.asked.append("run")
        return 0

    def truth(self, unit_id: str) -> Truth:
        return Truth("3", Direction.DOWN, 1.0, 2.0)

    def reroute(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        self.asked.append("reroute")

    def reverse(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        self.asked.append("reverse")

    def remove(self, unit_id: str) -> None:
        self.asked.append("remove")

    def collisions(self) -> tuple[str, ...]:
        return ("one",)

    def close(self) -> None:
        self.asked.append("close")


def test_a_recorder_passes_everything_on() -> None:
    silent = Silent()
    carrier: Carrier = Recorder(silent)
    carrier.insert("K1", ["3", "P5.normal"], Direction.DOWN, 80.0, 40.0)
    assert carrier.run([("K1", [1.0, 2.0])], 2) == 0
    carrier.reroute("K1", ["P5.normal"], Direction.DOWN)
    carrier.reverse("K1", ["3"], Direction.UP)
    carrier.remove("K1")
    carrier.close()
    assert silent.asked == ["insert", "run", "reroute", "reverse", "remove", "close"]
    assert carrier.truth("K1").speed_mps == 2.0
    assert carrier.collisions() == ("one",)


def test_a_recording_has_a_speed_for_every_step_of_a_train_on_the_line(tmp_path: Path) -> None:
    recorder = Recorder(Silent())
    recorder.run([], 3)
    recorder.insert("K2", ["3", "P5.normal"], Direction.DOWN, 80.0, 40.0)
    recorder.run([("K2", [1.0, 2.0])], 2)
    recorder.run([], 2)  # it stands
    recorder.remove("K2")
    recorder.insert("K1", ["9"], Direction.UP, 50.0, 40.0)
    recorder.run([("K1", [3.0])], 1)
    recorder.save(tmp_path / "recording.npz", begin_s=35_400.0)
    with np.load(tmp_path / "recording.npz") as data:
        speeds, header = data["speeds"], json.loads(str(data["header"]))
    nan = np.nan
    assert header["units"] == ["K1", "K2"]
    assert header["begin_s"] == 35_400.0
    np.testing.assert_array_equal(speeds[:, 1], [nan, nan, nan, 1.0, 2.0, 0.0, 0.0, nan])
    np.testing.assert_array_equal(speeds[:, 0], [nan] * 7 + [3.0])
    kinds = [(step, kind, unit) for step, kind, unit, *_ in header["operations"]]
    assert kinds == [(3, "insert", "K2"), (7, "remove", "K2"), (7, "insert", "K1")]
    assert header["operations"][0][3] == ["3+", "P5.normal+"]


def test_a_stretch_is_counted_where_it_is_carried() -> None:
    recorder = Recorder(Silent())
    for steps in (3, 50, 1):
        recorder.run([], steps)
    assert recorder.stretches == 3


@dataclass
class Relay:
    """Parties of which one sends every telegram on, twice."""

    asked: list[str] = field(default_factory=list)

    def __enter__(self) -> Relay:
        return self

    def __exit__(self, *_error: object) -> None:
        self.asked.append("closed")

    def advance(self, party_id: str, now_s: float, telegrams: Sequence[bytes], told: bytes) -> Advance:
        self.asked.append(party_id)
        return Advance(tuple(("u1", data) for data in (*telegrams, *telegrams)), told, None)

    def alive(self, party_id: str) -> bool:
        return party_id == "t"

    def kill(self, party_id: str) -> None:
        self.asked.append("kill")

    def restart(self, party_id: str) -> None:
        self.asked.append("restart")


def test_a_meter_passes_everything_on_and_counts_telegrams_both_ways() -> None:
    relay = Relay()
    with Metered(relay) as metered:
        assert metered.advance("t", 1.0, [b"a", b"b"], b"told").said == b"told"
        metered.advance("t", 2.0, [], b"")
        metered.kill("t")
        metered.restart("t")
        assert (metered.alive("t"), metered.alive("u")) == (True, False)
    assert relay.asked == ["t", "t", "kill", "restart", "closed"]
    assert (metered.queries, metered.telegrams) == (2, 6)
    assert metered.spent_s > 0.0


def test_time_is_divided_into_queries_and_stretches() -> None:
    """4 s, of which 1 s in 500 queries with 2000 telegrams; SUMO alone takes 2 s for the same 1000 stretches."""
    found = parts("a link", [{"wall_s": 4.0, "queries": 500, "telegrams": 2000, "queries_s": 1.0}], 1000, 2.0)
    assert found["us_per_query"] == 2000.0
    assert found["us_per_telegram"] == 500.0
    assert found["us_per_stretch"] == 3000.0
    assert found["us_per_stretch_beyond_sumo"] == 1000.0
    idle = parts("a link", [{"wall_s": 4.0, "queries": 0, "telegrams": 0, "queries_s": 0.0}], 1000, 2.0)
    assert (idle["us_per_query"], idle["us_per_telegram"]) == (0.0, 0.0)


def figures(
    sumo_s: float, simulated_s: float, zenoh_s: float, other: str = "d"
) -> dict[str, list[dict[str, Any]]]:
    asked = {"queries": 1, "telegrams": 1, "queries_s": 0.1, "peak_mb": 500.0}
    return {
        "sumo": [{"wall_s": sumo_s, "peak_mb": 100.0}] * 3,
        "simulated": [{"wall_s": simulated_s, "digest": "d", **asked}] * 3,
        "zenoh": [{"wall_s": zenoh_s, "digest": other, **asked}] * 3,
    }


@pytest.mark.parametrize(
    ("walls", "kept", "kept_if_busy"),
    [
        ((10.0, 13.9, 18.0), [True, True, True], [True, True, True]),
        ((10.0, 14.1, 18.4), [False, False, True], [True, True, True]),
        ((10.0, 17.1, 24.0), [False, False, True], [False, False, True]),
    ],
)
def test_budgets_are_ratios_and_a_busy_line_has_its_own(
    walls: tuple[float, float, float], kept: list[bool], kept_if_busy: list[bool]
) -> None:
    for budget, expected in ((BUDGET, kept), (BUSY_BUDGET, kept_if_busy)):
        found = report(figures(*walls), 10, budget)
        assert [line["kept"] for line in found["budgets"]] == expected
        assert found["same_digest"]
    assert not report(figures(*walls, other="e"), 10, BUDGET)["same_digest"]


@pytest.mark.parametrize("named", ["rtri_test_line", "turn_back"])
def test_sumo_alone_ends_where_the_full_system_ended(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, named: str
) -> None:
    scenario = load_scenario(request.getfixturevalue(named) if named == "turn_back" else named)
    ends: list[dict[str, tuple[str, float, float]]] = []
    close = libsumo.close

    def look_and_close() -> None:
        units = libsumo.vehicle.getIDList()
        here = libsumo.vehicle
        ends.append({u: (here.getRoadID(u), here.getLanePosition(u), here.getSpeed(u)) for u in units})
        close()

    monkeypatch.setattr(libsumo, "close", look_and_close)
    recorders: list[Recorder] = []

    def wrap(carrier: Carrier) -> Carrier:
        recorders.append(Recorder(carrier))
        return recorders[0]

    run = execute(scenario, PartyLink.SIMULATED, wrap=wrap)
    recorders[0].save(tmp_path / "recording.npz", run.result.begin_step / 10)
    figures = replay(tmp_path / "recording.npz", net_for(scenario.setup.line, tmp_path))
    assert figures["steps"] == run.result.end_step - run.result.begin_step
    full, alone = ends
    assert full.keys() == alone.keys() == set(run.result.stock_ids)
    for unit, (edge, at_m, speed_mps) in full.items():
        assert alone[unit][0] == edge
        assert alone[unit][1] == pytest.approx(at_m, abs=SAME_M)
        assert alone[unit][2] == speed_mps == 0.0


def test_the_time_of_laws_is_a_ratio_of_medians() -> None:
    """Of 2, 3 and 10 s the median is 3; of 3, 3.6 and 3.6 s it is 3.6: 1.2 times, which is just allowed."""
    present, best = laws.COMPARED
    rounds = {present: [2.0, 10.0, 3.0], best: [3.6, 3.0, 3.6]}
    figures = {law: [{"wall_s": s, "digest": law} for s in walls] for law, walls in rounds.items()}
    found = laws.report(figures)
    assert [row["of_present"] for row in found["rows"]] == [1.0, 1.2]
    assert found["budgets"][0]["kept"]
    assert found["same_digest"]
    figures[best][0]["wall_s"] = figures[best][1]["wall_s"] = 3.7
    figures[best][2]["digest"] = "another"
    found = laws.report(figures)
    assert not found["budgets"][0]["kept"]
    assert not found["same_digest"]


def test_every_part_of_the_bench_is_there_and_another_is_refused() -> None:
    assert all(callable(part_of(name)) for name in PARTS)
    with pytest.raises(InputError, match="--part"):
        part_of("no_such_part")


def test_memory_of_a_run_of_few_stretches_is_looked_at_while_it_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """The paper's line has 73 of them; when they are over, the processes of its parties are, too."""
    looked: list[int] = []
    memory = MemorySampler()
    monkeypatch.setattr(memory, "look", lambda: looked.append(memory._calls))
    for _ in range(73):
        memory.now_and_then(0.0, 0.0, 0)
    assert looked == [1, 2, 4, 8, 16, 32, 64]
