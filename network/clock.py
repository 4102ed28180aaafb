"""Times of the operating day as people read them."""

from __future__ import annotations

from typing import TypeVar

TimeT = TypeVar("TimeT", int, float)


def clock(time_s: float) -> str:
    """HH:MM:SS of seconds after midnight; hours go on after 23, and what is before midnight has a minus."""
    sign, whole_s = "-" if round(time_s) < 0 else "", abs(round(time_s))
    return f"{sign}{whole_s // 3600:02d}:{whole_s // 60 % 60:02d}:{whole_s % 60:02d}"


def first_given(*times_s: TimeT | None) -> TimeT:
    """The first time that is given; midnight, 0, is one. StopIteration where none is."""
    return next(time_s for time_s in times_s if time_s is not None)
