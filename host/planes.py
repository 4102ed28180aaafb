"""The two planes of a run of processes over Zenoh: key expressions, session configuration, what a process is
given in secret.

Radio plane: `branchline/<line>/radio/<party>` to a party and `branchline/<line>/said/<party>/<destination>` from it,
telegrams as they are, each with the tag of its round as attachment. Time plane: a query to
`branchline/<line>/time/<party>`: "it is now_s, you have been sent n telegrams in this round" answered "done, I sent m,
wake me at t" (`host.lockstep`). Everything runs over one Unix socket in a directory that only its owner can enter: no
port is open, but for parties on other machines (`host.over_tls`).
"""

from __future__ import annotations

import re
import secrets
import tempfile
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import msgspec

from host.parties import PartyError
from host.scratch import scratch
from network.errors import InputError
from radio.keys import KEY_BYTES, KeyRing

ANSWER_LIMIT_S: Final = 10.0
SOCKET_NAME: Final = "z"
SOCKET_PATH_BYTES_MAX: Final = 107  # sun_path holds 108 with its end (unix(7))
LOCK_SUFFIX: Final = ".lock"  # Zenoh locks the path beside the socket
SHORT_FOLDERS: Final = ("/tmp", "/var/tmp")
LEASE_MS: Final = 14 * 24 * 3600 * 1000
PAYLOAD_BYTES_MAX: Final = 60_000  # a low-latency link breaks at 65,536, headers included
_NAME: Final = re.compile(r"[^/*?#$\s]+")


class Secrets(msgspec.Struct, frozen=True):
    """What one boot of a party is given in its private file; all of it is drawn anew for every boot."""

    keys: KeyRing
    plane_key: bytes
    session_id: str


def new_secrets(keys: KeyRing) -> Secrets:
    """Secrets of a boot; Zenoh wants a session id without leading zeros."""
    return Secrets(keys, secrets.token_bytes(KEY_BYTES), f"{secrets.randbits(127) | 1 << 127:032x}")


def radio_key(line_id: str, party_id: str) -> str:
    """Key expression of the telegrams to a party."""
    return f"branchline/{_name(line_id)}/radio/{_name(party_id)}"


def said_key(line_id: str, party_id: str = "*", destination: str = "*") -> str:
    """Key expression of the telegrams of a party to `destination`; "*" for all."""
    ends = (end if end == "*" else _name(end) for end in (party_id, destination))
    return "/".join(("branchline", _name(line_id), "said", *ends))


def time_key(line_id: str, party_id: str) -> str:
    """Key expression of the questions to a party."""
    return f"branchline/{_name(line_id)}/time/{_name(party_id)}"


@contextmanager
def private_folder(first: Path | None = None) -> Generator[Path]:
    """A directory for a socket, mode 0700, with a path short enough for one; gone when the context ends.

    It is made in `first` (default: the folder for temporary files), or where that is too deep in `/tmp`.
    Raises PartyError where no path is short enough.
    """
    for base in (str(first or tempfile.gettempdir()), *SHORT_FOLDERS):
        if not Path(base).is_dir():
            continue
        with scratch("bl-", Path(base)) as folder:
            if len(bytes(folder / (SOCKET_NAME + LOCK_SUFFIX))) <= SOCKET_PATH_BYTES_MAX:
                yield folder
                return
    limit = f"{SOCKET_PATH_BYTES_MAX} bytes for a Unix socket"
    raise PartyError(f"no folder for temporary files has a path within {limit}; set TMPDIR to a shorter one")


def endpoint_of(folder: Path) -> str:
    """The endpoint of a run whose private directory this is."""
    return f"unixsock-stream/{folder / SOCKET_NAME}"


def session_json5(role: str, endpoint: str, session_id: str) -> str:
    """`session_config` as text."""
    return msgspec.json.encode(session_config(role, endpoint, session_id)).decode()


def session_config(role: str, endpoint: str, session_id: str) -> dict[str, Any]:
    """Zenoh configuration of a peer that only listens on or only connects to `endpoint`.

    `role` is "listen" or "connect". No scouting, no gossip: a run hears nobody but its own parties. Low latency
    leaves out the queues of priorities, so that what is put before a query or its reply comes before it.
    """
    other = {"listen": "connect", "connect": "listen"}[role]
    return {
        "id": session_id,
        "mode": "peer",
        role: {"endpoints": [endpoint], "timeout_ms": 5000, "exit_on_failure": True},
        other: {"endpoints": []},
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "adminspace": {"enabled": False},
        "transport": {
            "unicast": {"lowlatency": True, "qos": {"enabled": False}, "max_links": 1},
            "shared_memory": {"enabled": False},
            # A Unix socket closes with its process, so a link needs no sign of life; who is stopped gives none.
            "link": {"protocols": ["unixsock-stream"], "tx": {"lease": LEASE_MS, "keep_alive": 2}},
        },
    }


def _name(text: str) -> str:
    if not _NAME.fullmatch(text):
        raise InputError("party", "id", text, "an id without /, *, ?, #, $ and blanks")
    return text
