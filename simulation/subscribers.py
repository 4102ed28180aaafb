"""Who is told of something as it happens: each says so when it is made, and is told in that order."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, ParamSpec

P = ParamSpec("P")


class Subscribers(Generic[P]):
    """Those of one kind of happening; calling it tells them all."""

    def __init__(self) -> None:
        self._told: list[Callable[P, object]] = []

    def add(self, tell: Callable[P, object]) -> None:
        """From now on this is told too."""
        self._told.append(tell)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> None:
        """It has happened."""
        for tell in self._told:
            tell(*args, **kwargs)
