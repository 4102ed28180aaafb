"""Units whose event-driven part is frozen: what comes to them waits, and is taken in the order in which it came.

Physics and the compiled tick go on with the last command, supervised to the stop limit that the unit has: that limit
only ever restricts, so nothing that is safe rests on a unit that answers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator


class Piles:
    """What waits for frozen units, by slot."""

    def __init__(self) -> None:
        self._of: dict[int, list[Callable[[], None]]] = {}

    def __contains__(self, slot: int) -> bool:
        """Whether the unit is frozen."""
        return slot in self._of

    def freeze(self, slot: int) -> None:
        """From now on what comes to the unit waits."""
        self._of.setdefault(slot, [])

    def thaw(self, slot: int) -> Iterator[Callable[[], None]]:
        """The unit works again; what has waited, to be done now."""
        yield from self._of.pop(slot, [])

    def forget(self, slot: int) -> None:
        """The unit has lost its power, and with it what waited."""
        if slot in self._of:
            self._of[slot].clear()

    def when_it_works(self, slot: int, act: Callable[[], None]) -> None:
        """Do it now, or when the unit works again."""
        if slot in self._of:
            self._of[slot].append(act)
        else:
            act()
