"""What a proof that legs do not fit consists of, as a file has it; nothing is worked out here."""

from __future__ import annotations

import msgspec


class MoveBound(msgspec.Struct, frozen=True):
    """Leg `after` is moved by at least `least` ticks more than leg `before`, less so many periods.

    `section_id`: for which one waits for the other; empty where one set's stand says so.
    """

    before: int
    after: int
    least: int
    section_id: str = ""
    periods: int = 0

    def at_period(self, period: int) -> int:
        """The least difference at a period, ticks."""
        return self.least - self.periods * period

    def later(self, periods: int) -> MoveBound:
        """The same of a leg `after` so many periods later."""
        return MoveBound(self.before, self.after, self.least, self.section_id, self.periods + periods)


class Circle(msgspec.Struct, frozen=True, tag="circle"):
    """Bounds one after another, each from the leg at which that before it ended, and more than nothing together."""

    bounds: tuple[MoveBound, ...]


class TwoCases(msgspec.Struct, frozen=True, tag="cases"):
    """Of two bounds the one holds or the other, and why neither can be."""

    one_first: MoveBound
    other_first: MoveBound
    if_one: Circle | TwoCases
    if_other: Circle | TwoCases


Refutation = Circle | TwoCases


class ExcludedPeriods(msgspec.Struct, frozen=True):
    """No period from the one to the other, ticks, both among them (None: none is too long), and why."""

    from_ticks: int
    to_ticks: int | None
    because: Refutation


class Impossibility(msgspec.Struct, frozen=True):
    """A proof that legs do not fit: with periods that are excluded, or at all. `legs`: what the numbers mean."""

    tick_s: float
    legs: tuple[str, ...]
    excluded: tuple[ExcludedPeriods, ...]


def circles_of(proof: Refutation) -> tuple[Circle, ...]:
    """All circles of a proof, case by case."""
    return (proof,) if isinstance(proof, Circle) else (*circles_of(proof.if_one), *circles_of(proof.if_other))


def proof_text(proof: msgspec.Struct) -> str:
    """A proof as a file has it."""
    return msgspec.json.format(msgspec.json.encode(proof), indent=1).decode() + "\n"
