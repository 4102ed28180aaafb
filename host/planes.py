"""The two planes of a fleet of processes over Zenoh: key expressions, the questions of time, session
configuration.

Radio plane: `branchline/<line>/radio/<destination>`, telegrams as they are; an attachment names the round.
Time plane: a query to `branchline/<line>/time/<device>`: "it is now_s, you have been sent n telegrams in
this round" answered "done, I sent m, wake me at t". Rounds grow, so what a stalled process says late is
recognised and left out. Round 0 asks only whether the device is there; it also sends one empty telegram,
which proves the radio plane.
"""

from __future__ import annotations

import re
from typing import Final

import msgspec

from network.errors import InputError
from wayside.said import Input, Note, Output

READY_ROUND: Final = 0
ANSWER_LIMIT_S: Final = 10.0
_NAME: Final = re.compile(r"[^/*?#$\s]+")


class Question(msgspec.Struct, frozen=True, array_like=True):
    """From the simulator: advance to `now_s`; `telegrams` of this round are on the radio plane."""

    round: int
    now_s: float
    telegrams: int
    inputs: tuple[Input, ...] = ()


class Answer(msgspec.Struct, frozen=True, array_like=True):
    """From the device: done; `sent` telegrams of this round are on the radio plane."""

    round: int
    sent: int
    wake_at_s: float | None = None
    outputs: tuple[Output, ...] = ()
    notes: tuple[Note, ...] = ()


def radio_key(line_id: str, destination: str) -> str:
    """Key expression of the telegrams to `destination`; "*" for all."""
    return f"branchline/{_name(line_id)}/radio/{destination if destination == '*' else _name(destination)}"


def time_key(line_id: str, device_id: str) -> str:
    """Key expression of the questions to a device."""
    return f"branchline/{_name(line_id)}/time/{_name(device_id)}"


def round_tag(number: int) -> bytes:
    """The attachment that names a round."""
    return number.to_bytes(8, "big")


def session_json5(role: str, endpoint: str) -> str:
    """Zenoh configuration of a peer that only listens on or only connects to `endpoint`.

    `role` is "listen" or "connect". No scouting, no gossip: a run hears nobody but its own devices.
    """
    other = {"listen": "connect", "connect": "listen"}[role]
    config = {
        "mode": "peer",
        role: {"endpoints": [endpoint], "timeout_ms": 5000, "exit_on_failure": True},
        other: {"endpoints": []},
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "adminspace": {"enabled": False},
        "transport": {"shared_memory": {"enabled": False}, "link": {"rx": {"max_message_size": 1 << 20}}},
    }
    return msgspec.json.encode(config).decode()


def _name(text: str) -> str:
    if not _NAME.fullmatch(text):
        raise InputError("fleet", "id", text, "an id without /, *, ?, #, $ and blanks")
    return text
