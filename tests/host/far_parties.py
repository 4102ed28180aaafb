"""Parties as processes on other machines, which here are this one: over TLS on its loopback address."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Final

from cryptography.x509.oid import ExtendedKeyUsageOID

from host.certificates import PARTIES_FOLDER, CertificateIssuer
from host.devices import device_specs
from host.elsewhere import Elsewhere
from host.over_zenoh import ZenohParties
from host.process import environment
from tests.host.one_unit import MANAGER, MASTER, TERMINAL

ADDRESS: Final = "127.0.0.1"
EXPIRED: Final = "expired"
SIMULATORS: Final = "as the simulator"
NAMES: Final = (MANAGER.device_id, "t", "u1")


def certificates_in(folder: Path, names: Sequence[str] = NAMES) -> Path:
    """As `make_certificates`, with two more: one that has run out, and one for a simulator."""
    now = datetime.now(UTC)
    issuer = CertificateIssuer(now - timedelta(days=2), now + timedelta(hours=1))
    issuer.issue(folder, "simulator", ExtendedKeyUsageOID.SERVER_AUTH, ADDRESS)
    for name in names:
        issuer.issue(folder / PARTIES_FOLDER / name, name, ExtendedKeyUsageOID.CLIENT_AUTH)
    issuer.issue(folder / SIMULATORS, "t", ExtendedKeyUsageOID.SERVER_AUTH, ADDRESS)
    issuer.end = now - timedelta(days=1)
    issuer.issue(folder / EXPIRED, "t", ExtendedKeyUsageOID.CLIENT_AUTH)
    return folder


def free_endpoint() -> str:
    """Where nobody listens."""
    with socket.socket() as found:
        found.bind((ADDRESS, 0))
        return f"tls/{ADDRESS}:{found.getsockname()[1]}"


class Machines:
    """Those on which people start parties as soon as the simulator waits; gone with the context."""

    def __init__(self, certificates: Path, party_ids: Sequence[str], endpoint: str = "") -> None:
        self.started: dict[str, subprocess.Popen[str]] = {}
        self.said: list[str] = []
        self.elsewhere = Elsewhere(endpoint or free_endpoint(), certificates, tuple(party_ids), self._waited)

    def __enter__(self) -> Machines:
        return self

    def __exit__(self, *_: object) -> None:
        for process in self.started.values():
            process.kill()
            process.communicate()

    def ended(self, party_id: str) -> tuple[int, str]:
        """How a party's process has ended, and what it wrote on stderr."""
        _, err = self.started[party_id].communicate(timeout=60.0)
        return self.started[party_id].returncode, err

    @contextmanager
    def _waited(self, what: str) -> Generator[None]:
        self.said.append(what)
        for party_id in self.elsewhere.party_ids:
            self.started[party_id] = serve_party(self.elsewhere.folder_of(party_id), self.elsewhere.endpoint)
        yield


def serve_party(folder: Path, endpoint: str) -> subprocess.Popen[str]:
    """The command, as people give it."""
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "branchline", "serve-party", str(folder), "--connect", endpoint],
        stderr=subprocess.PIPE,
        text=True,
        env=environment(os.environ, Path.cwd()),
    )


def with_far(machines: Machines, directory: Path) -> ZenohParties:
    """The devices of a small line, some of them on those machines."""
    specs = device_specs(MANAGER, [TERMINAL], MASTER)
    return ZenohParties("line", specs, directory, machines.elsewhere)
