"""The tachometer compared with another axle (速度発電機の照合): the difference widens the bounds, or is a doubt.

The slide protection shows the speed of the last axle, converted to the tachometer's circumference. Two rolling axles
differ by no more than the variation of a turn (`unit.axles_differ_share`), which the growth of the bounds covers.
Differences beyond that are added up in each direction and widen the bound on that side, so the interval spans what both
axles say.

Invariant: the front is inside the bounds while at least one of the two axles is as good as wheels are stated to be, and
both while they slide or slip. Axles that are `APART_M` apart contradict each other: a doubt, reported once, until they
have agreed for `AGREES_M` (decision 072). From then on the faster axle counts, and during braking the greatest speed
that the train may still have. An axle that turns when the train must long be standing is wrong; then the other counts.
"""

from __future__ import annotations

from typing import Final

from onboard.records import UnitRow
from vehicle.compiled import compiled

NO_AXLE_MPS: Final = -1.0  # nothing shows another axle
APART_M: Final = 1.0  # assumed: slides that the protection does not see differ by less
AGREES_M: Final = 50.0
LONG_STAND_S: Final = 10.0  # assumed: brakes have long built up, and an axle's last pulses are over
ALIKE_MPS: Final = 0.02  # assumed: a clock between pulses shows speeds no finer
SURE_BRAKE_MPS2: Final = 0.05  # assumed: locked wheels on a rail with adhesion 0.02, down 15 permille

# unit.liar
NO_LIAR: Final = 0
TACHOMETER_LIES: Final = 1
LAST_AXLE_LIES: Final = 2


def forget_axles(unit: UnitRow) -> None:
    """Nothing has been compared yet."""
    unit.last_axle_mps = NO_AXLE_MPS
    unit.short_m = unit.short_most_m = unit.long_m = unit.long_most_m = unit.agree_m = unit.braked_mps = (
        unit.sure_stand_s
    ) = 0.0
    unit.apart, unit.liar, unit.odometer_off_m = 0, NO_LIAR, 0.0


@compiled
def last_run_m(unit: UnitRow, last_mps: float, step_s: float) -> float:
    """What the last axle has rolled in this step, m; keeps its speed."""
    before_mps = unit.last_axle_mps if unit.last_axle_mps >= 0.0 else last_mps
    unit.last_axle_mps = last_mps
    return (before_mps + last_mps) / 2.0 * step_s


@compiled
def counted_to_m(sum_m: float, before_m: float, pulse_m: float) -> float:
    """Up to where bounds hold a sum, m: what whole pulses differ by is no difference, neither rising nor falling."""
    return max(sum_m, min(before_m, sum_m + pulse_m))


@compiled
def compare(unit: UnitRow, run_m: float, last_m: float) -> tuple[float, float]:
    """Add up what the tachometer (`run_m`) has counted less than the last axle (`last_m`) while both roll, and more.

    Returns by how much the bounds ahead and behind are to be wider, m.
    """
    less_m, hidden_m = last_m - run_m, unit.axles_differ_share * run_m
    unit.short_m = max(unit.short_m + less_m - hidden_m, 0.0)
    unit.long_m = max(unit.long_m - less_m - hidden_m, 0.0)
    short_m, long_m = max(unit.short_most_m, unit.pulse_m), max(unit.long_most_m, unit.pulse_m)
    unit.short_most_m = counted_to_m(unit.short_m, short_m, unit.pulse_m)
    unit.long_most_m = counted_to_m(unit.long_m, long_m, unit.pulse_m)
    return max(unit.short_most_m - short_m, 0.0), max(unit.long_most_m - long_m, 0.0)


@compiled
def turn_alike(unit: UnitRow, shown_mps: float, last_mps: float) -> bool:
    """Whether two axles turn as fast as each other."""
    return bool(abs(shown_mps - last_mps) <= unit.axles_differ_share * last_mps + ALIKE_MPS)


@compiled
def contradict(unit: UnitRow, shown_mps: float, last_mps: float) -> None:
    """From now on the two contradict one another."""
    unit.apart, unit.agree_m, unit.braked_mps = 1, 0.0, max(shown_mps, last_mps)


@compiled
def come_apart(unit: UnitRow, shown_mps: float, last_mps: float, last_m: float) -> bool:
    """Whether the two axles contradict one another from now on; ends the doubt once they have long agreed."""
    if unit.apart == 0:
        if max(unit.short_m, unit.long_m) > APART_M:
            contradict(unit, shown_mps, last_mps)
        return bool(unit.apart != 0)
    unit.agree_m = unit.agree_m + last_m if turn_alike(unit, shown_mps, last_mps) else 0.0
    if unit.agree_m >= AGREES_M:
        unit.apart, unit.liar = 0, NO_LIAR
        unit.short_m = unit.short_most_m = unit.long_m = unit.long_most_m = 0.0
    return False


@compiled
def speed_to_go_by_mps(unit: UnitRow, shown_mps: float, last_mps: float, step_s: float) -> float:
    """The tachometer's speed, or what is safe to take for it while the axles contradict one another."""
    if unit.apart == 0:
        stands = shown_mps == 0.0 and (last_mps <= ALIKE_MPS or unit.wheel_slide != 0)
        return shown_mps if stands or shown_mps > 0.0 else last_mps
    if unit.liar != NO_LIAR:
        return last_mps if unit.liar == TACHOMETER_LIES else shown_mps
    faster_mps, slower_mps = max(shown_mps, last_mps), min(shown_mps, last_mps)
    if unit.notch < 0.0 or unit.emergency != 0:
        unit.braked_mps = max(min(unit.braked_mps, faster_mps) - SURE_BRAKE_MPS2 * step_s, slower_mps)
    else:
        unit.braked_mps = faster_mps
    unit.sure_stand_s = unit.sure_stand_s + step_s if unit.braked_mps <= 0.0 < faster_mps else 0.0
    if unit.sure_stand_s >= LONG_STAND_S:
        unit.liar = TACHOMETER_LIES if shown_mps > 0.0 else LAST_AXLE_LIES
    return float(unit.braked_mps)
