"""Parties on other machines: what the simulator tells them beyond what a process on its own machine is told, and the
TLS link between the two.

Both ends show a certificate (`host.certificates`). The simulator takes from a party, known by the name in it, only what
is that party's to say. Who has joined without being asked still ends the run, as on the socket.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from enum import Enum
from itertools import chain
from pathlib import Path
from typing import Any, Final

import msgspec

from host.party import Codec, PartySpec
from host.planes import radio_key, said_key, session_config, time_key
from host.process import Commission
from network.errors import COMMAND_LINE, InputError

AUTHORITY_FILE: Final = "authority.pem"
CERTIFICATE_FILE: Final = "certificate.pem"
KEY_FILE: Final = "key.pem"
LEASE_MS: Final = 60_000  # a machine may vanish without a word; one that sleeps for less is still there
_ENDPOINT: Final = re.compile(r"tls/(\[[0-9a-fA-F:.]+\]|[^\s/:?#\[\]]+):[0-9]{1,5}")
_BOTH_WAYS: Final = ("ingress", "egress")
_OWN: Final = (  # what a party does: on which key, which way past the simulator's end, by which messages of Zenoh
    ("says", said_key, ("ingress",), ("put",)),
    ("hears", radio_key, _BOTH_WAYS, ("put", "declare_subscriber")),
    ("answers", time_key, _BOTH_WAYS, ("query", "reply", "declare_queryable")),
)


class PowerDeed(Enum):
    """What the simulator tells a party's machine to do with the party."""

    ADVANCE = "advance"
    KILL = "kill"
    RESTART = "restart"
    LOSE = "lose"
    COMMISSION = "commission"
    LEAVE = "leave"  # the run is over


class ToldFar(msgspec.Struct, frozen=True, array_like=True):
    """`told` is for the party, or the `vital` of its commissioning; `number` is of that."""

    deed: PowerDeed = PowerDeed.ADVANCE
    told: bytes = b""
    number: int = 0


class PartyInvitation(msgspec.Struct, frozen=True):
    """What a party's machine is given in secret for one run, in a file that people carry there."""

    spec: PartySpec
    plane_key: bytes
    session_id: str


FAR: Final = Codec(ToldFar, ToldFar)


def check_endpoint(option: str, endpoint: str) -> None:
    """Raises InputError for what is no address for TLS: nothing else shows who is there."""
    if not _ENDPOINT.fullmatch(endpoint):
        raise InputError(
            COMMAND_LINE, option, endpoint, "tls/ADDRESS:PORT, where both ends show certificates"
        )


def tls_session_json5(
    role: str, endpoint: str, folder: Path, session_id: str, access: dict[str, Any] | None = None
) -> str:
    """Zenoh configuration of the end of the link whose certificate is in a folder; `access`: what it lets through,
    None: all.

    Without low latency, whose links end unnoticed when a certificate runs out; with one priority the order is the same.
    """
    config = session_config(role, endpoint, session_id)
    config["transport"]["unicast"]["lowlatency"] = False
    config["transport"]["link"] = {
        "protocols": ["tls"],
        "tx": {"lease": LEASE_MS, "keep_alive": 4},
        "tls": {
            "root_ca_certificate": str(folder / AUTHORITY_FILE),
            f"{role}_certificate": str(folder / CERTIFICATE_FILE),
            f"{role}_private_key": str(folder / KEY_FILE),
            "enable_mtls": True,
            "verify_name_on_connect": True,
            "close_link_on_expiration": True,
        },
    }
    if access is not None:
        config["access_control"] = access
    return msgspec.json.encode(config).decode()


def access_control(line_id: str, party_ids: Iterable[str]) -> dict[str, Any]:
    """Zenoh's rules for the simulator's end: nothing passes but what a party of this name may say and is told."""
    ids = sorted(party_ids)

    def rule(name: str, key: str, flows: Iterable[str], messages: Iterable[str]) -> dict[str, Any]:
        return {"id": name, "permission": "allow", "flows": flows, "messages": messages, "key_exprs": [key]}

    asks = rule("asks", said_key(line_id), ("egress",), ("declare_subscriber",))
    own = {
        party_id: [
            rule(f"{party_id} {does}", key(line_id, party_id), flows, messages)
            for does, key, flows, messages in _OWN
        ]
        for party_id in ids
    }
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": [asks, *chain.from_iterable(own.values())],
        "subjects": [{"id": party_id, "cert_common_names": [party_id]} for party_id in ids],
        "policies": [
            {"subjects": [party_id], "rules": [rule["id"] for rule in (asks, *own[party_id])]}
            for party_id in ids
        ],
    }


class FarProcess:
    """A party on another machine, with what a `PartyProcess` has for `host.over_zenoh`: its power goes by word."""

    at_fault: Final = False
    ending: Final = "has left the run"

    def __init__(self, tell: Callable[[ToldFar], None]) -> None:
        self.tell: Final = tell
        self.lost = False  # its durable state

    def alive(self) -> bool:
        """As far as is known: one that is not gives no answer."""
        return True

    def ended_within(self, _limit_s: float) -> bool:
        """Nobody declares its key any more, or its question would still wait."""
        return True

    def kill(self) -> None:
        """Power cut: its machine forgets all but the durable state."""
        self.tell(ToldFar(PowerDeed.KILL))

    def restart(self, commission: Commission | None) -> None:
        """Power back, after people's commissioning if there was one."""
        if commission is not None:
            self.lost = False
            self.tell(ToldFar(PowerDeed.COMMISSION, commission.vital, commission.number))
        self.tell(ToldFar(PowerDeed.RESTART))

    def lose(self) -> None:
        """Its durable state is gone."""
        self.lost = True
        self.tell(ToldFar(PowerDeed.LOSE))

    def terminate(self) -> None:
        """It ends with its link."""

    end = terminate
