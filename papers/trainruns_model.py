"""The driving course of TrainRuns (Kannenberg and Scheidt 2022) with its own assumptions, to check running times by.

No second physics for runs: nothing but `papers.trainruns` asks it. It is written anew from what that model
calculates, and shares with ours neither forces nor steps, so that the two can be compared. Assumed there:

- Wende's resistance ("Fahrdynamik des Schienenverkehrs", 2003, p. 151 and 153) of the *empty* traction unit, with
  15 km/h of wind; the load adds inertia and weight on gradients, and no resistance. g = 9.80665 m/s^2.
- Traction by straight lines between the points of a table, one constant braking deceleration, mass as a point.
- Explicit steps of distance: the acceleration at the beginning of a step holds through it. Where a step would pass what
  ends it (a limit, too little traction, the place to brake from, the end of a section, a point of interest) it is taken
  back, and the way there made with steps of a tenth, three times over.
- Within a section of one limit and one gradient the train accelerates, clears (holds its speed until its rear has
  left a lower limit), cruises, gets slower where its traction does not suffice, and brakes to the speed at which it
  must leave the section.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from operator import itemgetter
from typing import Final

GRAVITY_MPS2: Final = 9.80665
WIND_MPS: Final = 15.0 / 3.6
HUNDRED_KMH_MPS: Final = 100.0 / 3.6
STEP_M: Final = 20.0
REFINED: Final = 3  # times that a step is made a tenth of what it was
DIGITS: Final = REFINED + 1  # to which braking distances are rounded up and speeds to brake from rounded down
NEAR_M: Final = 1e-9
_first = itemgetter(0)


@dataclass(frozen=True, slots=True)
class ReferenceTrain:
    """A train as that model knows it; resistances in permille of the weight, `cars_*` of vehicles without motors."""

    length_m: float
    mass_kg: float  # loaded
    driving_kg: float  # on driving axles of the empty traction unit
    carrying_kg: float
    cars_kg: float
    mass_factor: float
    limit_mps: float
    braking_mps2: float
    freight: bool
    driving_permille: float
    carrying_permille: float
    air_permille: float
    cars_base_permille: float
    cars_rolling_permille: float
    cars_air_permille: float
    effort: tuple[tuple[float, float], ...]  # m/s, N

    def pull_n(self, speed_mps: float) -> float:
        """Tractive effort, N: straight between the points of its table, level beyond the last."""
        above = bisect_left(self.effort, speed_mps, key=_first)
        if above == len(self.effort):
            return self.effort[-1][1]
        (low_mps, low_n), (high_mps, high_n) = self.effort[max(above - 1, 0)], self.effort[max(above, 1)]
        return low_n + (high_n - low_n) * (speed_mps - low_mps) / (high_mps - low_mps)

    def resistance_n(self, speed_mps: float) -> float:
        """Resistance on the level, N: Wende's of the traction unit, Strahl's (freight) or Sauthoff's of the cars."""
        windy = ((speed_mps + WIND_MPS) / HUNDRED_KMH_MPS) ** 2
        still = (speed_mps / HUNDRED_KMH_MPS) ** 2
        unit = self.driving_permille * self.driving_kg + self.carrying_permille * self.carrying_kg
        unit += self.air_permille * (self.driving_kg + self.carrying_kg) * windy
        rolling = 0.0 if self.freight else self.cars_rolling_permille * speed_mps / HUNDRED_KMH_MPS
        air = self.cars_air_permille * (still if self.freight else windy)
        cars = self.cars_kg * (self.cars_base_permille + rolling + air)
        return (unit + cars) * GRAVITY_MPS2 * 1e-3

    def gradient_n(self, permille: float) -> float:
        """Gradient resistance, N."""
        return self.mass_kg * permille * 1e-3 * GRAVITY_MPS2


@dataclass(frozen=True, slots=True)
class UniformSection:
    """A stretch of one limit and one gradient; `points_m` end a step, its end among them."""

    begin_m: float
    end_m: float
    limit_mps: float
    permille: float
    points_m: tuple[float, ...]


class Stalled(ArithmeticError):  # noqa: N818 - names what happened
    """The train comes to a stand on a gradient."""


class _Why(Enum):
    """What ended a way."""

    LIMIT = "the section's limit"
    EARLIER_LIMIT = "the limit of a section that the rear is still in"
    BALANCE = "traction and resistance are alike"
    BRAKING = "the place to brake from"
    END = "the end of the section"


def running_time_s(
    train: ReferenceTrain, sections: Sequence[UniformSection], step_m: float = STEP_M, refined: int = REFINED
) -> float:
    """Least running time from a stand at the first section's beginning to a stand at the last one's end, s.

    Raises Stalled where the train cannot climb.
    """
    return _RunUnderWay(train, sections, step_m, refined).run()


class _RunUnderWay:
    """One run under way: position of the front, time and speed."""

    def __init__(
        self, train: ReferenceTrain, sections: Sequence[UniformSection], step_m: float, refined: int
    ) -> None:
        self._train = train
        self._sections = sections
        self._step_m = step_m
        self._refined = refined
        self._index = 0
        self._exits_mps = _exits_mps(train, sections)
        self._at_m = sections[0].begin_m
        self._t_s = 0.0
        self._speed_mps = 0.0

    def run(self) -> float:
        """The whole way."""
        for index, section in enumerate(self._sections):
            self._index, self._at_m = index, section.begin_m
            self._run_section(section)
        return self._t_s

    def _run_section(self, section: UniformSection) -> None:
        why: _Why | None = None
        while section.end_m - self._at_m >= 10.0**-self._refined:
            balance_n = self._balance_n()
            if why is _Why.BRAKING or self._at_m + self._braking_m() >= section.end_m:
                self._brake(section)
            elif balance_n < 0.0:
                why = self._step_on(section, slower=True)
            elif why is _Why.EARLIER_LIMIT:
                why = self._clear(section)
            elif why is _Why.LIMIT:
                why = self._cruise(section.end_m - self._braking_m())
            else:
                why = self._step_on(section, slower=False)

    # ways at constant speed ---------------------------------------------------------------------------------------

    def _cruise(self, to_m: float) -> _Why:
        if to_m > self._at_m:
            self._t_s += (to_m - self._at_m) / self._speed_mps
            self._at_m = to_m
        return _Why.BRAKING

    def _clear(self, section: UniformSection) -> _Why | None:
        """As fast as an earlier limit allows until the rear has left it."""
        _, until_m = self._lowest_limit()
        brake_from_m = section.end_m - self._braking_m()
        why = self._cruise(min(until_m, brake_from_m))
        if brake_from_m <= until_m:
            return why
        limit_mps, _ = self._lowest_limit()
        held = limit_mps != section.limit_mps and self._speed_mps >= limit_mps
        return _Why.EARLIER_LIMIT if held else None

    def _brake(self, section: UniformSection) -> None:
        """By the constant deceleration, step by step; the last piece ends where and as fast as it must."""
        exit_mps = min(self._exits_mps[self._index], self._speed_mps)
        while self._at_m < section.end_m:
            size_m = min(self._step_m, self._next_point_m(section) - self._at_m)
            whole = self._speed_mps**2 - 2.0 * self._train.braking_mps2 * self._step_m
            after = self._speed_mps**2 - 2.0 * self._train.braking_mps2 * size_m
            if whole < 0.0 or after <= exit_mps**2 or self._at_m + size_m >= section.end_m:
                self._t_s += 2.0 * (section.end_m - self._at_m) / (self._speed_mps + exit_mps)
                self._at_m, self._speed_mps = section.end_m, exit_mps
                return
            after_mps = math.sqrt(after)
            self._t_s += (self._speed_mps - after_mps) / self._train.braking_mps2
            self._at_m, self._speed_mps = self._at_m + size_m, after_mps

    # ways at full power -------------------------------------------------------------------------------------------

    def _step_on(self, section: UniformSection, *, slower: bool) -> _Why:
        """Steps at full power, getting faster, or `slower` where the gradient is too steep, until something ends it."""
        limit_mps, limit_until_m = self._lowest_limit()
        while True:
            size_m = self._step_m
            point_m = self._next_point_m(section)
            ended: _Why | None = None
            for refinement in range(1, self._refined + 2):
                ended = None
                past_point = False
                before = self._at_m, self._t_s, self._speed_mps
                while ended is None and self._at_m < point_m:
                    if self._at_m >= limit_until_m:
                        limit_mps, limit_until_m = self._lowest_limit()
                    before = self._at_m, self._t_s, self._speed_mps
                    self._step(size_m)
                    past_point = self._at_m > point_m
                    ended = self._ended(section, limit_mps, slower=slower)
                last = refinement == self._refined + 1
                if ended is None and not past_point:
                    break  # at the point
                if last:
                    if ended in (_Why.LIMIT, _Why.EARLIER_LIMIT, _Why.BRAKING):
                        self._at_m, self._t_s, self._speed_mps = before
                    elif past_point:
                        self._at_m = point_m
                    break
                self._at_m, self._t_s, self._speed_mps = before
                by_point = past_point and ended not in (_Why.BALANCE, _Why.BRAKING)
                size_m = point_m - self._at_m if by_point else self._step_m / 10.0**refinement
            if ended is not None:
                return ended
            if self._at_m >= section.end_m:
                return _Why.END

    def _step(self, size_m: float) -> None:
        """One step with the acceleration that its beginning has."""
        acceleration = self._balance_n() / (self._train.mass_kg * self._train.mass_factor)
        squared = self._speed_mps**2 + 2.0 * acceleration * size_m
        if squared <= 0.0:
            raise Stalled(f"at {self._at_m:.0f} m")
        after_mps = math.sqrt(squared)
        self._t_s += 2.0 * size_m / (self._speed_mps + after_mps)
        self._speed_mps = after_mps
        target_m = self._at_m + size_m
        point_m = self._next_point_m(self._sections[self._index])
        self._at_m = point_m if abs(target_m - point_m) < NEAR_M else target_m

    def _ended(self, section: UniformSection, limit_mps: float, *, slower: bool) -> _Why | None:
        """What a step has come to or passed; in the order in which it counts."""
        balance_n = self._balance_n()
        if (balance_n >= 0.0) if slower else (balance_n <= 0.0):
            return _Why.BALANCE
        if self._at_m + self._braking_m() > section.end_m and self._braking_m() > 0.0:
            return _Why.BRAKING
        if not slower and self._speed_mps > limit_mps:
            return _Why.LIMIT if limit_mps == section.limit_mps else _Why.EARLIER_LIMIT
        return None

    # what holds where it is ---------------------------------------------------------------------------------------

    def _balance_n(self) -> float:
        """Pull less what holds the train back, N; the point that its mass is lies at the front."""
        train, speed = self._train, self._speed_mps
        gradient_n = train.gradient_n(self._sections[self._index].permille)
        return train.pull_n(speed) - train.resistance_n(speed) - gradient_n

    def _braking_m(self) -> float:
        """Way to brake to the section's exit speed, m, rounded up."""
        exit_mps = self._exits_mps[self._index]
        way_m = (self._speed_mps**2 - exit_mps**2) / (2.0 * self._train.braking_mps2)
        return max(0.0, math.ceil(way_m * 10**DIGITS) / 10**DIGITS)

    def _next_point_m(self, section: UniformSection) -> float:
        return next(point_m for point_m in section.points_m if point_m > self._at_m)

    def _lowest_limit(self) -> tuple[float, float]:
        """The lowest limit under the train, m/s, and where its front is when its rear has left that, m."""
        here = self._sections[self._index]
        limit_mps, end_m = here.limit_mps, here.end_m
        for section in reversed(self._sections[: self._index]):
            if self._at_m - self._train.length_m >= section.end_m:
                break
            if section.limit_mps < limit_mps:
                limit_mps, end_m = section.limit_mps, section.end_m
        return limit_mps, end_m + self._train.length_m


def _exits_mps(train: ReferenceTrain, sections: Sequence[UniformSection]) -> tuple[float, ...]:
    """The greatest speeds at the ends of the sections from which all that follows can be braked for, m/s."""
    exits: list[float] = []
    entry_mps = 0.0
    for section in reversed(sections):
        exit_mps = min(section.limit_mps, entry_mps)
        exits.append(exit_mps)
        squared = exit_mps**2 + 2.0 * train.braking_mps2 * (section.end_m - section.begin_m)
        entry_mps = min(section.limit_mps, math.floor(math.sqrt(squared) * 10**DIGITS) / 10**DIGITS)
    return tuple(reversed(exits))
