"""The air between two parties: delay, loss in bursts, duplication, reordering, bit errors, coverage.

Loss follows Gilbert (1960) and Elliott (1963), in continuous time because telegrams are sparse: a link is
good or bad, changes at rates a (good to bad) and b (bad to good), so the share of bad time is a / (a + b),
a bad spell lasts 1 / b on average, and P(bad after t | now) relaxes to that share with exp(-(a + b) t). A
link keeps the order of telegrams except for those that reordering holds back and for second copies. Every
directed link draws from its own generator; nothing here reads a clock. Parties with two networks send each telegram
over both at once, as the published trials of crossings controlled by radio do with two mobile carriers.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from enum import Enum
from typing import Annotated, Final, NamedTuple

import msgspec
import numpy as np
from pydantic import Field, ValidationInfo, field_validator

from network.files.chances import BitError, GoodLoss
from network.files.kinds import about
from network.files.quantities import AddedDelay, LinkRate, Probability, TelegramDelay
from network.files.toml_input import Record
from radio.chance import generator

STEP_S: Final = 0.1
STEPS_PER_S: Final = 10
NETWORKS: Final = ("first", "second")  # of trains with a radio of each
_STEP_TOLERANCE: Final = 1e-9
_NEVER_P: Final = 1e-12


class DelayShape(Enum):
    """Distribution of the delay: the mean always, or the minimum plus an exponential tail with that mean."""

    CONSTANT = "constant"
    EXPONENTIAL = "exponential"


class AirEvent(Enum):
    """What happened to a telegram, for the counts."""

    SENT = "sent"
    UNCOVERED = "uncovered"
    LOST = "lost"
    DUPLICATED = "duplicated"
    REORDERED = "reordered"
    FLIPPED = "flipped"


class AirParameters(Record):
    """`[air]`: delay, loss, duplication, reordering and bit errors of every link.

    Defaults: a perfect link with one step of delay. Probabilities are per telegram except `flip_p`, per bit.
    """

    delay_min_s: Annotated[
        TelegramDelay, about("least delay of a telegram", "one step: what lock-step with processes needs")
    ] = STEP_S
    delay_mean_s: Annotated[
        TelegramDelay,
        Field(validate_default=True),
        about("mean delay, not below the least", "assumed: a perfect link"),
    ] = STEP_S
    delay_shape: Annotated[
        DelayShape,
        Field(strict=False),
        about("constant, or the least plus an exponential tail with that mean", "assumed: a queueing tail"),
    ] = DelayShape.EXPONENTIAL
    loss_good_p: Annotated[GoodLoss, about("loss while the link is good", "assumed: a perfect link")] = 0.0
    loss_bad_p: Annotated[Probability, about("loss while it is bad", "as in Gilbert 1960")] = 1.0
    good_to_bad_per_s: Annotated[
        LinkRate, about("rate at which a good link turns bad", "assumed: a perfect link")
    ] = 0.0
    bad_to_good_per_s: Annotated[
        LinkRate,
        about("rate at which a bad link turns good; a bad spell lasts 1 / this", "assumed: a second"),
    ] = 1.0
    duplicate_p: Annotated[Probability, about("a telegram comes twice", "assumed: a perfect link")] = 0.0
    reorder_p: Annotated[Probability, about("a telegram is held back", "assumed: a perfect link")] = 0.0
    reorder_delay_s: Annotated[
        AddedDelay, about("for how long it is held back", "assumed: a few telegrams")
    ] = 1.0
    flip_p: Annotated[BitError, about("a bit is wrong", "assumed: a perfect link")] = 0.0

    @field_validator("delay_mean_s")
    @classmethod
    def _mean_not_below_least(cls, mean_s: float, info: ValidationInfo) -> float:
        least_s = info.data.get("delay_min_s", STEP_S)
        if mean_s < least_s:
            raise ValueError(f"at least {least_s:g} (delay_min_s)")
        return mean_s

    @field_validator("bad_to_good_per_s")
    @classmethod
    def _bad_spells_end(cls, rate: float, info: ValidationInfo) -> float:
        if rate <= 0.0 < info.data.get("good_to_bad_per_s", 0.0):
            raise ValueError(
                "more than 0: a bad spell lasts 1 / this, and there are some (good_to_bad_per_s)"
            )
        return rate

    @property
    def bad_share(self) -> float:
        """Share of the time in which a link is bad."""
        total = self.good_to_bad_per_s + self.bad_to_good_per_s
        return self.good_to_bad_per_s / total if total > 0.0 else 0.0

    @property
    def loss_p(self) -> float:
        """Probability that a telegram is lost, over long times."""
        return self.loss_good_p + (self.loss_bad_p - self.loss_good_p) * self.bad_share

    def mean_delay_s(self, step_s: float = STEP_S) -> float:
        """Mean delay of a telegram that arrives, in whole steps as `Air` delivers it, s."""
        least_steps = max(1, math.ceil(self.delay_min_s / step_s - _STEP_TOLERANCE))
        tail_s = self.delay_mean_s - self.delay_min_s
        if self.delay_shape is DelayShape.CONSTANT:
            return step_s * max(1, math.ceil(self.delay_mean_s / step_s - _STEP_TOLERANCE))
        if tail_s <= 0.0:
            return step_s * least_steps
        # A further step is needed as often as the delay exceeds those before it.
        exceeds = math.exp(-(least_steps * step_s - self.delay_min_s) / tail_s)
        return step_s * (least_steps + exceeds / (1.0 - math.exp(-step_s / tail_s)))

    def later_p(self, steps: int, step_s: float = STEP_S) -> float:
        """Probability that a telegram which arrives is under way for more than so many steps."""
        if self.delay_shape is DelayShape.CONSTANT:
            return float(steps < max(1, math.ceil(self.delay_mean_s / step_s - _STEP_TOLERANCE)))
        if steps < max(1, math.ceil(self.delay_min_s / step_s - _STEP_TOLERANCE)):
            return 1.0
        tail_s = self.delay_mean_s - self.delay_min_s
        return math.exp(-(steps * step_s - self.delay_min_s) / tail_s) if tail_s > 0.0 else 0.0


class OnAverage(NamedTuple):
    """Of a telegram: how long it is under way if it arrives, s, and the share that does not, over long times."""

    delay_s: float
    loss_p: float


def on_average(first: AirParameters, second: AirParameters | None, step_s: float = STEP_S) -> OnAverage:
    """A telegram on one network, or on two at once: it arrives with whichever brings it first."""
    if second is None:
        return OnAverage(first.mean_delay_s(step_s), first.loss_p)
    one, other = first.loss_p, second.loss_p
    if one * other >= 1.0:
        return OnAverage(min(first.mean_delay_s(step_s), second.mean_delay_s(step_s)), 1.0)
    sooner_s, steps = 0.0, 0
    while (later_p := first.later_p(steps, step_s) * second.later_p(steps, step_s)) > _NEVER_P:
        sooner_s += later_p * step_s
        steps += 1
    alone_s = (1.0 - one) * other * first.mean_delay_s(step_s) + one * (1.0 - other) * second.mean_delay_s(
        step_s
    )
    return OnAverage(((1.0 - one) * (1.0 - other) * sooner_s + alone_s) / (1.0 - one * other), one * other)


class Delivery(msgspec.Struct, frozen=True):
    """Bytes that arrive at the destination in `step`."""

    step: int
    data: bytes


@dataclass(slots=True)
class _Link:
    chance: np.random.Generator
    bad: bool
    updated_step: int
    last_step: int


@dataclass(slots=True)
class Air:
    """One network of one run: the only state is that of its links and the counts. `stream`: what its draws are of."""

    parameters: AirParameters
    seed: int
    step_s: float = STEP_S
    stream: str = "air"
    counts: Counter[AirEvent] = field(default_factory=Counter)
    _links: dict[tuple[str, str], _Link] = field(default_factory=dict)

    def transmit(
        self, now_step: int, source: str, destination: str, data: bytes, covered: bool
    ) -> tuple[Delivery, ...]:
        """What becomes of a telegram sent in `now_step`: none, one or two deliveries, at least one step
        later.

        `covered`: both ends reach the radio network (無線). Steps of one link must not go back.
        """
        self.counts[AirEvent.SENT] += 1
        if not covered:
            self.counts[AirEvent.UNCOVERED] += 1
            return ()
        parameters = self.parameters
        link = self._link(now_step, source, destination)
        chance = link.chance
        if chance.random() < (parameters.loss_bad_p if link.bad else parameters.loss_good_p):
            self.counts[AirEvent.LOST] += 1
            return ()
        step = now_step + self._delay_steps(chance)
        if parameters.reorder_p and chance.random() < parameters.reorder_p:
            self.counts[AirEvent.REORDERED] += 1
            step += math.ceil(parameters.reorder_delay_s / self.step_s - _STEP_TOLERANCE)
        else:
            step = link.last_step = max(step, link.last_step)
        deliveries = [Delivery(step, self._flip(chance, data))]
        if parameters.duplicate_p and chance.random() < parameters.duplicate_p:
            self.counts[AirEvent.DUPLICATED] += 1
            later = step + self._delay_steps(chance)
            deliveries.append(Delivery(later, self._flip(chance, data)))
        return tuple(deliveries)

    def _link(self, now_step: int, source: str, destination: str) -> _Link:
        parameters = self.parameters
        link = self._links.get((source, destination))
        if link is None:
            chance = generator(self.seed, self.stream, source, destination)
            link = _Link(chance, bool(chance.random() < parameters.bad_share), now_step, now_step)
            self._links[source, destination] = link
        elapsed_s = (now_step - link.updated_step) * self.step_s
        if elapsed_s < 0.0:
            raise ValueError(
                f"step {now_step} is before step {link.updated_step} of link {source} to {destination}"
            )
        if elapsed_s > 0.0 and parameters.good_to_bad_per_s > 0.0:
            fade = math.exp(-(parameters.good_to_bad_per_s + parameters.bad_to_good_per_s) * elapsed_s)
            bad_p = parameters.bad_share + ((1.0 if link.bad else 0.0) - parameters.bad_share) * fade
            link.bad = bool(link.chance.random() < bad_p)
        link.updated_step = now_step
        return link

    def _delay_steps(self, chance: np.random.Generator) -> int:
        """Delay rounded up to whole steps, at least one: what makes lock-step with processes exact."""
        parameters = self.parameters
        delay_s = parameters.delay_mean_s
        if parameters.delay_shape is DelayShape.EXPONENTIAL:
            delay_s = parameters.delay_min_s
            delay_s += chance.exponential(parameters.delay_mean_s - parameters.delay_min_s)
        return max(1, math.ceil(delay_s / self.step_s - _STEP_TOLERANCE))

    def _flip(self, chance: np.random.Generator, data: bytes) -> bytes:
        if self.parameters.flip_p <= 0.0 or not data:
            return data
        flips = int(chance.binomial(8 * len(data), self.parameters.flip_p))
        if flips == 0:
            return data
        self.counts[AirEvent.FLIPPED] += 1
        changed = bytearray(data)
        for bit in chance.choice(8 * len(data), size=flips, replace=False).tolist():
            changed[bit // 8] ^= 1 << bit % 8
        return bytes(changed)


def combined(first: tuple[Delivery, ...], second: tuple[Delivery, ...], sent: bytes) -> tuple[Delivery, ...]:
    """What a receiver with a radio of each of two networks takes of one telegram, `sent` over both at once.

    The network on which it comes first and whole is the one that counts; where neither brings it whole, all that comes
    is taken, and the receiver's checks drop what is damaged.
    """
    whole = [copies for copies in (first, second) if any(one.data == sent for one in copies)]
    if not whole:
        return tuple(sorted((*first, *second), key=lambda one: one.step))
    return min(whole, key=lambda copies: min(one.step for one in copies if one.data == sent))
