"""What is due when: a queue of events by step, in the order in which they were put in."""

from __future__ import annotations

import heapq
from enum import IntEnum
from typing import Final, NamedTuple

EARLY_MAX: Final = 1_000_000  # items that may be put in first


class AgendaKind(IntEnum):
    """Kinds of events; within a step lower ones come first."""

    POINTS = 0  # a point machine, or the barriers of a level crossing, reach their end
    TO_DEVICE = 1  # telegrams and inputs reach a wayside device, or its timer is due
    TO_UNIT = 2  # a telegram reaches an on-board unit
    UNIT_TIMER = 3
    DUTY = 4  # a stock takes up its next duty
    SCRIPT = 5  # something fails, heals, or is done by a person
    PEOPLE = 6  # passengers and doors at a stop
    CREW = 7  # a crew has done what it took its time for
    PROCEDURE = 8  # people who work a line by substitute working look round


class Item(NamedTuple):
    """One thing due; no two have the same order."""

    step: int
    kind: AgendaKind
    order: int
    subject: str
    data: bytes | None = None


class Agenda:
    """A heap of items; equal items keep the order in which they came."""

    def __init__(self) -> None:
        self._heap: list[Item] = []
        self._order = 0
        self._early = -EARLY_MAX

    def put(self, step: int, kind: AgendaKind, subject: str, data: bytes | None = None) -> None:
        """Add an item."""
        self._order += 1
        heapq.heappush(self._heap, Item(step, kind, self._order, subject, data))

    def put_first(self, step: int, kind: AgendaKind, subject: str) -> None:
        """Add an item as if it had been put in before all others, though after those that this was said of."""
        self._early += 1
        heapq.heappush(self._heap, Item(step, kind, self._early, subject))

    def next_step(self) -> int | None:
        """Step of the earliest item; None when nothing is due ever again."""
        return self._heap[0].step if self._heap else None

    def subjects(self, kind: AgendaKind) -> frozenset[str]:
        """Who has an item of a kind."""
        return frozenset(item.subject for item in self._heap if item.kind is kind)

    def is_due(self, step: int, kind: AgendaKind) -> bool:
        """Whether an item of a kind is due at just this step."""
        return any(item.step == step and item.kind is kind for item in self._heap)

    def withdraw(self, kind: AgendaKind, subject: str, after_step: int = -1) -> None:
        """Take out what is due for a subject later than a step, but for telegrams on their way."""
        kept = [
            item
            for item in self._heap
            if item.subject != subject
            or item.kind is not kind
            or item.step <= after_step
            or item.data is not None
        ]
        if len(kept) < len(self._heap):
            self._heap = kept
            heapq.heapify(kept)

    def pop_due(self, step: int) -> Item | None:
        """The earliest item if it is due at `step`; None otherwise."""
        if self._heap and self._heap[0].step <= step:
            return heapq.heappop(self._heap)
        return None

    def pop_all(self, step: int, kind: AgendaKind, subject: str) -> list[Item]:
        """Further items of the same step, kind and subject, in order, taken out."""
        taken = [i for i in self._heap if i.step <= step and i.kind is kind and i.subject == subject]
        if taken:
            self._heap = [i for i in self._heap if i not in taken]
            heapq.heapify(self._heap)
        return sorted(taken)
