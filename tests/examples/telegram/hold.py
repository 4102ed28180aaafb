"""Held back at the next station: a train that stands at a stop asks for no route and does not leave.

Invariant: it only restricts. What is held stays held, nothing is given back, and a train under way goes on to its stop.
A telegram that is lost changes nothing; a unit that boots anew is no longer held back, and must be told again.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from msgspec.structs import replace

from onboard.authority.records import Authority, HeldBack
from onboard.authority.tables import Result, SignOnStanding, Table


def hold_back(state: Authority, event: HeldBack) -> Result:
    """Held back, or no more."""
    return replace(state, held_back=event.hold), ()


TABLE: Final[Table] = MappingProxyType({(standing, HeldBack): hold_back for standing in SignOnStanding})
