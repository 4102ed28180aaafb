"""The process of one party, as its parent sees it: started with its secrets, alive or not, ended, and what it
last wrote.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import sysconfig
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Final, NamedTuple

import msgspec

from host.party import PartySpec
from host.planes import Secrets

CONFIG_FILE: Final = "config.json"
DURABLE_FILE: Final = "durable"
LOG_FILE: Final = "stderr.log"
_END_LIMIT_S: Final = 2.0
_LOG_TAIL_BYTES: Final = 2000
WANTING_CODE: Final = 3  # the process ends for want of something: no bug
# Of Python's own settings, those that say where packages are; others could change what a party's program does.
_KEPT: Final = frozenset(
    {"PYTHONHOME", "PYTHONUSERBASE", "PYTHONNOUSERSITE", "PYTHONDONTWRITEBYTECODE", "PYTHONPYCACHEPREFIX"}
)
_ROOT: Final = Path(__file__).resolve().parent.parent


def environment(own: Mapping[str, str], folder: Path, root: Path = _ROOT) -> dict[str, str]:
    """The environment of a party's process, made of the caller's `own`, who works in `folder`.

    No entry of PYTHONPATH is the folder from which the program was called (an empty one is, too): a module there cannot
    stand in for one of ours. A checkout that is not installed (`root`) comes first, so that both ends are one program.
    """
    given = [Path(entry) for entry in own.get("PYTHONPATH", "").split(os.pathsep) if entry]
    path = [entry for entry in given if entry.is_absolute() and entry.resolve() != folder.resolve()]
    installed = {Path(sysconfig.get_path(name)).resolve() for name in ("purelib", "platlib")}
    if root.resolve() not in installed:
        path = [root, *(entry for entry in path if entry.resolve() != root)]
    kept = {name: text for name, text in own.items() if not name.startswith("PYTHON") or name in _KEPT}
    return kept | ({"PYTHONPATH": os.pathsep.join(map(str, path))} if path else {})


class Commission(NamedTuple):
    """What people enter to put a party into service (`host.store.commission`)."""

    number: int
    vital: bytes = b""


class PartyProcess:
    """One running `host.serve`. It ends by itself when its stdin or its parent is gone.

    Its secrets are the first line of its stdin and stand in no file, so that nobody's death leaves them.
    """

    def __init__(
        self,
        spec: PartySpec,
        secrets: Secrets,
        state: Path,
        endpoint: str,
        commission: Commission | None = None,
    ) -> None:
        state = state.resolve()
        state.mkdir(mode=0o700, parents=True, exist_ok=True)
        (state / CONFIG_FILE).write_bytes(spec.config)
        # -P, and a folder of its own: that from which the program was called cannot put a module in the way.
        command = [sys.executable, "-P", "-m", "host.serve", spec.role.value]
        command += ["--line", spec.line_id, "--party", spec.party_id, "--state", str(state)]
        command += ["--connect", endpoint]
        if commission is not None:
            command += ["--commission", str(commission.number), "--vital", commission.vital.hex()]
        with (state / LOG_FILE).open("ab") as log:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=log,
                cwd=state,
                env=environment(os.environ, Path.cwd()),
                start_new_session=True,  # a signal to the simulator's group is the simulator's alone to answer
            )
        with suppress(BrokenPipeError):  # it ended before it read them, which who asks it finds out
            self._tell(msgspec.json.encode(secrets) + b"\n")

    def _tell(self, line: bytes) -> None:
        if self._process.stdin is not None:
            self._process.stdin.write(line)
            self._process.stdin.flush()

    def alive(self) -> bool:
        """Whether it runs."""
        return self._process.poll() is None

    @property
    def ending(self) -> str:
        """How it ended, in words; only of one that has."""
        code = self._process.poll()
        if code is not None and code < 0:
            return f"was killed by {signal.Signals(-code).name}"
        return f"ended with code {code}"

    @property
    def at_fault(self) -> bool:
        """Whether its own program ended it, and no signal and no want of the machine."""
        code = self._process.poll()
        return code is not None and code > 0 and code != WANTING_CODE

    def ended_within(self, limit_s: float) -> bool:
        """Whether it ends within this time."""
        try:
            self._process.wait(limit_s)
        except subprocess.TimeoutExpired:
            return False
        return True

    def terminate(self) -> None:
        """Ask it to end; `end` waits for it."""
        self._process.terminate()

    def kill(self) -> None:
        """SIGKILL, and no trace of it left."""
        self._process.kill()
        self.end()

    def end(self) -> None:
        """Close its stdin, which ends it, and wait; SIGKILL if that does not help."""
        if self._process.stdin is not None:
            with suppress(BrokenPipeError):  # what was not read
                self._process.stdin.close()
        if not self.ended_within(_END_LIMIT_S):
            self._process.kill()
            self._process.wait()


def last_words(state: Path) -> str:
    """What the process of this state last wrote; empty if nothing."""
    log = state / LOG_FILE
    return log.read_bytes()[-_LOG_TAIL_BYTES:].decode(errors="replace").strip() if log.exists() else ""


def write_private(path: Path, data: bytes) -> None:
    """A file that nobody else can read at any moment, even if one of that name was there before."""
    path.unlink(missing_ok=True)
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(handle, "wb") as file:
        file.write(data)
