"""Faults of radio links, beyond the air model: each telegram passes all faults in force on its link, in order.

A link is written `A -> B` or `A <-> B`; `*` is any party.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final, Literal, Self

import numpy as np
from msgspec.structs import replace
from pydantic import BeforeValidator, Field, PrivateAttr

from network.files.quantities import AddedDelay, Distance, Probability, Share
from network.files.toml_input import one_of
from radio.air import NETWORKS, STEPS_PER_S, Delivery
from simulation.faults.fault import Fault, InForce, Names, Onset, folded_value

ANY: Final = "*"
BOTH_WAYS: Final = " <-> "
ONE_WAY: Final = " -> "
LINK_HELP: Final = "a link such as 'V1 <-> block-manager' or '* -> OGN-W'"

Telegram = tuple[Delivery, ...]  # what arrives of one telegram, and when
OfNetwork = Literal["any", "first", "second"]
_ON_ONE: Final = "of trains with two radio networks, the one that it is in"


@dataclass(frozen=True, slots=True)
class FaultyLink:
    """From one party to another, or both ways; `*` is any party."""

    source: str
    destination: str
    both_ways: bool = False

    @classmethod
    def parse(cls, text: object) -> FaultyLink:
        """The link that 'A -> B' or 'A <-> B' names. ValueError if the words are not of that form."""
        if isinstance(text, FaultyLink):
            return text
        for arrow in (BOTH_WAYS, ONE_WAY):
            ends = text.split(arrow) if isinstance(text, str) else []
            if len(ends) == 2 and all(end and not any(c in "<> " for c in end) for end in ends):
                return cls(ends[0], ends[1], arrow == BOTH_WAYS)
        raise ValueError(LINK_HELP)

    def joins(self, source: str, destination: str) -> bool:
        """Whether a telegram from `source` to `destination` goes over it."""
        return self._leads(source, destination) or (self.both_ways and self._leads(destination, source))

    def _leads(self, source: str, destination: str) -> bool:
        return self.source in (ANY, source) and self.destination in (ANY, destination)

    def __str__(self) -> str:
        return f"{self.source}{BOTH_WAYS if self.both_ways else ONE_WAY}{self.destination}"


class LinkFault(Fault[Telegram]):
    """What a link does to telegrams; `applied_to` is asked for each one that is sent."""

    aims_at = "link"
    changes = "link"
    in_order = ()
    target: Annotated[FaultyLink, BeforeValidator(FaultyLink.parse)]
    network: OfNetwork = Field(default="any", description=_ON_ONE)
    _chance: np.random.Generator | None = PrivateAttr(default=None)  # from when it has begun

    @classmethod
    def targets(cls, names: Names) -> tuple[str, ...]:
        return (*names.units, *names.devices, ANY)

    def wrong_target(self, names: Names) -> str:
        parties = self.targets(names)
        for end in (self.target.source, self.target.destination):
            if end not in parties:
                return f"a link between {one_of(parties[:-1], end)}, or '*'"
        return ""

    def taking_hold(self, onset: Onset) -> Self:
        copy = self.model_copy()
        copy._chance = onset.chance
        return copy

    @property
    def chance(self) -> np.random.Generator:
        """Where its chance comes from. ValueError before it has begun."""
        if self._chance is None:
            raise ValueError(f"{self.kind} has not begun")
        return self._chance

    def applied_to(self, telegram: Telegram) -> Telegram:
        return tuple(
            changed
            for delivery in telegram
            for changed in (self.disturbed(delivery) if self.hits() else (delivery,))
        )

    def hits(self) -> bool:
        """Whether this one is disturbed; all are, unless a kind leaves it to chance."""
        return True

    def disturbed(self, delivery: Delivery, /) -> Telegram:
        """What becomes of a telegram that is hit."""
        raise NotImplementedError


class ChanceLinkFault(LinkFault):
    """One that hits some telegrams and not others."""

    p: Probability = Field(description="probability that a telegram is hit")

    def hits(self) -> bool:
        return self.chance.random() < self.p


class Cut(LinkFault):
    """Nothing gets through."""

    kind = "cut"

    def disturbed(self, _delivery: Delivery) -> Telegram:
        return ()


class Loss(ChanceLinkFault):
    """Telegrams are lost."""

    kind = "loss"

    def disturbed(self, _delivery: Delivery) -> Telegram:
        return ()


class Delay(LinkFault):
    """All telegrams take longer."""

    kind = "delay"
    seconds: AddedDelay = Field(description="time added")

    def disturbed(self, delivery: Delivery) -> Telegram:
        return (_later(delivery, self.seconds),)


class Duplicate(ChanceLinkFault):
    """Telegrams arrive twice, the second time a step later."""

    kind = "duplicate"

    def disturbed(self, delivery: Delivery) -> Telegram:
        return delivery, replace(delivery, step=delivery.step + 1)


class Reorder(ChanceLinkFault):
    """Telegrams are held back, so that others overtake them."""

    kind = "reorder"
    seconds: AddedDelay = Field(default=1.0, description="time held back")

    def disturbed(self, delivery: Delivery) -> Telegram:
        return (_later(delivery, self.seconds),)


class Flip(ChanceLinkFault):
    """Telegrams have one bit inverted."""

    kind = "flip"

    def disturbed(self, delivery: Delivery) -> Telegram:
        data = bytearray(delivery.data)
        bit = int(self.chance.integers(8 * len(data)))
        data[bit // 8] ^= 1 << bit % 8
        return (replace(delivery, data=bytes(data)),)


@dataclass(frozen=True, slots=True)
class LineStretch:
    """A stretch of line from a share of a section on, by rising kilometrage; its length, m; for which network."""

    section_id: str
    from_share: float
    length_m: float
    network: OfNetwork = "any"


class DeadZone(Fault[tuple[LineStretch, ...]]):
    """The radio does not reach a stretch of line, on all parallel tracks, and no unit knows it."""

    kind = "dead_zone"
    aims_at = "section"
    changes = "coverage"
    in_order = ()
    target: str
    from_share: Share = Field(
        default=0.0,
        description="where it begins, as a share of the section from its end of lower kilometrage on",
    )
    length_m: Distance = Field(description="its length, also beyond the section")
    network: OfNetwork = Field(default="any", description=_ON_ONE)

    def applied_to(self, dead: tuple[LineStretch, ...]) -> tuple[LineStretch, ...]:
        return (*dead, LineStretch(self.target, self.from_share, self.length_m, self.network))


def is_of(fault_network: OfNetwork, network: str) -> bool:
    """Whether a fault is in a network, one of `NETWORKS`."""
    return fault_network in ("any", network)


def disturbed(
    in_force: InForce, source: str, destination: str, deliveries: Telegram, network: str = NETWORKS[0]
) -> Telegram:
    """What the link faults in force make of a telegram on its way in a network."""
    faults = in_force.in_family(LinkFault)
    on_its_way = [f for f in faults if is_of(f.network, network) and f.target.joins(source, destination)]
    return folded_value(deliveries, on_its_way)


def _later(delivery: Delivery, seconds: float) -> Delivery:
    return replace(delivery, step=delivery.step + round(seconds * STEPS_PER_S))
