"""The process of one party: what it refuses, and that it starts light."""

import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

from host.devices import device_specs
from host.planes import new_secrets
from wayside.config import MANAGER_ID, ManagerConfig, PointsEntry, SectionEntry, TerminalConfig

MANAGER = ManagerConfig("line", MANAGER_ID, ("u1",), (SectionEntry("P", portal=True),), ())
TERMINAL = TerminalConfig("line", "t", (PointsEntry("p", "S", 8.0),))


@pytest.mark.parametrize(
    ("key", "value"),
    [("--party", "other"), ("--line", "other"), ("stdin", "{}\n"), ("stdin", ""), ("role", "block-manager")],
)
def test_the_process_refuses_what_does_not_fit(tmp_path: Path, key: str, value: str) -> None:
    spec = device_specs(MANAGER, [TERMINAL], b"m" * 32)[1]
    (tmp_path / "config.json").write_bytes(spec.config)
    secrets = msgspec.json.encode(new_secrets(spec.keys)) + b"\n" if key != "stdin" else value.encode()
    options = {
        "--line": "line",
        "--party": "t",
        "--state": str(tmp_path),
    }
    role = "point-terminal" if key != "role" else value
    options |= {"--connect": f"unixsock-stream/{tmp_path}/z"} | (
        {} if key in {"role", "stdin"} else {key: value}
    )
    command = [sys.executable, "-P", "-m", "host.serve", role]
    words = [word for pair in options.items() for word in pair]
    done = subprocess.run([*command, *words], input=secrets, stderr=subprocess.PIPE, check=False, timeout=60)
    assert done.returncode == 2
    assert len(done.stderr.decode().strip().splitlines()) == 1


def test_the_process_of_a_device_starts_light() -> None:
    code = "import sys, host.serve, host.device; print(*sorted(sys.modules))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, check=True, text=True, timeout=60
    )
    heavy = {"numpy", "numba", "libsumo", "matplotlib", "scipy", "pydantic", "polars", "onboard", "ortools"}
    assert heavy.isdisjoint(done.stdout.split())
