"""What the desk costs: updates a second and bytes to each browser, and the server's share of a core, at ten times real
time when most trains are on the line, with a browser that takes nothing and one that closes. Then the day runs to its
end and has the digest that it has without a desk.

Wall time and the share of a core are of this machine; browsers are clients in a process of their own.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any, Final

import psutil

from console.aside import served
from console.protocol import SetPace
from network.errors import InputError
from scenario.scenario import Scenario, load_scenario
from study.evaluate.afresh import budget_of
from study.runner.run import simulation_of

FACTOR: Final = 10.0
MEASURED_S: Final = 10.0
UPDATES_A_S_MIN: Final = 10.0
OF_A_CORE_MAX: Final = 0.30
KB_A_S_MAX: Final = 200.0
# Each reads for some seconds and says how much came; the last but one reads nothing, the last has closed at once.
CLIENT: Final = """
import json, sys, time
from threading import Thread
from websockets.sync.client import connect
url, seconds = sys.argv[1], float(sys.argv[2])
found = []
def hello(desk, seat): desk.send(json.dumps({"say": "hello", "seat": seat, "version": int(sys.argv[3])}))
def read(seat):
    with connect(url, compression=None, max_size=None) as desk:
        hello(desk, seat); desk.recv(); desk.recv()
        count = size = 0; end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            try: text = desk.recv(timeout=left)
            except TimeoutError: break
            count += 1; size += len(text)
        found.append((seat, count / seconds, size / seconds / 1000))
slow = connect(url, compression=None, max_queue=1); hello(slow, "instructor")
closed = connect(url); hello(closed, "dispatcher"); closed.close()
readers = [Thread(target=read, args=(seat,)) for seat in ("instructor", "dispatcher", "staff", "guest")]
for one in readers: one.start()
for one in readers: one.join()
print(json.dumps(sorted(found)))
"""


def bench(scenario: str, rounds: int, tell: Callable[[str], None]) -> dict[str, Any]:
    """Medians over rounds of some seconds, and whether the day has its digest. `tell` is told what goes on."""
    from console.protocol import VERSION

    loaded = load_scenario(scenario)
    busy_s, trains = busiest_s(loaded)
    tell(f"{scenario}: {trains} trains under way at {int(busy_s // 3600)}:{int(busy_s // 60) % 60:02}")
    with served(loaded) as desk:
        live, thread = desk.live, desk.thread
        desk.run_to(busy_s)
        desk.ask(SetPace(factor=FACTOR))
        seen: list[tuple[float, float, list[tuple[str, float, float]]]] = []
        for _ in range(rounds):
            began_s, server_s, desk_s = time.monotonic(), _cpu_s(thread.native_id), _cpu_s(live.thread_id)
            done = subprocess.run(
                [sys.executable, "-c", CLIENT, desk.socket, str(MEASURED_S), str(VERSION)],
                capture_output=True,
                check=True,
            )
            wall_s = time.monotonic() - began_s
            seen.append(
                (
                    (_cpu_s(thread.native_id) - server_s) / wall_s,
                    (_cpu_s(live.thread_id) - desk_s) / wall_s,
                    json.loads(done.stdout),
                )
            )
        desk.run_to(200_000.0)
        digest = live.moment.known.digest
    with simulation_of(loaded.setup) as simulation:
        same = simulation.run().digest == digest
    return _figures(scenario, rounds, trains, seen, same_digest=same)


def _figures(
    scenario: str,
    rounds: int,
    trains: int,
    seen: list[tuple[float, float, list[tuple[str, float, float]]]],
    *,
    same_digest: bool,
) -> dict[str, Any]:
    seats = [seat for seat, _, _ in seen[0][2]]
    rows = [
        {
            "browser": seat,
            "updates_a_s": round(statistics.median(clients[k][1] for _, _, clients in seen), 2),
            "kB_a_s": round(statistics.median(clients[k][2] for _, _, clients in seen), 1),
        }
        for k, seat in enumerate(seats)
    ]
    of_core = round(statistics.median(server for server, _, _ in seen), 3)
    least = min(float(str(row["updates_a_s"])) for row in rows)
    most = max(float(str(row["kB_a_s"])) for row in rows)
    budgets = [
        budget_of(f"server, share of a core ({trains} trains)", OF_A_CORE_MAX, of_core),
        budget_of("kB a second to a browser", KB_A_S_MAX, most),
        budget_of("seconds between updates", round(1.0 / UPDATES_A_S_MIN, 3), _apart_s(least)),
    ]
    return {
        "scenario": scenario,
        "rounds": rounds,
        "rows": rows,
        "budgets": budgets,
        "desk_of_a_core": round(statistics.median(desk for _, desk, _ in seen), 3),
        "trains": trains,
        "same_digest": same_digest,
    }


def _apart_s(updates_a_s: float) -> float | None:
    """How long lies between two updates, s; None where none came."""
    return round(1.0 / updates_a_s, 3) if updates_a_s else None


def busiest_s(scenario: Scenario) -> tuple[float, int]:
    """When most trains are planned to be under way, s, and how many. InputError for a day without any."""
    spans = [(t.calls[0].first_s, t.calls[-1].first_s) for t in scenario.setup.timetable.trains.values()]
    if not spans:
        raise InputError("command line", "SCENARIO", scenario.id, "a day with trains")
    return max(((begin, sum(a <= begin < b for a, b in spans)) for begin, _ in spans), key=lambda one: one[1])


def _cpu_s(thread_id: int | None) -> float:
    return sum(t.user_time + t.system_time for t in psutil.Process().threads() if t.id == thread_id)
