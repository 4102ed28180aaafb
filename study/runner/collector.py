"""When Python's collector of circles looks through all that lives on: rarely, as runs and imports make hardly any."""

from __future__ import annotations

import gc
from collections.abc import Generator
from contextlib import contextmanager
from typing import Final

MORE_OBJECTS: Final = (
    20_000  # than were freed; after Python's 700, imports alone are looked through time and again
)


@contextmanager
def collecting_rarely() -> Generator[None]:
    """As long as the context lasts."""
    before = gc.get_threshold()
    gc.set_threshold(MORE_OBJECTS, 20, 20)
    try:
        yield
    finally:
        gc.set_threshold(*before)
