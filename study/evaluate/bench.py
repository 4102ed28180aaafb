"""What a run costs: the same day carried by SUMO alone, by the full system in one process, and over Zenoh.

The day is run once to record what the carrier was asked to do. Then each way runs in turn, each in a fresh process,
round after round, so that a machine whose speed drifts treats all alike. "SUMO alone" is libsumo with one setSpeed
for each train on the line and each step. Compilation is done before anything is timed; imports are not timed.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
import psutil

from network.model import Direction
from simulation.carriers.carrier import Carrier, Truth
from simulation.carriers.sumo import edge_id

WAYS: Final = ("sumo", "simulated", "zenoh")
NAMES: Final = {
    "sumo": "SUMO alone",
    "simulated": "full system, simulated links",
    "zenoh": "full system, Zenoh processes",
}
REPLAY_CHUNK: Final = 4096


@dataclass(frozen=True, slots=True)
class Operation:
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
    operations: list[Operation] = field(default_factory=list)
    chunks: list[tuple[int, dict[str, list[float]]]] = field(default_factory=list)
    steps: int = 0

    def insert(
        self, unit_id: str, pieces: Sequence[str], direction: Direction, offset_m: float, length_m: float
    ) -> None:
        """Pass on and remember."""
        edges = tuple(edge_id(piece, direction) for piece in pieces)
        self.operations.append(Operation(self.steps, "insert", unit_id, edges, offset_m, length_m))
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
        self.operations.append(Operation(self.steps, "reroute", unit_id, edges))
        self.inner.reroute(unit_id, pieces, direction)

    def reverse(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Pass on and remember."""
        edges = tuple(edge_id(piece, direction) for piece in pieces)
        back = edge_id(pieces[0], direction.opposite)
        self.operations.append(Operation(self.steps, "reroute", unit_id, (back, *edges)))
        self.inner.reverse(unit_id, pieces, direction)

    def remove(self, unit_id: str) -> None:
        """Pass on and remember."""
        self.operations.append(Operation(self.steps, "remove", unit_id))
        self.inner.remove(unit_id)

    def collisions(self) -> tuple[str, ...]:
        """Pass on."""
        return self.inner.collisions()

    def close(self) -> None:
        """Pass on."""
        self.inner.close()

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
    operations = [Operation(*values) for values in header["operations"]]
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


def record(scenario: str, folder: Path) -> tuple[Path, Path]:
    """Run a scenario once; returns the recording and the net that it ran on."""
    from study.run.run import Link, execute
    from study.scenario.scenario import load_scenario
    from sumo_cfg.build import net_for

    recorders: list[Recorder] = []

    def wrap(carrier: Carrier) -> Carrier:
        recorders.append(Recorder(carrier))
        return recorders[-1]

    loaded = load_scenario(scenario)
    run = execute(loaded, Link.SIMULATED, wrap=wrap)
    recording = folder / "recording.npz"
    recorders[0].save(recording, run.result.begin_step / 10)
    return recording, net_for(loaded.setup.line, folder)


class Memory:
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
        """As a progress callback: every 2000th call, so that it costs nothing that counts."""
        self._calls += 1
        if self._calls % 2000 == 0:
            self.look()


def run_child(way: str, scenario: str, recording: Path, net: Path) -> dict[str, float]:
    """One timed run in this process; peak memory is this process and its children together."""
    memory = Memory()
    if way == "sumo":
        figures = replay(recording, net)
    else:
        from study.run.run import Link, execute
        from study.scenario.scenario import load_scenario

        run = execute(load_scenario(scenario), Link(way), progress=memory.now_and_then)
        figures = {"wall_s": float(run.summary["wall_s"]), "digest": run.summary["digest"]}
    memory.look()
    return figures | {"peak_mb": memory.peak_mb}


def bench(scenario: str, rounds: int, tell: Callable[[str], None]) -> dict[str, Any]:
    """The three-way table: medians of wall time, ratios and peak memory. `tell` is told what goes on."""
    with tempfile.TemporaryDirectory(prefix="branchline-bench-") as name:
        folder = Path(name)
        tell(f"recording {scenario}")
        recording, net = record(scenario, folder)
        figures: dict[str, list[dict[str, Any]]] = {way: [] for way in WAYS}
        for number in range(rounds):
            for way in WAYS:
                tell(f"round {number + 1} of {rounds}: {NAMES[way]}")
                command = [
                    sys.executable,
                    "-m",
                    "study.evaluate.bench",
                    way,
                    scenario,
                    str(recording),
                    str(net),
                ]
                done = subprocess.run(command, capture_output=True, text=True, check=False)
                if done.returncode != 0:
                    raise RuntimeError(f"{NAMES[way]} failed: {done.stderr.strip()[-500:]}")
                figures[way].append(json.loads(done.stdout))
    median = {way: statistics.median(f["wall_s"] for f in figures[way]) for way in WAYS}
    digests = {f["digest"] for way in WAYS[1:] for f in figures[way]}
    return {
        "scenario": scenario,
        "rounds": rounds,
        "rows": [
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
        ],
        "same_digest": len(digests) == 1,
        "budgets": {"full system of SUMO alone": 2.0, "Zenoh of simulated links": 1.5, "peak_mb": 1000},
    }


if __name__ == "__main__":
    way, scenario, recording, net = sys.argv[1:5]
    sys.stdout.write(json.dumps(run_child(way, scenario, Path(recording), Path(net))) + "\n")
