"""The radio of a run: one network, or two that carry each telegram at once, with what faults make of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple

from radio.air import NETWORKS, Air, Delivery, combined
from simulation.faults.fault import InForce
from simulation.faults.links import disturbed
from simulation.setup import Setup


class OnAir(NamedTuple):
    """What arrives of a telegram, and whether any network reached its unit."""

    deliveries: tuple[Delivery, ...]
    covered: bool


class Radio:
    """`reached` says of a unit which networks reach it now."""

    def __init__(self, setup: Setup, reached: Callable[[str], tuple[bool, ...]], in_force: InForce) -> None:
        settings = [one for one in (setup.air, setup.second_air) if one is not None]
        self._networks: Final = {
            name: Air(one, setup.seed, stream="air" if name == NETWORKS[0] else f"air {name}")
            for name, one in zip(setup.networks, settings, strict=True)
        }
        self._reached: Final = reached
        self._in_force: Final = in_force

    def transmit(self, step: int, source: str, destination: str, data: bytes, unit_id: str) -> OnAir:
        """Send a telegram from or to a unit by every network."""
        reached = self._reached(unit_id)
        found = [
            disturbed(
                self._in_force,
                source,
                destination,
                air.transmit(step, source, destination, data, covered),
                network,
            )
            for (network, air), covered in zip(self._networks.items(), reached, strict=True)
        ]
        return OnAir(found[0] if len(found) == 1 else combined(found[0], found[1], data), any(reached))
