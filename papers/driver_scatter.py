"""Drivers on one hop in the same time: how much their energy scatters, and by how much their habits have to.

Oda's first chapter: over the same hop in the same running time the energy of drivers differs by about +-20 % (Iseki),
and by 20 % in other data (Yokota). Taken here as: 19 of 20 drivers are within 20 % of the mean, so one standard
deviation is 10 %; of traction energy, on the nominal hop of Yasunobu and others (table 1's train, 1,000 m of level
track) in 90 s, the middle of its running times. The habits' deviations relative to one another are assumed; all are
multiplied by one factor, found by `python -m papers.driver_scatter` and rounded to a tenth: DEFAULT_FACTOR, with
which `[law.driver]` has its defaults.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.laws.driver import Driver
from onboard.driving.laws.settings import LawTables
from papers.single_hop import HopBench, HopWay, TimedHop, one_gradient
from papers.yasunobu_train import HOP_M, paper_bench
from radio.chance import generator

DRIVERS: Final = 100
HOP_S: Final = 90.0
SIGMA_SHARE: Final = 0.10
PUNCTUAL_S: Final = 1.0
# assumed: how much drivers differ in each habit, relative to the other habits
PROPORTIONS: Final = Driver(
    power_share_sigma=0.2,
    swing_sigma_mps=0.6,
    coast_sigma_s=8.0,
    look_sigma_s=0.3,
    under_sigma_mps=0.3,
    brake_share_sigma=0.2,
)
DEFAULT_FACTOR: Final = 0.4
SIGMAS: Final = tuple(name for name in Driver.model_fields if "_sigma" in name)


@dataclass(frozen=True, slots=True)
class DriverScatter:
    """Drivers' hops in the same time, and those of drivers who cannot make it."""

    hops: tuple[TimedHop, ...]
    late: int

    @property
    def energies_kwh(self) -> NDArray[np.float64]:
        """Traction energy of each, at the wire."""
        return np.array([hop.traction_kwh for hop in self.hops])

    @property
    def sigma_share(self) -> float:
        """Standard deviation of the energy, as a share of its mean."""
        return float(self.energies_kwh.std() / self.energies_kwh.mean())

    @property
    def half_range_share(self) -> float:
        """Half of what lies between the thriftiest and the most wasteful, as a share of the mean."""
        return float(np.ptp(self.energies_kwh) / 2.0 / self.energies_kwh.mean())


def widened_habits(factor: float) -> Driver:
    """Habits whose deviations are those of PROPORTIONS times `factor`."""
    return PROPORTIONS.model_copy(update={name: factor * getattr(PROPORTIONS, name) for name in SIGMAS})


def scatter(
    settings: Driver, drivers: int = DRIVERS, seed: int = 1, way: HopWay | None = None, time_s: float = HOP_S
) -> DriverScatter:
    """`drivers` drivers over one hop in `time_s`, drawn as on the line, by (seed, driver, number)."""
    tables = LawTables.model_validate({"driver": settings})
    over = one_gradient(HOP_M) if way is None else way
    hops: list[TimedHop] = []
    for number in range(drivers):
        hops.append(HopBench(paper_bench("driver", tables, habit_draws(seed, number)), over).timed(time_s))
    punctual = tuple(hop for hop in hops if abs(hop.off_s) <= PUNCTUAL_S)
    return DriverScatter(punctual, drivers - len(punctual))


def habit_draws(seed: int, number: int) -> Callable[[str, str], float]:
    """What one driver's habits are drawn from."""
    chance = generator(seed, "driver", str(number))
    return lambda _law, _field: float(chance.normal())


def calibrated_factor(drivers: int = DRIVERS, seed: int = 1) -> float:
    """The factor with which the energy of drivers scatters by SIGMA_SHARE, by bisection to a hundredth."""
    low, high = 0.1, 3.0
    while high - low > 0.01:
        middle = (low + high) / 2.0
        if scatter(widened_habits(middle), drivers, seed).sigma_share < SIGMA_SHARE:
            low = middle
        else:
            high = middle
    return (low + high) / 2.0


def main() -> None:
    """Print the factor and what comes of it."""
    factor = calibrated_factor()
    found = scatter(widened_habits(factor))
    sys.stdout.write(
        f"factor {factor:.2f}: sigma {found.sigma_share:.1%}, half range {found.half_range_share:.1%}\n"
    )
    sys.stdout.write(f"mean {found.energies_kwh.mean():.2f} kWh, {found.late} drivers who are late\n")
    for name in SIGMAS:
        sys.stdout.write(f"{name} = {getattr(widened_habits(factor), name):.3f}\n")


if __name__ == "__main__":
    main()
