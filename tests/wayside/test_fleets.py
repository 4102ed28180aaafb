"""The two fleets: the same bytes, in this process and over Zenoh; kills, restarts, and nothing left afterwards."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest

from host.devices import Advance, DeviceSpec, Fleet, FleetError, device_specs
from host.local import LocalFleet
from host.over_zenoh import ZenohFleet
from network.model import Position
from radio.envelope import Endpoint, Received
from radio.keys import key_ring
from radio.messages import PointsCommand, RouteGranted, RouteRequest, SignOn
from simulation.world import point_machine
from simulation.world.point_machine import PointMachine
from wayside.config import MANAGER_ID, ManagerConfig, PointsEntry, RouteEntry, SectionEntry, TerminalConfig
from wayside.said import ConfirmOutside, PointsDetected, Started, StartThrow

MASTER = b"m" * 32
MANAGER = ManagerConfig(
    "line",
    MANAGER_ID,
    ("u1",),
    (SectionEntry("P", portal=True), SectionEntry("S", terminal_ids=("t",)), SectionEntry("T")),
    (RouteEntry("R", "P", ("S", "T")),),
)
TERMINAL = TerminalConfig("line", "t", (PointsEntry("p", "S", 8.0),))


def specs() -> tuple[DeviceSpec, ...]:
    return device_specs(MANAGER, [TERMINAL], MASTER)


def local(_directory: Path) -> Fleet:
    return LocalFleet(specs())


def zenoh(directory: Path) -> Fleet:
    return ZenohFleet("line", specs(), directory)


fleets = pytest.mark.parametrize("make", [local, pytest.param(zenoh, marks=pytest.mark.system)])


class Script:
    """One train and one machine against a fleet; `log` has every answer."""

    def __init__(self, fleet: Fleet) -> None:
        self.fleet = fleet
        self.train = Endpoint(key_ring(MASTER, "u1", [MANAGER_ID, "t"]), 1)
        self.machine = PointMachine("p", 0.5, Position.NORMAL)
        self.log: list[tuple[str, Advance]] = []
        self.grant: RouteGranted | None = None

    def ask(
        self, device: str, now_s: float, *telegrams: bytes, inputs: tuple[ConfirmOutside, ...] = ()
    ) -> None:
        given = [point_machine.detection(self.machine)] if device == "t" else list(inputs)
        advance = self.fleet.advance(device, now_s, telegrams, given)
        self.log.append((device, advance))
        for _, data in advance.telegrams:
            opened = self.train.open(data, now_s)
            assert isinstance(opened, Received)
            if isinstance(opened.message, RouteGranted):
                self.grant = opened.message
        for output in advance.outputs:
            self.machine = point_machine.step(self.machine, output, now_s)

    def run(self) -> list[tuple[str, Advance]]:
        train = self.train
        self.ask(MANAGER_ID, 0.0, inputs=(ConfirmOutside("u1", "Sato"),))
        for now_s in (0.1, 0.2):
            self.ask(MANAGER_ID, now_s, train.seal(MANAGER_ID, SignOn("u1", ("P",)), now_s, 1), b"noise")
        for now_s in (0.3, 0.4):
            request = RouteRequest("u1", "R", ("S", "T"))
            self.ask(MANAGER_ID, now_s, train.seal(MANAGER_ID, request, now_s, 2))
        assert self.grant is not None
        (capability,) = self.grant.capabilities
        command = PointsCommand("p", Position.REVERSE, "S", self.grant.token, capability.mac)
        self.ask("t", 0.5, train.seal("t", command, 0.5, 3))
        self.machine = point_machine.advance(self.machine, 1.0)
        self.ask("t", 1.0)
        for device in (MANAGER_ID, "t"):
            self.fleet.kill(device)
            assert not self.fleet.alive(device)
            self.fleet.restart(device)
            assert self.fleet.alive(device)
            self.ask(device, 2.0)
        return self.log


@pytest.mark.system
def test_both_fleets_give_the_same_bytes(tmp_path: Path) -> None:
    with local(tmp_path) as one:
        expected = Script(one).run()
    with zenoh(tmp_path) as other:
        found = Script(other).run()
    assert found == expected
    assert sum(len(advance.telegrams) for _, advance in found) >= 6
    assert any(isinstance(output, StartThrow) for _, advance in found for output in advance.outputs)


@fleets
def test_a_killed_device_is_down_and_comes_back_with_a_new_boot(
    tmp_path: Path, make: Callable[[Path], Fleet]
) -> None:
    with make(tmp_path) as fleet:
        (note, *_) = fleet.advance("t", 0.0, []).notes
        assert note == Started(epoch=1)
        with pytest.raises(FleetError, match="runs already"):
            fleet.restart("t")
        fleet.kill("t")
        fleet.kill("t")
        with pytest.raises(FleetError, match="is down"):
            fleet.advance("t", 0.1, [])
        fleet.restart("t")
        (note, *_) = fleet.advance("t", 0.2, [], [PointsDetected("p", Position.NORMAL, True)]).notes
        assert note == Started(epoch=2)


def processes_of(directory: Path) -> list[int]:
    """Processes that name the directory on their command line."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                line = (entry / "cmdline").read_bytes()
            except OSError:
                continue
            if str(directory).encode() in line and int(entry.name) != os.getpid():
                found.append(int(entry.name))
    return found


@pytest.mark.system
@pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs /proc to see processes")
def test_nothing_is_left_after_an_error(tmp_path: Path) -> None:
    def fail() -> None:
        with zenoh(tmp_path) as fleet:
            fleet.advance("t", 0.0, [])
            assert len(processes_of(tmp_path)) == 2
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert processes_of(tmp_path) == []


PARENT = """
import sys
from pathlib import Path
from tests_fleets import zenoh
with zenoh(Path(sys.argv[1])) as fleet:
    fleet.advance("t", 0.0, [])
    print("up", flush=True)
    sys.stdin.read()
"""


@pytest.mark.system
@pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs /proc to see processes")
def test_devices_end_when_their_parent_is_killed(tmp_path: Path) -> None:
    (tmp_path / "code").mkdir()
    (tmp_path / "code" / "tests_fleets.py").write_text(
        Path(__file__).read_text(encoding="utf-8"), encoding="utf-8"
    )
    script = tmp_path / "code" / "parent.py"
    script.write_text(PARENT, encoding="utf-8")
    state = tmp_path / "state"
    with subprocess.Popen(
        [sys.executable, str(script), str(state)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == b"up\n"
        devices = [pid for pid in processes_of(state) if pid != parent.pid]
        assert len(devices) == 2
        handles = [os.pidfd_open(pid) for pid in devices]
        parent.send_signal(signal.SIGKILL)
    for handle in handles:
        # A pidfd becomes readable when its process ends; no sleep, only a limit.
        assert select.select([handle], [], [], 20.0)[0] == [handle]
        os.close(handle)


@pytest.mark.system
def test_a_device_that_cannot_start_says_why(tmp_path: Path) -> None:
    (tmp_path / "t").mkdir()
    (tmp_path / "t" / "durable").write_bytes(b"damaged")
    with pytest.raises(FleetError, match=r"device t ended while it started; it wrote: .*undamaged"):
        zenoh(tmp_path).__enter__()
    assert processes_of(tmp_path) == []


@pytest.mark.system
@pytest.mark.parametrize(
    ("key", "value"), [("--device", "other"), ("--line", "other"), ("--key-file", "missing")]
)
def test_the_process_refuses_what_does_not_fit(tmp_path: Path, key: str, value: str) -> None:
    spec = specs()[1]
    (tmp_path / "config.json").write_bytes(spec.config_json)
    (tmp_path / "keys.json").write_bytes(msgspec.json.encode(spec.keys))
    options = {
        "--line": "line",
        "--device": "t",
        "--state": str(tmp_path),
        "--key-file": str(tmp_path / "keys.json"),
    }
    options |= {"--connect": "tcp/127.0.0.1:1", key: value}
    command = [sys.executable, "-m", "host.serve", "point-terminal"]
    words = [word for pair in options.items() for word in pair]
    done = subprocess.run(
        [*command, *words], stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False, timeout=60
    )
    assert done.returncode == 2
    assert len(done.stderr.decode().strip().splitlines()) == 1


@pytest.mark.system
def test_a_device_starts_light() -> None:
    code = "import sys, host.serve; print(*sorted(sys.modules))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, check=True, text=True, timeout=60
    )
    heavy = {"numpy", "numba", "libsumo", "matplotlib", "scipy", "pydantic"}
    assert heavy.isdisjoint(done.stdout.split())
