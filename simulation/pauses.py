"""How long people take this time: draws of `[people]`, each from a generator of its own, so that none moves another."""

from __future__ import annotations

import math
from collections import Counter
from typing import Final

from radio.chance import generator
from simulation.people import LID_TIMES, Pause
from simulation.setup import STEPS_PER_S, Setup

STREAM: Final = "people"


class Pauses:
    """Draws of one run, by seed, pause, who makes it, and how often they have before; each pause has one caller."""

    def __init__(self, setup: Setup) -> None:
        self._people: Final = setup.people
        self._seed: Final = setup.seed
        self._today: Final = setup.today
        self._counts: Counter[tuple[Pause, str]] = Counter()

    def steps(self, pause: Pause, who: str) -> int:
        """How long somebody takes this time, in steps; `who` is a stock id or a person."""
        self._counts[pause, who] += 1
        count = str(self._counts[pause, who])
        chance = generator(self._seed, STREAM, pause.value, who, count, *self._today)
        sigma = self._people.sigma
        times = math.exp(sigma * float(chance.standard_normal()) - 0.5 * sigma**2)
        return round(self._people.mean_s(pause) * min(times, LID_TIMES) * STEPS_PER_S)
