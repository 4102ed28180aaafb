"""Parties in the simulator's own process: the same machines, the same bytes, no Zenoh."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Self

from host.boot import boot
from host.parties import PartyError
from host.party import Advance, Party, PartySpec
from host.store import MemoryStore, commission


class LocalParties:
    """`host.parties.Parties` without processes. A killed party keeps its durable state only.

    Entering the context is the first commissioning of them all.
    """

    def __init__(self, specs: Iterable[PartySpec]) -> None:
        self.specs = {spec.party_id: spec for spec in specs}
        self._stores = {party_id: MemoryStore() for party_id in self.specs}
        self._running: dict[str, Party] = {}

    def __enter__(self) -> Self:
        for party_id, store in self._stores.items():
            commission(store)
            self.restart(party_id)
        return self

    def __exit__(self, *_: object) -> None:
        self._running.clear()

    def advance(self, party_id: str, now_s: float, telegrams: Sequence[bytes], told: bytes) -> Advance:
        """Let a party act at `now_s`. PartyError if it is down."""
        party = self._running.get(party_id)
        if party is None:
            raise PartyError(f"party {party_id} is down")
        return party.advance(now_s, telegrams, told)

    def alive(self, party_id: str) -> bool:
        """Whether the party runs."""
        return party_id in self._running

    def running(self, party_id: str) -> Party | None:
        """The party itself, to look at and not to touch; None: it is down."""
        return self._running.get(party_id)

    def kill(self, party_id: str) -> None:
        """Power cut."""
        self._running.pop(party_id, None)

    def restart(self, party_id: str) -> None:
        """Power back: a new boot epoch. PartyError if it runs, NotCommissioned if its durable state is lost."""
        if party_id in self._running:
            raise PartyError(f"party {party_id} runs already")
        self._running[party_id] = boot(self.specs[party_id], self._stores[party_id])

    def lose(self, party_id: str) -> None:
        """Its durable state is gone."""
        self._stores[party_id] = MemoryStore()

    def commission(self, party_id: str, number: int, vital: bytes) -> None:
        """People put it into service again."""
        commission(self._stores[party_id], number, vital)
