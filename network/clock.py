"""Times of the operating day as people read them."""

from __future__ import annotations


def clock(time_s: float) -> str:
    """HH:MM:SS of seconds after midnight; hours go on after 23, and what is before midnight has a minus."""
    sign, whole_s = "-" if round(time_s) < 0 else "", abs(round(time_s))
    return f"{sign}{whole_s // 3600:02d}:{whole_s // 60 % 60:02d}:{whole_s % 60:02d}"
