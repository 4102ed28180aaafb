"""Who may connect, and how much may be said: hosts and origins, tokens of seats, sizes and rates. Nothing is done here.

On loopback a seat is anybody's who can open a page of this machine; a page of another origin cannot, and neither can a
name that leads here from elsewhere. Where the desk listens to others each seat has a token.
"""

from __future__ import annotations

import json
import os
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from hmac import compare_digest
from pathlib import Path
from typing import Final

from console.seats import Seat
from network.errors import InputError

LOOPBACK: Final = "127.0.0.1"
HTTP_PORT: Final = 80
LOOPBACK_NAMES: Final = (LOOPBACK, "localhost")
SOCKETS_MAX: Final = 64
MESSAGES_A_S: Final = 20.0
MESSAGES_AT_ONCE: Final = 40.0
REFUSED_MAX: Final = 100  # messages of a connection, before it is closed
TOKEN_BYTES: Final = 24
SEAT_WITHIN_S = 10.0  # who takes none would hold one of the places for ever


class Refusal(Enum):
    """Why a connection or message is refused; counted."""

    HOST = "another host's name"
    ORIGIN = "a page of another origin"
    TOKEN = "a token that is not this seat's"
    SOCKETS = "too many connections"
    SIZE = "a message that is too long"
    FORM = "no message of the protocol"
    RATE = "too many messages"
    SILENCE = "no seat is taken in time"


@dataclass(frozen=True, slots=True)
class AccessRules:
    """`hosts`: as which the desk may be called; None: by any, and then there are `tokens`, by seat."""

    hosts: frozenset[str] | None
    tokens: Mapping[Seat, str] | None = None

    def refused(self, host: str, origin: str | None) -> Refusal | None:
        """Why a request with these headers is refused. A browser says of which origin its page is; others say none."""
        if self.hosts is not None and host not in self.hosts:
            return Refusal.HOST
        # What encrypts for a desk that others reach stands before it, and pages come by that.
        schemes = ("http",) if self.tokens is None else ("http", "https")
        if origin is not None and origin not in (f"{scheme}://{host}" for scheme in schemes):
            return Refusal.ORIGIN
        return None

    def opens(self, seat: Seat, token: str) -> bool:
        """Whether a token opens a seat."""
        return self.tokens is None or compare_digest(self.tokens[seat].encode(), token.encode())


def on_loopback(port: int) -> AccessRules:
    """For this machine alone, without tokens. Browsers leave the port of HTTP out."""
    names = {f"{name}:{port}" for name in LOOPBACK_NAMES}
    return AccessRules(frozenset(names.union(LOOPBACK_NAMES) if port == HTTP_PORT else names))


def with_tokens() -> AccessRules:
    """For other machines too, with new tokens."""
    return AccessRules(None, {seat: secrets.token_urlsafe(TOKEN_BYTES) for seat in Seat})


def write_tokens(rules: AccessRules, file: Path) -> None:
    """Put the tokens where their owner alone can read them. InputError where the file is there or cannot be written."""
    tokens = {seat.value: token for seat, token in (rules.tokens or {}).items()}
    try:
        handle = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except OSError as error:
        raise InputError(
            "command line", "--tokens", str(file), f"a new file in a folder that is there: {error.strerror}"
        ) from error
    with os.fdopen(handle, "w", encoding="utf-8") as stream:
        json.dump(tokens, stream, indent=2)


@dataclass(frozen=True, slots=True)
class Allowance:
    """How many messages a connection may still send, and since when it has had no more than that."""

    left: float = MESSAGES_AT_ONCE
    at_s: float = 0.0

    def after(self, now_s: float) -> tuple[bool, Allowance]:
        """Whether one more may be sent now, and what is left then."""
        left = min(self.left + (now_s - self.at_s) * MESSAGES_A_S, MESSAGES_AT_ONCE)
        return (True, Allowance(left - 1.0, now_s)) if left >= 1.0 else (False, Allowance(left, now_s))
