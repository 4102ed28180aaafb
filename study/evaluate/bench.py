"""What a run costs: the same day carried by SUMO alone, by the full system in one process, and over Zenoh.

The day is run once to record what the carrier was asked to do. Then each way runs in turn, each in a fresh process,
round after round, so that a machine whose speed drifts treats all alike. "SUMO alone" is libsumo with one setSpeed
for each train on the line and each step. Compilation is done before anything is timed; imports are not timed.

Beside the ratios stands where the time goes (`COMPUTED`): in the stretches, one call of the kernel each, and in the
queries, one call of a party each, with the telegrams that they carry there and back.
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self

import numpy as np
import psutil

from host.parties import Parties
from host.party import Advance
from host.scratch import scratch
from network.model import Direction
from simulation.carriers.carrier import Carrier, Truth
from simulation.carriers.sumo import edge_id
from study.evaluate.afresh import budget_of, in_rounds
from study.evaluate.optimum_bench import bench_optimum

WAYS: Final = ("sumo", "simulated", "zenoh")
NAMES: Final = {
    "sumo": "SUMO alone",
    "simulated": "full system, simulated links",
    "zenoh": "full system, Zenoh processes",
}
REPLAY_CHUNK: Final = 4096
COMPUTED: Final = (
    "a stretch is one call of the kernel, a query one call of a party; us a query and us a telegram: the time in all"
    " queries, by the number of queries, and of telegrams to and from parties; us a stretch: all other time of the"
    " run by the number of stretches, 'beyond SUMO' less what SUMO alone takes for the same stretches"
)


@dataclass(frozen=True, slots=True)
class Budget:
    """How often the time of SUMO alone the full system may take, and of simulated links that over Zenoh."""

    of_sumo_alone: float
    of_simulated_links: float
    peak_mb: float = 1000.0


BUSY_TRAINS: Final = 90  # a line with as many trains a day is a busy one
BUDGET: Final = Budget(1.4, 1.3)
BUSY_BUDGET: Final = Budget(1.7, 1.4)


@dataclass(frozen=True, slots=True)
class CarrierOperation:
    """Something asked of the carrier after `step` steps: insert, reverse, reroute or remove."""

    step: int
    kind: str
    unit_id: str
    edges: tuple[str, ...] = ()
    offset_m: float = 0.0
    length_m: float = 0.0


@dataclass(slots=True)
class Recorder:
    """A carrier that passes everything on and remembers it."""

    inner: Carrier
    operations: list[CarrierOperation] = field(default_factory=list)
    chunks: list[tuple[int, dict[str, list[float]]]] = field(default_factory=list)
    steps: int = 0

    def insert(
        self, unit_id: str, pieces: Sequence[str], direction: Direction, offset_m: float, length_m: float
    ) -> None:
        """Pass on and remember."""
        edges = tuple(edge_id(piece, direction) for piece in pieces)
        self.operations.append(CarrierOperation(self.steps, "insert", unit_id, edges, offset_m, length_m))
        self.inner.insert(unit_id, pieces, direction, offset_m, length_m)

    def run(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> int:
        """Pass on and remember."""
        self.chunks.append((self.steps, {unit_id: list(speeds) for unit_id, speeds in columns}))
        hit = self.inner.run(columns, steps)
        self.steps += hit or steps
        return hit

    def truth(self, unit_id: str) -> Truth:
        """Pass on."""
        return self.inner.truth(unit_id)

    def reroute(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Pass on and remember."""
        edges = tuple(edge_id(piece, direction) for piece in pieces)
        self.operations.append(CarrierOperation(self.steps, "reroute", unit_id, edges))
        self.inner.reroute(unit_id, pieces, direction)

    def reverse(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Pass on and remember."""
        edges = tuple(edge_id(piece, direction) for piece in pieces)
        back = edge_id(pieces[0], direction.opposite)
        self.operations.append(CarrierOperation(self.steps, "reroute", unit_id, (back, *edges)))
        self.inner.reverse(unit_id, pieces, direction)

    def remove(self, unit_id: str) -> None:
        """Pass on and remember."""
        self.operations.append(CarrierOperation(self.steps, "remove", unit_id))
        self.inner.remove(unit_id)

    def collisions(self) -> tuple[str, ...]:
        """Pass on."""
        return self.inner.collisions()

    def close(self) -> None:
        """Pass on."""
        self.inner.close()

    @property
    def stretches(self) -> int:
        """Calls of the kernel: each is carried once."""
        return len(self.chunks)

    def save(self, file: Path, begin_s: float) -> None:
        """Write the recording: speeds (steps, units; NaN where a train is not on the line) and operations."""
        units = sorted({operation.unit_id for operation in self.operations})
        column = {unit_id: index for index, unit_id in enumerate(units)}
        speeds = np.full((self.steps, len(units)), np.nan)
        on_since: dict[str, int] = {}
        for operation in self.operations:
            if operation.kind == "insert":
                on_since[operation.unit_id] = operation.step
            elif operation.kind == "remove":
                first = on_since.pop(operation.unit_id)
                speeds[first : operation.step, column[operation.unit_id]] = 0.0
        for unit_id, first in on_since.items():
            speeds[first:, column[unit_id]] = 0.0
        for first, columns in self.chunks:
            for unit_id, values in columns.items():
                speeds[first : first + len(values), column[unit_id]] = values
        operations = [
            [o.step, o.kind, o.unit_id, list(o.edges), o.offset_m, o.length_m] for o in self.operations
        ]
        header = json.dumps({"units": units, "begin_s": begin_s, "operations": operations})
        np.savez(file, speeds=speeds, header=np.array(header))


def replay(recording: Path, net: Path) -> dict[str, float]:
    """SUMO alone: the recorded speeds, one setSpeed a train and step. Returns wall_s and steps."""
    import libsumo

    from sumo_cfg.options import LANE_CHANGE_MODE, SPEED_MODE, add_train_type, sumo_command

    with np.load(recording) as data:
        speeds = data["speeds"]
        header = json.loads(str(data["header"]))
    units: list[str] = header["units"]
    operations = [CarrierOperation(*values) for values in header["operations"]]
    libsumo.start([*sumo_command(net), "--begin", f"{header['begin_s']:.1f}"])
    set_speed, step = libsumo.vehicle.setSpeed, libsumo.simulationStep
    started = time.perf_counter()
    kinds: set[str] = set()
    on_line: list[tuple[str, int]] = []
    upcoming = 0
    for first in range(0, len(speeds), REPLAY_CHUNK):
        for k, row in enumerate(speeds[first : first + REPLAY_CHUNK].tolist(), first):
            while upcoming < len(operations) and operations[upcoming].step <= k:
                operation = operations[upcoming]
                upcoming += 1
                if operation.kind == "insert":
                    kind = f"train-{operation.length_m:g}"
                    if kind not in kinds:
                        add_train_type(kind, operation.length_m)
                        kinds.add(kind)
                    libsumo.route.add(f"route-{upcoming}", list(operation.edges))
                    libsumo.vehicle.add(operation.unit_id, f"route-{upcoming}", typeID=kind)
                    libsumo.vehicle.moveTo(operation.unit_id, operation.edges[0] + "_0", operation.offset_m)
                    libsumo.vehicle.setSpeedMode(operation.unit_id, SPEED_MODE)
                    libsumo.vehicle.setLaneChangeMode(operation.unit_id, LANE_CHANGE_MODE)
                    on_line.append((operation.unit_id, units.index(operation.unit_id)))
                elif operation.kind == "remove":
                    libsumo.vehicle.remove(operation.unit_id)
                    on_line = [entry for entry in on_line if entry[0] != operation.unit_id]
                else:
                    libsumo.vehicle.setRoute(operation.unit_id, list(operation.edges))
            for unit_id, index in on_line:
                set_speed(unit_id, row[index])
            step()
    wall_s = time.perf_counter() - started
    libsumo.close()
    return {"wall_s": wall_s, "steps": float(len(speeds))}


@dataclass(frozen=True, slots=True)
class Recording:
    """A day as the carrier was asked for it."""

    file: Path
    net: Path
    stretches: int
    trains: int


def record(scenario: str, folder: Path) -> Recording:
    """Run a scenario once, and keep what the carrier was asked to do."""
    from scenario.scenario import load_scenario
    from study.runner.run import PartyLink, execute
    from sumo_cfg.build import net_for

    recorders: list[Recorder] = []

    def wrap(carrier: Carrier) -> Carrier:
        recorders.append(Recorder(carrier))
        return recorders[-1]

    loaded = load_scenario(scenario)
    run = execute(loaded, PartyLink.SIMULATED, wrap=wrap)
    file = folder / "recording.npz"
    recorders[0].save(file, run.result.begin_step / 10)
    trains = len(run.result.trains_planned)
    return Recording(file, net_for(loaded.setup.line, folder), recorders[0].stretches, trains)


@dataclass(slots=True)
class Metered:
    """Parties that pass everything on, count it and time it."""

    inner: Parties
    queries: int = 0
    telegrams: int = 0
    spent_s: float = 0.0

    def __enter__(self) -> Self:
        self.inner.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.inner.__exit__(kind, error, trace)

    def advance(self, party_id: str, now_s: float, telegrams: Sequence[bytes], told: bytes) -> Advance:
        """Pass on, count and time."""
        started = time.perf_counter()
        done = self.inner.advance(party_id, now_s, telegrams, told)
        self.spent_s += time.perf_counter() - started
        self.queries += 1
        self.telegrams += len(telegrams) + len(done.telegrams)
        return done

    def alive(self, party_id: str) -> bool:
        """Pass on."""
        return self.inner.alive(party_id)

    def kill(self, party_id: str) -> None:
        """Pass on."""
        self.inner.kill(party_id)

    def restart(self, party_id: str) -> None:
        """Pass on."""
        self.inner.restart(party_id)

    def lose(self, party_id: str) -> None:
        """Pass on."""
        self.inner.lose(party_id)

    def commission(self, party_id: str, number: int, vital: bytes) -> None:
        """Pass on."""
        self.inner.commission(party_id, number, vital)


class MemorySampler:
    """Resident memory of this process and its children, sampled; the recording is read before it counts."""

    def __init__(self) -> None:
        self.peak_mb = 0.0
        self._process = psutil.Process()
        self._calls = 0

    def look(self) -> None:
        """Take a sample."""
        sizes = [self._process.memory_info().rss]
        for child in self._process.children(recursive=True):
            with suppress(psutil.NoSuchProcess):
                sizes.append(child.memory_info().rss)
        self.peak_mb = max(self.peak_mb, sum(sizes) / 1e6)

    def now_and_then(self, _now_s: float, _end_s: float, _arrived: int) -> None:
        """As a progress callback: at twice as many calls each time, and every 2000th, so that it costs nothing."""
        self._calls += 1
        if self._calls.bit_count() == 1 or self._calls % 2000 == 0:
            self.look()


def run_child(way: str, scenario: str, recording: Path, net: Path) -> dict[str, float]:
    """One timed run in this process; peak memory is this process and its children together."""
    memory = MemorySampler()
    if way == "sumo":
        figures = replay(recording, net)
    else:
        from scenario.scenario import load_scenario
        from study.runner.run import PartyLink, execute

        meters: list[Metered] = []

        def watch(parties: Parties) -> Parties:
            meters.append(Metered(parties))
            return meters[-1]

        run = execute(load_scenario(scenario), PartyLink(way), progress=memory.now_and_then, watch=watch)
        figures = {"wall_s": float(run.summary["wall_s"]), "digest": run.summary["digest"]}
        figures |= {"queries": meters[-1].queries, "telegrams": meters[-1].telegrams}
        figures |= {"queries_s": meters[-1].spent_s}
    memory.look()
    return figures | {"peak_mb": memory.peak_mb}


def bench(scenario: str, rounds: int, tell: Callable[[str], None]) -> dict[str, Any]:
    """The three-way table: medians of wall time, ratios, parts and peak memory. `tell` gets what goes on."""
    with scratch("branchline-bench-") as folder:
        tell(f"recording {scenario}")
        recording = record(scenario, folder)
        kept = str(recording.file), str(recording.net)
        figures = in_rounds("study.evaluate.bench", NAMES, rounds, tell, scenario, *kept)
    budget = BUSY_BUDGET if recording.trains >= BUSY_TRAINS else BUDGET
    tell(f"{scenario}: a run of least energy")
    return {
        "scenario": scenario,
        "rounds": rounds,
        "trains": recording.trains,
        **report(figures, recording.stretches, budget),
        "optimum": bench_optimum(scenario),
    }


def report(figures: dict[str, list[dict[str, Any]]], stretches: int, budget: Budget) -> dict[str, Any]:
    """What the figures of all rounds come to: rows, parts and budgets, each budget with whether it is kept."""
    median = {way: statistics.median(f["wall_s"] for f in figures[way]) for way in WAYS}
    rows: list[dict[str, Any]] = [
        {
            "way": NAMES[way],
            "wall_s": round(median[way], 3),
            "wall_s_min": round(min(f["wall_s"] for f in figures[way]), 3),
            "wall_s_max": round(max(f["wall_s"] for f in figures[way]), 3),
            "of_sumo_alone": round(median[way] / median["sumo"], 3),
            "of_simulated_links": round(median[way] / median["simulated"], 3),
            "peak_mb": round(max(f["peak_mb"] for f in figures[way]), 1),
        }
        for way in WAYS
    ]
    found = (rows[1]["of_sumo_alone"], rows[2]["of_simulated_links"], max(row["peak_mb"] for row in rows))
    limits = (budget.of_sumo_alone, budget.of_simulated_links, budget.peak_mb)
    names = ("full system of SUMO alone", "Zenoh of simulated links", "peak MB")
    return {
        "rows": rows,
        "stretches": stretches,
        "parts": [parts(NAMES[way], figures[way], stretches, median["sumo"]) for way in WAYS[1:]],
        "computed": COMPUTED,
        "same_digest": len({f["digest"] for way in WAYS[1:] for f in figures[way]}) == 1,
        "budgets": [budget_of(*one) for one in zip(names, limits, found, strict=True)],
    }


def parts(name: str, rounds: Sequence[dict[str, Any]], stretches: int, sumo_s: float) -> dict[str, Any]:
    """Where the time of one link goes, in microseconds; medians over the rounds (see `COMPUTED`)."""
    queries, telegrams = rounds[0]["queries"], rounds[0]["telegrams"]
    spent_s = statistics.median(f["queries_s"] for f in rounds)
    other_s = statistics.median(f["wall_s"] - f["queries_s"] for f in rounds)
    return {
        "way": name,
        "queries": queries,
        "telegrams": telegrams,
        "us_per_query": round(1e6 * spent_s / max(queries, 1), 1),
        "us_per_telegram": round(1e6 * spent_s / max(telegrams, 1), 1),
        "us_per_stretch": round(1e6 * other_s / max(stretches, 1), 1),
        "us_per_stretch_beyond_sumo": round(1e6 * (other_s - sumo_s) / max(stretches, 1), 1),
    }


if __name__ == "__main__":
    way, scenario, recording, net = sys.argv[1:5]
    sys.stdout.write(json.dumps(run_child(way, scenario, Path(recording), Path(net))) + "\n")
