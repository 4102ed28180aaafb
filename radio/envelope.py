"""The envelope of a telegram, and what a receiver does about each threat (after EN 50159:2010).

| threat        | defence                                                       | dropped as               |
|---------------|---------------------------------------------------------------|--------------------------|
| repetition    | sequence number, window of the last 64                        | REPEATED                 |
| deletion      | request repeated with its correlation; receivers idempotent   | none; gaps are counted   |
| insertion     | destination, known source, key per pair                       | WRONG_DESTINATION,       |
|               |                                                               | UNKNOWN_SOURCE           |
|               | boot of the destination                                       | EARLIER_BOOT             |
| re-sequencing | sequence number, boot epoch of the source                     | OUT_OF_ORDER, OLD_EPOCH  |
| corruption    | HMAC-SHA256, 128 bits                                         | CORRUPTED                |
| delay         | time sent, age limit by the receiver's own clock              | STALE, IMPLAUSIBLE_TIME  |
| masquerade    | HMAC with a key that only the two parties have                | CORRUPTED                |

A party that restarts has forgotten the sequence numbers. So every telegram names the boot of the
*destination* as last heard (0: never), and one meant for an earlier boot is dropped: nothing sent to a
predecessor takes effect.

Every party has a clock of its own. A telegram older than `AGE_MAX_S` by its receiver's clock is STALE, one that comes
from more than `CLOCK_SKEW_MAX_S` ahead of it has an IMPLAUSIBLE_TIME: so two parties whose clocks differ by more than
that hear each other no longer, and silence frees and proves nothing. Clocks that differ by less move the age limit
by no more than they differ. The echo of the receiver's own last time is no ground to drop (its clock may have been
set back since, and two parties that both were ahead would never hear each other again); it gives the round trip, by
one clock alone, where there is one. What this cannot see: a link that delays by as much as its receiver is slow.

Wire format: MessagePack array (`Envelope`) followed by 16 bytes of code.
"""

from __future__ import annotations

from collections import Counter
from enum import Enum
from typing import Final, TypedDict

import msgspec
from msgspec.structs import replace

from radio.keys import MAC_BYTES, KeyRing, mac, mac_equal
from radio.messages import AnyMessage
from radio.noted import TelegramDropped, TookEffect

AGE_MAX_S: Final = 5.0
TELEGRAM_BYTES_MAX: Final = 4096
SEQUENCE_WINDOW: Final = 64
CLOCK_SKEW_MAX_S: Final = 1.0  # two clocks in order differ by no more
ON_THE_AIR_S: Final = AGE_MAX_S + CLOCK_SKEW_MAX_S  # after which what was sent takes no effect any more
_ROUNDING_S: Final = 1e-6


class DropReason(Enum):
    """Why a telegram took no effect."""

    CORRUPTED = "corrupted"
    WRONG_DESTINATION = "wrong destination"
    UNKNOWN_SOURCE = "unknown source"
    EARLIER_BOOT = "meant for an earlier boot"
    OLD_EPOCH = "old epoch"
    IMPLAUSIBLE_TIME = "implausible time"
    STALE = "stale"
    REPEATED = "repeated"
    OUT_OF_ORDER = "out of order"


class Envelope(msgspec.Struct, frozen=True, array_like=True):
    """Header and payload of a telegram. `sent_s` is by the sender's clock, `echo_s` the peer's last `sent_s`;
    `peer_epoch` 0 and `echo_s` None: never heard.
    """

    source: str
    destination: str
    epoch: int
    peer_epoch: int
    sequence: int
    sent_s: float
    echo_s: float | None
    correlation: int
    payload: msgspec.Raw


class Peer(msgspec.Struct, frozen=True):
    """What one party remembers of another. `window` has bit i set if sequence number `heard_sequence - i`
    came.
    """

    sent_sequence: int = 0
    heard_epoch: int = 0
    heard_sequence: int = -1
    window: int = 0
    heard_sent_s: float | None = None


class Received(msgspec.Struct, frozen=True):
    """A telegram that passed. `fresh`: its sender has heard this boot; `missing`: numbers skipped before
    it.
    """

    source: str
    epoch: int
    sequence: int
    fresh: bool
    correlation: int
    sent_s: float
    round_trip_s: float | None
    missing: int
    message: AnyMessage

    def noted(self, receiver: str) -> TookEffect:
        """What its receiver writes in the journal."""
        return TookEffect(
            source=self.source,
            receiver=receiver,
            epoch=self.epoch,
            sequence=self.sequence,
            kind=type(self.message).__name__,
            correlation=self.correlation,
        )


class Dropped(msgspec.Struct, frozen=True):
    """A telegram that did not. `envelope` is set once the code has proven it."""

    reason: DropReason
    envelope: Envelope | None = None

    def noted(self, receiver: str) -> TelegramDropped:
        """What its receiver writes in the journal."""
        return TelegramDropped(
            source=None if self.envelope is None else self.envelope.source,
            receiver=receiver,
            why=self.reason.value,
            **noted_terms(self.envelope),
        )


class NotedTerms(TypedDict):
    """What a note of a telegram takes from its header."""

    epoch: int | None
    sequence: int | None
    kind: str | None
    correlation: int | None


_HEADER: Final = msgspec.msgpack.Decoder(Envelope)
_PAYLOAD: Final = msgspec.msgpack.Decoder(AnyMessage)
_ENCODER: Final = msgspec.msgpack.Encoder()
_UNREADABLE: Final = (msgspec.MsgspecError, UnicodeDecodeError, RecursionError)


def kind_of(envelope: Envelope) -> str | None:
    """Kind of the message inside, for the journal; None if it is unreadable. Nobody acts on this."""
    try:
        return type(_PAYLOAD.decode(envelope.payload)).__name__
    except _UNREADABLE:
        return None


def noted_terms(header: Envelope | None) -> NotedTerms:
    """For the journal: those of a header, all None where there is none to read."""
    if header is None:
        return NotedTerms(epoch=None, sequence=None, kind=None, correlation=None)
    return NotedTerms(
        epoch=header.epoch,
        sequence=header.sequence,
        kind=kind_of(header),
        correlation=header.correlation,
    )


def header_of(data: bytes) -> Envelope | None:
    """Header of a telegram, for the journal; None if it is unreadable. Nobody acts on this."""
    try:
        return _HEADER.decode(data[:-MAC_BYTES])
    except _UNREADABLE:
        return None


def encode(key: bytes, envelope: Envelope) -> bytes:
    """The telegram's bytes, code included."""
    data = _ENCODER.encode(envelope)
    return data + mac(key, data)


def decode(owner: str, keys: KeyRing, data: bytes) -> Envelope | DropReason:
    """Header of a telegram for `owner` whose code is right; the payload is not looked at before that."""
    if not MAC_BYTES < len(data) <= TELEGRAM_BYTES_MAX:
        return DropReason.CORRUPTED
    body, code = data[:-MAC_BYTES], data[-MAC_BYTES:]
    try:
        envelope = _HEADER.decode(body)
    except _UNREADABLE:
        return DropReason.CORRUPTED
    if envelope.destination != owner:
        return DropReason.WRONG_DESTINATION
    key = keys.pairs.get(envelope.source)
    if key is None:
        return DropReason.UNKNOWN_SOURCE
    return envelope if mac_equal(mac(key, body), code) else DropReason.CORRUPTED


def check(
    peer: Peer, envelope: Envelope, own_epoch: int, now_s: float, age_max_s: float
) -> tuple[Peer, DropReason | None]:
    """Time, boot and sequence of an authentic telegram; a peer changes only when the telegram passes."""
    if envelope.peer_epoch not in (0, own_epoch):
        return peer, DropReason.EARLIER_BOOT
    if envelope.epoch < peer.heard_epoch:
        return peer, DropReason.OLD_EPOCH
    if not envelope.sent_s <= now_s + CLOCK_SKEW_MAX_S + _ROUNDING_S:  # written so that a NaN fails too
        return peer, DropReason.IMPLAUSIBLE_TIME
    if now_s - envelope.sent_s > age_max_s + _ROUNDING_S:
        return peer, DropReason.STALE
    known = peer.heard_epoch == envelope.epoch
    last, window = (peer.heard_sequence, peer.window) if known else (-1, 0)
    ahead = envelope.sequence - last
    if ahead <= 0:
        came_before = -ahead < SEQUENCE_WINDOW and bool(window >> -ahead & 1)
        return peer, DropReason.REPEATED if came_before else DropReason.OUT_OF_ORDER
    mask = (1 << SEQUENCE_WINDOW) - 1
    shifted = (window << ahead) & mask if ahead < SEQUENCE_WINDOW else 0
    heard = replace(
        peer,
        heard_epoch=envelope.epoch,
        heard_sequence=envelope.sequence,
        window=shifted | 1,
        heard_sent_s=envelope.sent_s,
    )
    return heard, None


def _round_trip_s(envelope: Envelope, now_s: float) -> float | None:
    """Since the peer's last telegram that its sender has heard; None where the own clock was set back since."""
    echo_s = envelope.echo_s
    return now_s - echo_s if echo_s is not None and echo_s <= now_s + _ROUNDING_S else None


class Endpoint:
    """One party's end of all its channels: seals what it sends, opens what it receives, counts what it
    drops.
    """

    def __init__(self, keys: KeyRing, epoch: int, age_max_s: float = AGE_MAX_S) -> None:
        if epoch < 1:
            raise ValueError(f"epoch is {epoch}; expected 1 or more, because 0 means never heard")
        self.owner = keys.owner
        self.epoch = epoch
        self.age_max_s = age_max_s
        self.dropped: Counter[DropReason] = Counter()
        self.missing = 0
        self.peers: dict[str, Peer] = {}
        self._keys = keys

    def seal(self, destination: str, message: AnyMessage, now_s: float, correlation: int = 0) -> bytes:
        """The telegram to `destination`. Raises KeyError if there is no key for it."""
        peer = self.peers.get(destination, Peer())
        envelope = Envelope(
            self.owner,
            destination,
            self.epoch,
            peer.heard_epoch,
            peer.sent_sequence,
            now_s,
            peer.heard_sent_s,
            correlation,
            msgspec.Raw(_ENCODER.encode(message)),
        )
        data = encode(self._keys.pairs[destination], envelope)
        self.peers[destination] = replace(peer, sent_sequence=peer.sent_sequence + 1)
        return data

    def open(self, data: bytes, now_s: float) -> Received | Dropped:
        """The telegram in `data`, or why it takes no effect. Never raises, whatever the bytes."""
        envelope = decode(self.owner, self._keys, data)
        if isinstance(envelope, DropReason):
            return self._drop(envelope, None)
        peer = self.peers.get(envelope.source, Peer())
        heard, reason = check(peer, envelope, self.epoch, now_s, self.age_max_s)
        if reason is not None:
            return self._drop(reason, envelope)
        try:
            message = _PAYLOAD.decode(envelope.payload)
        except _UNREADABLE:
            return self._drop(DropReason.CORRUPTED, envelope)
        same_boot = peer.heard_epoch == envelope.epoch
        missing = envelope.sequence - (peer.heard_sequence if same_boot else -1) - 1
        # What a peer said before this boot first heard it was not meant to reach us: not a gap.
        missing = missing if peer.heard_epoch else 0
        self.missing += missing
        self.peers[envelope.source] = heard
        return Received(
            envelope.source,
            envelope.epoch,
            envelope.sequence,
            envelope.peer_epoch == self.epoch,
            envelope.correlation,
            envelope.sent_s,
            _round_trip_s(envelope, now_s),
            missing,
            message,
        )

    def _drop(self, reason: DropReason, envelope: Envelope | None) -> Dropped:
        self.dropped[reason] += 1
        return Dropped(reason, envelope)
