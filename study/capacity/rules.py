"""By which rules sections are had and given back: as units do it, and what else theory may suppose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Rules:
    """The rules of one theory.

    `late`: ways are set as late as the train can still run unhindered (Sperrzeiten), not when units ask for them; it
    then also signs on at its portal as late as it can. `by_section`: each section is had and given back by itself, the
    latter as soon as the safe rear has left it (virtual blocks); else a route is had whole, and given back at the
    arrival tag. `throws`: points always have to be thrown; else they lie as the train before left them. `unslowed`:
    trains run as fast as they are driven and stay no longer than they must; else they keep their times.
    """

    late: bool = False
    by_section: bool = False
    throws: bool = False
    unslowed: bool = False


AS_UNITS: Final = Rules()
MINIMAL: Final = Rules(late=True, throws=True)
VIRTUAL_BLOCKS: Final = Rules(late=True, by_section=True, throws=True)
