"""Telegrams on the air between two parties, as far as their order, boots and correlations go.

The envelope drops what is repeated or overtaken (`radio.envelope.check`: only greater sequence numbers pass), so a
copy has no effect, and whatever a telegram overtakes counts as lost. Each direction between two parties is therefore a
queue that may lose its head: the same effects in the same order as a multiset with copies and in any order. What is
older than the age limit is lost too. `tests/verify/test_on_air.py` compares both, with the real check.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

import msgspec

from radio.envelope import AGE_MAX_S, DropReason, Envelope, Peer, Received, check
from radio.messages import AnyMessage
from wayside.actions import Action, Send

_NOTHING: Final = msgspec.Raw(b"")


class InAir(NamedTuple):
    """A telegram under way: boot of its sender, the receiver's boot as its sender last heard it (0: never)."""

    epoch: int
    peer_epoch: int
    correlation: int
    message: AnyMessage


def sealed(
    units: Sequence[str], epoch: int, heard: Sequence[int], actions: Iterable[Action]
) -> tuple[tuple[int, InAir], ...]:
    """What a party on the wayside sends by these actions, and to which unit; `heard`: the boot of each unit."""
    return tuple(
        (unit, InAir(epoch, heard[unit], action.correlation, action.message))
        for action in actions
        if isinstance(action, Send)
        for unit in (units.index(action.destination),)
    )


def opened(source: str, telegram: InAir, own_epoch: int, heard_epoch: int) -> Received | DropReason:
    """What its receiver makes of it: by the envelope's own check, in time and order."""
    envelope = Envelope(
        source, "", telegram.epoch, telegram.peer_epoch, 0, 0.0, None, telegram.correlation, _NOTHING
    )
    _, reason = check(Peer(heard_epoch=heard_epoch), envelope, own_epoch, 0.0, AGE_MAX_S)
    if reason is not None:
        return reason
    fresh = telegram.peer_epoch == own_epoch
    return Received(source, telegram.epoch, 0, fresh, telegram.correlation, 0.0, None, 0, telegram.message)
