"""Keys of the line: one per pair of parties, one per manager and terminal, all from one master key.

HKDF after RFC 5869 with SHA-256. A device receives the `KeyRing` of its own pairs only, so a stolen terminal
cannot speak for a train. Message authentication codes are HMAC-SHA256 cut to 128 bits (RFC 2104, section 5).
"""

from __future__ import annotations

import hashlib
import hmac
from collections.abc import Iterable
from functools import lru_cache
from typing import Final

import msgspec

MAC_BYTES: Final = 16
KEY_BYTES: Final = 32


def hkdf(master: bytes, info: bytes, length: int = KEY_BYTES, salt: bytes = b"") -> bytes:
    """Derive `length` bytes from `master` for the purpose `info`. RFC 5869, sections 2.2 and 2.3."""
    if not 0 < length <= 255 * 32:
        raise ValueError(f"length is {length}; expected 1 to 8160 bytes")
    pseudorandom = hmac.digest(salt or bytes(32), master, hashlib.sha256)
    block, output = b"", b""
    for counter in range(1, -(-length // 32) + 1):
        block = hmac.digest(pseudorandom, block + info + bytes([counter]), hashlib.sha256)
        output += block
    return output[:length]


def mac(key: bytes, data: bytes) -> bytes:
    """HMAC-SHA256 of `data`, its first 16 bytes."""
    begun = _keyed(key).copy()
    begun.update(data)
    return begun.digest()[:MAC_BYTES]


@lru_cache(maxsize=4096)
def _keyed(key: bytes) -> hmac.HMAC:
    """What is the same for all that goes under one key: half of the time that a telegram's code takes."""
    return hmac.new(key, digestmod=hashlib.sha256)


def mac_equal(left: bytes, right: bytes) -> bool:
    """Whether two codes are equal, in a time that does not tell where they differ."""
    return hmac.compare_digest(left, right)


def pair_key(master: bytes, one: str, other: str) -> bytes:
    """The key that two parties share; the order of the two does not matter."""
    return hkdf(master, msgspec.msgpack.encode(("pair", *sorted((one, other)))))


def capability_key(master: bytes, terminal_id: str) -> bytes:
    """The key that the block manager and one terminal share, and nobody else knows."""
    return hkdf(master, msgspec.msgpack.encode(("capability", terminal_id)))


def capability_mac(key: bytes, terminal_id: str, section_id: str, unit_id: str, token: int) -> bytes:
    """What proves to the terminal that the manager granted `section_id` to `unit_id` under `token`."""
    return mac(key, msgspec.msgpack.encode(("grant", terminal_id, section_id, unit_id, token)))


class KeyRing(msgspec.Struct, frozen=True):
    """The keys one party holds: `pairs` by peer, `capabilities` by terminal (manager: all; terminal: its
    own).
    """

    owner: str
    pairs: dict[str, bytes]
    capabilities: dict[str, bytes]


def key_ring(master: bytes, owner: str, peers: Iterable[str], terminal_ids: Iterable[str] = ()) -> KeyRing:
    """The keys of `owner`. Only the block manager and terminals have `terminal_ids`."""
    return KeyRing(
        owner,
        {peer: pair_key(master, owner, peer) for peer in sorted(peers)},
        {terminal: capability_key(master, terminal) for terminal in sorted(terminal_ids)},
    )
