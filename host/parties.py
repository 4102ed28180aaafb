"""The parties of a run as the simulator sees them: advance one to a time, cut its power, give it back.

Two implementations give the same bytes: `host.local.LocalParties` in this process, and
`host.over_zenoh.ZenohParties` with a process per party over Zenoh. A party is asked only when something is
due: a telegram, something it is told, or the time at which it wished to be asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType
from typing import Protocol, Self

from host.party import Advance


class PartyError(RuntimeError):
    """A party is down, or did not answer: the run cannot go on."""


class PartyBug(PartyError):  # noqa: N818 - names what happened
    """The program of a party failed: no loss from outside, but a fault of ours."""


class ForeignError(PartyError):
    """Somebody who is not of this run spoke on its planes, or joined them: the run does not go on."""


class Parties(Protocol):
    """The parties of one run. Leaving the context ends them all, whatever happened."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None, /
    ) -> None: ...

    def advance(self, party_id: str, now_s: float, telegrams: Sequence[bytes], told: bytes) -> Advance:
        """Let a party act at `now_s`. PartyError if it is down; ask `alive` first."""
        ...

    def alive(self, party_id: str) -> bool:
        """Whether the party runs."""
        ...

    def kill(self, party_id: str) -> None:
        """Power cut: everything but the durable state is gone. Nothing happens if it is down."""
        ...

    def restart(self, party_id: str) -> None:
        """Power back: a new boot epoch. What it must see of the world it has to be told anew.

        Raises NotCommissioned, and it stays down, if its durable state is lost.
        """
        ...

    def lose(self, party_id: str) -> None:
        """The durable state of a party that is down is gone."""
        ...

    def commission(self, party_id: str, number: int, vital: bytes) -> None:
        """People put a party that is down into service again (see `host.store.commission`), before its next boot."""
        ...
