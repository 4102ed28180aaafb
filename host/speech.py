"""What leaves a unit: what its machine says, unless the world has its speech fail (a fault of the simulation).

A unit that is mad, or one whose key is stolen, says more than its machine does, in its name and under its key: it
claims what it does not hold. That can be told from nothing but its contradictions; two persons bar it.
"""

from __future__ import annotations

from msgspec.structs import replace

from radio.envelope import Endpoint
from radio.messages import AnyMessage, Claim


class Speech(Endpoint):
    """A unit's endpoint. `claims_besides`: what each claim names besides what its unit holds."""

    claims_besides: tuple[str, ...] = ()

    def seal(self, destination: str, message: AnyMessage, now_s: float, correlation: int = 0) -> bytes:
        """As any endpoint. A unit that says it does not know says so: where its train stands is no lie to tell."""
        if isinstance(message, Claim) and message.section_ids is not None:
            more = tuple(s for s in self.claims_besides if s not in message.section_ids)
            message = replace(message, section_ids=(*message.section_ids, *more))
        return super().seal(destination, message, now_s, correlation)
